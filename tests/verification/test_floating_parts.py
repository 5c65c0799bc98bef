# SPDX-License-Identifier: BSD-3-Clause
"""Two unsymmetric parts that only contact holds, in the plane and in space, as their decks stand: full order.

Forces of all contacts at random points and at the corners of the box against an independent code (a quadratic program in
lambda), each solver against it, and the equilibrium of the contact forces with the loads.
"""

import itertools

import numpy as np
import pytest
import yaml

from floating_parts import Bracket, Saddle
from runs import INPUT, read_snapshots, read_table, write_input

SEED = 1495
N_POINTS = 200
# active_set factors K anew in each step; at all points with --all-points
N_CHOSEN = {"bracket": 20, "saddle": 6}
PATIENCE = 7200  # s
# Both codes are exact but for rounding: what is left is the conditioning of K.
SAME_SOLUTION = 1e-8
BALANCE = 1e-9
PARTS = {"bracket": Bracket, "saddle": Saddle}
PROBLEM = {"bracket": "bracket beside a wall, plane strain, T3", "saddle": "saddle on two feet, T4"}


@pytest.fixture(scope="module", params=PARTS)
def part(request):
    """Name, independent code and points of a part; its forces there."""
    reference = PARTS[request.param]()
    points = draw_points(request.param)
    return request.param, reference, points, np.array([reference.forces(*point) for point in points])


def draw_points(name):
    """The corners of the box of a deck, then random points in it."""
    print("seed", SEED)
    ranges = yaml.safe_load((INPUT / f"{name}.yaml").read_text())["parameters"]
    assert tuple(ranges) == PARTS[name].names
    corners = np.array(list(itertools.product(*((entry["min"], entry["max"]) for entry in ranges.values()))))
    draw = np.random.default_rng(SEED)
    inside = draw.uniform(corners[0], corners[-1], (N_POINTS - len(corners), len(ranges)))
    return np.vstack([corners, inside])


def sample(signorom, folder, name, points, solver=None, n_ranks=1, **limits):
    """Snapshots of a deck at points."""
    folder.mkdir(exist_ok=True)
    deck = write_input(name, folder, {"training: {sobol: 200}": "training: {file: points.csv}"})
    if solver:
        deck.write_text(f"{deck.read_text()}solver: {{type: {solver}}}\n")
    lines = [",".join(PARTS[name].names), *(",".join(map(repr, point)) for point in points.tolist())]
    (folder / "points.csv").write_text("\n".join([*lines, ""]))
    signorom("sample", deck, folder=folder, n_ranks=n_ranks, **limits)
    snapshots = read_snapshots(folder / "results" / name / "snapshots.h5")
    assert (snapshots["reasons"] > 0).all()
    np.testing.assert_allclose(snapshots["parameters"], points, rtol=1e-12, atol=1e-12)
    return snapshots


def largest_error(found, expected):
    """Of the points, each relative to its own forces."""
    return (np.linalg.norm(found - expected, axis=1) / np.linalg.norm(expected, axis=1)).max()


def test_parts_are_not_simple(part):
    """Contacts open and close with the point, hundreds of different sets, two patches at least under load."""
    name, reference, points, expected = part
    is_closed = expected > 1e-9 * expected.max()
    n_closed = is_closed.sum(axis=1)
    assert n_closed.max() > 1.5 * n_closed.min()
    assert len(np.unique(is_closed, axis=0)) > 0.4 * len(points)
    assert is_closed.any(axis=0).sum() > is_closed.all(axis=0).sum() + 20
    assert reference.problem.motions.shape[1] == 3
    print(name, "closed", n_closed.min(), n_closed.max(), "of", expected.shape[1])


def test_forces_are_those_of_another_code(signorom, tmp_path, part, figures):
    """The solver that the program chooses for a sweep, at all points."""
    name, _, points, expected = part
    found = sample(signorom, tmp_path, name, points)["multipliers"]
    worst = largest_error(found, expected)
    figures.at_most(
        PROBLEM[name], f"forces at {N_POINTS} points", worst, SAME_SOLUTION, "an independent code"
    )


@pytest.mark.parametrize("n_ranks", [1, 2])
def test_active_set_agrees(signorom, tmp_path, part, figures, n_ranks):
    """Without condensation, at some of the points; none is a start for the next one's neighborhood."""
    name, _, points, expected = part
    chosen = slice(0, N_CHOSEN[name] // n_ranks)
    found = sample(signorom, tmp_path, name, points[chosen], "active_set", n_ranks)["multipliers"]
    worst = largest_error(found, expected[chosen])
    quantity = f"forces by active_set, ranks: {n_ranks}"
    figures.at_most(PROBLEM[name], quantity, worst, SAME_SOLUTION, "an independent code")


def test_contact_forces_balance_the_loads(signorom, tmp_path, part, figures):
    """R'B' lambda = R'F for each motion that only contact holds, relative to the sizes of its parts."""
    name, reference, points, _ = part
    chosen = points[:50]
    found = sample(signorom, tmp_path, name, chosen, n_ranks=2)["multipliers"]
    work, motions = reference.problem.work[:, reference.order], reference.problem.motions
    worst = 0.0
    for point, forces in zip(chosen, found, strict=True):
        arguments = point if name == "bracket" else point[:2]
        load = reference.load(*arguments)
        size = np.abs(work) @ forces + np.abs(motions).T @ np.abs(load)
        worst = max(worst, np.abs((work @ forces - motions.T @ load) / size).max())
    figures.at_most(PROBLEM[name], "contact forces against loads", worst, BALANCE, "equilibrium")


def predict(signorom, folder, name, points):
    """Forces of all contacts that `run` with all defaults and then `predict` give."""
    signorom("run", write_input(name, folder), folder=folder)
    lines = [",".join(PARTS[name].names), *(",".join(map(repr, point)) for point in points.tolist())]
    (folder / "asked.csv").write_text("\n".join([*lines, ""]))
    model = folder / "results" / name / "model.h5"
    signorom("predict", model, "--points", "asked.csv", "--output", "answers.csv", folder=folder)
    answers = read_table(folder / "answers.csv")
    assert set(answers["status"]) == {"answered"}
    return np.column_stack([values for column, values in answers.items() if column.startswith("lambda_")])


def test_default_model_is_exact(signorom, tmp_path, part, figures, pytestconfig):
    """No key of solver or reduction in the deck: every point is answered, with the forces of the full order."""
    name, _, points, expected = part
    found = predict(signorom, tmp_path, name, points)
    source = "an independent code"
    figures.at_most(
        PROBLEM[name],
        f"forces of predict at {N_POINTS} points",
        largest_error(found, expected),
        SAME_SOLUTION,
        source,
    )
    if not pytestconfig.getoption("--all-points"):
        return  # test_active_set_agrees has some of them
    active = sample(signorom, tmp_path / "active", name, points, "active_set", time_limit=PATIENCE)
    worst = largest_error(found, active["multipliers"])
    quantity = f"forces of predict at {N_POINTS} points"
    figures.at_most(PROBLEM[name], quantity, worst, SAME_SOLUTION, "solver active_set")
