# SPDX-License-Identifier: BSD-3-Clause
"""`signorom-post convert` with decks of Abaqus and CalculiX: names, sets of sets, surfaces, parts, errors."""

import math
from pathlib import Path

import numpy as np
import pytest
from msh_content import Msh

from signorom_post.cli import main

# two cubes of edge 1, one above the other, with a common face at z = 1
CUBES = """*Heading
** a comment
*Node, nset=NALL
1, 0, 0, 0
2, 1, 0, 0
3, 1, 1, 0
4, 0, 1, 0
5, 0, 0, 1
6, 1, 0, 1
7, 1, 1, 1
8, 0, 1, 1
9, 0, 0, 2
10, 1, 0, 2
11, 1, 1, 2
12, 0, 1, 2.0D0
*ELEMENT, TYPE=C3D8R,
ELSET=Lower
1, 1, 2, 3, 4,
5, 6, 7, 8
*element, type=c3d8, elset=UPPER
2, 5, 6, 7, 8, 9, 10, 11, 12
"""
LOWER, UPPER = [[0, 0, 0], [1, 1, 1]], [[0, 0, 1], [1, 1, 2]]
BOTTOM, MIDDLE, TOP = ([[0, 0, z], [1, 1, z]] for z in (0, 1, 2))


def converted(text: str, folder: Path, *options: str) -> Msh:
    """Writes a deck, converts it, and reads the result."""
    (folder / "part.inp").write_text(text)
    assert main(["convert", str(folder / "part.inp"), "-o", str(folder / "part.msh"), *options]) == 0
    return Msh(folder / "part.msh")


def test_element_sets_become_regions(tmp_path: Path) -> None:
    mesh = converted(CUBES + "*ELSET, ELSET=both\nlower, upper\n", tmp_path)
    assert mesh.names(3) == ["Lower", "UPPER", "both"]
    assert mesh.box(3, "Lower") == LOWER
    assert mesh.box(3, "UPPER") == UPPER
    assert mesh.n_elements(3, "both") == 2
    assert len(mesh.places) == 12


@pytest.mark.parametrize(
    "sets",
    [
        "*NSET, NSET=top\n9, 10, 11, 12\n",
        "*nset, nset=top, GENERATE\n9, 12, 1\n",
        "*NSET, NSET=top\n9, 10\n*NSET, NSET=TOP\n11\n12,\n",
        "*NSET, NSET=half, GENERATE\n9, 10\n*NSET, NSET=rest\n11, 12\n*NSET, NSET=top\nHalf, rest\n",
        "*NSET, NSET=_corners, INTERNAL\n9, 10, 11, 12\n*SURFACE, NAME=top, TYPE=NODE\n_corners\n",
        "*SURFACE, NAME=top, TYPE=ELEMENT\nupper, S2\n",
        "*SURFACE, NAME=top\n2, s2\n",
    ],
)
def test_ways_to_name_the_top(sets: str, tmp_path: Path) -> None:
    mesh = converted(CUBES + sets, tmp_path)
    assert mesh.box(2, "top") == TOP
    assert mesh.n_elements(2, "top") == 1
    assert [name for name in mesh.names(2) if name.startswith("_")] == []


def test_faces_of_a_hexahedron(tmp_path: Path) -> None:
    """S1 to S6 of the manual of CalculiX: 1234, 5876, 1562, 2673, 3784, 4851."""
    faces = {
        "S1": [[0, 0, 0], [1, 1, 0]],
        "S3": [[0, 0, 0], [1, 0, 1]],
        "S4": [[1, 0, 0], [1, 1, 1]],
        "S5": [[0, 1, 0], [1, 1, 1]],
        "S6": [[0, 0, 0], [0, 1, 1]],
    }
    mesh = converted(CUBES + "".join(f"*SURFACE, NAME={face}\n1, {face}\n" for face in faces), tmp_path)
    assert {face: mesh.box(2, face) for face in faces} == faces


def test_surface_of_a_set_is_its_outer_faces(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The face between both cubes is no outer face: five remain of the lower one, and S2 of it is said."""
    mesh = converted(CUBES + "*SURFACE, NAME=skin\nlower,\n*SURFACE, NAME=inner\nlower, S2\n", tmp_path)
    assert mesh.n_elements(2, "skin") == 5
    assert mesh.names(2) == ["skin"]
    assert "surface inner" in capsys.readouterr().out


def test_nodes_without_a_face_are_points(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mesh = converted(CUBES + "*NSET, NSET=pin\n3, 11\n*NSET, NSET=all\nnall\n", tmp_path)
    assert mesh.n_elements(0, "pin") == 2
    assert mesh.box(0, "pin") == [[1, 1, 0], [1, 1, 2]]
    said = capsys.readouterr().out
    assert "boundary pin: 2 points" in said
    assert "node set all" in said.split("left out")[1]


def test_node_set_and_surface_of_one_name(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Same faces: once. Other faces: another name."""
    text = CUBES + "*NSET, NSET=top\n9, 10, 11, 12\n*SURFACE, NAME=top\nupper, S2\n"
    text += "*NSET, NSET=low\n1, 2, 3, 4\n*SURFACE, NAME=low\nlower, S3\n"
    mesh = converted(text, tmp_path)
    assert mesh.names(2) == ["low", "low_nodes", "top"]
    assert "the same faces as boundary top" in capsys.readouterr().out


def test_what_is_left_out_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Materials, steps, shells, beams, springs."""
    text = (
        CUBES + "*ELEMENT, TYPE=S4, ELSET=shells\n11, 1, 2, 6, 9\n*ELEMENT, TYPE=B31, ELSET=beams\n12, 1, 7\n"
    )
    text += "*ELEMENT, TYPE=SPRINGA, ELSET=springs\n13, 1, 7\n*ELSET, ELSET=odd\n13\n*MATERIAL, NAME=steel\n*ELASTIC\n"
    text += "2e5, 0.3\n*STEP\n*STATIC\n*BOUNDARY\n1, 1, 3\n*END STEP\n"
    converted(text, tmp_path)
    said = " ".join(capsys.readouterr().out.split("left out")[1].split())
    for words in (
        "S4: 1 element",
        "*MATERIAL (1) materials",
        "*STEP (1) steps",
        "*BOUNDARY (1) supports",
        "*ELEMENT, TYPE=SPRINGA (1)",
    ):
        assert words in said


def test_shells_on_a_face_name_it(tmp_path: Path) -> None:
    """gmsh and others write the elements of surfaces (CPS4, S4) beside the cells."""
    mesh = converted(CUBES + "*ELEMENT, TYPE=CPS4, ELSET=lid\n3, 9, 12, 11, 10\n", tmp_path)
    assert mesh.box(2, "lid") == TOP


def test_split_gives_each_side_its_boundary(tmp_path: Path) -> None:
    mesh = converted(CUBES + "*SURFACE, NAME=Bottom\nlower, S1\n", tmp_path, "--split", "Lower", "UPPER")
    assert mesh.names(2) == [
        "Bottom",
        "Lower_to_UPPER",
        "UPPER_to_Lower",
    ]
    assert len(mesh.places) == 16
    both = [mesh.groups[2, name][0][1] for name in ("Lower_to_UPPER", "UPPER_to_Lower")]
    assert set(both[0]).isdisjoint(both[1])
    assert mesh.box(2, "Lower_to_UPPER") == mesh.box(2, "UPPER_to_Lower") == MIDDLE


def wheel_on_plate() -> str:
    """A wheel of 24 sectors of radius 1 that touches the plate below it at one node; plane."""
    nodes, cells = ["1, 0, 1"], []
    for i in range(24):
        angle = 2 * math.pi * i / 24
        nodes.append(f"{i + 2}, {math.sin(angle)!r}, {1 - math.cos(angle)!r}")
        cells.append(f"{i + 1}, 1, {i + 2}, {(i + 1) % 24 + 2}")
    nodes += ["100, -1, 0", "101, 1, 0", "102, -1, -1", "103, 0, -1", "104, 1, -1"]
    text = "*NODE\n" + "\n".join(nodes) + "\n*ELEMENT, TYPE=CPE3, ELSET=wheel\n" + "\n".join(cells)
    return text + "\n*ELEMENT, TYPE=CPE4, ELSET=plate\n101, 102, 103, 2, 100\n102, 103, 104, 101, 2\n"


def test_split_of_a_wheel_on_its_plate(tmp_path: Path) -> None:
    """They share one node: the new boundaries are the whole rim and the whole upper side of the plate."""
    mesh = converted(wheel_on_plate(), tmp_path, "--split", "wheel", "plate")
    assert mesh.n_elements(1, "wheel_to_plate") == 24
    assert mesh.n_elements(1, "plate_to_wheel") == 2
    assert mesh.box(1, "plate_to_wheel") == [[-1, 0, 0], [1, 0, 0]]
    # no set names a side: the others of the plate get names, to be held
    assert sorted(mesh.sides(1)) == ["plate_side_1", "plate_side_2", "plate_side_3"]


@pytest.mark.parametrize(
    ("names", "words"),
    [
        (("Lower", "middle"), "there is no region 'middle'; the regions are: Lower, UPPER"),
        (("Lower", "Lower"), "have cells in common"),
    ],
)
def test_split_that_cannot_be(
    names: tuple[str, str], words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "part.inp").write_text(CUBES)
    assert main(["convert", str(tmp_path / "part.inp"), "--split", *names]) == 2
    assert words in capsys.readouterr().err
    assert not (tmp_path / "part.msh").exists()


PART = "*PART, NAME=Cube\n*NODE\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n5,0,0,1\n6,1,0,1\n7,1,1,1\n8,0,1,1\n"
PART += "*ELEMENT, TYPE=C3D8\n1,1,2,3,4,5,6,7,8\n*NSET, NSET=low\n1,2,3,4\n*END PART\n"
ASSEMBLY = PART + "*ASSEMBLY, NAME=all\n*INSTANCE, NAME=a, PART=cube\n*END INSTANCE\n"
ASSEMBLY += "*INSTANCE, NAME=b, PART=Cube\n0, 0, 1.5\n0, 0, 0, 0, 0, 1, 90.\n*END INSTANCE\n"
ASSEMBLY += "*ELSET, ELSET=_lid_S2, INTERNAL, INSTANCE=b\n1,\n*SURFACE, NAME=lid\n_lid_S2, S2\n"
ASSEMBLY += "*NSET, NSET=feet\na.low\n*NSET, NSET=feet\nb.low\n*NSET, NSET=one\na.3\n*END ASSEMBLY\n"


def test_instances_of_a_part(tmp_path: Path) -> None:
    """The second one is lifted by 1.5 and turned about z by 90 degrees, which takes x into y and y into -x."""
    mesh = converted(ASSEMBLY, tmp_path)
    assert mesh.names(3) == ["a", "b"]
    assert mesh.box(3, "a") == LOWER
    np.testing.assert_allclose(mesh.box(3, "b"), [[-1, 0, 1.5], [0, 1, 2.5]], atol=1e-15)
    assert mesh.names(2) == ["a.low", "b.low", "feet", "lid"]
    assert mesh.n_elements(2, "feet") == 2
    np.testing.assert_allclose(mesh.box(2, "lid"), [[-1, 0, 2.5], [0, 1, 2.5]], atol=1e-15)
    assert mesh.box(0, "one") == [[1, 1, 0], [1, 1, 0]]


def test_included_files_and_data_of_other_files(tmp_path: Path) -> None:
    (tmp_path / "mesh").mkdir()
    (tmp_path / "mesh" / "cubes.txt").write_text(CUBES)
    (tmp_path / "top.txt").write_text("9, 10, 11, 12\n")
    mesh = converted("*INCLUDE, INPUT=mesh/cubes.txt\n*NSET, NSET=top, INPUT=top.txt\n", tmp_path)
    assert mesh.box(2, "top") == TOP


def test_bodies_without_names(tmp_path: Path) -> None:
    """Cells in no set are a region per body; faces in no set are boundaries that end at sharp edges."""
    text = "*NODE\n" + "".join(
        f"{i + 1}, {x + 3 * body}, {y}, {z}\n" for i, (body, z, y, x) in enumerate(np.ndindex(2, 2, 2, 2))
    )
    text += "*ELEMENT, TYPE=C3D8\n1, 1, 2, 4, 3, 5, 6, 8, 7\n2, 9, 10, 12, 11, 13, 14, 16, 15\n"
    mesh = converted(text + "*NSET, NSET=floor\n1, 2, 3, 4\n", tmp_path)
    assert mesh.names(3) == ["body_1", "body_2"]
    assert mesh.names(2) == ["floor"]
    sides = [*(f"body_1_side_{i}" for i in range(1, 6)), *(f"body_2_side_{i}" for i in range(1, 7))]
    assert sorted(mesh.sides(2)) == sides
    assert [mesh.n_elements(2, side) for side in sides] == [1] * 11


def test_cells_of_negative_volume_and_with_repeated_nodes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A mirrored tetrahedron is turned; a hexahedron that is a prism becomes one."""
    text = "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n5,1,0,1\n6,0,1,1\n7,0,0,-1\n"
    text += "*ELEMENT, TYPE=C3D8, ELSET=a\n1, 1,2,3,3, 4,5,6,6\n*ELEMENT, TYPE=C3D4, ELSET=b\n2, 1,2,3,7\n"
    mesh = converted(text, tmp_path)
    assert [kind for kind, _ in mesh.groups[3, "a"]] == [6]
    ((_, nodes),) = mesh.groups[3, "b"]
    corners = mesh.places[nodes]
    assert np.linalg.det(corners[1:] - corners[0]) > 0
    said = capsys.readouterr().out
    assert "1 cell had a negative volume" in said
    assert "1 cell had a node twice" in said


BAD = {
    "a number": (CUBES.replace("10, 1, 0, 2", "10, one, 0, 2"), ":13: error: 'one' is not a number"),
    "a node": (
        CUBES.replace("11, 12\n", "11, 13\n"),
        ":21: error: element 2 has node 13, which is not defined",
    ),
    "too few nodes": (
        CUBES.replace("11, 12\n", "11\n"),
        ":21: error: element 2 has 7 nodes, and C3D8 needs 8",
    ),
    "a set": (CUBES + "*NSET, NSET=a\n1\nb\n", ":24: error: there is no node set 'b'"),
    "a set of itself": (CUBES + "*NSET, NSET=a\nb\n*NSET, NSET=b\na\n", "holds itself"),
    "a face": (CUBES + "*SURFACE, NAME=a\nlower, S7\n", ":23: error: a hexahedron has no face S7"),
    "a word": (CUBES + "*SURFACE, NAME=a\nlower, top\n", ":23: error: 'TOP' is not a face"),
    "an instance": (ASSEMBLY.replace("PART=cube", "PART=sphere"), ": error: there is no part 'sphere'"),
    "a missing file": ("*INCLUDE, INPUT=no.inp\n", ":1: error: *INCLUDE names the file 'no.inp'"),
    "a circle of files": ("*INCLUDE, INPUT=part.inp\n", "does one include itself?"),
    "no nodes": ("squeeze: 0.2\n", "part.inp: error: the file has no nodes (*NODE)"),
    "shells only": (
        CUBES.split("*ELEMENT")[0] + "*ELEMENT, TYPE=S4\n1, 1, 2, 6, 5\n",
        "shells cannot become bodies",
    ),
    "no elements": (CUBES.split("*ELEMENT")[0], "no solid or plane elements"),
    "an empty file": (" \n", "part.inp: error: the file is empty"),
    "a step of 0": (CUBES + "*NSET, NSET=a, GENERATE\n1, 4, 0\n", ":23: error: a line of GENERATE"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_decks(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text, words = BAD[name]
    (tmp_path / "part.inp").write_text(text)
    assert main(["convert", str(tmp_path / "part.inp")]) == 2
    assert words in capsys.readouterr().err
    assert not (tmp_path / "part.msh").exists()
