# SPDX-License-Identifier: BSD-3-Clause
"""D12 in the plane: a quarter of two shrunk rings, paired along averaged normals, against Lamé."""

import numpy as np
import pytest

import shrink_fit
from block_meshes import Mesh
from lame import ThickCylinder
from runs import read_snapshots, write_deck

PROBLEM = "shrink fit in the plane, averaged normals"
# Moderate mesh: 5 cells per ring, 16 around the quarter.
LAME = 1e-2
SAME = 1e-10
SAME_SOLVER = 1e-8
INNER, MIDDLE, OUTER = shrink_fit.INNER / 2, shrink_fit.MIDDLE / 2, shrink_fit.OUTER / 2
FACE = MIDDLE + shrink_fit.INTERFERENCE / 2
SQUEEZE = 10.0


def rings(n_radial, n_around, swing=0.0):
    """Rings as blocks of radius and angle, bent round; swing makes the steps of the angle uneven."""
    part = np.linspace(0, 1, n_around + 1)
    angles = np.pi / 2 * (part + swing * np.sin(4 * np.pi * part) / (4 * np.pi))
    mesh = Mesh()
    for region, ends, faces in (
        ("inner_ring", (INNER, FACE), {(0, 1): "inner_face"}),
        ("outer_ring", (MIDDLE, OUTER), {(0, 0): "outer_face", (0, 1): "outside"}),
    ):
        radii = np.linspace(*ends, n_radial + 1)
        mesh.add_block(region, [radii, angles], "Q4", {**faces, (1, 0): "level", (1, 1): "upright"})
    radius, angle = mesh.coordinates[:, 0].copy(), mesh.coordinates[:, 1].copy()
    mesh.coordinates[:, 0] = np.where(angle == angles[-1], 0.0, radius * np.cos(angle))
    mesh.coordinates[:, 1] = radius * np.sin(angle)
    return mesh


def sample(signorom, folder, mesh, n_ranks=1, **changes):
    """Snapshots without and with the squeeze."""
    folder.mkdir(exist_ok=True)
    deck = write_deck("quarter_rings", folder, **changes)
    mesh.write(folder / "rings.msh")
    signorom("sample", deck, folder=folder, n_ranks=n_ranks)
    snapshots = read_snapshots(folder / "results" / "quarter_rings" / "snapshots.h5")
    assert (snapshots["reasons"] > 0).all()
    return snapshots


def exact_pressures():
    """Of the fit alone, and with what a squeeze brings to the one thick ring that both then are."""
    one = ThickCylinder(
        shrink_fit.YOUNG_MODULUS, shrink_fit.POISSON_RATIO, INNER, OUTER, outer_pressure=SQUEEZE, ends="free"
    )
    fit = shrink_fit.pressure("free")
    return np.array([fit, fit - one.stress(MIDDLE)[0]])


def pressures(snapshots, mesh):
    """Force over the mean of both sides' edges, half of one at each rim; shape (points, nodes)."""
    nodes = mesh.nodes_of("inner_face")
    edges = np.linalg.norm(np.diff(mesh.coordinates[nodes], axis=0), axis=1)
    lengths = (np.append(edges, 0) + np.append(0, edges)) / 2 * (MIDDLE + FACE) / (2 * FACE)
    return snapshots["multipliers"] / lengths


@pytest.fixture(scope="module")
def shrunk(signorom, tmp_path_factory):
    """Mesh and snapshots."""
    mesh = rings(5, 16)
    return mesh, sample(signorom, tmp_path_factory.mktemp("rings"), mesh)


@pytest.mark.parametrize("swing", [0.0, 0.5])
def test_pressure_is_lame(signorom, tmp_path, figures, swing):
    """At every node, on equal and on uneven edges."""
    mesh = rings(5, 16, swing)
    found = pressures(sample(signorom, tmp_path, mesh), mesh)
    for values, exact in zip(found, exact_pressures(), strict=True):
        np.testing.assert_allclose(values, exact, rtol=LAME)
    worst = values[np.abs(values - exact).argmax()]
    edges = "equal" if swing == 0 else "uneven"
    figures.compare(PROBLEM, f"pressure at the worst node, {edges} edges", worst, exact, LAME, "Lamé", "MPa")


def exact_displacement(radius, is_inner):
    """Radial, of both rings: their faces, 0.0025 mm apart before the fit, carry the same force."""
    force = shrink_fit.force_of_meshes("free") / (2 * np.pi)
    material = (shrink_fit.YOUNG_MODULUS, shrink_fit.POISSON_RATIO)
    inner = ThickCylinder(*material, INNER, FACE, outer_pressure=force / FACE, ends="free")
    outer = ThickCylinder(*material, MIDDLE, OUTER, inner_pressure=force / MIDDLE, ends="free")
    return np.where(is_inner, inner.displacement(radius), outer.displacement(radius))


def test_displacement_converges_with_order_two(signorom, tmp_path, figures):
    """Polygons in place of circles, linear elements: half the edges, a quarter of the largest error."""
    errors = []
    for n in (1, 2, 4):
        mesh = rings(3 * n, 6 * n)
        u = sample(signorom, tmp_path / str(n), mesh)["displacement"][0].reshape(-1, 2)
        is_inner = np.isin(np.arange(len(u)), mesh.nodes_of("inner_ring"))
        radius = np.linalg.norm(mesh.coordinates, axis=1)
        exact = exact_displacement(radius, is_inner)[:, None] * mesh.coordinates[:, :2] / radius[:, None]
        errors.append(np.linalg.norm(u - exact, axis=1).max() / np.abs(exact).max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    for order, cells in zip(orders, ("first to second mesh", "second to third"), strict=True):
        name = f"order of the displacement, {cells}"
        figures.compare(PROBLEM, name, order, 2, 0.2, "linear elements", kind="absolute")


@pytest.mark.parametrize(
    ("n_ranks", "solver", "tolerance"),
    [(2, "condensed", SAME), (3, "condensed", SAME), (4, "condensed", SAME)]
    + [(1, solver, SAME_SOLVER) for solver in ("active_set", "snesvi")],
)
def test_same_on_ranks_and_by_solvers(signorom, tmp_path, shrunk, n_ranks, solver, tolerance):
    """A pair on one ray, whatever the ranks; rows that mix components suit every solver."""
    mesh, expected = shrunk
    changes = {"type: condensed": f"type: {solver}", "squeeze: 2}}": "squeeze: 2}, groups: 1}"}
    found = sample(signorom, tmp_path, mesh, n_ranks, **changes)
    for name in ("multipliers", "displacement"):
        limit = tolerance * np.abs(expected[name]).max()
        np.testing.assert_allclose(found[name], expected[name], rtol=0, atol=limit)


def test_either_surface_may_be_first(signorom, tmp_path, shrunk):
    """Normals of the outer ring instead: the same force to the order of the mesh."""
    mesh, expected = shrunk
    found = sample(
        signorom,
        tmp_path,
        mesh,
        **{"first: inner_face, second: outer_face": "first: outer_face, second: inner_face"},
    )
    np.testing.assert_allclose(found["multipliers"].sum(1), expected["multipliers"].sum(1), rtol=1e-6)
