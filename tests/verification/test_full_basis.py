# SPDX-License-Identifier: BSD-3-Clause
"""Consistency: all modes on the whole mesh reproduce the full-order model.

A solution is the response to the prescribed values plus K^-1 B' lambda: with as many independent snapshots as
contact pairs, the modes span every solution in the box, not only the training points.
"""

import h5py
import numpy as np
import pytest

from runs import read_snapshots, read_table, write_deck

N_CELLS = 48
N_PAIRS = 7
N_MOVED_ENDS = 2
# Rounding of the snapshots over the smallest singular value kept, 1e-4 of the first (check_formulas.py).
TOLERANCE = 1e-9


CASES = {
    "elastic_lifting": "elastic_lifting",
    "multiplier": "multiplier",
    # hats that a complete basis does not need
    "elastic_lifting, enriched": "elastic_lifting\n  enrichment: {type: greedy, max_condition_number: 1}",
}


@pytest.fixture(scope="module", params=list(CASES))
def results(request, signorom, tmp_path_factory):
    """Folder with the results of both treatments of the prescribed values and of an enriched basis, and which."""
    folder = tmp_path_factory.mktemp("full_basis")
    change = {"dirichlet: elastic_lifting": f"dirichlet: {CASES[request.param]}"}
    signorom("run", write_deck("full_basis", folder, **change), folder=folder)
    return folder / "results" / "full_basis", request.param


def test_domain_is_the_whole_mesh(results):
    """Every cell, every contact row, no interface; one mode per pair, one per moved end with `multiplier`."""
    folder, treatment = results
    with h5py.File(folder / "model.h5") as file:
        cluster = file["clusters/1"]
        assert cluster["cells"].shape == (N_CELLS,)
        assert cluster["contact_rows"][()].tolist() == list(range(1, N_PAIRS + 1))
        assert cluster["interface_dofs"].shape == (0,)
        # the two prescribed rows take their two modes away again
        n_hats = N_PAIRS if "enriched" in treatment else 0
        assert cluster.attrs["n_hats"] == n_hats
        assert cluster["basis"].shape[0] == N_PAIRS + n_hats
        values = cluster["singular_values"][()]
    n_modes = N_PAIRS + (N_MOVED_ENDS if treatment == "multiplier" else 0)
    assert (values > 1e-10 * values[0]).sum() == n_modes


def test_answers_are_the_full_order_ones(results, figures):
    """Displacement, multipliers and energy at 81 points, 36 of which or fewer were trained."""
    folder, _ = results
    table = read_table(folder / "validation.csv")
    assert len(table["e_u"]) == 81
    has_contact = table["n_active_full_order"] > 0
    assert has_contact.sum() > 70
    assert not has_contact.all()
    problem, source = "all modes, whole mesh as RID", "full-order model"
    worst = {name: np.nanmax(table[name][has_contact]) for name in ("e_lambda_rid", "e_lambda_all")}
    for name, value in {"e_u": table["e_u"].max(), **worst}.items():
        figures.at_most(problem, f"{name}, largest of 81 points, {results[1]}", value, TOLERANCE, source)
    # both stamps equally far: a rigid motion, whose energy is rounding in both models
    assert table["e_energy_relative"][has_contact].max() <= TOLERANCE
    assert table["e_energy"].max() <= TOLERANCE
    np.testing.assert_array_equal(table["n_active"], table["n_active_full_order"])


def test_reduced_stiffness_is_symmetric_on_the_whole_mesh(results):
    """V' K V of the whole mesh is symmetric; only a part of the mesh makes (10) unsymmetric."""
    folder, _ = results
    with h5py.File(folder / "model.h5") as file:
        stiffness = file["clusters/1/reduced_stiffness"][()]
    np.testing.assert_allclose(stiffness, stiffness.T, rtol=0, atol=1e-12 * np.abs(stiffness).max())
    assert np.linalg.eigvalsh(0.5 * (stiffness + stiffness.T)).min() > 0


def test_snapshots_satisfy_the_contact_conditions(results):
    """Equilibrium, penetration, sign and complementarity of every snapshot."""
    folder, _ = results
    snapshots = read_snapshots(folder / "snapshots.h5")
    assert snapshots["multipliers"].min() >= 0
    assert np.abs(snapshots["residuals"]).max() <= 1e-9
