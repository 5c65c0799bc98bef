# SPDX-License-Identifier: BSD-3-Clause
"""Quadratic elements: patch tests on curved cells, gmsh's and VTK's order of nodes, pressures on arcs, refusals."""

import re
import subprocess

import numpy as np
import pytest

from block_meshes import GMSH_TYPES, LINEAR, MIDDLES, SOLIDS_WITH, SOLIDS_WITHOUT, Mesh, stacked_blocks
from known_stresses import STRAINS, block_stress
from runs import read_fields, read_report

TOLERANCE = 1e-10
SINGLE = ["T10", "H20", "H27", "W15", "W18", "P13", "P14"]
SIDES = {(0, 0): "left", (0, 1): "right", (1, 0): "front", (1, 1): "back", (2, 0): "bottom", (2, 1): "top"}


def write_problem(folder, mesh, model, boundaries, loads="", unit="m", factor=1.0, n_cases=1):
    """Mesh and deck, with entries for boundaries and loads; a linear body far away has the contact.

    The fields of the points 1 to n_cases are asked for: `place` is 0.35, and `case` the number of the point.
    """
    n_dim = 3 if model == "solid" else 2
    far = [np.array([50.0, 51.0])] * n_dim
    mesh.add_block(
        "stop", far, "H8" if n_dim == 3 else "Q4", {(n_dim - 1, 0): "foot", (n_dim - 1, 1): "stop_top"}
    )
    mesh.coordinates *= factor
    mesh.write(folder / "body.msh")
    axes = {"solid": "xyz", "axisymmetric": "rz"}.get(model, "xy")
    held = ", ".join(f"{axis}: 0" for axis in axes)
    zeros = ", ".join(["0"] * (n_dim - 1))
    load_lines = "".join(f"\n  - {load}" for load in loads)
    points = ", ".join(f"{{place: 0.35, case: {i}}}" for i in range(1, n_cases + 1))
    deck = folder / "body.yaml"
    deck.write_text(f"""title: A body of quadratic elements
mesh: {{file: body.msh, model: {model}, length_unit: {unit}}}
parameters: {{place: {{min: 0.0, max: 1.0, unit: m}}, case: {{min: 1, max: 9}}}}
materials: {{all: {{regions: [body, stop], young_modulus: 2.0e6, poisson_ratio: 0.3}}}}
boundary_conditions:
  - {{boundary: foot, displacement: {{{held}}}}}
{"".join(f"  - {entry}" + chr(10) for entry in boundaries)}{"loads:" if loads else ""}{load_lines}
contact:
  - {{first: stop_top, obstacle: {{type: half_space, point: [{zeros}, 60], normal: [{zeros}, -1]}}}}
output: {{fields: [displacement, contact, stress], points: [{points}]}}
""")
    return deck


def strained(names):
    """The five or six sides that move as STRAINS say."""
    xx, yy, zz, xy, yz, xz = STRAINS.tolist()
    rows = {"x": (xx, xy, xz), "y": (xy, yy, yz), "z": (xz, yz, zz)}
    motion = ", ".join(f'{axis}: "{a!r} * x + {b!r} * y + {c!r} * z"' for axis, (a, b, c) in rows.items())
    return [f"{{boundary: {name}, displacement: {{{motion}}}}}" for name in names]


def curved_block(element):
    """A box of distorted cells with curved inner edges and faces."""
    lines = [
        np.array([0.0, 0.3, 0.55, 1.0]),
        np.array([0.0, 0.4, 0.7, 1.0]),
        np.array([-1.0, -0.6, -0.2, 0.0]),
    ]
    mesh = Mesh()
    mesh.add_block("body", lines, LINEAR[element], SIDES, 0.15, seed=1)
    mesh.make_quadratic(element)
    low, high = mesh.coordinates.min(axis=0), mesh.coordinates.max(axis=0)
    is_inner = np.all((mesh.coordinates > low + 1e-9) & (mesh.coordinates < high - 1e-9), axis=1)
    noise = np.random.default_rng(3).uniform(-0.012, 0.012, mesh.coordinates.shape)
    mesh.coordinates += noise * is_inner[:, None]
    return mesh


@pytest.mark.parametrize("element", [*SINGLE, SOLIDS_WITHOUT, SOLIDS_WITH])
def test_one_stress_everywhere(signorom, tmp_path, figures, element):
    """Five sides move, the sixth carries its traction: cells, nodes and displacements."""
    mesh = curved_block(element)
    n_nodes, n_cells = len(mesh.coordinates), sum(name == "body" for _, name, _ in mesh.elements)
    stress = block_stress()
    traction = ", ".join(f"{axis}: {float(stress[i])!r}" for axis, i in (("x", 5), ("y", 4), ("z", 2)))
    sides = [name for name in SIDES.values() if name != "top"]
    deck = write_problem(
        tmp_path, mesh, "solid", strained(sides), [f"{{boundary: top, traction: {{{traction}}}}}"]
    )
    signorom("solve", deck, folder=tmp_path, n_ranks=2)
    fields = read_fields(tmp_path / "results" / "body" / "fields.h5")
    xx, yy, zz, xy, yz, xz = STRAINS
    exact = mesh.coordinates[:n_nodes] @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    worst = [
        np.abs(fields["displacement"][:n_nodes] - exact).max() / np.abs(exact).max(),
        np.abs(fields["stress"][:n_cells] - stress).max() / np.abs(stress).max(),
        np.abs(fields["stress_smoothed"][:n_nodes] - stress).max() / np.abs(stress).max(),
    ]
    name = f"{element}: displacement, stress of cells and nodes"
    figures.at_most("patch test, curved quadratic cells", name, max(worst), TOLERANCE, "Hooke's law")


GEO = """Mesh.SecondOrderIncomplete = {incomplete};
Point(1) = {{0, 0, 0}}; Point(2) = {{2, 0, 0}}; Line(1) = {{1, 2}}; Transfinite Curve {{1}} = 3;
Extrude {{ 0, 1, 0 }} {{ Curve{{1}}; Layers{{2}}; {recombine} }}
{solid}
"""
BOX = 'Extrude {{ 0, 0, 1 }} {{ Surface{{5}}; Layers{{2}}; {recombine} }} Physical Volume("all") = {{1}};'
# tetrahedra on hexahedra: gmsh puts pyramids between them
TWO_BOXES = """Mesh.SecondOrderIncomplete = {incomplete};
SetFactory("OpenCASCADE");
Box(1) = {{0, 0, 0, 1, 1, 1}}; Box(2) = {{0, 0, 1, 1, 1, 1}}; Coherence;
Transfinite Curve{{:}} = 3; Transfinite Surface{{:}}; Transfinite Volume{{1}}; Recombine Surface{{1, 2, 3, 4, 5, 6}};
"""


@pytest.mark.parametrize("element", ["T6", "Q8", "Q9", *SINGLE])
def test_order_of_gmsh(tmp_path, element):
    """The tests' meshes have the order of gmsh: each further node in the middle of its corners."""
    recombine = "Recombine;" if element[0] in "QH" else ""
    is_solid = element in SINGLE
    solid = BOX.format(recombine="Recombine;" if element[0] in "HW" else "")
    if not is_solid:
        solid = 'Physical Surface("all") = {5};'
    source = tmp_path / "box.geo"
    incomplete = int(element in ("Q8", "H20", "W15", "P13"))
    text = TWO_BOXES if element[0] == "P" else GEO
    source.write_text(text.format(incomplete=incomplete, recombine=recombine, solid=solid))
    path = tmp_path / "box.msh"
    command = [
        "gmsh",
        f"-{3 if is_solid else 2}",
        "-order",
        "2",
        "-format",
        "msh22",
        str(source),
        "-o",
        str(path),
    ]
    subprocess.run(command, capture_output=True, check=True)
    lines = path.read_text().splitlines()
    start = lines.index("$Nodes") + 2
    rows = [line.split() for line in lines[start : lines.index("$EndNodes")]]
    places = {int(row[0]): np.array(row[1:], dtype=float) for row in rows}
    rows = [list(map(int, line.split())) for line in lines[lines.index("$Elements") + 2 : -1]]
    found = [row[3 + row[2] :] for row in rows if row[1] == GMSH_TYPES[element]]
    assert found
    for nodes in found:
        x = np.array([places[node] for node in nodes])
        n_corners = len(nodes) - len(MIDDLES[element])
        middles = [x[list(corners)].mean(axis=0) for corners in MIDDLES[element]]
        np.testing.assert_allclose(x[n_corners:], middles, atol=1e-12)


@pytest.mark.parametrize("element", ["T6", "Q8", "Q9", *SINGLE])
def test_order_of_vtk(signorom, tmp_path, element):
    """VTK finds each edge's node in the middle of its ends, and each face's in the middle of its corners.

    XDMF has no pyramid with a node in the middle of its base.
    """
    pytest.importorskip("vtkmodules.vtkIOXdmf2")
    from vtkmodules.vtkIOXdmf2 import vtkXdmfReader

    n_dim = 3 if element in SINGLE else 2
    mesh = Mesh()
    line = np.array([0.0, 1.0, 3.0])
    faces = {(0, 0): "left"}
    mesh.add_block("body", [line, 2 * line, 3 * line][:n_dim], LINEAR[element], faces)
    mesh.make_quadratic(element)
    axes = "xyz"[:n_dim]
    held = f"{{boundary: left, displacement: {{{', '.join(f'{axis}: 0' for axis in axes)}}}}}"
    deck = write_problem(tmp_path, mesh, "solid" if n_dim == 3 else "plane_stress", [held])
    signorom("solve", deck, folder=tmp_path)
    reader = vtkXdmfReader()
    reader.SetFileName(str(tmp_path / "results" / "body" / "fields.xdmf"))
    reader.Update()
    grid = reader.GetOutputDataObject(0)
    places = np.array([grid.GetPoint(i) for i in range(grid.GetNumberOfPoints())])
    n_nodes = 13 if element == "P14" else len(mesh.elements[0][2])
    cells = [grid.GetCell(i) for i in range(grid.GetNumberOfCells())]
    assert sum(cell.GetNumberOfPoints() == n_nodes for cell in cells) == len(cells) - 1
    for cell in cells[:-1]:
        for i in range(cell.GetNumberOfEdges()):
            edge = cell.GetEdge(i)
            ends = [places[edge.GetPointId(j)] for j in range(3)]
            np.testing.assert_allclose(ends[2], (ends[0] + ends[1]) / 2, atol=1e-6)
        for i in range(cell.GetNumberOfFaces()):
            face = cell.GetFace(i)
            if face.GetNumberOfPoints() == 9:
                x = np.array([places[face.GetPointId(j)] for j in range(9)])
                np.testing.assert_allclose(x[8], x[:4].mean(axis=0), atol=1e-6)


def sector(element, n_dim):
    """A quarter of a ring between the radii 1 and 2, of height 1 in three dimensions; "bore" and "rim" are its arcs."""
    lines = [np.linspace(1, 2, 3), np.linspace(0, np.pi / 2, 4), np.linspace(0, 1, 3)][:n_dim]
    mesh = Mesh()
    mesh.add_block("body", lines, LINEAR[element], {(0, 0): "bore", (0, 1): "rim"})
    mesh.make_quadratic(element)
    r, angle = mesh.coordinates[:, 0].copy(), mesh.coordinates[:, 1].copy()
    mesh.coordinates[:, 0], mesh.coordinates[:, 1] = r * np.cos(angle), r * np.sin(angle)
    return mesh


# Parts of the bore; a curve's pressure has the resultant p times the extent across, however it bends.
WINDOWS = {
    "": (1.0, 1.0),
    ", window: {axis: x, min: 0.4}": (None, 0.6),
    ", window: {axis: x, min: place}": (None, 0.65),
}
WINDOWS |= {", window: {axis: y, max: place}": (0.35, None)}


@pytest.mark.parametrize("element", ["T6", "Q8", "Q9", *SINGLE])
def test_pressure_on_an_arc(signorom, tmp_path, figures, element):
    """Reactions of the held rim: pressure times the projected part of the bore, exactly; one window at each point."""
    n_dim = 3 if element in SINGLE else 2
    mesh = sector(element, n_dim)
    held = f"{{boundary: rim, displacement: {{{', '.join(f'{axis}: 0' for axis in 'xyz'[:n_dim])}}}}}"
    model = "solid" if n_dim == 3 else "plane_strain"
    loads = [
        f'{{boundary: bore, pressure: "100 * (case == {i})"{window}}}' for i, window in enumerate(WINDOWS, 1)
    ]
    signorom(
        "solve", write_problem(tmp_path, mesh, model, [held], loads, n_cases=len(WINDOWS)), folder=tmp_path
    )
    points = read_report(tmp_path, "body")["points"]
    for i, (window, parts) in enumerate(WINDOWS.items(), 1):
        entries = points[str(i)]["reactions"].values()
        found = next(entry for entry in entries if entry["boundary"] == "rim")
        worst = max(
            abs(found[axis] / (-100.0 * part) - 1) for axis, part in zip("xy", parts, strict=True) if part
        )
        figures.at_most("pressure on an arc", f"{element}{window}: resultant", worst, TOLERANCE, "projection")


def volume_of_revolution(mesh):
    """Of the quarter ring around x = 0: the integral of pi x^2 dy along its arcs of three nodes, exactly."""
    points, weights = np.polynomial.legendre.leggauss(3)
    total = 0.0
    for name, sign in (("rim", 1), ("bore", -1)):
        for nodes in mesh.facets_of(name):
            first, last, middle = mesh.coordinates[nodes, :2]
            bend, slope = (first + last) / 2 - middle, (last - first) / 2
            x = middle[0] + slope[0] * points + bend[0] * points**2
            total += sign * np.pi * np.sum(weights * x**2 * (slope[1] + 2 * bend[1] * points))
    return total


@pytest.mark.parametrize("element", ["T6", "Q8", "Q9"])
def test_gravity_and_pressure_in_the_round(signorom, tmp_path, figures, element):
    """A half ball with a bore: its weight, and the pressure in the bore that pushes it with p pi r^2."""
    mesh = sector(element, 2)
    held = "{boundary: rim, displacement: {r: 0, z: 0}}"
    loads = ["{boundary: bore, pressure: 100.0}", "{region: body, body_force: {z: -10.0}}"]
    deck = write_problem(tmp_path, mesh, "axisymmetric", [held], loads)
    signorom("solve", deck, folder=tmp_path)
    entries = read_report(tmp_path, "body")["points"]["1"]["reactions"].values()
    found = next(entry for entry in entries if entry["boundary"] == "rim")["z"]
    expected = 10 * volume_of_revolution(mesh) - 100 * np.pi
    figures.compare(
        "half ball", f"{element}: force on the rim", found, expected, TOLERANCE, "p pi r^2 and volume"
    )


@pytest.mark.parametrize("element", ["T10", "H20", "H27"])
def test_weight_of_a_curved_body(signorom, tmp_path, figures, element):
    """A quarter of a tube on its side: the reactions of the held rim are its weight, up to the arcs' 2e-4."""
    mesh = sector(element, 3)
    held = "{boundary: rim, displacement: {x: 0, y: 0, z: 0}}"
    deck = write_problem(tmp_path, mesh, "solid", [held], ["{region: body, body_force: {y: -10.0}}"])
    signorom("solve", deck, folder=tmp_path, n_ranks=4)
    entries = read_report(tmp_path, "body")["points"]["1"]["reactions"].values()
    found = next(entry for entry in entries if entry["boundary"] == "rim")["y"]
    figures.compare(
        "quarter of a tube", f"{element}: weight", found, 10 * 0.75 * np.pi, 5e-4, "volume of a tube"
    )


@pytest.mark.parametrize(("element", "model"), [("Q8", "plane_strain"), ("H20", "solid")])
def test_millimeters_and_ranks(signorom, tmp_path, figures, element, model):
    """The same pressure in a window on four ranks with the mesh in mm, on one rank in m."""
    n_dim = 3 if model == "solid" else 2
    held = f"{{boundary: rim, displacement: {{{', '.join(f'{axis}: 0' for axis in 'xyz'[:n_dim])}}}}}"
    loads = ["{boundary: bore, pressure: 100.0, window: {axis: x, min: place}}"]
    shown = []
    for unit, factor, n_ranks in (("m", 1.0, 1), ("mm", 1000.0, 4)):
        folder = tmp_path / unit
        folder.mkdir()
        deck = write_problem(folder, sector(element, n_dim), model, [held], loads, unit, factor)
        signorom("solve", deck, folder=folder, n_ranks=n_ranks)
        shown.append(read_fields(folder / "results" / "body" / "fields.h5"))
    for name in ("displacement", "stress", "stress_smoothed"):
        worst = np.abs(shown[1][name] - shown[0][name]).max() / np.abs(shown[0][name]).max()
        figures.at_most(
            "pressure on an arc", f"{element}: {name} in mm on 4 ranks", worst, TOLERANCE, "the same in m"
        )


def contact_deck(folder, model="plane_strain", formulation="auto"):
    """Two blocks, of the mesh that a test writes."""
    direction = "[0, 0, 1]" if model == "solid" else "[0, 1]"
    up = {"solid": "z", "axisymmetric": "z"}.get(model, "y")
    deck = folder / "two.yaml"
    deck.write_text(f"""title: Two blocks
mesh: {{file: two.msh, model: {model}, length_unit: m}}
parameters: {{stroke: {{min: 0.0, max: 0.1, unit: m}}}}
materials: {{all: {{regions: [lower, upper], young_modulus: 2.0e6, poisson_ratio: 0.3}}}}
boundary_conditions:
  - {{boundary: bottom, displacement: {{{up}: 0}}}}
  - {{boundary: top, displacement: {{{up}: -stroke}}}}
contact:
  - {{first: lower_face, second: upper_face, direction: {direction}, formulation: {formulation}}}
""")
    return deck


def refusal(signorom, folder, mesh, model="plane_strain", formulation="auto"):
    """What `check` says, after exit code 2."""
    mesh.write(folder / "two.msh")
    done = signorom.run("check", contact_deck(folder, model, formulation), folder=folder)
    assert done.returncode == 2, done.stdout + done.stderr
    return done.stderr


@pytest.mark.parametrize(("element", "face"), [("T10", "T6"), ("H20", "Q8")])
def test_faces_without_corner_weights(signorom, tmp_path, element, face):
    """In pairs of nodes: refused with the place in the deck, the reason and the remedy."""
    said = refusal(signorom, tmp_path, stacked_blocks(element, 3), "solid", "node_to_node")
    said = " ".join(said.split())
    assert f"two.yaml:9:13: error: contact[1]: the surface 'lower_face' has {face} faces" in said
    assert "a uniform pressure gives zero or negative forces at their corners" in said
    assert "Mesh.ElementOrder = 1" in said
    assert "formulation: mortar" in said


def test_edge_on_the_axis(signorom, tmp_path):
    """With 2 pi r the corner of a quadratic edge at r = 0 has no weight: no pair of nodes takes it, mortar does."""
    mesh = stacked_blocks("Q8", 2)
    mesh.write(tmp_path / "two.msh")
    said = signorom("check", contact_deck(tmp_path, "axisymmetric", "auto"), folder=tmp_path)
    why = "because node-to-node contact cannot use an edge of three nodes that ends on the axis"
    assert f"contact[1]: mortar, {why}: 100.0 % of 'lower_face' faces 'upper_face'" in said
    said = refusal(signorom, tmp_path, mesh, "axisymmetric", "node_to_node")
    assert (
        "two.yaml:9:13: error: contact[1]: the surface 'lower_face' has an edge of three nodes that ends"
        in said
    )
    assert "hint: take formulation: mortar" in said


def test_quadratic_edge_facing_two_linear_ones(signorom, tmp_path):
    """The nodes face each other, but one edge of three nodes meets two of two."""
    mesh = Mesh()
    mesh.add_block("lower", [np.array([0.0, 0.5, 1.0])] * 2, "Q4", {(1, 0): "bottom", (1, 1): "lower_face"})
    mesh.coordinates[:, 1] -= 1
    mesh.make_quadratic("Q8")
    mesh.add_block(
        "upper", [np.linspace(0, 1, 5), np.array([0.0, 1.0])], "Q4", {(1, 1): "top", (1, 0): "upper_face"}
    )
    said = refusal(signorom, tmp_path, mesh, formulation="node_to_node")
    assert "two.yaml:9:13: error: contact[1]: a facet of 'lower_face' with a node in its middle" in said
    assert "faces no facet whose nodes are the partners of its own" in said


@pytest.mark.parametrize(
    ("regions", "said"),
    [
        (
            ("lower",),
            "the Q4 2 of 'lower' and the Q8 1 of 'half' do not have the same node in the middle of their common edge",
        ),
        (("lower", "upper"), "the line 10 of 'bottom' and the Q8 1 of"),
        (("bottom",), "the line3 10 of 'bottom' and the Q4 1 of"),
    ],
)
def test_mixed_orders(signorom, tmp_path, regions, said):
    """Half of a region linear; linear edges on quadratic cells; quadratic edges on linear cells."""
    mesh = stacked_blocks("Q4", 2)
    if regions == ("lower",):
        regions = ("half",)
        lower = [i for i, (kind, name, _) in enumerate(mesh.elements) if (kind, name) == ("Q4", "lower")]
        for i in lower[::2]:
            mesh.elements[i] = ("Q4", "half", mesh.elements[i][2])
    mesh.make_quadratic("Q8", regions)
    message = refusal(signorom, tmp_path, mesh)
    assert re.search(rf"two\.msh:\d+:1: error: {said}", message), message
    assert "hint:" in message
    assert "Mesh.ElementOrder" in message
