# SPDX-License-Identifier: BSD-3-Clause
"""Flat rigid punch: the force distribution away from the edges converges with order 1."""

import numpy as np
import pytest

import punch
from gmsh_ascii import read_mesh
from gmsh_mesh import make_mesh
from patch_test import tributary_lengths
from runs import MESHES, solve_input

PROBLEM = "flat rigid punch on half-plane"
N_FACE = (8, 16, 32, 64)
# The displacement near the edge goes with the root of the distance; linear elements see that error, of order twice the
# exponent 1/2, everywhere.
LOWEST_ORDER = 0.9
# largest error of the finest mesh in the L2 norm over |x| <= 0.8 a; the block is 100 a
FINEST = 0.01


@pytest.fixture(scope="module")
def contacts(signorom, tmp_path_factory):
    """Sorted positions and forces of four meshes, each half as coarse as the one before."""
    found = []
    for n_face in N_FACE:
        folder = tmp_path_factory.mktemp(f"punch_{n_face}")
        mesh = read_mesh(make_mesh(MESHES / "punch.geo", folder / "punch.msh", n_face=n_face))
        (fields,), _ = solve_input(signorom, "punch", folder, {str(MESHES / "punch.msh"): "punch.msh"})
        x = mesh.coordinates[mesh.nodes_of["block_face"], 0]
        order = np.argsort(x)
        found.append((x[order], fields["multipliers_full_order"][order]))
    return found


def errors(x, forces):
    """Pressure error over |x| <= 0.8 a (L2, relative) and |x| <= 0.5 a (largest, relative to the middle)."""
    load, lengths = 2 * forces.sum(), tributary_lengths(x)
    exact = punch.nodal_forces(x, 1.0, load) / lengths
    difference = forces / lengths - exact
    is_far, is_middle = x <= 0.8 + 1e-9, x <= 0.5 + 1e-9
    norms = [np.sqrt(np.sum((values**2 * lengths)[is_far])) for values in (difference, exact)]
    return norms[0] / norms[1], np.abs(difference[is_middle]).max() / punch.pressure(0.0, 1.0, load)


def test_punch_is_closed_everywhere(contacts):
    """A flat punch presses with all its nodes, most at the edge."""
    for x, forces in contacts:
        assert (forces > 0).all()
        assert (forces / tributary_lengths(x)).argmax() == len(x) - 1


def test_distribution_converges(contacts, figures):
    """Order of both error measures from mesh to mesh."""
    measured = np.array([errors(*contact) for contact in contacts])
    orders = np.log2(measured[:-1] / measured[1:])
    print("errors (L2 to 0.8 a, largest to 0.5 a)", *measured, "orders", *orders, sep="\n")
    source = "P' / (pi sqrt(a^2 - x^2))"
    figures.at_most(PROBLEM, "pressure to 0.8 a, L2 error with 64 edges", measured[-1, 0], FINEST, source)
    for order, n_face in zip(orders[:, 0], N_FACE[1:], strict=True):
        name = f"order of that, {n_face // 2} to {n_face} edges"
        figures.at_least(PROBLEM, name, order, LOWEST_ORDER, "singular edge", reference=1.0)
    mean = np.log2(measured[0, 1] / measured[-1, 1]) / (len(N_FACE) - 1)
    name = "mean order of the largest error to 0.5 a"
    figures.at_least(PROBLEM, name, mean, LOWEST_ORDER, "singular edge", reference=1.0)
