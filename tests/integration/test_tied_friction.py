# SPDX-License-Identifier: BSD-3-Clause
"""Friction and histories where the matrix of all contacts has no room: contacts that always stick are tied."""

import re
import zipfile

import h5py
import numpy as np
import pytest

from block_meshes import Mesh
from results import read_table
from runs import refuse
from test_fmu import Instance, run_post
from test_friction_gradients import check_given, trained, walk

SAME = 1e-8
N_ACROSS = 120  # contacts with friction less one: W of these and of the tied surface takes 0.7 MB
N_BASE = 30
# Only the tied surface holds the bed, and only contact with friction holds the strip along x.
DECK = """\
title: A strip that is pressed on a bed, and pulled
units: {{length: m, force: N, time: s}}
mesh: {{file: strip.msh, model: plane_strain}}
parameters:
  press: {{min: 0.9e-3, max: 1.1e-3, unit: m}}
  pull: {{min: 0, max: 4.0e4, unit: Pa}}
  mu: {{min: 0.4, max: 0.5}}
history:
  tables:
    load: {{time: [0, 1], value: [0, 1]}}
    end: {{time: [0, 1, 2, 4], value: [0, 0, 1, -1]}}
  steps:
    - {{until: 1, increments: 2}}
    - {{until: 4, increments: 6}}
materials:
  bed: {{regions: [base, bed], young_modulus: 2.0e6, poisson_ratio: 0.3}}
  strip: {{regions: [strip], young_modulus: 7.0e6, poisson_ratio: 0.2}}
boundary_conditions:
  - {{boundary: bottom, displacement: {{x: 0, y: 0}}}}
  - {{boundary: top, displacement: {{y: "load * press * (0.2 - x)"}}}}
loads:
  - {{boundary: right, traction: {{x: "pull * end"}}}}
contact:
  - {{first: bed_face, second: strip_face, direction: [0, 1], friction: mu}}
  - {{first: bed_bottom, second: base_face, tied: true}}
solver: {{type: active_set}}
training: {{grid: {{press: 2, pull: 2, mu: 2}}}}
test: {{grid: {{press: 2, pull: 3, mu: 2}}}}
reduction: {{{reduction}}}
output: {{points: [{{press: 1.0e-3, pull: 3.0e4, mu: 0.42}}]}}
"""
TIED = "max_full_order_size: 0.4"
POINT = "press=1.03e-3,pull=3.3e4,mu=0.44"


def write_strip(folder, reduction, **changes):
    """Mesh and deck: a strip on a bed, which is tied to a base with fewer nodes; the left end is lifted."""
    folder.mkdir(exist_ok=True)
    across, few = (np.linspace(0.0, 1.0, n + 1) for n in (N_ACROSS, N_BASE))
    mesh = Mesh()
    mesh.add_block("base", [few, np.linspace(-0.1, -0.06, 3)], "Q4", {(1, 0): "bottom", (1, 1): "base_face"})
    bed = {(1, 0): "bed_bottom", (1, 1): "bed_face"}
    mesh.add_block("bed", [across, np.linspace(-0.06, 0.0, 4)], "Q4", bed)
    strip = {(1, 0): "strip_face", (1, 1): "top", (0, 1): "right"}
    mesh.add_block("strip", [across, np.linspace(0.0, 0.03, 3)], "Q4", strip)
    mesh.write(folder / "strip.msh")
    text = DECK.format(reduction=reduction)
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    (folder / "strip.yaml").write_text(text)
    return folder / "strip.yaml"


def columns_of(table, kind):
    """Forces lambda_k or tau_k of all rows of a table."""
    return np.array(
        [values for name, values in table.items() if re.fullmatch(rf"{kind}_\d+", name)], dtype=float
    )


def answers_of(signorom, model, folder, *arguments, code=0):
    """Table of `predict`, from times and tables of a file or from the model's own."""
    command = ["predict", model, *arguments, "--output", "answers.csv"]
    done = signorom.run(*command, folder=folder)
    assert done.returncode == code, done.stderr
    return read_table(folder / "answers.csv")


def solved(signorom, folder, point, **changes):
    """Table of the full order at a point, with the deck changed."""
    write_strip(folder, TIED, **changes)
    signorom("solve", "strip.yaml", "--at", point, folder=folder)
    return read_table(folder / "results" / "strip" / "history.csv")


def check_same(answers, wanted, n_rows):
    """Same forces, and the same contacts slip."""
    for kind in ("lambda", "tau"):
        one, other = (columns_of(table, kind)[:, :n_rows] for table in (answers, wanted))
        assert np.linalg.norm(one - other) <= SAME * np.linalg.norm(other)
        assert np.abs(other).max() > 0
    for name in ("contact_1_slip_share", "contact_1_dissipation", "contact_1_area", "n_active"):
        assert answers[name][:n_rows] == pytest.approx(wanted[name][:n_rows], rel=1e-6, abs=1e-9)


@pytest.fixture(scope="module")
def tied(signorom, tmp_path_factory):
    """What `run` says, and its results."""
    folder = tmp_path_factory.mktemp("tied")
    deck = write_strip(folder, TIED)
    return signorom("run", deck.name, folder=folder), folder / "results" / "strip"


def status_of(model):
    """0 open, 1 closed, 2 may change, of all contact forces."""
    with h5py.File(model) as file:
        assert file["clusters/1"].attrs["kind"] in (b"tied", "tied")
        return file["clusters/1/tied/1/status"][()]


def test_answers_equal_the_full_order(tied):
    said, folder = tied
    errors = read_table(folder / "validation.csv")
    assert max(errors["e_lambda_all"]) <= SAME
    assert max(errors["e_u_energy_relative"]) <= SAME
    told = re.search(r"cluster 1: (\d+) contacts may change, (\d+) stay closed, (\d+) stay open", said)
    normal, tangential = np.split(status_of(folder / "model.h5"), 2)
    assert [int(number) for number in told.groups()] == [(normal == k).sum() for k in (2, 1, 0)]
    # tied surfaces never change, and all rows of a contact have one status
    assert (normal[N_ACROSS + 1 :] == 1).all()
    assert (tangential == normal).all()
    assert set(normal[: N_ACROSS + 1]) == {0, 1, 2}
    assert (normal == 2).sum() < N_ACROSS / 2


def test_check_and_describe(signorom, tied):
    folder = tied[1].parent.parent
    said = signorom("check", "strip.yaml", folder=folder)
    assert "unknowns only at contacts that change at the training points, and around them (kind tied)" in said
    said = signorom("describe", tied[1] / "model.h5", folder=folder)
    status = status_of(tied[1] / "model.h5")
    n_changing, n_tied = ((status == k).sum() for k in (2, 1))
    assert (
        f"{n_changing} contact rows may change, {n_tied} tied (always closed, with friction also stuck)"
        in said
    )


def test_unseen_history(signorom, tmp_path, tied):
    """Other times and tables, as the command solve finds them."""
    (tmp_path / "h.csv").write_text(
        "time,load,end\n0.5,0.7,0\n0.75,1,0.4\n1.5,1.02,-0.9\n2,0.95,0.3\n3,1,0.9\n"
    )
    tables = {
        "{time: [0, 1], value: [0, 1]}": "{time: [0.5, 0.75, 1.5, 2, 3], value: [0.7, 1, 1.02, 0.95, 1]}",
        "{time: [0, 1, 2, 4], value: [0, 0, 1, -1]}": "{time: [0.5, 0.75, 1.5, 2, 3], value: [0, 0.4, -0.9, 0.3, 0.9]}",
        "    - {until: 1, increments: 2}\n    - {until: 4, increments: 6}": "".join(
            f"    - {{until: {time}, increments: 1}}\n" for time in (0.5, 0.75, 1.5, 2, 3)
        ),
    }
    wanted = solved(signorom, tmp_path, POINT, **tables)
    answers = answers_of(signorom, tied[1] / "model.h5", tmp_path, "--at", POINT, "--history", "h.csv")
    assert set(answers["status"]) == {"answered"}
    assert max(wanted["contact_1_slip_share"]) > 0
    check_same(answers, wanted, 5)
    assert set(answers["error_bound"]) == {"none"}


def test_condensed_solver(signorom, tmp_path):
    """Condensed to its contacts, the bed hangs on the tied surface alone: a slender part without any other support."""
    wanted = solved(signorom, tmp_path / "sparse", POINT)
    answers = solved(signorom, tmp_path / "dense", POINT, **{"type: active_set": "type: condensed"})
    check_same(answers, wanted, 8)


def test_a_tied_contact_slips(signorom, tmp_path, tied):
    """The answer ends at the first time at which a contact that is taken as stuck slips in the full order."""
    point = "press=1.03e-3,pull=9e4,mu=0.44"
    model = tied[1] / "model.h5"
    answers = answers_of(signorom, model, tmp_path, "--at", point, code=3)
    wanted = solved(signorom, tmp_path, point)
    always = status_of(model)[: N_ACROSS + 1] == 1
    normal, tangential = (columns_of(wanted, kind) for kind in ("lambda", "tau"))
    n = N_ACROSS + 1
    slips = np.abs(tangential[:n]) >= 0.44 * normal[:n] * (1 - 1e-9)
    is_broken = slips[always].any(axis=0)
    first = int(np.argmax(is_broken))
    assert is_broken[first]
    assert 0 < first < 7
    reason = "a contact opens, closes or slips that does not change at the training points"
    assert answers["status"] == ["answered"] * first + [reason] * (8 - first)
    check_same(answers, wanted, first)


def test_contacts_that_close_later(signorom, tmp_path):
    """They stick where they have closed, which is no tie: they count as contacts that may change."""
    late = {
        "press * (0.2 - x)": "press * (0.2 - x) - 3.0e-5 * late",
        "  tables:\n": "  tables:\n    late: {time: [0, 2, 4], value: [0, 0, 1]}\n",
    }
    deck = write_strip(tmp_path, "max_full_order_size: 0.6", **late)
    signorom("run", deck.name, folder=tmp_path)
    folder = tmp_path / "results" / "strip"
    assert max(read_table(folder / "validation.csv")["e_lambda_all"]) <= SAME
    normal = columns_of(read_table(folder / "history.csv"), "lambda")[: N_ACROSS + 1]
    closes = (normal[:, 1] == 0) & (normal[:, -1] > 0)
    assert closes.sum() > 3
    assert (status_of(folder / "model.h5")[: N_ACROSS + 1][closes] == 2).all()


def test_all_stick(signorom, tmp_path):
    """Only the tied surface and contacts that stick: nothing is unknown, and forces follow from the loads."""
    stuck = {
        "{boundary: top, displacement: {y": "{boundary: top, displacement: {x: 0, y",
        "load * press * (0.2 - x)": "-load * press",
        "mu: {min: 0.4, max: 0.5}": "mu: {min: 2, max: 3}",
        "mu: 0.42": "mu: 2.2",
    }
    deck = write_strip(tmp_path, TIED, **stuck)
    said = signorom("run", deck.name, folder=tmp_path)
    assert f"cluster 1: 0 contacts may change, {2 * N_ACROSS + 2} stay closed, 0 stay open" in said
    errors = read_table(tmp_path / "results" / "strip" / "validation.csv")
    assert max(errors["e_lambda_all"]) <= SAME
    assert max(errors["e_u_energy_relative"]) <= SAME


def test_no_room(signorom, tmp_path):
    deck = write_strip(tmp_path, "max_full_order_size: 0.05")
    signorom("sample", deck.name, folder=tmp_path)
    said = refuse(signorom, "train", deck.name, folder=tmp_path)
    assert re.search(r"strip\.yaml:\d+:\d+: error: contacts have friction or are tied, but the matrix", said)
    told = re.search(r"with unknowns only at contacts that change it still takes (\S+) MB", said)
    assert 0.05 < float(told[1]) < 0.4


def test_bodies_that_changing_contacts_hold(signorom, tmp_path):
    """Where nothing holds the strip but contacts that may change, there is no such model."""
    loose = {
        "{min: 0, max: 4.0e4": "{min: 0, max: 1.2e5",
        "pull: 3.0e4": "pull: 1.0e5",
        "mu: {min: 0.4": "mu: {min: 0.0",
    }
    deck = write_strip(tmp_path, "max_full_order_size: 1.5", **loose)
    signorom.run("sample", deck.name, folder=tmp_path)
    said = refuse(signorom, "train", deck.name, folder=tmp_path)
    assert "do not hold the bodies that only contact holds" in said


def test_ranks_agree(signorom, tmp_path, tied):
    deck = write_strip(tmp_path, TIED)
    signorom("sample", deck.name, folder=tmp_path, n_ranks=3)
    signorom("train", deck.name, folder=tmp_path, n_ranks=3)
    one, three = (
        answers_of(signorom, folder / "model.h5", tmp_path, "--at", POINT)
        for folder in (tied[1], tmp_path / "results" / "strip")
    )
    check_same(three, one, 8)


def test_exact_boundaries_and_derivatives(signorom, post, tmp_path):
    """Displacements of a boundary, and derivatives through a history against differences of whole histories."""
    deck = write_strip(tmp_path, TIED + ", displacement: {boundaries: [right]}")
    given = {"press": 1.03e-3, "pull": 3.3e4, "mu": 0.44}
    with post.Model(trained(signorom, deck)) as model:
        nodes = model.nodes[0]
        shown = ~np.isnan(walk(model, given, [(time,) for time in model.times[:2]], nodes).displacement[:, 0])
        assert shown.sum() == 3
        for end in (1, 3, 7):
            check_given(model, given, [(time,) for time in model.times[: end + 1]], nodes[shown])


def test_memory_is_restored(post, tied):
    """Another history in between changes nothing."""
    with post.Model(tied[1] / "model.h5") as model:
        with model.start(press=1.03e-3, pull=3.3e4, mu=0.44) as history:
            wanted = [history.advance(time, nodes=[]).multipliers for time in model.times]
        one = model.start(press=1.03e-3, pull=3.3e4, mu=0.44)
        other = model.start(press=0.95e-3, pull=1.1e4, mu=0.48)
        with one, other:
            for time, forces in zip(model.times, wanted, strict=True):
                other.advance(time, nodes=[])
                np.testing.assert_array_equal(one.advance(time, nodes=[]).multipliers, forces)


def test_unit_goes_back(library, post, tmp_path, tied):
    """A unit of FMI answers as the model does, and its state is the memory of the contacts that may change."""
    model, unit = tied[1] / "model.h5", tmp_path / "strip.fmu"
    done = run_post(library, "fmu", model, "--output", unit, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    with zipfile.ZipFile(unit) as archive:
        archive.extractall(tmp_path / "unit")
    given = {"press": 1.03e-3, "pull": 3.3e4, "mu": 0.44}
    steps = [(0.5, 0.7, 0.0), (1.0, 1.0, 0.6), (1.5, 1.0, -0.9), (2.0, 1.0, 0.3)]
    names = ["contact_1.force_x", "contact_1.force_y", "contact_1.moment_z"]
    wanted = []
    with post.Model(model) as online, online.start(**given) as history:
        for time, load, end in steps:
            sums = history.advance(time, nodes=[], load=load, end=end).resultants
            wanted.append([*sums.forces[0], *sums.moments[0]])
    instance = Instance(tmp_path / "unit").start()
    instance.set(**given)
    instance.fmu.enterInitializationMode()
    instance.fmu.exitInitializationMode()

    def go(number):
        """Outputs after a step."""
        time, load, end = steps[number]
        before = steps[number - 1][0] if number > 0 else 0.0
        instance.set(load=load, end=end)
        instance.fmu.doStep(before, time - before)
        return instance.get(*names)

    found = [go(0), go(1)]
    state = instance.fmu.getFMUState()
    found.append(go(2))
    instance.fmu.setFMUState(state)
    found += [go(2), go(3)]
    for one, other in zip(found, [*wanted[:3], *wanted[2:]], strict=True):
        assert one == pytest.approx(other, rel=1e-12, abs=1e-9)
    instance.fmu.freeFMUState(state)
    instance.fmu.freeInstance()
