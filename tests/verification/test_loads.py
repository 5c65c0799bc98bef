# SPDX-License-Identifier: BSD-3-Clause
"""Bars under pressure, traction and weight: displacements by formula, reactions that balance the loads."""

import numpy as np
import pytest
import yaml

import bar_with_gap as bar
import patch_test
from gmsh_ascii import read_mesh
from runs import HERE, read_fields, write_deck

# Uniaxial fields are in the span of linear elements: what is left is rounding.
TOLERANCE = 1e-10
PUSH = 1.5


def solve(signorom, folder, **replacements):
    """Displacement (n_nodes, 2) and the report's first point."""
    deck = write_deck("loaded_bars", folder, **replacements)
    signorom("solve", deck, folder=folder)
    results = folder / "results" / "loaded_bars"
    report = yaml.safe_load((results / "report.yaml").read_text())
    return read_fields(results / "fields.h5")["displacement"][:, :2], report["points"]["1"]


@pytest.fixture(scope="module")
def mesh():
    """The mesh by the reference's reader."""
    return read_mesh(HERE / "meshes" / "bar_with_gap.msh")


@pytest.mark.parametrize("solver", ["condensed", "active_set", "snesvi"])
def test_pressure_and_traction_compress_the_bars(signorom, tmp_path, mesh, solver):
    """u = p (distance from the held end) / E, away from the other bar."""
    u, point = solve(signorom, tmp_path, **{"type: condensed": f"type: {solver}"})
    y = mesh.coordinates[:, 1]
    expected = np.where(
        y < bar.GAP / 2,
        -PUSH * (y + bar.LOWER_HEIGHT) / bar.LOWER_MODULUS,
        PUSH * (bar.GAP + bar.UPPER_HEIGHT - y) / bar.UPPER_MODULUS,
    )
    scale = np.abs(expected).max()
    np.testing.assert_allclose(u[:, 1], expected, rtol=0, atol=TOLERANCE * scale)
    np.testing.assert_allclose(u[:, 0], 0, rtol=0, atol=TOLERANCE * scale)
    assert point["n_active"] == 0
    x = mesh.coordinates[:, 0]
    resultant = PUSH * (x.max() - x.min())
    assert [reaction["boundary"] for reaction in point["reactions"].values()] == ["lower_base", "upper_base"]
    assert point["reactions"]["1"]["y"] == pytest.approx(resultant, rel=1e-9)
    assert point["reactions"]["2"]["y"] == pytest.approx(-resultant, rel=1e-9)
    assert point["residuals"]["force_balance"] <= 1e-9
    assert point["residuals"]["equilibrium"] <= 1e-9


def test_weight_of_a_bar(signorom, tmp_path, mesh):
    """The mean displacement of the free end is f h^2 / (2 E) exactly: a field linear in y is a test function."""
    loads = "  - {region: lower, body_force: {y: -push}}\n  - {region: lower, body_force: {y: 0.5 * (1 + y)}}"
    old = "  - {boundary: lower_face, pressure: push}"
    u, point = solve(signorom, tmp_path, **{old: loads})
    nodes = mesh.nodes_of["lower_face"]
    lengths = patch_test.tributary_lengths(mesh.coordinates[nodes, 0])
    mean = lengths @ u[nodes, 1] / lengths.sum()
    # the second force grows from the held end, s (1 + y): s h^3 / (3 E)
    expected = -PUSH * bar.LOWER_HEIGHT**2 / (2 * bar.LOWER_MODULUS) + 0.5 * bar.LOWER_HEIGHT**3 / (
        3 * bar.LOWER_MODULUS
    )
    assert mean == pytest.approx(expected, rel=1e-9)
    assert point["residuals"]["force_balance"] <= 1e-9


def test_displacements_may_depend_on_the_place(signorom, tmp_path, mesh):
    """A patch test by prescribed values: u = push (x, y) on the lower bar's ends, expression by expression."""
    u, _ = solve(
        signorom,
        tmp_path,
        **{
            "lower_base, displacement: {x: 0.0, y: 0.0}": "lower_base, "
            'displacement: {x: "1e-3*push*x", y: "1e-3*push*y"}',
            "  - {boundary: upper_base": '  - {boundary: lower_face, displacement: {x: "1e-3*push*x", y: "1.5e-3*y"}}\n'
            "  - {boundary: upper_base",
        },
    )
    for name in ("lower_base", "lower_face"):
        nodes = mesh.nodes_of[name]
        np.testing.assert_allclose(u[nodes], 1.5e-3 * mesh.coordinates[nodes, :2], rtol=0, atol=1e-15)
