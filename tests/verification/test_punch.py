# SPDX-License-Identifier: BSD-3-Clause
"""Flat rigid punch (verification.md D10): the force distribution away from the edges converges with order 1."""

import numpy as np
import pytest

import punch
from gmsh_ascii import read_mesh
from gmsh_mesh import make_mesh
from patch_test import tributary_lengths
from runs import HERE, read_snapshots, write_deck

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
        deck = write_deck("punch", folder)
        mesh = read_mesh(make_mesh(HERE / "meshes" / "punch.geo", folder / "punch.msh", n_face=n_face))
        signorom("sample", deck, folder=folder)
        snapshots = read_snapshots(folder / "results" / "punch" / "snapshots.h5")
        assert (snapshots["reasons"] > 0).all()
        x = mesh.coordinates[mesh.nodes_of["block_face"], 0]
        order = np.argsort(x)
        found.append((x[order], snapshots["multipliers"][-1][order]))
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


def test_distribution_converges(contacts):
    """Order of both error measures from mesh to mesh."""
    measured = np.array([errors(*contact) for contact in contacts])
    orders = np.log2(measured[:-1] / measured[1:])
    print("errors (L2 to 0.8 a, largest to 0.5 a)", *measured, "orders", *orders, sep="\n")
    assert measured[-1, 0] <= FINEST
    assert (orders[:, 0] >= LOWEST_ORDER).all()
    assert np.log2(measured[0, 1] / measured[-1, 1]) / (len(N_FACE) - 1) >= LOWEST_ORDER
