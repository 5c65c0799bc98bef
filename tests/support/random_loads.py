# SPDX-License-Identifier: BSD-3-Clause
"""Seeded load cases of tests/verification/decks/random_loads.yaml."""

import numpy as np

from decks import copy_deck
from program import ROOT, TIME_LIMIT
from results import read_snapshots

SEED = 1495
N_CASES = 1000
NAMES = ("P1", "P2", "shear", "low1", "low2", "width1", "width2")
# [-] what a solution leaves, relative; [mm] for the penetration
SMALL_RESIDUAL = 1e-9
# Both solvers are exact but for rounding: what is left is the conditioning of the stiffness.
SAME_SOLUTION = 1e-8


def draw_cases():
    """Returns the load cases, shape (N_CASES, 7), the same in each call; columns as NAMES.

    Of every tenth case, the first one included, pressures and shear are 2 % of the others, so that a few pairs close or
    none.
    """
    draw = np.random.default_rng(SEED)
    lower = np.array([-50.0, -150.0, -40.0, 0.0, 0.0, 0.02, 0.02])
    upper = np.array([300.0, 300.0, 40.0, 6.5, 6.5, 7.0, 7.0])
    cases = draw.uniform(lower, upper, (N_CASES, len(NAMES)))
    cases[::10, :3] *= 0.02
    return cases


def sample(program, folder, solver, cases, time_limit=TIME_LIMIT):
    """Runs `sample` with a solver type at the cases in `folder`, and returns read_snapshots of the result.

    AssertionError unless the exit code is 0, that is, all cases have converged.
    """
    folder.mkdir(exist_ok=True)
    deck = copy_deck(
        ROOT / "tests" / "verification" / "decks" / "random_loads.yaml",
        folder,
        **{"type: condensed": f"type: {solver}"},
    )
    rows = [",".join(map(repr, map(float, case))) for case in cases]
    (folder / "points.csv").write_text("\n".join([",".join(NAMES), *rows, ""]))
    program("sample", deck, folder=folder, time_limit=time_limit)
    snapshots = read_snapshots(folder / "results" / "random_loads" / "snapshots.h5")
    np.testing.assert_allclose(snapshots["parameters"], cases, rtol=1e-12, atol=1e-12)
    return snapshots


def largest_difference(one, other):
    """Returns the largest difference of a displacement or contact force in two snapshot sets.

    Each of the two is relative to the largest absolute value in all cases of `other`.
    """
    return max(
        np.abs(one[name] - other[name]).max() / np.abs(other[name]).max()
        for name in ("displacement", "multipliers")
    )
