# SPDX-License-Identifier: BSD-3-Clause
"""Decks of input/ whose materials yield and creep, by the tutorial: what it, balances and physics say of the answers."""

import re

import h5py
import numpy as np
import pytest

from results import read_fields, read_table
from runs import read_report
from tutorial import check_pictures, check_verdicts, part_fixture

# [-] of what Newton's method leaves, relative to the largest force
ROUNDING = 1e-6
# [-] what models with 8 and 16 training histories are made for
FORCES = 0.01


def check_errors(results):
    """All test histories are answered, with an estimate that has the size of the error or more."""
    table = read_table(results / "validation.csv")
    assert "none" not in table["solver"]
    errors, estimates = table["e_lambda_all"], table["error_estimate"]
    is_pressed = np.isfinite(errors) & (estimates > 0)
    assert np.quantile(errors[is_pressed], 0.95) < FORCES
    assert np.median(errors[is_pressed] / estimates[is_pressed]) < 1


def check_work(report):
    """Residual of the balance of work of each step, relative to its largest part; no step was cut."""
    for point in report["points"].values():
        assert abs(point["work"]["residual"]) <= ROUNDING
        assert point["flow"]["n_cuts"] == 0


rod_part = part_fixture("pcmi")


@pytest.fixture(scope="module")
def rod(rod_part):
    """Results of pcmi.yaml."""
    return rod_part[1] / "pcmi"


clamp_part = part_fixture("clamp_creep")


@pytest.fixture(scope="module")
def clamp(clamp_part):
    """Results of clamp_creep.yaml."""
    return clamp_part[1] / "clamp_creep"


@pytest.mark.parametrize("name", ["rod", "clamp"])
def test_models(name, request):
    outputs, _ = request.getfixturevalue(f"{name}_part")
    check_verdicts(outputs)
    results = request.getfixturevalue(name)
    check_errors(results)
    check_work(read_report(results.parents[1], results.name))


def during(table, first, last):
    """Sum of the pressures on the pellet at the times of an interval with both ends."""
    time = table["time"]
    return -table["contact_1_force_r"][(time >= first - 1e-9) & (time <= last + 1e-9)]


def test_two_cycles_of_power(rod):
    """Creep takes pressure in each hold, the gap opens between, and the second peak is lower."""
    table = read_table(rod / "history.csv")
    holds = [during(table, 12, 60), during(table, 72, 124)]
    for hold in holds:
        assert (np.diff(hold) < 0).all()
    assert holds[1].max() < holds[0].max()
    for time in (66, 130):
        assert during(table, time, time) == 0
    largest = holds[0].max()
    assert np.abs(table["contact_1_force_z"]).max() <= ROUNDING * largest


def test_hoop_force_carries_the_pressures(rod, figures):
    """The cut along a meridian: the hoop force of the cladding balances both pressures, while it yields and creeps."""
    table = read_table(rod / "history.csv")
    with h5py.File(rod / "fields.h5") as file:
        corners = file["mesh/coordinates"][()][file["mesh/topology"][:, :4], :2]
        is_cladding = file["points/0001/region"][()] == 1 + [*file["mesh/region_names"].asstr()].index(
            "cladding"
        )
    sides = np.ptp(corners[is_cladding], axis=1)
    areas, outside = sides[:, 0] * sides[:, 1], corners[is_cladding].max(axis=(0, 1))
    found, wanted = [], []
    for i in range(len(table["time"])):
        stress = read_fields(rod / "fields.h5", i + 1)["stress"][is_cladding, 2]
        found.append(2 * np.pi * (stress * areas).sum())
        pressed = 2 * np.pi * outside[0] * outside[1] * table["P"][i] * table["warm"][i]
        wanted.append(-table["contact_1_force_r"][i] - pressed)
    errors = np.abs(np.subtract(found, wanted)) / np.abs(wanted).max()
    # stresses are means over cells by their volume, and a cut has areas: less by the square of cell over radius
    figures.at_most(
        "fuel rod over two cycles", "error of the hoop force", errors.max(), 1e-3, "equilibrium", "-"
    )


def test_force_of_a_hot_bolt(clamp):
    """Equal expansion changes nothing; then the force falls, ever slower, more when hotter."""
    table = read_table(clamp / "history.csv")
    seat, flange = -table["contact_1_force_z"], table["contact_2_force_z"]
    np.testing.assert_allclose(seat, flange, rtol=ROUNDING)
    is_hotter = table["hot"] == table["hot"].max()
    histories = [seat[~is_hotter], seat[is_hotter]]
    times = table["time"][is_hotter]
    for force in histories:
        assert force[1] == pytest.approx(force[0], rel=ROUNDING)
        assert (np.diff(force) < ROUNDING * force[0]).all()
        rates = -np.diff(force[2:]) / np.diff(times[2:])
        assert (np.diff(rates) < 0).all()
    assert (histories[1][2:] < histories[0][2:]).all()


def test_tutorial_of_the_rod(rod_part, rod):
    """Numbers that the tutorial names."""
    outputs, results = rod_part
    trained = outputs["signorom run $CLONE/input/pcmi.yaml"]
    assert re.search(r"inelastic strains: \d+ modes, \d+ of 144 integration points", trained)
    assert "5 training histories: largest estimate of 100 candidates" in trained
    assert re.search(
        r"selected \d+ points by audit, tolerance 0.01, max_points 12: ended by tolerance", trained
    )
    assert "strains accepted" in trained
    table = read_table(rod / "history.csv")
    force = {
        time: abs(table["contact_1_force_r"][np.isclose(table["time"], time)][0]) for time in (12, 60, 66, 72)
    }
    assert [f"{value:.0f}" for value in force.values()] == ["7563", "4771", "0", "4809"]
    assert force[12] == -table["contact_1_force_r"].min()
    slow = read_table(results / "slow" / "history.csv")
    assert -slow["contact_1_force_r"].min() == pytest.approx(6890, rel=2e-3)


def test_tutorial_of_the_clamp(clamp_part, clamp):
    """Numbers that the tutorial names: the bolt that creeps, and is tightened again."""
    _, results = clamp_part
    table = read_table(clamp / "history.csv")
    at = table["contact_2_force_z"][np.isclose(table["time"], 1000)]
    assert [f"{value:.0f}" for value in (table["contact_2_force_z"][0], *at)] == ["4911", "2941", "2336"]
    again = read_table(results / "again" / "history.csv")
    at = [again["contact_2_force_z"][np.isclose(again["time"], time)][0] for time in (500, 502, 1000)]
    assert at == pytest.approx([3060, 4510, 3060], rel=3e-3)
    assert again["error_estimate"][-1] < 0.005


def test_pictures_of_the_tutorial(signorom, rod_part, clamp_part):
    """All that it names."""
    _, results = rod_part
    names = ["pcmi/figures/histories.png", "pcmi/figures/errors_over_time.png", "pcmi/figures/animation.gif"]
    check_pictures(signorom, results, *names, "slow/figures/histories.png")
    _, results = clamp_part
    names = ["clamp_creep/figures/hysteresis.png", "clamp_creep/figures/check_bodies.png"]
    check_pictures(signorom, results, *names, "again/figures/histories.png")
