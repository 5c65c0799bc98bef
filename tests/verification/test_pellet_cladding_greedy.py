# SPDX-License-Identifier: BSD-3-Clause
"""Case b, points selected greedily: projection errors against NumPy, the error bound against the errors it bounds."""

import re

import numpy as np

from runs import read_snapshots, read_table, write_input

PROBLEM = "case b, greedy selection"
INITIAL = 10
# [-] seven digits in the table
SAME_DIGITS = 1e-5
TRAINING = (
    "training: {greedy: {candidates: {sobol: 2000}, indicator: projection, initial: 10, max_points: 200}}"
)


def select(signorom, folder, greedy):
    """selection.csv as columns, the largest indicator left, and the results folder."""
    changes = {TRAINING: f"training: {{greedy: {{{greedy}, initial: {INITIAL}}}}}"}
    deck = write_input("pellet_cladding_greedy", folder, changes)
    signorom("sample", deck, folder=folder)
    results = folder / "results" / deck.stem
    text = (results / "selection.csv").read_text()
    lines = text.splitlines(keepends=True)
    (folder / "selection.csv").write_text("".join(line for line in lines if not line.startswith("#")))
    left = float(re.search(r"largest indicator left (\S+)", text).group(1))
    return read_table(folder / "selection.csv"), left, results


def test_projection_errors_are_those_of_numpy(signorom, tmp_path, figures):
    """Distance of 300 solutions from the span of the 40 chosen ones, by a QR factorization."""
    table, left, results = select(signorom, tmp_path, "candidates: {sobol: 300}, max_points: 40")
    assert len(table["order"]) == 40
    pool = read_snapshots(results / "candidates.h5")
    vectors = (pool["displacement"] / np.linalg.norm(pool["displacement"], axis=1)[:, None]).T
    points = np.array([table["P1"], table["h1"]]).T
    chosen = [int(np.flatnonzero((pool["parameters"] == point).all(axis=1))[0]) for point in points]
    basis, _ = np.linalg.qr(vectors[:, chosen])
    rest = vectors - basis @ (basis.T @ vectors)
    largest = np.linalg.norm(rest - basis @ (basis.T @ rest), axis=0).max()
    figures.compare(
        PROBLEM, "largest projection error of 300, 40 chosen", left, largest, SAME_DIGITS, "NumPy, QR"
    )
    assert (np.diff(table["indicator"][INITIAL:]) <= SAME_DIGITS * table["indicator"][INITIAL]).all()


def test_bound_is_never_below_the_error(signorom, tmp_path, figures):
    """Energy errors of displacement and forces where the model was worst, in four rounds, over their bound."""
    greedy = "candidates: {sobol: 200}, indicator: defect, max_points: 50, batch: 10"
    table, _, _ = select(signorom, tmp_path, greedy)
    error = np.maximum(table["error_u"], table["error_lambda"])[INITIAL:]
    bound = table["indicator"][INITIAL:]
    assert len(error) == 40
    answered = np.isfinite(bound)
    assert answered.sum() > 20
    assert (error[answered] > 0).all()
    ratio = (error[answered] / bound[answered]).max()
    figures.at_most(PROBLEM, "energy error over its bound, 40 points", ratio, 1, "triangle inequality")
