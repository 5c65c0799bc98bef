# SPDX-License-Identifier: BSD-3-Clause
"""Rigid obstacles: a plane on a block (patch test) and a sphere pressed into one (Hertz)."""

import numpy as np
import pytest

import hertz
from block_meshes import LINEAR, SOLIDS_WITHOUT, Mesh, consistent_areas
from runs import read_snapshots, solve_deck, write_deck, write_deck_with
from sphere_mesh import RADIUS, sphere_on_block

PATCH = 1e-10
HERTZ = 0.01
MODULUS, POISSON_RATIO = 2.0e6, 0.3
AXES = {"axisymmetric": "rz", "solid": "xyz"}


def block(element, n_dim):
    """1 wide and 1 high, off the grid inside; names of tests/support/block_meshes.py."""
    across = (
        [np.array([0.0, 0.3, 0.55, 1.0])]
        if n_dim == 2
        else [np.array([0.0, 0.3, 1.0]), np.array([0.0, 0.4, 1.0])]
    )
    sides = dict(list({(0, 0): "left", (1, 0): "front"}.items())[: n_dim - 1])
    mesh = Mesh()
    faces = {(n_dim - 1, 0): "bottom", (n_dim - 1, 1): "lower_face"} | sides
    linear = LINEAR.get(element, element)
    mesh.add_block("lower", [*across, np.array([-1.0, -0.6, -0.2, 0.0])], linear, faces, 0.25, seed=1)
    if linear != element:
        mesh.make_quadratic(element)
    return mesh


@pytest.mark.parametrize("solver", ["condensed", "active_set", "snesvi"])
@pytest.mark.parametrize(
    ("model", "element"),
    [
        ("plane_strain", "mixed"),
        ("plane_stress", "T3"),
        ("axisymmetric", "Q4"),
        ("solid", "H8"),
        ("axisymmetric", "Q8"),
        ("solid", "T10"),
        ("solid", "H20"),
        ("solid", SOLIDS_WITHOUT),
    ],
)
def test_plane_presses_evenly(signorom, tmp_path, model, element, solver):
    """P = E' stroke / 1, E' = E / (1 - nu^2) in plane strain; no force before the plane is there.

    The multipliers of quadratic facets belong to a changed basis; their sum is the force.
    """
    axes = AXES.get(model, "xy")
    mesh = block(element, len(axes))
    supports = [("bottom", axes[-1]), *zip(("left", "front"), axes[:-1], strict=False)]
    entries = "".join(f"\n  - {{boundary: {name}, displacement: {{{axis}: 0}}}}" for name, axis in supports)
    changes = {
        "model: plane_strain": f"model: {model}",
        "boundary_conditions: []": f"boundary_conditions:{entries}",
        "type: condensed": f"type: {solver}",
    }
    if model == "solid":
        changes |= {"point: [0, -stroke]": "point: [5, 7, -stroke]", "normal: [0, -1]": "normal: [0, 0, -3]"}
    deck = write_deck("rigid_plane", tmp_path, **changes)
    mesh.write(tmp_path / "block.msh")
    signorom("sample", deck, folder=tmp_path)
    snapshots = read_snapshots(tmp_path / "results" / "rigid_plane" / "snapshots.h5")
    assert (snapshots["reasons"] > 0).all()
    areas = consistent_areas(mesh, "lower_face", is_round=model == "axisymmetric")[
        mesh.nodes_of("lower_face")
    ]
    modulus = MODULUS / (1 - POISSON_RATIO**2) if model == "plane_strain" else MODULUS
    strokes = snapshots["parameters"][:, 0]
    expected = modulus * np.outer(np.maximum(strokes, 0), areas)
    multipliers = snapshots["multipliers"]
    if element in LINEAR:
        assert (multipliers[strokes > 0] > 0).all()
        multipliers, expected = multipliers.sum(axis=1), expected.sum(axis=1)
    np.testing.assert_allclose(multipliers, expected, rtol=0, atol=PATCH * expected.max())
    for stroke, displacement in zip(strokes, snapshots["displacement"], strict=True):
        up = len(axes) - 1
        z = mesh.coordinates[:, up]
        found = displacement.reshape(-1, len(axes))[:, up]
        np.testing.assert_allclose(
            found, -max(stroke, 0) * (z + 1), rtol=0, atol=PATCH * np.abs(strokes).max()
        )


@pytest.mark.parametrize("solver", ["condensed", "active_set"])
def test_block_that_rests_on_a_plane(signorom, tmp_path, solver):
    """Nothing but the plane holds the block upward: p = load, u = lift - load (z - z_foot) / E' below a pressed top."""
    mesh = block("Q4", 2)
    changes = {
        "boundary_conditions: []": "boundary_conditions: [{boundary: left, displacement: {x: 0}}]\n"
        "loads: [{boundary: lower_face, pressure: 1000}]",
        "first: lower_face": "first: bottom",
        "point: [0, -stroke], normal: [0, -1]": "point: [0, stroke - 1], normal: [0, 1]",
        "type: condensed": f"type: {solver}",
    }
    deck = write_deck("rigid_plane", tmp_path, **changes)
    mesh.write(tmp_path / "block.msh")
    signorom("sample", deck, folder=tmp_path)
    snapshots = read_snapshots(tmp_path / "results" / "rigid_plane" / "snapshots.h5")
    areas = consistent_areas(mesh, "bottom")[mesh.nodes_of("bottom")]
    modulus = MODULUS / (1 - POISSON_RATIO**2)
    for stroke, multipliers, displacement in zip(
        snapshots["parameters"][:, 0], snapshots["multipliers"], snapshots["displacement"], strict=True
    ):
        np.testing.assert_allclose(multipliers, 1000 * areas, rtol=1e-9)
        found = displacement.reshape(-1, 2)[:, 1]
        expected = stroke - 1000 / modulus * (mesh.coordinates[:, 1] + 1)
        np.testing.assert_allclose(found, expected, rtol=0, atol=PATCH * 0.1)


def block_alone(mesh):
    """The block of sphere_on_block, without the sphere."""
    is_used = np.zeros(len(mesh.coordinates), dtype=bool)
    is_used[mesh.nodes_of("block")] = True
    number = np.cumsum(is_used) - 1
    mesh.coordinates = mesh.coordinates[is_used]
    mesh.elements = [
        (kind, name, number[list(nodes)].tolist())
        for kind, name, nodes in mesh.elements
        if is_used[list(nodes)].all()
    ]
    return mesh


def test_rigid_sphere_is_hertz(signorom, tmp_path, figures):
    """Half-width and peak for the load found at each approach, 1 / E* of the block alone; Q4 of a / 15 to a / 26."""
    mesh = block_alone(sphere_on_block(2, 0.15, 40, 1.15))
    deck = write_deck("rigid_sphere", tmp_path)
    mesh.write(tmp_path / "block.msh")
    signorom("sample", deck, folder=tmp_path)
    snapshots = read_snapshots(tmp_path / "results" / "rigid_sphere" / "snapshots.h5")
    assert (snapshots["reasons"] > 0).all()
    nodes = mesh.nodes_of("block_face")
    radius = mesh.coordinates[nodes, 0]
    areas = consistent_areas(mesh, "block_face", is_round=True)[nodes]
    for approach, multipliers in zip(snapshots["parameters"][:, 0], snapshots["multipliers"], strict=True):
        half_width, peak = hertz.fit(radius, multipliers / areas)
        modulus = hertz.contact_modulus(hertz.NAFEMS_MATERIALS[1], None)
        exact = hertz.Point(modulus, RADIUS, multipliers.sum())
        problem = f"rigid sphere on a block, approach {approach:g} mm"
        figures.compare(problem, "half-width a", half_width, exact.half_width, HERTZ, "Hertz", "mm")
        figures.compare(problem, "peak pressure p0", peak, exact.peak, HERTZ, "Hertz", "MPa")


# the deck of the sphere in the round as a quarter in space, and the approach
QUARTER = {
    "model: axisymmetric": "model: solid",
    "axis, displacement: {r: 0.0}}": "left, displacement: {x: 0}}\n  - {boundary: front, displacement: {y: 0}}",
    "center: [0, 50": "center: [0, 0, 50",
    "direction: [0, 1]": "direction: [0, 0, 1]",
    "solver: {type: condensed}": "output: {points: [{approach: 0.3}]}",
}


@pytest.mark.parametrize(
    ("element", "at_axis", "everywhere"), [("T10", 0.03, 0.05), ("H20", 0.02, 0.03), ("H27", 0.02, 0.02)]
)
def test_rigid_sphere_on_quadratic_faces(signorom, tmp_path, figures, element, at_axis, everywhere):
    """Pressures for the load found, 1 / E* of the block alone; faces of six, eight and nine nodes, a / 3.3.

    With a / 3, a / 4.4 and a / 6.5 the pressure on the axis is off by 2.1, 1.0 and 0.4 % (T10).
    """
    mesh = block_alone(sphere_on_block(3, 1.2, 4, 1.8, element=element, size=30.0))
    deck = write_deck_with("rigid_sphere", tmp_path, QUARTER)
    mesh.write(tmp_path / "block.msh")
    (fields,), _ = solve_deck(signorom, deck)
    modulus = hertz.contact_modulus(hertz.NAFEMS_MATERIALS[1], None)
    exact = hertz.Point(modulus, RADIUS, 4 * fields["multipliers_full_order"].sum())
    nodes = mesh.nodes_of("block_face")
    radius = np.linalg.norm(mesh.coordinates[nodes, :2], axis=1)
    pressure = fields["contact_pressure"][nodes]
    problem = f"rigid sphere on a quarter of a block, {element}"
    peak = pressure[np.argmin(radius)]
    figures.compare(problem, "pressure on the axis", peak, exact.peak, at_axis, "Hertz", "MPa")
    differences = (pressure - exact.pressure(radius))[radius < 0.9 * exact.half_width]
    worst = np.sqrt(np.mean(differences**2)) / exact.peak
    figures.at_most(problem, "pressure at nodes, root mean square over p0", worst, everywhere, "Hertz")
