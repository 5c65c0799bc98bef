# SPDX-License-Identifier: BSD-3-Clause
"""What tables, report and files say of friction: a block that is pressed onto another one and drawn over it.

The blocks are 1 wide, so stiff that only slip moves them, and nu = 0. The normal force is the pressure P, whatever its
distribution, and where all nodes slip friction is f P along the motion: its work in a step is f P times the step. The
moment of f P about the contact, with f = 0.1, does not lift the rim (|e| < 1/6 of the width).
"""

import h5py
import numpy as np
import pytest
import yaml

from block_meshes import stacked_blocks
from results import read_table
from vtk_fields import read_with_vtk

FRICTION, PRESSURE = 0.1, 4.0
# [m] a step of the upper block, there and back; its direction in space
STEP = 0.005
WAYS = {2: np.array([1.0]), 3: np.array([0.6, 0.8])}
# [-] elastic displacements are P / E = 4e-9 beside steps of 5e-3; with a larger E, reactions have more rounding
STIFF = 1e-5
# [-] the same numbers by other sums
SAME = 1e-12
# [-] energy and reactions of a stiff block that moves are rounding: 1e-16 E u is 1e-9 of f P
ROUNDED = 1e-7
DECK = """title: A block drawn over another one
units: {{length: m, force: N, time: h}}
mesh: {{file: part.msh, model: {model}}}
parameters: {{P: {{min: 1, max: 9, unit: Pa}}}}
history:
  tables: {{slide: {{time: [0, 1, 3], value: [0, {far}, -{far}]}}}}
  steps: [{{until: 1, increments: 2}}, {{until: 3, increments: 4}}]
materials: {{all: {{regions: [lower, upper], young_modulus: 1e9, poisson_ratio: 0}}}}
boundary_conditions:
  - {{boundary: bottom, displacement: {{{held}}}}}
  - {{boundary: top, displacement: {{{drawn}}}}}
loads: [{{boundary: top, pressure: P}}]
contact: [{{first: lower_face, second: upper_face, formulation: {formulation}, friction: {friction}}}]
training: {{grid: {{P: 2}}}}
reduction: {{fields: true}}
output: {{points: [{{P: {pressure}}}, {{P: {twice}}}]}}
"""
# along the way: slip of each step, and the direction of friction on the lower block
STEPS = STEP * np.array([1, 1, -1, -1, -1, -1])


def write_deck(folder, n_dim, formulation="node_to_node", far=2 * STEP, friction=FRICTION):
    """Mesh and deck."""
    stacked_blocks("Q4" if n_dim == 2 else "H8", n_dim).write(folder / "part.msh")
    axes = "xyz"[:n_dim]
    way = WAYS[n_dim]
    deck = folder / "part.yaml"
    deck.write_text(
        DECK.format(
            model="plane_strain" if n_dim == 2 else "solid",
            far=far,
            held=", ".join(f"{axis}: 0" for axis in axes),
            drawn=", ".join(f"{axis}: {share} * slide" for axis, share in zip(axes, way, strict=False)),
            formulation=formulation,
            friction=friction,
            pressure=PRESSURE,
            twice=2 * PRESSURE,
        )
    )
    return deck


@pytest.fixture(
    scope="module", params=[(2, "node_to_node"), (2, "mortar"), (3, "node_to_node"), (3, "mortar")], ids=str
)
def case(request, signorom, tmp_path_factory):
    """Number of dimensions, and the results of `run`, whose output point has P = PRESSURE."""
    folder = tmp_path_factory.mktemp("friction")
    n_dim, formulation = request.param
    signorom("run", write_deck(folder, n_dim, formulation), folder=folder)
    return n_dim, folder / "results" / "part"


def check_slipping(table, n_dim):
    """All slip: friction is f P along the motion of the upper block, here on the lower one."""
    assert table["contact_1_slip_share"] == pytest.approx(np.ones(6), rel=SAME)
    work = FRICTION * PRESSURE * STEP
    assert table["contact_1_dissipation"] == pytest.approx(np.full(6, work), rel=STIFF)
    for axis, share in zip("xyz", WAYS[n_dim], strict=False):
        forces = FRICTION * PRESSURE * share * np.sign(STEPS)
        assert table[f"contact_1_force_{axis}"] == pytest.approx(forces, rel=STIFF)
    assert table[f"contact_1_force_{'xyz'[n_dim - 1]}"] == pytest.approx(np.full(6, -PRESSURE), rel=STIFF)


def test_tables(signorom, case):
    """history.csv of the full order, and the table of predict."""
    n_dim, results = case
    table = read_table(results / "history.csv")
    check_slipping({name: values[:6] for name, values in table.items()}, n_dim)
    assert table["contact_1_dissipation"][6:] == pytest.approx(
        2 * table["contact_1_dissipation"][:6], rel=STIFF
    )
    signorom("predict", results / "model.h5", "--at", f"P={PRESSURE}", "--output", "t.csv", folder=results)
    check_slipping(read_table(results / "t.csv"), n_dim)


def test_report(case):
    """The numbers of history.csv, and the work of each step, in which the mean of the forces of both ends draws."""
    _, results = case
    table = read_table(results / "history.csv")
    report = yaml.safe_load((results / "report.yaml").read_text())
    assert report["units"]["work"] == ("N*m/m" if case[0] == 2 else "N*m")
    work = FRICTION * PRESSURE * STEP
    # from rest half of f P draws it; where it turns, the mean of f P and -f P
    supports = work * np.array([0.5, 1, 0, 1, 1, 1])
    for k in range(6):
        point = report["points"][str(k + 1)]
        contact = point["contacts"]["1"]
        assert contact["slip_share"] == pytest.approx(table["contact_1_slip_share"][k], rel=SAME)
        assert contact["dissipation"] == pytest.approx(table["contact_1_dissipation"][k], rel=1e-9)
        assert point["work"]["friction"] == pytest.approx(work, rel=STIFF)
        assert point["work"]["supports"] == pytest.approx(supports[k], rel=STIFF, abs=STIFF * work)
        assert point["work"]["time_error"] == pytest.approx(supports[k] - work, rel=STIFF, abs=STIFF * work)
        assert point["work"]["loads"] == pytest.approx(0, abs=STIFF * work)
        assert point["work"]["residual"] < ROUNDED
        second = report["points"][str(k + 7)]["work"]
        assert second["supports"] == pytest.approx(2 * supports[k], rel=STIFF, abs=STIFF * work)


def check_surface(shown, way, step):
    """All nodes slip by a step of the upper block, and friction is f times the pressure, against the slip."""
    slip, traction = shown.nodes["slip"], shown.nodes["tangential_traction"]
    pressure = shown.nodes["contact_pressure"]
    assert list(shown.nodes["friction_status"]) == [3] * len(slip)
    assert list(shown.nodes["status"]) == [2] * len(slip)
    # the multipliers are on the lower or on the upper block
    side = np.sign(slip[0] @ way * step)
    assert slip == pytest.approx(np.outer(np.full(len(slip), side * step), way), rel=1e-4, abs=1e-4 * STEP)
    assert traction == pytest.approx(
        -side * np.sign(step) * FRICTION * np.outer(pressure, way), rel=1e-4, abs=1e-5
    )
    assert pressure.min() > 0.1


def test_fields(signorom, case):
    """contact.xdmf and fields.xdmf of the full order and of predict, as viewers read them."""
    n_dim, results = case
    signorom("predict", results / "model.h5", "--at", f"P={PRESSURE}", "--fields", folder=results)
    way = np.pad(WAYS[n_dim], (0, 3 - len(WAYS[n_dim])))
    for folder in (results, results / "predicted_fields"):
        surface = list(read_with_vtk(folder / "contact.xdmf").values())
        bodies = list(read_with_vtk(folder / "fields.xdmf").values())
        for k, step in enumerate(STEPS):
            check_surface(surface[k], way, step)
            nodes = bodies[k].nodes
            is_closed = nodes["contact_pressure"] > 0
            assert list(nodes["friction_status"]) == list(np.where(is_closed, 3, 0))
            # each block's surface slips over the other one: the lower one moves back
            is_upper = is_closed & (abs(nodes["displacement"] @ way) > 0.5 * STEP)
            is_lower = is_closed & ~(abs(nodes["displacement"] @ way) > 0.5 * STEP)
            along = nodes["slip"] @ way
            if not np.isclose(np.sum(STEPS[: k + 1]), 0):
                assert along[is_upper] == pytest.approx(step, rel=1e-4)
                assert along[is_lower] == pytest.approx(-step, rel=1e-4)
                assert is_upper.sum() == is_lower.sum() > 0
            assert not along[~is_closed].any()
            friction = nodes["tangential_traction"] @ way
            assert abs(friction) == pytest.approx(FRICTION * nodes["contact_pressure"], rel=1e-4)
            assert not (friction * along > 0).any()


def test_fields_of_the_model(post, case):
    """Beside those of the full order in the files of `run`, and in Python."""
    n_dim, results = case
    names = ("tangential_traction", "slip", "friction_status")
    for name in ("fields.h5", "contact.h5"):
        with h5py.File(results / name) as file:
            for point in list(file["points"].values())[:6]:
                for field in names:
                    wanted = point[field][()]
                    largest = abs(wanted).max()
                    assert largest > 0
                    assert point[f"{field}_reduced"][()] == pytest.approx(wanted, abs=1e-7 * largest)
    with (
        post.Model(results / "model.h5") as model,
        h5py.File(results / "fields.h5") as file,
        model.start(P=PRESSURE) as history,
    ):
        with pytest.raises(ValueError, match="call advance first"):
            history.fields()
        for k, time in enumerate(model.times):
            history.advance(time)
            fields = history.fields()
            assert fields.point["time"] == time
            for field in names:
                wanted = file[f"points/{k + 1:04}/{field}_reduced"][()]
                wanted = wanted[:, :n_dim] if wanted.ndim > 1 else wanted
                assert getattr(fields, field) == pytest.approx(wanted, rel=SAME)
        assert fields.units["slip"] == "m"
        assert fields.units["tangential_traction"] == "Pa"


def test_sticking(signorom, tmp_path):
    """A draw of less than the friction can hold: at most G far / 2 = 0.25 of 0.4. No slip, no work, and the share 0."""
    signorom("solve", write_deck(tmp_path, 2, far=1e-9), "--at", f"P={PRESSURE}", folder=tmp_path)
    table = read_table(tmp_path / "results" / "part" / "history.csv")
    assert list(table["contact_1_slip_share"]) == [0] * 6
    assert list(table["contact_1_dissipation"]) == [0] * 6
    assert max(abs(table["contact_1_force_x"])) > 0.01
    with h5py.File(tmp_path / "results" / "part" / "contact.h5") as file:
        for point in file["points"].values():
            assert set(point["friction_status"][()]) == {2}
            assert not point["slip"][()].any()
        assert "2 sticks, 3 slips" in file["points/0001/friction_status"].attrs["description"]
        assert file["points/0001/tangential_traction"].attrs["unit"] == "Pa"
    report = yaml.safe_load((tmp_path / "results" / "part" / "report.yaml").read_text())
    for k in range(6):
        work = report["points"][str(k + 1)]["work"]
        assert work["residual"] < 1e-9
        # closed contacts that stick take no work at all
        assert work["contact"] == pytest.approx(0, abs=1e-9 * (abs(work["energy"]) + abs(work["loads"])))


def work_of(signorom, folder, n_steps):
    """Sums over a history in which soft blocks are sheared until a part of the contact slips: name of a work -> sum."""
    folder.mkdir()
    deck = write_deck(folder, 2, far=0.06, friction=0.5)
    text = deck.read_text().replace("1e9", "1e3").replace("increments: 2", f"increments: {n_steps}")
    deck.write_text(text.replace(", {until: 3, increments: 4}", ""))
    signorom("solve", deck, "--at", f"P={PRESSURE}", folder=folder)
    report = yaml.safe_load((folder / "results" / "part" / "report.yaml").read_text())
    table = read_table(folder / "results" / "part" / "history.csv")
    assert 0 < table["contact_1_slip_share"][-1] < 1
    works = [report["points"][str(k + 1)]["work"] for k in range(n_steps)]
    # equilibrium to rounding at both ends of each step
    assert max(work["residual"] for work in works) < 1e-12
    return {name: sum(work[name] for work in works) for name in works[0]}


def test_balance_of_work(signorom, tmp_path):
    """The work of loads and supports is energy and friction but for an error of the time steps, of the first order."""
    found = {n: work_of(signorom, tmp_path / str(n), n) for n in (16, 32, 64)}
    for works in found.values():
        error = works["loads"] + works["supports"] - works["energy"] - works["friction"]
        assert error == pytest.approx(works["time_error"], rel=1e-6)
        assert works["friction"] > 0.03 * works["energy"]
    errors = [abs(found[n]["time_error"]) for n in found]
    assert errors[-1] < 0.05 * found[64]["friction"]
    # half the step, half the error
    assert np.divide(errors[1:], errors[:-1]) == pytest.approx(np.full(2, 0.5), abs=0.05)


def test_without_friction(signorom, tmp_path):
    """No columns and no keys of friction."""
    deck = write_deck(tmp_path, 2)
    deck.write_text(deck.read_text().replace(f", friction: {FRICTION}", ""))
    signorom("solve", deck, "--at", f"P={PRESSURE}", folder=tmp_path)
    results = tmp_path / "results" / "part"
    table = read_table(results / "history.csv")
    assert not [name for name in table if "slip" in name or "dissipation" in name]
    report = yaml.safe_load((results / "report.yaml").read_text())
    assert "work" not in report["points"]["1"]
    assert "slip_share" not in report["points"]["1"]["contacts"]["1"]
    for name in ("contact", "fields"):
        with h5py.File(results / f"{name}.h5") as file:
            assert not {"tangential_traction", "slip", "friction_status"} & set(file["points/0001"])
