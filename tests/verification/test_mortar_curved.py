# SPDX-License-Identifier: BSD-3-Clause
"""Curved surfaces whose nodes do not match: a press fit that the mesh holds, a cylinder and a sphere on a block."""

import numpy as np
import pytest

import hertz
from block_meshes import LINEAR, QUADRATIC, Mesh
from lame import ThickCylinder
from runs import MESHES, solve_deck, write_deck_with, write_input
from sphere_mesh import RADIUS, SIZE, sphere_on_block
from spread import spread

FACES = ("inner_face", "outer_face")
CONTACT = "first: lower_face, second: upper_face, direction: [0, 1]"
YOUNG_MODULUS, POISSON_RATIO = 2.0e6, 0.3
# radii of the rings; the inner one is larger than the hole of the outer one
INTERFERENCE = 1e-3
INNER, OUTER = (0.5, 1 + INTERFERENCE), (1.0, 1.5)


def press_fit_pressure(first):
    """Lame, plane strain: the walls move by the interference; the pressure on the first one, the same force on both."""

    def compliance(radii, wall, **pressure):
        ring = ThickCylinder(YOUNG_MODULUS, POISSON_RATIO, *radii, **pressure, ends="held")
        return abs(ring.displacement(wall))

    own = INNER[1] if first == "inner_face" else OUTER[0]
    moved = compliance(INNER, INNER[1], outer_pressure=own / INNER[1])
    moved += compliance(OUTER, OUTER[0], inner_pressure=own / OUTER[0])
    return INTERFERENCE / moved


def write_rings(path, element, step, n_high=None):
    """A quarter of two rings, 8 edges facing 13 at step 1; in space with 2 layers facing 3, ends held."""
    mesh = Mesh()
    for i, (name, radii, n) in enumerate((("inner", INNER, 8), ("outer", OUTER, 13))):
        lines = [np.linspace(*radii, 5 * step + 1), np.linspace(0, np.pi / 2, n * step + 1)]
        sides = {(0, 1 - i): f"{name}_face", (1, 0): "on_x", (1, 1): "on_y"}
        if n_high:
            lines.append(np.linspace(0, 0.5, n_high + i + 1))
            sides |= {(2, 0): "ends", (2, 1): "ends"}
        mesh.add_block(name, lines, LINEAR.get(element, element), sides)
    if element in QUADRATIC:
        mesh.make_quadratic(element)
    r, angle = mesh.coordinates[:, 0].copy(), mesh.coordinates[:, 1].copy()
    mesh.coordinates[:, 0], mesh.coordinates[:, 1] = r * np.cos(angle), r * np.sin(angle)
    mesh.write(path)
    return mesh


def press(signorom, folder, first, element, step, n_high=None):
    """Mesh and fields of the rings; no gap in the deck, the mesh has the interference."""
    mesh = write_rings(folder / "blocks.msh", element, step, n_high)
    supports = "\n  - {boundary: on_x, displacement: {y: 0}}\n  - {boundary: on_y, displacement: {x: 0}}"
    changes = {
        "boundary_conditions: []": "boundary_conditions:" + supports,
        "[lower, upper]": "[inner, outer]",
    }
    second = FACES[1 - FACES.index(first)]
    changes |= {CONTACT: f"first: {first}, second: {second}", "ratio: 0.0": f"ratio: {POISSON_RATIO}"}
    if n_high:
        changes["model: plane_strain"] = "model: solid"
        changes["boundary_conditions: []"] += "\n  - {boundary: ends, displacement: {z: 0}}"
    (fields, *_), _ = solve_deck(signorom, write_deck_with("patch_models", folder, changes))
    return mesh, fields["contact_pressure"]


def pressure_error(mesh, name, pressure):
    """L2 norm of sum p_j N_j - p over the edges of a surface, relative."""
    exact, places, weights = press_fit_pressure(name), *np.polynomial.legendre.leggauss(5)
    squares = []
    for nodes in mesh.facets_of(name):
        values = np.array([(1 - places) / 2, (1 + places) / 2])
        if len(nodes) == 3:
            values = np.array([places * (places - 1) / 2, places * (places + 1) / 2, 1 - places**2])
        squares.append(weights @ (pressure[nodes] @ values / exact - 1) ** 2 / 2)
    return np.sqrt(np.mean(squares))


@pytest.mark.parametrize("first", FACES)
@pytest.mark.parametrize(
    ("element", "order", "worst"), [("Q4", 1, 5e-3), ("T3", 1, 5e-3), ("Q8", 1.9, 2e-4), ("T6", 1.9, 2e-4)]
)
def test_press_fit_of_the_mesh(signorom, tmp_path, figures, element, order, worst, first):
    """Order on curved edges: 1 of linear ones, whose displacements cannot be curved; 2 of quadratic ones, nearly."""
    problem = f"press fit of the mesh, {element}, {first} first"
    errors = []
    for step in (1, 2, 4):
        folder = tmp_path / str(step)
        folder.mkdir()
        mesh, pressure = press(signorom, folder, first, element, step)
        errors.append(pressure_error(mesh, first, pressure))
    print(problem, *errors)
    measured = np.log2(errors[0] / errors[-1]) / 2
    figures.at_least(problem, "order of the pressure, L2", measured, order, "Lamé")
    figures.at_most(problem, "pressure with 32 facing 52 edges, L2", errors[-1], worst, "Lamé")


@pytest.mark.parametrize("first", FACES)
@pytest.mark.parametrize(("element", "worst"), [("H8", 0.03), ("T4", 0.15)])
def test_press_fit_in_space(signorom, tmp_path, figures, element, worst, first):
    """The same with 16 facing 26 edges and 2 facing 3 layers: the resultant, and the pressure at every node."""
    problem = f"press fit of the mesh, {element}, {first} first"
    mesh, pressure = press(signorom, tmp_path, first, element, 2, n_high=2)
    nodes = mesh.nodes_of(first)
    exact = press_fit_pressure(first)
    found = np.abs(pressure[nodes] / exact - 1)
    figures.at_most(problem, "pressure at nodes", found.max(), worst, "Lamé")
    figures.compare(problem, "mean pressure", pressure[nodes].mean(), exact, 0.01, "Lamé", "Pa")


# the deck of the sphere in the round: another mesh, cut off as far away as the block
MESH_OF_DECK = {str(MESHES / "sphere.msh"): "sphere.msh", "{load: 20.0e3}, {load: 50.0e3}, ": ""}
ROUND = MESH_OF_DECK | {"(_pi * 50^2)": f"(_pi * {SIZE}^2)"}
# a cylinder in the plane, 16 half-widths to the ends
WIDE = 100.0
PLANE = MESH_OF_DECK | {
    "model: axisymmetric": "model: plane_strain",
    "axis, displacement: {r: 0}": "axis, displacement: {x: 0}",
    "base, displacement: {z: 0}": "base, displacement: {y: 0}",
    "(_pi * 50^2)": f"(2 * {WIDE})",
    "load: 100.0e3}": f"load: {hertz.NAFEMS_LOAD}}}",
}
SOLID = {
    str(MESHES / "sphere.msh"): "sphere.msh",
    "(_pi * 50^2)": f"(4 * {SIZE}^2)",
    "model: axisymmetric": "model: solid",
    "axis, displacement: {r: 0}}": "left, displacement: {x: 0}}\n  - {boundary: front, displacement: {y: 0}}",
    "{load: 20.0e3}, {load: 50.0e3}, ": "",
}
SIDES = "first: block_face, second: sphere_face, direction: [0, 1]"
MODULUS = hertz.contact_modulus(*hertz.NAFEMS_MATERIALS)
CYLINDER = "NAFEMS cylinder on block, nodes that do not match"


def fit_contact(signorom, folder, mesh, changes, first=None):
    """Half-width and peak from the pressures of the first surface, and its nodes' positions and pressures."""
    mesh.write(folder / "sphere.msh")
    sides = {None: SIDES, "block_face": SIDES[: SIDES.index(", dir")]}
    sides["sphere_face"] = "first: sphere_face, second: block_face"
    (fields,), _ = solve_deck(signorom, write_input("sphere", folder, changes | {SIDES: sides[first]}))
    nodes = mesh.nodes_of(first or "block_face")
    x, pressure = mesh.coordinates[nodes, 0], fields["contact_pressure"][nodes]
    return *hertz.fit(x, pressure), x, pressure


@pytest.fixture(scope="module")
def converged(signorom, tmp_path_factory):
    """Half-width and peak of the cylinder on a fine mesh with matching nodes of Q9."""
    mesh = sphere_on_block(2, 0.2, 60, 1.12, element="Q9", size=WIDE)
    half_width, peak, _, _ = fit_contact(signorom, tmp_path_factory.mktemp("fine"), mesh, PLANE)
    return half_width, peak


ALLOWED = {"Q4": 0.01, "Q8": 0.003}
# edges of block and sphere, and the first surface
SIDES_FIRST = [
    ((40, 29), "block_face"),
    ((40, 29), "sphere_face"),
    ((29, 40), "sphere_face"),
    ((29, 40), "block_face"),
]


@pytest.mark.parametrize(("element", "sides"), spread(list(ALLOWED), SIDES_FIRST))
def test_cylinder(signorom, tmp_path, figures, converged, element, sides):
    """D2: half-width and peak against the fine matching mesh, and against Hertz."""
    allowed, (edges, first) = ALLOWED[element], sides
    mesh = sphere_on_block(2, 12 / edges[0], edges[0], 1.15, edges[1], element, WIDE)
    half_width, peak, _, _ = fit_contact(signorom, tmp_path, mesh, PLANE, first)
    exact = hertz.nafems_cylinder()
    case = f"{element}, {edges[0]} facing {edges[1]}, {first} first"
    figures.compare(CYLINDER, f"a, {case}", half_width, converged[0], allowed, "fine matching mesh", "mm")
    figures.compare(CYLINDER, f"p0, {case}", peak, converged[1], allowed, "fine matching mesh", "MPa")
    figures.compare(CYLINDER, f"a against Hertz, {case}", half_width, exact.half_width, 0.015, "Hertz", "mm")
    figures.compare(CYLINDER, f"p0 against Hertz, {case}", peak, exact.peak, 0.015, "Hertz", "MPa")


@pytest.mark.parametrize("first", ["block_face", "sphere_face"])
@pytest.mark.parametrize("element", ["Q4", "Q8"])
def test_sphere_in_the_round(signorom, tmp_path, figures, element, first):
    """Radius and peak of a sphere on a block."""
    mesh = sphere_on_block(2, 7 / 40, 40, 1.15, 29, element)
    half_width, peak, x, pressure = fit_contact(signorom, tmp_path, mesh, ROUND, first)
    exact = hertz.Point(MODULUS, RADIUS, 100e3)
    problem = f"Hertz sphere on block, nodes that do not match, {element}, {first} first"
    figures.compare(problem, "radius a at 100 kN", half_width, exact.half_width, 0.015, "Hertz", "mm")
    figures.compare(problem, "peak p0 of the fit", peak, exact.peak, 0.015, "Hertz", "MPa")
    at_axis = pressure[np.argmin(x)]
    figures.compare(problem, "pressure on the axis", at_axis, exact.peak, 0.02, "Hertz", "MPa")


@pytest.fixture(scope="module")
def converged_round(signorom, tmp_path_factory):
    """Of the sphere, by the first side: p^2 as a polynomial of r^2, on a fine mesh with matching nodes of Q9."""
    polynomials = {}
    for first in ("block_face", "sphere_face"):
        mesh = sphere_on_block(2, 7 / 60, 60, 1.15, element="Q9")
        _, _, r, pressure = fit_contact(signorom, tmp_path_factory.mktemp(first), mesh, ROUND, first)
        near = r < 0.9 * HALF_WIDTH
        polynomials[first] = np.polyfit(r[near] ** 2, pressure[near] ** 2, 6)
    return polynomials


HALF_WIDTH = hertz.Point(MODULUS, RADIUS, 100e3).half_width


@pytest.mark.parametrize("n_sphere", [40, 29])
@pytest.mark.parametrize("first", ["block_face", "sphere_face"])
@pytest.mark.parametrize("element", ["Q4", "T3"])
def test_order_in_the_round(signorom, tmp_path, figures, converged_round, element, first, n_sphere):
    """Edges of a / 6 to a / 23, n_sphere facing each 40 of the block; the L2 norm over r < 0.8 a, and the axis alone."""
    problem = f"Hertz sphere on block, {element}, 40 facing {n_sphere} edges, {first} first"
    over_contact, on_axis, shares = [], [], []
    for n in (10, 20, 40):
        folder = tmp_path / str(n)
        folder.mkdir()
        mesh = sphere_on_block(2, 7 / n, n, 1.15, round(n * n_sphere / 40), element)
        _, _, r, pressure = fit_contact(signorom, folder, mesh, ROUND, first)
        order = np.argsort(r)
        r, pressure = r[order], pressure[order]
        is_inside = r < 0.8 * HALF_WIDTH
        exact = np.sqrt(np.polyval(converged_round[first], r[is_inside] ** 2))
        # of the node on the axis and of the rings
        areas = np.gradient(r) * np.where(r > 0, r, r[1] / 6)
        wrong = pressure[is_inside] - exact
        over_contact.append(np.sqrt(areas[is_inside] @ wrong**2 / (areas[is_inside] @ exact**2)))
        on_axis.append(abs(wrong[0]) / exact[0])
        shares.append(r[1] / HALF_WIDTH)
    print(problem, *over_contact, *on_axis)
    measured = np.log2(over_contact[0] / over_contact[-1]) / 2
    figures.at_least(problem, "order of the pressure, L2", measured, 1.3, "fine matching mesh")
    name = "pressure on the axis over h / a"
    figures.at_most(problem, name, on_axis[-1] / shares[-1], 0.4, "fine matching mesh")
    if element == "Q4":
        measured = np.log2(on_axis[0] / on_axis[-1]) / 2
        figures.at_least(problem, "order of the pressure on the axis", measured, 0.8, "fine matching mesh")


def test_quarter_of_a_sphere_in_space(signorom, tmp_path, figures, pytestconfig):
    """T10, four edges over the contact radius and 5 %; with --all-points eight, in two minutes, and 1.5 %."""
    is_fine = pytestconfig.getoption("--all-points")
    step, edges, allowed = (0.5, (14, 10), 0.015) if is_fine else (0.9, (8, 5), 0.05)
    mesh = sphere_on_block(3, step, edges[0], 1.5 if is_fine else 2.0, edges[1], "T10")
    mesh.write(tmp_path / "sphere.msh")
    sides = SIDES[: SIDES.index(", dir")]
    deck = write_input("sphere", tmp_path, SOLID | {SIDES: sides})
    if not is_fine:  # a third of the time of multigrid on 96 thousand dofs
        deck.write_text(deck.read_text() + "solver: {type: condensed}\n")
    (fields,), _ = solve_deck(signorom, deck)
    nodes = mesh.nodes_of("block_face")
    distance = np.linalg.norm(mesh.coordinates[nodes, :2], axis=1)
    half_width, peak = hertz.fit(distance, fields["contact_pressure"][nodes])
    exact = hertz.Point(MODULUS, RADIUS, 100e3)
    problem = f"Hertz sphere on block, a quarter of T10, {edges[0]} facing {edges[1]} edges"
    figures.compare(problem, "radius a at 100 kN", half_width, exact.half_width, allowed, "Hertz", "mm")
    figures.compare(problem, "peak p0 of the fit", peak, exact.peak, allowed, "Hertz", "MPa")
