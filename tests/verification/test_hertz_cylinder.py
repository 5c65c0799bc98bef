# SPDX-License-Identifier: BSD-3-Clause
"""Cylinder on a block (NAFEMS): half-width by a fit, peak pressure, elliptical distribution."""

import numpy as np
import pytest

import hertz
from gmsh_ascii import read_mesh
from patch_test import tributary_lengths
from runs import MESHES, solve_deck, solve_input, write_input

PROBLEM = "NAFEMS cylinder on block, plane strain"
# [N/mm] output points of the deck
LOADS = (5e3, 15e3, 25e3, 35e3)
# Finite bodies cost about 1 % against Hertz: R is 8 half-widths, the block 16.
HERTZ = 0.02
SAME_SOLUTION = 1e-8
BALANCE = 1e-9
# The cylinder pushed down by its cut instead of loaded there: SNESVI needs every body held.
PUSHED = {
    "load: {min: 1.0e3, max: 35.0e3, unit: N/mm}": "load: {min: 0.2, max: 1.33, unit: mm}",
    "block_base, displacement: {y: 0}}": "block_base, displacement: {y: 0}}\n"
    "  - {boundary: cylinder_top, displacement: {y: -load}}",
    "loads:\n  - {boundary: cylinder_top, pressure: load / 100}": "#",
    "points: [{load: 5.0e3}, {load: 15.0e3}, {load: 25.0e3}, {load: 35.0e3}]": "points: [{load: 0.5}, {load: 1.3}]",
}


@pytest.fixture(scope="module")
def mesh():
    """The mesh by the reference's reader."""
    return read_mesh(MESHES / "hertz_cylinder.msh")


def solve(signorom, folder, solver, changes=None):
    """Fields and report of each load by one solver."""
    deck = write_input("hertz_cylinder", folder, changes)
    deck.write_text(f"{deck.read_text()}solver: {{type: {solver}}}\n")
    return solve_deck(signorom, deck)


@pytest.fixture(scope="module")
def answers(signorom, tmp_path_factory):
    """Fields and report of the four loads."""
    return solve_input(signorom, "hertz_cylinder", tmp_path_factory.mktemp("hertz"))


def measure(mesh, fields):
    """Fitted half-width and peak, position and pressure of the closed nodes."""
    # the order of the multipliers is that of the first surface's nodes
    x = mesh.coordinates[mesh.nodes_of["block_face"], 0]
    pressure = fields["multipliers_full_order"] / tributary_lengths(x)
    is_closed = pressure > 0
    x, pressure = x[is_closed], pressure[is_closed]
    order = np.argsort(x)
    return *hertz.fit(x, pressure), x[order], pressure[order]


def test_figures_of_the_benchmark(answers, mesh, figures):
    """35 kN per mm: a = 6.2146 mm, p0 = 3585.37 MPa."""
    half_width, peak, x, pressure = measure(mesh, answers[0][-1])
    assert x[1] - x[0] <= half_width / 30
    source = "Hertz; NAFEMS (Konter 2006)"
    figures.compare(PROBLEM, "half-width a at 35 kN/mm", half_width, 6.2146, HERTZ, source, "mm")
    figures.compare(PROBLEM, "peak p0 of the fit", peak, 3585.37, HERTZ, source, "MPa")
    figures.compare(PROBLEM, "largest nodal pressure", pressure.max(), 3585.37, HERTZ, source, "MPa")


def test_every_load_follows_hertz(answers, mesh):
    """At each load half-width, peak and pressure of one connected contact from the middle outwards."""
    modulus = hertz.contact_modulus(*hertz.NAFEMS_MATERIALS)
    for load, fields in zip(LOADS, answers[0], strict=True):
        half_width, peak, x, pressure = measure(mesh, fields)
        exact = hertz.Line(modulus, hertz.NAFEMS_RADIUS, load)
        print(f"{load} N/mm: a {half_width / exact.half_width - 1:+.2%}, p0 {peak / exact.peak - 1:+.2%}")
        assert half_width == pytest.approx(exact.half_width, rel=HERTZ)
        assert peak == pytest.approx(exact.peak, rel=HERTZ)
        np.testing.assert_allclose(np.diff(x), x[1] - x[0], rtol=1e-9)
        # the border of the contact is sharper than the mesh
        is_inside = x <= 0.9 * exact.half_width
        np.testing.assert_allclose(
            pressure[is_inside], exact.pressure(x[is_inside]), rtol=0, atol=HERTZ * exact.peak
        )


def test_contact_carries_the_load(answers, figures):
    """Half the load of the whole cylinder, at each load."""
    forces = np.array([fields["multipliers_full_order"].sum() for fields in answers[0]])
    worst = np.abs(forces / (np.array(LOADS) / 2) - 1).max()
    figures.at_most(PROBLEM, "contact force against load, relative", worst, BALANCE, "equilibrium")


@pytest.mark.parametrize(
    ("first", "second", "changes"),
    [("condensed", "active_set", {}), ("snesvi", "active_set", PUSHED)],
    ids=["loaded", "pushed"],
)
def test_solvers_agree(signorom, tmp_path, figures, first, second, changes):
    """The same forces and displacements by each solver."""
    found = []
    for solver in (first, second):
        folder = tmp_path / solver
        folder.mkdir()
        found.append(solve(signorom, folder, solver, changes)[0])
    worst = max(
        np.abs(b[name] - a[name]).max() / np.abs(a[name]).max()
        for name in ("multipliers_full_order", "displacement")
        for a, b in zip(*found, strict=True)
    )
    figures.at_most(PROBLEM, f"{first} against {second}, relative", worst, SAME_SOLUTION, "each other")
