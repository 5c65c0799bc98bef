# SPDX-License-Identifier: BSD-3-Clause
"""Meshes that others made: all formats of gmsh, groups without names, no groups, planes, boundaries that are missing.

The meshes are those of `block_meshes`, written by `gmsh_formats`; meshio reads the same files, where it can.
"""

import re
import subprocess

import meshio
import numpy as np
import pytest
import yaml

from block_meshes import stacked_blocks
from gmsh_formats import FORMATS, groups_of, write_as
from gmsh_mesh import make_mesh
from runs import read_fields

NOUNS = {0: "point", 1: "curve", 2: "surface", 3: "volume"}


def drafted(signorom, folder, name="part"):
    """What `init` says, its deck, and the boundaries of the deck: name -> ranges of the coordinates."""
    said = signorom("init", f"{name}.msh", folder=folder)
    text = (folder / f"{name}.yaml").read_text()
    boxes = {}
    for line in re.findall(r"^#   (.*)$", text, re.MULTILINE):
        boundary, box = line.split(": ")
        boxes[boundary] = [float(number) for number in re.findall(r"-?\d+\.\d+(?:e-?\d+)?", box)]
    return said, yaml.safe_load(text), boxes


def names_of(mesh, grouping):
    """The name by which a deck calls each group (dimension, name) of a mesh."""
    numbers = {"numbered": 1, "none": 101}
    return {
        (n_dim, name): name if grouping == "named" else f"{NOUNS[n_dim]}_{i + numbers[grouping]}"
        for i, (n_dim, name) in enumerate(groups_of(mesh))
    }


def boxes_by_meshio(path, grouping, n_dim):
    """Name or number of each boundary -> ranges of its coordinates, from what meshio reads."""
    mesh = meshio.read(path, "gmsh")
    key = "gmsh:geometrical" if grouping == "none" else "gmsh:physical"
    nodes = {}
    for block, tags in zip(mesh.cells, mesh.cell_data[key], strict=True):
        for tag in np.unique(tags):
            nodes.setdefault((block.dim, int(tag)), []).extend(block.data[tags == tag].ravel())
    names = {(dim, tag): name for name, (tag, dim) in mesh.field_data.items()}
    boxes = {}
    for (dim, tag), own in nodes.items():
        if dim < n_dim:
            places = mesh.points[own, :n_dim]
            box = np.stack([places.min(axis=0), places.max(axis=0)], axis=1).ravel()
            boxes[names.get((dim, tag), f"{NOUNS[dim]}_{tag}")] = box.tolist()
    return boxes


@pytest.mark.parametrize("grouping", ["named", "numbered", "none"])
@pytest.mark.parametrize(("version", "is_binary"), FORMATS)
def test_every_format(signorom, tmp_path, version, is_binary, grouping):
    """Regions, boundaries and contact that `init` finds; boxes by meshio for the formats that it reads."""
    element = "T3" if version < "4" else "H8"
    n_dim = 2 if element == "T3" else 3
    mesh = stacked_blocks(element, n_dim)
    write_as(mesh, tmp_path / "part.msh", version, is_binary, grouping)
    said, deck, boxes = drafted(signorom, tmp_path)
    names = names_of(mesh, grouping)
    assert list(deck["materials"]) == [names[n_dim, "lower"], names[n_dim, "upper"]]
    pairs = [{entry["first"], entry["second"]} for entry in deck["contact"]]
    assert pairs == [{names[n_dim - 1, "lower_face"], names[n_dim - 1, "upper_face"]}]
    assert (said.count("note: ") == 0) is (grouping == "named")
    assert ("physical groups of the mesh without a name" in said) is (grouping == "numbered")
    assert ("elements of the mesh in no physical group" in said) is (grouping == "none")
    # meshio knows no 2.0 and 2.1, and in binary 2.2 no node numbers with holes
    if (version, is_binary) in [("2.2", False), ("4.0", False), ("4.0", True), ("4.1", False), ("4.1", True)]:
        expected = boxes_by_meshio(tmp_path / "part.msh", grouping, n_dim)
        assert sorted(boxes) == sorted(expected)
        for name, box in expected.items():
            assert boxes[name] == pytest.approx(box, abs=1e-3)


@pytest.mark.parametrize("version", ["2.0", "2.2", "4.0", "4.1"])
def test_other_machines(signorom, tmp_path, version):
    """Numbers with the other byte order; in 4.1, sizes of 4 bytes, too: the same deck, mark by mark."""
    mesh = stacked_blocks("H8", 3)
    write_as(mesh, tmp_path / "part.msh", version, True)
    signorom("init", "part.msh", folder=tmp_path)
    expected = (tmp_path / "part.yaml").read_text()
    for order, size in [(">", "Q"), ("<", "I"), (">", "I")]:
        if size == "I" and version != "4.1":
            continue
        write_as(mesh, tmp_path / "part.msh", version, True, order=order, size=size)
        (tmp_path / "part.yaml").unlink()
        signorom("init", "part.msh", folder=tmp_path)
        assert (tmp_path / "part.yaml").read_text() == expected


DECK = """title: Two blocks
mesh: {{file: part.msh, model: plane_strain, length_unit: m}}
parameters: {{stroke: {{min: 0.0, max: 0.1, unit: m}}}}
materials: {{all: {{regions: [{lower}, {upper}], young_modulus: 2.0e6, poisson_ratio: 0.3}}}}
boundary_conditions:
  - {{boundary: {bottom}, displacement: {{x: 0, y: 0}}}}
  - {{boundary: {top}, displacement: {{x: 0, y: -stroke}}}}
contact:
  - {{first: {lower_face}, second: {upper_face}, direction: [0, 1]}}
output: {{points: [{{stroke: 0.1}}]}}
"""


def solved(signorom, folder, mesh, grouping, coordinates=None, n_ranks=1):
    """The fields of two blocks that are pressed together, and what `solve` says."""
    if coordinates is not None:
        mesh.coordinates = coordinates
    folder.mkdir()
    write_as(mesh, folder / "part.msh", "4.1", grouping=grouping)
    names = {name: own for (_, name), own in names_of(mesh, grouping).items()}
    (folder / "part.yaml").write_text(DECK.format(**names))
    said = signorom("solve", "part.yaml", folder=folder, n_ranks=n_ranks)
    return read_fields(folder / "results" / "part" / "fields.h5"), said


@pytest.mark.parametrize("grouping", ["numbered", "none"])
def test_same_answer_without_names(signorom, tmp_path, grouping):
    """Bit by bit, on two ranks; the note is there once."""
    expected, said = solved(signorom, tmp_path / "named", stacked_blocks("T6", 2), "named", n_ranks=2)
    assert "note: " not in said
    fields, said = solved(signorom, tmp_path / grouping, stacked_blocks("T6", 2), grouping, n_ranks=2)
    np.testing.assert_array_equal(fields["displacement"], expected["displacement"])
    assert said.count("of the mesh") == 1
    assert names_of(stacked_blocks("T6", 2), grouping)[2, "lower"] in said


@pytest.mark.parametrize("order", [[0, 2, 1], [2, 0, 1]])
def test_mesh_in_another_plane(signorom, tmp_path, order):
    """In the planes y = const and x = const the other two axes, in their order, are x and y."""
    mesh = stacked_blocks("T3", 2)
    expected, _ = solved(signorom, tmp_path / "plane", stacked_blocks("T3", 2), "named")
    places = mesh.coordinates + [0, 0, 7.0]
    fields, said = solved(signorom, tmp_path / "turned", mesh, "named", places[:, order])
    np.testing.assert_array_equal(fields["displacement"], expected["displacement"])
    axes = "x and z" if order == [0, 2, 1] else "y and z"
    assert f"{axes} of the file are x and y of the model" in said


def test_names_beside_numbers(signorom, tmp_path):
    """Some groups have names, some have not, and some elements are in no group."""
    mesh = stacked_blocks("T3", 2)
    write_as(mesh, tmp_path / "part.msh", "2.2")
    text = (tmp_path / "part.msh").read_text()
    upper = groups_of(mesh).index((2, "upper")) + 1
    top = groups_of(mesh).index((1, "top")) + 1
    names = re.search(r"\$PhysicalNames\n.*?\n(.*)\$EndPhysicalNames", text, re.DOTALL).group(1)
    kept = [line for line in names.splitlines() if '"upper"' not in line]
    text = text.replace(names, "\n".join(kept) + "\n").replace(
        f"$PhysicalNames\n{len(kept) + 1}", f"$PhysicalNames\n{len(kept)}"
    )
    # the elements of `top` lose their group, but not their entity
    text = re.sub(rf"^(\d+ 1 2) {top} ", r"\1 0 ", text, flags=re.MULTILINE)
    (tmp_path / "part.msh").write_text(text)
    said, deck, boxes = drafted(signorom, tmp_path)
    assert list(deck["materials"]) == ["lower", f"surface_{upper}"]
    assert boxes[f"curve_entity_{top + 100}"] == [0.0, 1.0, 1.0, 1.0]
    assert f"without a name are called by dimension and number: surface_{upper}\n" in said
    assert f"geometric entity: curve_entity_{top + 100}\n" in said


def test_unused_nodes_and_elements_of_two_formats(signorom, tmp_path):
    """A node of nothing, a construction point, a curve of a solid: no region or boundary is lost, none is made up."""
    mesh = stacked_blocks("T4", 3)
    n = len(mesh.coordinates)
    mesh.coordinates = np.vstack([mesh.coordinates, [[9.0, 9.0, 9.0], [8.0, 8.0, 8.0]]])
    mesh.elements.append(("P1", "far", [n]))
    edge = [node for node in mesh.nodes_of("bottom") if mesh.coordinates[node, 1] == 0.0][:2]
    mesh.elements.append(("L2", "edge", [int(node) for node in edge]))
    write_as(mesh, tmp_path / "part.msh", "4.1", True, "none")
    _, deck, boxes = drafted(signorom, tmp_path)
    assert len(deck["materials"]) == 2
    names = names_of(mesh, "none")
    assert names[1, "edge"] in boxes
    assert names[0, "far"] not in boxes


# two blocks of which only the physical groups of the cells are saved
BODIES = """SetFactory("OpenCASCADE");
DefineConstant[n_dim = 2];
Mesh.MeshSizeMax = 0.5;
If (n_dim == 2)
  Rectangle(1) = {0, 0, 0, 1, 1};
  Rectangle(2) = {0, 1, 0, 1, 1};
  Physical Surface(7) = {1, 2};
Else
  Box(1) = {0, 0, 0, 1, 1, 1};
  Box(2) = {0, 0, 1, 1, 1, 1};
  Physical Volume(7) = {1, 2};
EndIf
"""


@pytest.mark.parametrize("n_dim", [2, 3])
def test_boundary_that_is_missing(signorom, tmp_path, n_dim):
    """Only the bodies have elements: what gmsh can do is said, and works."""
    (tmp_path / "part.geo").write_text(BODIES)
    make_mesh(tmp_path / "part.geo", tmp_path / "part.msh", n_dim, n_dim=n_dim)
    done = signorom.run("init", "part.msh", folder=tmp_path)
    assert done.returncode == 2
    assert "part.msh: error: the mesh has no elements on its boundary" in done.stderr
    command = re.search(r"writes divided.msh: (gmsh .*divided.msh)", " ".join(done.stderr.split())).group(1)
    subprocess.run(command, shell=True, cwd=tmp_path, capture_output=True, check=True)
    _, deck, boxes = drafted(signorom, tmp_path, "divided")
    sides = [box for name, box in boxes.items() if name.startswith(NOUNS[n_dim - 1])]
    assert len(sides) == 2 * 2 * n_dim
    assert sum(box[2 * n_dim - 2 :] == [1.0, 1.0] for box in sides) == 2
    assert len(deck["contact"]) == 1


def test_plane_mesh_out_of_all_planes(signorom, tmp_path):
    """A tilted plane: the extents are said."""
    mesh = stacked_blocks("T3", 2)
    mesh.coordinates[:, 2] = mesh.coordinates[:, 1]
    write_as(mesh, tmp_path / "part.msh", "4.1")
    done = signorom.run("init", "part.msh", folder=tmp_path)
    assert done.returncode == 2
    said = (
        "a plane model needs a mesh in a plane z = const, y = const or x = const; here x runs from 0.0 to 1.0"
    )
    assert said in done.stderr


# a cube, nodes 1 to 8, below two tetrahedra that divide its top, or below one pyramid
TORN = """$MeshFormat
2.2 0 8
$EndMeshFormat
$Nodes
9
1 0 0 0
2 1 0 0
3 1 1 0
4 0 1 0
5 0 0 1
6 1 0 1
7 1 1 1
8 0 1 1
9 0.5 0.5 2
$EndNodes
$Elements
COUNT
1 3 2 2 1 1 4 3 2
2 5 2 1 1 1 2 3 4 5 6 7 8
TOP
$EndElements
"""


def test_tetrahedra_on_a_quadrilateral_face(signorom, tmp_path):
    """The edge from 5 to 7 divides the face 5, 6, 7, 8 of the cube, whose displacement bends there: a note says so."""
    top = "3 4 2 3 1 5 6 7 9\n4 4 2 3 1 5 7 8 9"
    (tmp_path / "torn.msh").write_text(TORN.replace("COUNT", "4").replace("TOP", top))
    done = signorom.run("init", "torn.msh", folder=tmp_path)
    said = " ".join((done.stdout + done.stderr).split())
    assert "note: 2 cells of the mesh have an edge across a quadrilateral face of another cell" in said
    assert "torn.msh:20, the T4 3 of 'volume_3', between the nodes 5 and 7, on the H8 2 of 'volume_1'" in said
    (tmp_path / "whole.msh").write_text(TORN.replace("COUNT", "3").replace("TOP", "3 7 2 3 1 5 6 7 8 9"))
    assert "quadrilateral face" not in signorom("init", "whole.msh", folder=tmp_path)
