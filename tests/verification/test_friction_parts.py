# SPDX-License-Identifier: BSD-3-Clause
"""Decks of input/ with friction, by the tutorial: what it and physics say of the answers."""

import itertools

import h5py
import numpy as np
import pytest

from friction_formulas import ShaftInHub
from results import read_table
from runs import read_report, write_input
from tutorial import check_pictures, check_verdicts, part_fixture

EXACT = 1e-9
# largest difference of forces between two solvers after all times; each is exact to rounding, which histories add up
SAME = 2e-8


def columns_of(table, kind):
    """Columns lambda_k or tau_k, shape (n_rows, n_contacts)."""
    return np.array([values for name, values in table.items() if name.startswith(f"{kind}_")]).T


def check_work(report, allowed):
    """Residual of the balance of work of each step of each point, relative to the work of this step."""
    for point in report["points"].values():
        assert abs(point["work"]["residual"]) <= allowed


# meshes/press_fit_pull.geo and the deck
SHAFT = ShaftInHub(young=210e3, poisson=0.3, radius=10.0, outside=25.0, length=30.0)
SHAFT_CONTACT = 2 * np.pi * 10.0 * 30.0


press_fit_part = part_fixture("press_fit_pull")


@pytest.fixture(scope="module")
def press_fit(press_fit_part):
    """Results of press_fit_pull.yaml."""
    return press_fit_part[1] / "press_fit_pull"


def predicted(signorom, results, folder, *arguments):
    """Table of answers."""
    signorom("predict", results / "model.h5", *arguments, "--output", "answers.csv", folder=folder)
    answers = read_table(folder / "answers.csv")
    assert set(answers["status"]) == {"answered"}
    return answers


def test_press_fit_is_exact(press_fit):
    """The model has the forces of the full order at all times."""
    table = read_table(press_fit / "validation.csv")
    assert max(table["e_lambda_all"]) <= EXACT
    check_work(read_report(press_fit.parents[1], "press_fit_pull"), EXACT)


@pytest.mark.parametrize(("interference", "mu"), [(0.01, 0.15), (0.005, 0.1), (0.015, 0.25)])
def test_press_fit(signorom, press_fit, tmp_path, figures, interference, mu):
    """Pressure of the fit; slip that begins at the pulled end and only grows; force when all slips, and its work."""
    answers = predicted(signorom, press_fit, tmp_path, "--at", f"interference={interference},mu={mu}")
    normal, tangential = columns_of(answers, "lambda"), columns_of(answers, "tau")
    force, share, time = answers["contact_1_force_z"], answers["contact_1_slip_share"], answers["time"]
    problem = f"shaft pulled out of its hub, f = {mu}, {interference} mm"
    # hot, the hub slides freely
    fitted = int(np.argmin(np.abs(time - 1)))
    assert np.abs(tangential[: fitted + 1]).max() == 0
    # the shaft outside of the hub presses its end outwards, too
    figures.compare(
        problem,
        "mean pressure",
        normal[fitted].sum() / SHAFT_CONTACT,
        SHAFT.pressure(interference),
        0.015,
        "Lamé",
        "MPa",
    )
    assert (np.diff(share[fitted + 1 :]) >= -EXACT).all()
    assert share[fitted + 1] < 0.5
    assert (np.diff(force[fitted:]) >= -EXACT * force[-1]).all()
    # all slips from one time on: friction at its limit everywhere, a constant force, and its work
    full = share >= 1 - EXACT
    full[: fitted + 1] = False
    assert full.sum() >= 5
    np.testing.assert_allclose(tangential[full], mu * normal[full], rtol=EXACT)
    np.testing.assert_allclose(force[full], mu * normal[-1].sum(), rtol=EXACT)
    work = force[-1] * np.diff(answers["pull"])[-1]
    assert answers["contact_1_dissipation"][-1] == pytest.approx(work, rel=EXACT)
    assert (answers["contact_1_dissipation"][fitted + 1 :] >= 0).all()
    wanted = SHAFT.pull_of_thinner_shaft(interference, mu)
    figures.compare(problem, "force at full slip", force[-1], wanted, 0.025, "Lamé, thinner shaft", "N")
    # without the thinner shaft the closed form is too large by f k L / r to first order
    assert 0.03 < 1 - force[-1] / SHAFT.pull(interference, mu) < 0.12


def test_friction_during_the_fit_is_forgotten(signorom, press_fit, tmp_path):
    """With friction from the start, the shaft grows along its axis and is held back; full slip forgets that."""
    deck = write_input("press_fit_pull", tmp_path, {'friction: "time > 1 ? mu : 0"': "friction: mu"})
    signorom("solve", deck, folder=tmp_path)
    held = read_table(tmp_path / "results" / "press_fit_pull" / "history.csv")
    free = read_table(press_fit / "history.csv")
    fitted = int(np.argmin(np.abs(held["time"] - 1)))
    assert held["contact_1_force_z"][fitted] < -0.2 * free["contact_1_force_z"][-1]
    assert held["contact_1_force_z"][-1] == pytest.approx(free["contact_1_force_z"][-1], rel=EXACT)
    for kind in ("lambda", "tau"):
        difference = columns_of(held, kind)[-1] - columns_of(free, kind)[-1]
        assert np.abs(difference).max() <= EXACT * columns_of(free, "lambda")[-1].max()


# by deck: what its elastic constants become, with further parameters and their box
VARIED = {
    "press_fit_pull": {
        "  mu: {min: 0.1,": "  young: {min: 100e3, max: 300e3}\n  nu: {min: 0.2, max: 0.4}\n  mu: {min: 0.1,",
        "steel: {regions: [shaft, hub], young_modulus: 210.0e3, poisson_ratio: 0.3}": (
            "steel: {regions: [shaft], young_modulus: 210.0e3, poisson_ratio: 0.3}\n"
            "  other: {regions: [hub], young_modulus: young, poisson_ratio: nu}"
        ),
        "mu: 0.15}]}": "mu: 0.15, young: 200e3, nu: 0.35}]}",
        "reduction: {fields: true}": "reduction: {fields: true, stiffness_tolerance: 1e-8}",
    },
    "bolted_joint": {
        "  mu: {min: 0.1,": "  young: {min: 100e3, max: 250e3}\n  mu: {min: 0.1,",
        "young_modulus: 210.0e3": "young_modulus: young",
        "{mu: 0.12, tightening: 0.01}, {mu: 0.25, tightening": "{mu: 0.12, young: 200e3, tightening",
    },
}


@pytest.mark.parametrize("name", VARIED)
def test_elastic_constants_as_parameters(signorom, tmp_path, name):
    """Forces of the full order at all times: exact for a modulus of a whole body, interpolated otherwise."""
    deck = write_input(name, tmp_path, VARIED[name])
    said = signorom("run", deck, folder=tmp_path)
    assert "forces accepted: " in said
    assert "fields accepted: " in said
    allowed = {"press_fit_pull": 1e-8, "bolted_joint": EXACT}[name]
    table = read_table(tmp_path / "results" / name / "validation.csv")
    assert len(set(table["young"])) > 1
    assert max(table["e_lambda_all"]) <= allowed
    # at the training points, too, whose histories are asked for one after the other
    assert read_report(tmp_path, name)["reduction"]["largest_error"] <= allowed
    assert max(table["e_u_energy_relative"]) <= 1e-7
    assert min(table["error_bound"]) >= 0


def test_press_fit_in_a_cycle(signorom, press_fit, tmp_path):
    """Pulled and pushed until all slips, by tables of a file: the loop closes, and its area is the work of friction."""
    path = [(0.5, 0, 0.5), (1, 0, 1)]
    path += [
        (1 + k / 20, pull, 1)
        for k, pull in enumerate(
            np.interp(np.arange(1, 121) / 20, [0, 1, 3, 5, 6], [0, 0.03, -0.03, 0.03, 0]), 1
        )
    ]
    rows = [",".join(map(str, row)) for row in path]
    (tmp_path / "cycle.csv").write_text("\n".join(["time,pull,fit", *rows, ""]))
    answers = predicted(
        signorom, press_fit, tmp_path, "--at", "interference=0.01,mu=0.15", "--history", "cycle.csv"
    )
    force, time, pull = answers["contact_1_force_z"], answers["time"], answers["pull"]
    first, last = (int(np.argmin(np.abs(time - wanted))) for wanted in (2, 6))
    assert force[last] == pytest.approx(force[first], rel=EXACT)
    # pushed, the shaft is thicker and holds more
    assert -force.min() > 1.1 * force.max()
    steps = slice(first + 1, last + 1)
    # forces act over a step by their value at its end, in the elastic part by the mean of both ends
    area = np.sum((force[first:last] + force[steps]) / 2 * np.diff(pull[first : last + 1]))
    assert answers["contact_1_dissipation"][steps].sum() == pytest.approx(area, rel=0.05)


joint_part = part_fixture("bolted_joint")


@pytest.fixture(scope="module")
def joint(joint_part):
    """Results of bolted_joint.yaml."""
    return joint_part[1] / "bolted_joint"


def shear_of(table):
    """Force along x on the upper plate from below and from the head, and the preload."""
    return table["contact_1_force_x"], table["contact_2_force_x"], table["contact_1_force_z"]


def test_joint_is_exact(joint):
    """The model has the forces of the full order at all times."""
    table = read_table(joint / "validation.csv")
    assert max(table["e_lambda_all"]) <= EXACT
    check_work(read_report(joint.parents[1], "bolted_joint"), EXACT)


def test_joint_obeys_coulomb_and_equilibrium(joint):
    """At each contact and time; what comes through the head goes through the thread that is tied."""
    table = read_table(joint / "history.csv")
    assert set(table["status"]) == {"converged"}
    pairs = sorted({name[:-2] for name in table if name.startswith("tau_")})
    nothing = np.zeros(len(table["time"]))
    with h5py.File(joint / "fields.h5") as file:
        places = file["mesh/coordinates"][()]
    n_checked = 0
    for name in pairs:
        node = int(name.removeprefix("tau_"))
        # the thread, of radius 3, is tied
        if np.hypot(*places[node - 1, :2]) > 3.1:
            normal = table[f"lambda_{node}"]
            # on the plane of symmetry there is one tangent
            size = np.hypot(table.get(f"{name}_1", nothing), table.get(f"{name}_2", nothing))
            assert (size <= table["mu"] * normal * (1 + EXACT) + EXACT * normal.max()).all()
            n_checked += 1
    assert n_checked >= 50
    plate, head, preload = shear_of(table)
    for axis in "xz":
        through_head, through_thread = table[f"contact_2_force_{axis}"], table[f"contact_3_force_{axis}"]
        np.testing.assert_allclose(through_thread, through_head, atol=EXACT * preload.max())
    np.testing.assert_allclose(table["contact_2_force_z"], -preload, rtol=EXACT)
    assert (np.abs(plate) <= table["mu"] * preload * (1 + EXACT)).all()
    assert (np.abs(head) <= table["mu"] * preload * (1 + EXACT)).all()


def test_joint_slides_at_twice_the_friction(joint, figures):
    """Little friction: plate and head slip everywhere at both ends of the cycle, along x but for what is left of y."""
    table = read_table(joint / "history.csv")
    plate, head, preload = shear_of(table)
    for time in (4, 6):
        rows = np.flatnonzero(np.isclose(table["time"], time) & (table["mu"] == 0.12))
        assert len(rows) == 1
        k = rows[0]
        assert [table[f"contact_{i}_slip_share"][k] for i in (1, 2)] == pytest.approx([1, 1])
        found = abs(plate[k] + head[k])
        quantity = f"force at full slip, time {time}"
        figures.compare("bolted joint", quantity, found, 2 * 0.12 * preload[k], 1e-4, "2 f N", "N")


def test_joint_in_cycles(signorom, joint, tmp_path):
    """Where all slips, the loop closes in the second cycle; where the head sticks, it comes closer with each one."""
    time = np.append([0.5, 1], 1 + np.arange(1, 55) / 6)
    shift = np.interp(time, [1, 2, 4, 6, 8, 10], [0, 0.03, -0.03, 0.03, -0.03, 0.03])
    rows = [f"{t},{s},{min(t, 1)}" for t, s in zip(time.tolist(), shift.tolist(), strict=True)]
    (tmp_path / "cycles.csv").write_text("\n".join(["time,shift,tight", *rows, ""]))
    for mu, closes in ((0.12, True), (0.25, False)):
        answers = predicted(
            signorom, joint, tmp_path, "--at", f"mu={mu},tightening=0.01", "--history", "cycles.csv"
        )
        force = -(answers["contact_1_force_x"] + answers["contact_2_force_x"])
        ends = [int(np.argmin(np.abs(time - end))) for end in (2, 6, 10)]
        moved = [abs(force[after] / force[before] - 1) for before, after in itertools.pairwise(ends)]
        assert moved[1] <= (1e-6 if closes else 0.3 * moved[0])
        work = answers["contact_1_dissipation"] + answers["contact_2_dissipation"]
        # never below 0, but for rounding
        assert work.min() >= -EXACT * work.max()
        cycle = slice(ends[1] + 1, ends[2] + 1)
        area = np.sum((force[cycle] + force[ends[1] : ends[2]]) / 2 * np.diff(shift[ends[1] : ends[2] + 1]))
        assert work[cycle].sum() == pytest.approx(area, rel=0.1)


@pytest.mark.parametrize("name", ["press_fit_pull", "bolted_joint"])
def test_sparse_systems_give_the_same(signorom, press_fit, joint, tmp_path, name):
    """The solver active_set, without the dense matrix, at all times of the points of the deck; on two ranks."""
    expected = read_table({"press_fit_pull": press_fit, "bolted_joint": joint}[name] / "history.csv")
    deck = write_input(name, tmp_path)
    deck.write_text(f"{deck.read_text()}solver: {{type: active_set, linear: cholesky}}\n")
    signorom("solve", deck, folder=deck.parent, n_ranks=2)
    found = read_table(deck.parent / "results" / name / "history.csv")
    assert found["status"] == expected["status"]
    for kind in ("lambda", "tau"):
        size = np.abs(columns_of(expected, kind)).max()
        np.testing.assert_allclose(
            columns_of(found, kind), columns_of(expected, kind), rtol=0, atol=SAME * size
        )


def test_preload_of_the_joint(signorom, joint, tmp_path):
    """Tightened alone, everything grows in proportion: contact, slip and preload."""
    preloads = []
    for tightening in (0.005, 0.015):
        at = f"mu=0.2,tightening={tightening}"
        answers = predicted(signorom, joint, tmp_path, "--at", at)
        preloads.append(answers["contact_1_force_z"][:2])
    assert preloads[0] == pytest.approx(preloads[1] / 3, rel=1e-7)
    assert preloads[0][0] == pytest.approx(preloads[0][1] / 2, rel=1e-7)


def test_tutorial_of_the_press_fit(press_fit_part, press_fit):
    """Verdict, and numbers that the tutorial names: the shaft that is pulled out."""
    outputs, results = press_fit_part
    check_verdicts(outputs)
    checked = outputs["signorom check $CLONE/input/press_fit_pull.yaml --fields"]
    assert "440 training, 220 test; 44 times of each point are counted" in checked
    last = {name: values[-1] for name, values in read_table(press_fit / "history.csv").items()}
    assert f"{last['contact_1_force_z']:.0f}" == "23396"
    assert last["contact_1_slip_share"] == pytest.approx(1)
    force = read_table(results / "cycle" / "history.csv")["contact_1_force_z"]
    assert -force.min() > 1.1 * force.max()


def test_tutorial_of_the_joint(joint_part):
    """Verdict, and numbers that the tutorial names: the bolted joint."""
    outputs, results = joint_part
    check_verdicts(outputs)
    checked = outputs["signorom check $CLONE/input/bolted_joint.yaml --fields"]
    assert "only contact holds the body 'bolt'" in checked
    table = read_table(results / "shear" / "history.csv")
    assert f"{table['contact_1_force_z'][-1]:.0f}" == "1709"
    assert f"{-table['contact_1_force_x'][-1]:.0f}" == "205"
    assert f"{-table['contact_2_force_x'][-1]:.0f}" == "205"
    first, second = (table["contact_1_force_x"][np.isclose(table["time"], time)] for time in (6, 10))
    assert second == pytest.approx(first, rel=1e-6)


def test_pictures_of_the_tutorial(signorom, press_fit_part, joint_part):
    """All that it names."""
    _, results = press_fit_part
    names = [
        f"press_fit_pull/figures/{name}" for name in ("hysteresis.png", "stick_slip.png", "animation.gif")
    ]
    check_pictures(signorom, results, *names, "cycle/figures/hysteresis.png")
    _, results = joint_part
    names = [
        f"bolted_joint/{name}.png" for name in ("figures/hysteresis", "figures/stick_slip", "head/hysteresis")
    ]
    check_pictures(signorom, results, *names, "shear/figures/hysteresis.png")
