# SPDX-License-Identifier: BSD-3-Clause
"""Contact of surfaces in space whose nodes do not match: dual mortar against known answers."""

import re

import numpy as np
import pytest

from block_meshes import LINEAR, QUADRATIC, SOLIDS, Mesh, consistent_areas
from runs import read_fields, write_deck_with
from spread import spread

EXACT = 1e-10
DISTORTED = 1e-6
YOUNG_MODULUS = 2.0e6
HEIGHT = 2.0
STROKE = 0.1
PRESSURE = YOUNG_MODULUS * STROKE / HEIGHT
PATCH = "patch test in space, nodes that do not match"
SOLVERS = ("condensed", "active_set", "snesvi")
FACES = ("lower_face", "upper_face")
UP = np.array([0.0, -np.sin(np.pi / 6), np.cos(np.pi / 6)])


def blocks(elements, sizes, moved=0.0):
    """Two blocks, 1 by 1 wide and 1 high each, that meet at height 0; nodes inside the faces off the grid by `moved`.

    Elements may be of any order; the middle nodes of quadratic ones stay in the middle.
    """
    mesh = Mesh()
    for name, element, (n_x, n_y), floor in zip(
        ("lower", "upper"), elements, sizes, (-1.0, 0.0), strict=True
    ):
        start = len(mesh.coordinates)
        lines = [np.linspace(0, 1, n_x + 1) ** 1.2, np.linspace(0, 1, n_y + 1) ** 0.9]
        side = int(name == "lower")
        faces = {(2, side): f"{name}_face", (2, 1 - side): "bottom" if side else "top", (0, 0): "left"}
        lines.append(np.linspace(floor, floor + 1, 3))
        mesh.add_block(name, lines, LINEAR.get(element, element), faces, 0.2, seed=n_x)
        x = mesh.coordinates[start:]
        is_inner = (x[:, 2] == 0) & np.all((x[:, :2] > 0) & (x[:, :2] < 1), axis=1)
        noise = np.random.default_rng(n_y).uniform(-moved, moved, (len(x), 2)) / max(n_x, n_y)
        x[:, :2] += noise * is_inner[:, None]
        if element in QUADRATIC:
            mesh.make_quadratic(element, [name, *faces.values()])
    return mesh


def turn(mesh):
    """By 30 degrees about x: height 0 gets the normal UP."""
    cosine, sine = UP[2], -UP[1]
    turned = np.array([[1, 0, 0], [0, cosine, -sine], [0, sine, cosine]])
    mesh.coordinates = mesh.coordinates @ turned.T


def patch_deck(folder, contact=f"first: {FACES[0]}, second: {FACES[1]}", solver="condensed", down=(0, 0, -1)):
    """The deck of the patch tests: the bottom held, the top moved."""
    motion = ", ".join(
        f"{axis}: {float(part)!r} * stroke" for axis, part in zip("xyz", down, strict=True) if part
    )
    motion += "".join(f", {axis}: 0" for axis, part in zip("xyz", down, strict=True) if not part)
    entries = "\n  - {boundary: bottom, displacement: {x: 0, y: 0, z: 0}}"
    entries += f"\n  - {{boundary: top, displacement: {{{motion}}}}}"
    return write_deck_with(
        "patch_models",
        folder,
        {
            "model: plane_strain": "model: solid",
            "boundary_conditions: []": f"boundary_conditions:{entries}",
            "first: lower_face, second: upper_face, direction: [0, 1]": contact,
            "solver: {type: condensed}": f"solver: {{type: {solver}}}\ntraining: {{grid: {{stroke: 2}}}}",
        },
    )


def solved(signorom, deck, n_ranks=1):
    """What the program says, and the fields at the output point."""
    said = signorom("solve", deck, folder=deck.parent, n_ranks=n_ranks)
    return said, read_fields(deck.parent / "results" / deck.stem / "fields.h5")


def patch_errors(mesh, fields, first):
    """Of contact forces, displacements, stresses and pressures against the uniform ones, relative."""
    nodes = mesh.nodes_of(first)
    found = fields["contact_force"][nodes]
    sense = 1 if first == "upper_face" else -1
    areas = consistent_areas(mesh, first)[nodes]
    forces = sense * PRESSURE * areas[:, None] * UP
    stress = fields["stress"] + PRESSURE * np.array([0, UP[1] ** 2, UP[2] ** 2, 0, UP[1] * UP[2], 0])
    exact = -STROKE / HEIGHT * (mesh.coordinates @ UP + 1)[:, None] * UP
    return {
        "forces": np.abs(found - forces).max() / np.abs(forces).max(),
        "stress": np.abs(stress).max() / PRESSURE,
        "displacement": np.abs(fields["displacement"] - exact).max() / STROKE,
        "pressure": np.abs(fields["contact_pressure"][nodes] / PRESSURE - 1).max(),
    }


def solve_patch(signorom, folder, mesh, first, solver="condensed", n_ranks=1):
    """What the program says of the turned patch test, and its worst errors."""
    turn(mesh)
    mesh.write(folder / "blocks.msh")
    second = FACES[1 - FACES.index(first)]
    deck = patch_deck(folder, f"first: {first}, second: {second}", solver, -UP)
    said, fields = solved(signorom, deck, n_ranks)
    return said, patch_errors(mesh, fields, first)


@pytest.mark.parametrize("first", FACES)
@pytest.mark.parametrize(
    ("elements", "sizes"),
    [
        (("T4", "H8"), ((7, 8), (2, 2))),
        (("T4", "H8"), ((2, 2), (7, 8))),
        (("H8", "H8"), ((3, 2), (11, 7))),
        (("T4", "T4"), ((3, 3), (5, 4))),
        (("W6", "P5"), ((3, 2), (4, 5))),
        ((SOLIDS, SOLIDS), ((4, 3), (3, 5))),
    ],
)
def test_uniform_pressure(signorom, tmp_path, figures, elements, sizes, first):
    """Turned by 30 degrees, nu = 0, either side first: E U / H everywhere."""
    said, errors = solve_patch(signorom, tmp_path, blocks(elements, sizes), first)
    second = FACES[1 - FACES.index(first)]
    assert (
        f"node-to-node contact cannot pair the nodes of both surfaces: 100.0 % of '{first}' faces '{second}'"
        in said
    )
    name = f"{'/'.join(elements)} {sizes}, {first} first"
    figures.at_most(PATCH, name, max(errors.values()), EXACT, "uniform pressure")


def test_triangles_and_quadrilaterals_on_one_surface(signorom, tmp_path, figures):
    """The lower surface belongs to a block of tetrahedra and, beside it, one of hexahedra."""
    mesh = Mesh()
    heights = np.linspace(-1, 0, 3)
    for element, ends, n in (("T4", (0, 0.45), 3), ("H8", (0.45, 1), 4)):
        lines = [np.linspace(*ends, n + 1), np.linspace(0, 1, n + 2), heights]
        mesh.add_block("lower", lines, element, {(2, 1): "lower_face", (2, 0): "bottom"}, 0.2, seed=n)
    lines = [np.linspace(0, 1, 6), np.linspace(0, 1, 4), heights + 1]
    mesh.add_block("upper", lines, "T4", {(2, 0): "upper_face", (2, 1): "top", (0, 0): "left"}, 0.2, seed=9)
    turn(mesh)
    mesh.write(tmp_path / "blocks.msh")
    for first, second in (FACES, FACES[::-1]):
        _, fields = solved(signorom, patch_deck(tmp_path, f"first: {first}, second: {second}", down=-UP))
        worst = max(patch_errors(mesh, fields, first).values())
        figures.at_most(
            PATCH, f"T4 and H8 beside each other, {first} first", worst, EXACT, "uniform pressure"
        )


@pytest.mark.parametrize("first", FACES)
def test_distorted_quadrilaterals(signorom, tmp_path, figures, first):
    """Faces of quadrilaterals that are no parallelograms: integration is not exact."""
    mesh = blocks(("H8", "H8"), ((4, 3), (7, 9)), moved=0.25)
    _, errors = solve_patch(signorom, tmp_path, mesh, first)
    for quantity in ("stress", "displacement", "pressure"):
        name = f"distorted hexahedra, {first} first: {quantity}"
        figures.at_most(PATCH, name, errors[quantity], DISTORTED, "uniform pressure")


@pytest.mark.parametrize("elements", [("T10", "H8"), ("H27", "T10"), ("H20", "T4"), ("H27", "H27")])
def test_quadratic_faces(signorom, tmp_path, figures, elements):
    """The first surface has faces of 4 or 9 nodes, or triangles; the second, of any kind."""
    mesh = Mesh()
    for name, element, n, floor in zip(("lower", "upper"), elements, (3, 4), (-1.0, 0.0), strict=True):
        side = int(name == "lower")
        faces = {(2, side): f"{name}_face", (2, 1 - side): "bottom" if side else "top"}
        lines = [
            np.linspace(0, 1, n + 1) ** 1.2,
            np.linspace(0, 1, n) ** 0.9,
            np.linspace(floor, floor + 1, 3),
        ]
        mesh.add_block(name, lines, LINEAR.get(element, element), faces, 0.2, seed=n)
        if element in QUADRATIC:
            mesh.make_quadratic(element, [name, *faces.values()])
    first = FACES[0] if elements[0] == "H27" else FACES[1]
    _, errors = solve_patch(signorom, tmp_path, mesh, first)
    figures.at_most(
        PATCH, f"{'/'.join(elements)}, {first} first", max(errors.values()), EXACT, "uniform pressure"
    )


@pytest.mark.parametrize(("solver", "n_ranks"), spread(SOLVERS, [1, 2, 4]))
def test_solvers_and_ranks(signorom, tmp_path, figures, solver, n_ranks):
    """Tetrahedra on hexahedra, 1 to 4 ranks."""
    mesh = blocks(("T4", "H8"), ((5, 4), (2, 3)))
    _, errors = solve_patch(signorom, tmp_path, mesh, FACES[0], solver, n_ranks)
    figures.at_most(PATCH, f"{solver}, ranks: {n_ranks}", max(errors.values()), EXACT, "uniform pressure")


@pytest.mark.parametrize("elements", [("T4", "T4"), ("H8", "H8")])
def test_matching_nodes_give_pairs(signorom, tmp_path, figures, elements):
    """On flat faces with matching nodes mortar is node-to-node contact; nu = 0.3, a gap, distorted faces."""
    mesh = blocks(elements, ((4, 3), (4, 3)), moved=0.1 if elements[0] == "H8" else 0.0)
    lower, upper = (mesh.nodes_of(name) for name in FACES)
    mesh.coordinates[upper, :2] = mesh.coordinates[lower, :2]
    mesh.write(tmp_path / "blocks.msh")
    found = {}
    for formulation in ("node_to_node", "mortar"):
        folder = tmp_path / formulation
        folder.mkdir()
        (folder / "blocks.msh").write_bytes((tmp_path / "blocks.msh").read_bytes())
        deck = patch_deck(folder, f"first: {FACES[0]}, second: {FACES[1]}, formulation: {formulation}")
        deck.write_text(deck.read_text().replace("poisson_ratio: 0.0", "poisson_ratio: 0.3"))
        _, found[formulation] = solved(signorom, deck)
    for name, allowed in (("contact_force", 1e-12), ("displacement", 1e-12), ("contact_pressure", DISTORTED)):
        pairs, mortar = found["node_to_node"][name], found["mortar"][name]
        nodes = lower if name == "contact_pressure" else slice(None)
        worst = np.abs(mortar - pairs)[nodes].max() / np.abs(pairs).max()
        figures.at_most("matching nodes in space", f"{name}, {elements[0]}", worst, allowed, "node_to_node")


@pytest.mark.parametrize("unit", ["m", "mm"])
def test_forces_balance_where_a_part_is_covered(signorom, tmp_path, figures, unit):
    """A smaller, turned stamp of tetrahedra, either side first: one resultant, no moment; the note counts all area."""
    mesh = Mesh()
    line = np.linspace(0, 1, 6)
    mesh.add_block("lower", [line, line, line[:4] - line[3]], "H8", {(2, 0): "bottom", (2, 1): FACES[0]})
    stamp = [np.linspace(-0.31, 0.27, 5), np.linspace(-0.2, 0.25, 4), np.linspace(0, 0.5, 3)]
    start = len(mesh.coordinates)
    mesh.add_block("upper", stamp, "T4", {(2, 0): FACES[1], (2, 1): "top", (0, 0): "left"}, 0.2, seed=2)
    cosine, sine = np.cos(0.4), np.sin(0.4)
    x = mesh.coordinates[start:]
    x[:, :2] = x[:, :2] @ np.array([[cosine, sine], [-sine, cosine]]) + [0.52, 0.47]
    mesh.coordinates *= 1000 if unit == "mm" else 1
    mesh.write(tmp_path / "blocks.msh")
    for first, second in (FACES, FACES[::-1]):
        deck = patch_deck(tmp_path, f"first: {first}, second: {second}")
        deck.write_text(deck.read_text().replace("length_unit: m}", f"length_unit: {unit}}}"))
        said, fields = solved(signorom, deck)
        covered = 100 * (0.58 * 0.45 if first == FACES[0] else 1.0)
        share = sum(float(part) for part in re.findall(r"([0-9.]+) % (?:of|in facets)", said))
        assert share == pytest.approx(covered, rel=1e-5)
        forces = fields["contact_force"]
        size = np.abs(forces[mesh.nodes_of(FACES[0]), 2]).sum()
        assert size > 0
        left_over = np.abs(forces.sum(axis=0)).max() / size
        x = mesh.coordinates / (1000 if unit == "mm" else 1)
        moment = max(abs(x[:, i] @ forces[:, 2]) for i in (0, 1)) / size
        name = f"{first} first, {unit}"
        figures.at_most("stamp on a block in space", f"resultant, {name}", left_over, 1e-12, "equilibrium")
        figures.at_most("stamp on a block in space", f"moment, {name}", moment, 1e-12, "equilibrium")


def rings(path, n_around):
    """A quarter of two rings that meet at radius 1, with different meshes around and along the axis."""
    mesh = Mesh()
    for i, (name, radii) in enumerate((("inner", (0.5, 1.0)), ("outer", (1.0, 1.5)))):
        sides = {(0, 1 - i): f"{name}_face", (1, 0): "on_x", (1, 1): "on_y", (2, 0): "ends", (2, 1): "ends"}
        lines = [
            np.linspace(*radii, 9),
            np.linspace(0, np.pi / 2, n_around[i] + 1),
            np.linspace(0, 0.4, 3 + i),
        ]
        mesh.add_block(name, lines, "H8", sides)
    r, angle = mesh.coordinates[:, 0].copy(), mesh.coordinates[:, 1].copy()
    mesh.coordinates[:, 0], mesh.coordinates[:, 1] = r * np.cos(angle), r * np.sin(angle)
    mesh.write(path)
    return mesh


def shrink(signorom, folder, mesh, first):
    """Pressure at the nodes of the first surface of two rings with held ends, and Lame's; planes of symmetry."""
    second = {"inner_face": "outer_face", "outer_face": "inner_face"}[first]
    deck = folder / "rings.yaml"
    deck.write_text(f"""title: Shrink fit
mesh: {{file: rings.msh, model: solid}}
parameters: {{interference: {{min: 0.0, max: 0.001, unit: m}}}}
materials: {{all: {{regions: [inner, outer], young_modulus: 2.0e6, poisson_ratio: 0.3}}}}
boundary_conditions:
  - {{boundary: on_x, displacement: {{y: 0}}}}
  - {{boundary: on_y, displacement: {{x: 0}}}}
  - {{boundary: ends, displacement: {{z: 0}}}}
contact:
  - {{first: {first}, second: {second}, initial_gap: "-interference"}}
output: {{points: [{{interference: 0.001}}]}}
""")
    _, fields = solved(signorom, deck)
    # Lame: delta / r = p / E' (compliance of both rings), E' = E / (1 - nu^2)
    compliance = (1.5**2 + 1) / (1.5**2 - 1) + (1 + 0.5**2) / (1 - 0.5**2)
    pressure = 0.001 * YOUNG_MODULUS / (1 - 0.3**2) / compliance
    return fields["contact_pressure"][mesh.nodes_of(first)], pressure


@pytest.mark.parametrize("first", ["inner_face", "outer_face"])
def test_shrink_fit(signorom, tmp_path, figures, first):
    """Lame's pressure, the same whichever side comes first."""
    mesh = rings(tmp_path / "rings.msh", (16, 23))
    found, pressure = shrink(signorom, tmp_path, mesh, first)
    name = f"pressure, {first} first"
    figures.compare("shrink fit in space", f"mean {name}", found.mean(), pressure, 1e-3, "Lamé", "Pa")
    figures.at_most(
        "shrink fit in space", f"spread of {name}", np.ptp(found) / pressure, 0.02, "axial symmetry"
    )
