# SPDX-License-Identifier: BSD-3-Clause
"""Cylinder on a block (verification.md D2, NAFEMS): half-width by a fit, peak pressure, elliptical distribution."""

import numpy as np
import pytest

import hertz
from gmsh_ascii import read_mesh
from patch_test import tributary_lengths
from runs import HERE, read_snapshots, write_deck

# Finite bodies cost about 1 % against Hertz: R is 8 half-widths, the block 16.
HERTZ = 0.02
SAME_SOLUTION = 1e-8
SOLVERS = ("condensed", "active_set", "snesvi")


def positions():
    """x of the contact nodes in the order of the multipliers, that of the first surface's nodes."""
    mesh = read_mesh(HERE / "meshes" / "hertz_cylinder.msh")
    return mesh.coordinates[mesh.nodes_of["block_face"], 0]


def sample(signorom, folder, solver):
    """Snapshots of 11 approaches."""
    deck = write_deck("hertz_cylinder", folder, **{"type: condensed": f"type: {solver}"})
    signorom("sample", deck, folder=folder)
    return read_snapshots(folder / "results" / "hertz_cylinder" / "snapshots.h5")


@pytest.fixture(scope="module")
def snapshots(signorom, tmp_path_factory):
    """By the condensed solver."""
    return sample(signorom, tmp_path_factory.mktemp("hertz"), "condensed")


def measure(multipliers):
    """Load of the whole cylinder, fitted half-width and peak, position and pressure of the closed nodes."""
    x = positions()
    pressure = multipliers / tributary_lengths(x)
    is_closed = pressure > 0
    x, pressure = x[is_closed], pressure[is_closed]
    order = np.argsort(x)
    return 2 * multipliers.sum(), *hertz.fit(x, pressure), x[order], pressure[order]


def test_figures_of_the_benchmark(snapshots):
    """35 kN per mm: a = 6.2146 mm, p0 = 3585.37 MPa."""
    load, half_width, peak, _, pressure = measure(snapshots["multipliers"][-1])
    print(
        f"P' = {load:.1f} N/mm, a = {half_width:.4f} mm, p0 = {peak:.2f} MPa, max p = {pressure.max():.2f} MPa"
    )
    assert load == pytest.approx(hertz.NAFEMS_LOAD, rel=1e-4)
    assert half_width == pytest.approx(6.2146, rel=HERTZ)
    assert peak == pytest.approx(3585.37, rel=HERTZ)
    assert pressure.max() == pytest.approx(3585.37, rel=HERTZ)


def test_every_load_follows_hertz(snapshots):
    """At each approach: half-width, peak and pressure of the closed contact for the load found there."""
    modulus = hertz.contact_modulus(*hertz.NAFEMS_MATERIALS)
    for multipliers in snapshots["multipliers"]:
        load, half_width, peak, x, pressure = measure(multipliers)
        exact = hertz.Line(modulus, hertz.NAFEMS_RADIUS, load)
        assert half_width == pytest.approx(exact.half_width, rel=HERTZ)
        assert peak == pytest.approx(exact.peak, rel=HERTZ)
        # one connected contact from the middle outwards; its border is sharper than the mesh
        np.testing.assert_allclose(np.diff(x), x[1] - x[0], rtol=1e-9)
        is_inside = x <= 0.9 * exact.half_width
        np.testing.assert_allclose(
            pressure[is_inside], exact.pressure(x[is_inside]), rtol=0, atol=HERTZ * exact.peak
        )


@pytest.mark.parametrize("solver", SOLVERS[1:])
def test_solvers_agree(signorom, tmp_path, snapshots, solver):
    """The same forces and displacements by each solver."""
    other = sample(signorom, tmp_path, solver)
    assert (other["reasons"] > 0).all()
    for name in ("multipliers", "displacement"):
        limit = SAME_SOLUTION * np.abs(snapshots[name]).max()
        np.testing.assert_allclose(other[name], snapshots[name], rtol=0, atol=limit)
