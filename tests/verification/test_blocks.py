# SPDX-License-Identifier: BSD-3-Clause
"""Two blocks in space under a pressure on part of the top: uniform stress, resultant and its place by equilibrium."""

import numpy as np
import pytest

from runs import solve_input

PROBLEMS = {1: "two blocks in space, H8", 3: "the same on three ranks"}
# [mm] half width of the blocks, depth of the half, height of one
HALF_WIDTH, DEPTH, HEIGHT = 10.0, 10.0, 10.0
# [MPa] of the deck: lower and upper block
MATERIALS = ((70e3, 0.34), (210e3, 0.3))
PRESSURE = 50.0
POINTS = "points: [{P: 50, edge: -10}, {P: 50, edge: 4.5}]"
EDGES = (-10.0, -7.3, 0.0, 4.5, 6.0)
# Uniform stress is in the span of the elements, and a window is integrated exactly: what is left is rounding.
ROUNDING = 1e-10
BALANCE = 1e-9


@pytest.fixture(scope="module", params=[1, 3], ids=["one_rank", "three_ranks"])
def answers(request, signorom, tmp_path_factory):
    """Fields, node coordinates and nodes of the multipliers at each edge, on one and three ranks; the report."""
    import h5py

    folder = tmp_path_factory.mktemp("blocks")
    points = ", ".join(f"{{P: {PRESSURE}, edge: {edge}}}" for edge in EDGES)
    changes = {POINTS: f"points: [{points}]"}
    fields, report = solve_input(signorom, "blocks", folder, changes, n_ranks=request.param)
    with h5py.File(folder / "results" / "blocks" / "fields.h5") as file:
        rows = [file[f"contact/{side}/nodes"][()] - 1 for side in ("first", "second")]
        return fields, file["mesh/coordinates"][()], rows, report


def test_whole_top_gives_uniform_stress(answers, figures):
    """Edge at the left end: uniaxial stress P in both blocks, contact pressure P, linear displacement."""
    fields, x, (rows, second_rows), report = answers
    problem = PROBLEMS[report["sizes"]["n_ranks"]]
    first = fields[0]
    worst = np.abs(first["contact_pressure"][rows] / PRESSURE - 1).max()
    figures.at_most(
        problem, "contact pressure against the pressure on top", worst, ROUNDING, "uniaxial stress"
    )
    is_lower = x[:, 2] < HEIGHT / 1e6
    is_lower[second_rows] = False
    (below, nu_below), (above, nu_above) = MATERIALS
    sink = np.where(is_lower, (x[:, 2] + HEIGHT) / below, HEIGHT / below + x[:, 2] / above)
    # held at x = -10 and y = 0
    spread = np.where(is_lower, nu_below / below, nu_above / above)
    expected = PRESSURE * np.stack([spread * (x[:, 0] + HALF_WIDTH), spread * x[:, 1], -sink], axis=1)
    worst = np.abs(first["displacement"] - expected).max() / np.abs(expected).max()
    figures.at_most(problem, "displacement, largest difference", worst, ROUNDING, "uniaxial stress")


def test_window_is_integrated_exactly(answers, figures):
    """Resultant P (10 - edge) depth, at x = (10 + edge) / 2: the pairs carry both, whichever are closed."""
    fields, x, (rows, _), report = answers
    problem = PROBLEMS[report["sizes"]["n_ranks"]]
    errors, n_open = [], []
    for edge, answer, point in zip(EDGES, fields, report["points"].values(), strict=True):
        forces = answer["multipliers_full_order"]
        load = PRESSURE * (HALF_WIDTH - edge) * DEPTH
        reactions = {entry["boundary"]: entry for entry in point["reactions"].values()}
        errors.append(
            [
                reactions["base"]["z"] / load - 1,
                forces.sum() / load - 1,
                (forces @ x[rows, 0] / load - (HALF_WIDTH + edge) / 2) / HALF_WIDTH,
            ]
        )
        for name, axis in (("front", "y"), ("corners", "x")):
            assert abs(reactions[name][axis]) <= BALANCE * load
        n_open.append((forces == 0).sum())
    errors = np.abs(errors).max(axis=0)
    figures.at_most(
        problem, "reaction against the resultant of the windows", errors[0], BALANCE, "equilibrium"
    )
    figures.at_most(problem, "contact force against the resultant", errors[1], BALANCE, "equilibrium")
    figures.at_most(
        problem, "place of the contact force along x, over the width", errors[2], BALANCE, "equilibrium"
    )
    # the farther right the load, the more of the left end lifts
    assert n_open == sorted(n_open)
    assert n_open[0] == 0 < n_open[-1]
