# SPDX-License-Identifier: BSD-3-Clause
"""1000 seeded load cases on the mesh of case b: every one converges, from near and from far, and the solvers agree."""

import numpy as np
import pytest

from gmsh_ascii import read_mesh
from random_loads import N_CASES, SAME_SOLUTION, SEED, SMALL_RESIDUAL, draw_cases, largest_difference, sample
from runs import ROOT

PROBLEM = "case b under random loads"
# closed pairs all start closed in the active set: the first two cases of these have hardly any in the end
CHOSEN = (16, 86, 333, 666, 999)
# [s] all cases by active_set take minutes, on a busy machine more
TIME_LIMIT = 36000


@pytest.fixture(scope="module")
def condensed(signorom, tmp_path_factory):
    """All cases by the condensed solver, each from the closed pairs of the case before, which says nothing about it."""
    print("seed", SEED)
    return sample(signorom, tmp_path_factory.mktemp("random") / "condensed", "condensed", draw_cases())


def test_all_cases_converge(condensed, figures):
    """Signs, equilibrium, penetration and complementarity, measured with K itself and not with the condensed problem."""
    assert (condensed["reasons"] > 0).all()
    assert condensed["multipliers"].min() >= 0
    worst = np.abs(condensed["residuals"]).max()
    figures.at_most(PROBLEM, "residuals of 1000 cases", worst, SMALL_RESIDUAL, "the equations (3)")


def test_cases_are_not_alike(condensed):
    """No contact, contact in one zone and in two; hundreds of different sets of closed pairs."""
    mesh = read_mesh(ROOT / "meshes" / "pellet_cladding.msh")
    by_height = np.argsort(mesh.coordinates[mesh.nodes_of["fuel_surface"], 1])
    is_closed = condensed["multipliers"][:, by_height] > 0
    n_closed = is_closed.sum(axis=1)
    n_zones = (np.diff(is_closed.astype(int), axis=1, prepend=0) == 1).sum(axis=1)
    assert n_closed.min() == 0
    assert n_closed.max() > 60
    assert {1, 2} <= set(n_zones)
    assert len(np.unique(is_closed, axis=0)) > 300


def test_order_of_the_cases_does_not_matter(signorom, tmp_path, condensed):
    """Backwards every case starts from another set."""
    backwards = sample(signorom, tmp_path / "backwards", "condensed", draw_cases()[:300][::-1])
    forwards = {name: condensed[name][:300][::-1] for name in ("displacement", "multipliers")}
    assert (backwards["reasons"] > 0).all()
    assert largest_difference(backwards, forwards) < SAME_SOLUTION


def test_active_set_agrees(signorom, tmp_path, condensed, figures, pytestconfig):
    """Some cases; all with --all-points."""
    is_long = pytestconfig.getoption("--all-points")
    chosen = [*CHOSEN, *(i for i in range(N_CASES) if is_long and i not in CHOSEN)]
    active = sample(signorom, tmp_path / "active_set", "active_set", draw_cases()[chosen], TIME_LIMIT)
    assert (active["reasons"] > 0).all()
    assert (condensed["multipliers"][chosen[:2]] > 0).sum(axis=1).max() < 20
    expected = {name: condensed[name][chosen] for name in ("displacement", "multipliers")}
    difference = largest_difference(active, expected)
    figures.at_most(
        PROBLEM, "u and lambda, active_set and condensed", difference, SAME_SOLUTION, "each other"
    )
