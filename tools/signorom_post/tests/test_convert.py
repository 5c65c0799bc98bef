# SPDX-License-Identifier: BSD-3-Clause
"""`signorom-post convert`: orders of nodes, the formats beside Abaqus's, files that cannot be used."""

from collections.abc import Callable
from pathlib import Path

import h5py
import meshio
import numpy as np
import pytest
import vtk
from msh_content import Msh

from signorom_post.cli import main
from signorom_post.convert.elements import (
    BY_NAME,
    KINDS,
    NASTRAN_MIDDLES,
    VTK_MIDDLES,
    from_middles,
    from_unv,
)

#: VTK's own cells, whose reference nodes give the order; those of its pyramid have no middles
VTK_CELLS = {
    "L3": vtk.vtkQuadraticEdge,
    "T6": vtk.vtkQuadraticTriangle,
    "Q8": vtk.vtkQuadraticQuad,
    "Q9": vtk.vtkBiQuadraticQuad,
    "T10": vtk.vtkQuadraticTetra,
    "W15": vtk.vtkQuadraticWedge,
    "W18": vtk.vtkBiQuadraticQuadraticWedge,
    "H20": vtk.vtkQuadraticHexahedron,
    "H27": vtk.vtkTriQuadraticHexahedron,
}


@pytest.mark.parametrize("name", VTK_CELLS)
def test_order_of_vtk(name: str) -> None:
    """Each node behind the corners is in the middle of those that its name gives, by VTK's reference nodes."""
    kind = BY_NAME[name]
    places = np.array(VTK_CELLS[name]().GetParametricCoords()).reshape(-1, 3)
    for node, middle in enumerate(VTK_MIDDLES[name].split(), kind.n_corners):
        np.testing.assert_allclose(places[node], places[[int(i) for i in middle]].mean(axis=0), atol=1e-12)


#: order of the manual of gmsh (Node ordering), as pairs of corners
GMSH_EDGES = {
    "T10": "01 12 02 03 23 13",
    "H20": "01 03 04 12 15 23 26 37 45 47 56 67",
    "W15": "01 02 03 12 14 25 34 35 45",
    "P13": "01 03 04 12 14 23 24 34",
}


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_each_order_is_a_permutation(kind: object) -> None:
    for order in (from_middles(kind, VTK_MIDDLES), from_middles(kind, NASTRAN_MIDDLES), from_unv(kind)):
        if kind.name in VTK_MIDDLES or kind.n_nodes == kind.n_corners:
            assert sorted(order) == list(range(kind.n_nodes))
    if kind.n_dim > 1:
        assert sorted(kind.mirrored) == list(range(kind.n_nodes))
        assert (kind.mirrored[kind.mirrored] == np.arange(kind.n_nodes)).all()
    if kind.name in GMSH_EDGES:
        assert kind.middles == GMSH_EDGES[kind.name]


# a prism of 1 x 1 x 2 of two cubes; names of nodes are (x, y, z)
CORNERS = [(x, y, z) for z in (0, 1, 2) for y in (0, 1) for x in (0, 1)]
CUBE = [0, 1, 3, 2, 4, 5, 7, 6]
LOWER, UPPER = CUBE, [node + 4 for node in CUBE]
TOP = [8, 9, 11, 10]
TOP_BOX = [[0, 0, 2], [1, 1, 2]]
UPPER_BOX = [[0, 0, 1], [1, 1, 2]]


def convert(path: Path, *options: str) -> Msh:
    """Converts a file, and reads the result."""
    output = path.with_name("converted.msh")
    assert main(["convert", str(path), "-o", str(output), *options]) == 0
    return Msh(output)


def from_one(nodes: list[int]) -> list[int]:
    return [node + 1 for node in nodes]


def write_unv(path: Path) -> None:
    """Nodes (2411), two bricks, a shell and a rod with the line that Salome writes for it (2412), groups (2467)."""
    lines = ["    -1", "  2411"]
    for i, place in enumerate(CORNERS, 1):
        lines += [
            f"{i:10d}         1         1        11",
            "".join(f"{x:25.16E}" for x in place).replace("E", "D"),
        ]
    lines += ["    -1", "    -1", "  2412"]
    for i, (descriptor, nodes) in enumerate([(115, LOWER), (115, UPPER), (94, TOP), (11, [0, 1])], 1):
        lines.append(f"{i:10d}{descriptor:10d}         2         1         7{len(nodes):10d}")
        lines += ["         0         0         0"] if descriptor == 11 else []
        lines.append("".join(f"{node:10d}" for node in from_one(nodes)))
    lines += ["    -1", "    -1", "  2467"]
    groups = {
        "upper": (8, [2]),
        "lower": (8, [1]),
        "top": (8, [3]),
        "floor": (7, [1, 2, 3, 4]),
        "edge": (8, [4]),
    }
    for i, (name, (what, members)) in enumerate(groups.items(), 1):
        lines += [f"{i:10d}" + "         0" * 6 + f"{len(members):10d}", name]
        words = [f"{what:10d}{member:10d}         0         0" for member in members]
        lines += ["".join(words[j : j + 2]) for j in range(0, len(words), 2)]
    path.write_text("\n".join([*lines, "    -1", "    -1", "   164", "  2  foreign", "    -1", ""]))


def write_med(path: Path) -> None:
    """The layout of MED 3: coordinates and nodes by columns, families with names of 80 bytes."""
    with h5py.File(path, "w") as file:
        step = file.create_group("ENS_MAA/part/-0000000000000000001-0000000000000000001")
        file["ENS_MAA/part"].attrs["ESP"] = 3
        step["NOE/COO"] = np.array(CORNERS, dtype=float).T.ravel()
        step["NOE/FAM"] = [1] * 4 + [0] * 8
        # the corners of a hexahedron run the other way round than gmsh's
        turned = [0, 3, 2, 1, 4, 7, 6, 5]
        step["MAI/HE8/NOD"] = np.array([LOWER, UPPER])[:, turned].T.ravel() + 1
        step["MAI/HE8/FAM"] = [-1, -2]
        step["MAI/QU4/NOD"] = np.array(TOP) + 1
        step["MAI/QU4/FAM"] = [-3]
        step["MAI/SE2/NOD"] = [1, 2]
        step["MAI/SE2/FAM"] = [-4]
        families = {("NOEUD", 1): ["floor"], ("ELEME", -1): ["lower", "all"], ("ELEME", -2): ["upper", "all"]}
        families |= {("ELEME", -3): ["top"], ("ELEME", -4): ["edge"]}
        for (kind, number), names in families.items():
            family = file.create_group(f"FAS/part/{kind}/FAM_{number}")
            family.attrs["NUM"] = number
            rows = [list(name.encode().ljust(80, b"\0")) for name in names]
            family["GRO/NOM"] = np.array(rows, dtype=np.int8)


@pytest.mark.parametrize(("suffix", "write"), [("unv", write_unv), ("med", write_med)])
def test_groups_of_nodes_and_elements(suffix: str, write: Callable[[Path], None], tmp_path: Path) -> None:
    path = tmp_path / f"part.{suffix}"
    write(path)
    mesh = convert(path)
    assert [name for name in mesh.names(3) if name != "all"] == ["lower", "upper"]
    assert mesh.box(3, "upper") == UPPER_BOX
    assert mesh.names(2) == ["floor", "top"]
    assert mesh.box(2, "top") == TOP_BOX
    assert mesh.box(2, "floor") == [[0, 0, 0], [1, 1, 0]]
    assert mesh.box(1, "edge") == [[0, 0, 0], [1, 0, 0]]


def write_bdf(path: Path, form: str) -> None:
    """Two bricks of properties 7 (named by a comment) and 8; supports 5 (THRU) and 6; 1.5-1 is 0.15."""

    def card(name: str, *words: object) -> list[str]:
        fields = [str(word) for word in words]
        if form == "free":
            rows = [fields[i : i + 8] for i in range(0, len(fields), 8)]
            return [",".join([name if i == 0 else "", *row]) for i, row in enumerate(rows)]
        width, n, star = (16, 4, "*") if form == "large" else (8, 8, "")
        rows = ["".join(word.rjust(width) for word in fields[i : i + n]) for i in range(0, len(fields), n)]
        return [f"{name + star if i == 0 else star or '+':<8}{row}" for i, row in enumerate(rows)]

    lines = ["SOL 101", "CEND", "SUBCASE 1", "SPC = 5", "BEGIN BULK", '$HMNAME PROP               7"lower" 4']
    for i, (x, y, z) in enumerate(CORNERS, 1):
        lines += card("GRID", i, "", f"{x}.", "1.5-1" if y else ".0", f"{z}.0E0")
    lines += card("CHEXA", 1, 7, *from_one(LOWER)) + card("CHEXA", 2, 8, *from_one(UPPER))
    lines += card("SPC1", 5, 123, 1, "THRU", 4) + card("SPC1", 6, 3, *from_one(TOP))
    lines += card("PSOLID", 7, 1) + card("MAT1", 1, "2.1+5", "", "0.3") + ["ENDDATA"]
    path.write_text("\n".join(lines) + "\n")


@pytest.mark.parametrize("form", ["small", "large", "free"])
def test_bulk_data_of_nastran(form: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_bdf(tmp_path / "part.bdf", form)
    mesh = convert(tmp_path / "part.bdf")
    assert mesh.names(3) == ["lower", "property_8"]
    assert mesh.box(3, "property_8") == [[0, 0, 1], [1, 0.15, 2]]
    assert mesh.box(2, "SPC_5") == [[0, 0, 0], [1, 0.15, 0]]
    assert mesh.box(2, "SPC_6") == [[0, 0, 2], [1, 0.15, 2]]
    assert "MAT1 (1)" in capsys.readouterr().out.split("left out")[1]


@pytest.mark.parametrize("suffix", ["vtu", "vtk", "xdmf", "mesh", "msh"])
def test_formats_of_meshio(suffix: str, tmp_path: Path) -> None:
    """Whole numbers on cells are regions; quadrilaterals on outer faces carry theirs as boundaries."""
    mark = {"mesh": "medit:ref", "msh": "gmsh:physical"}.get(suffix, "part")
    mesh = meshio.Mesh(
        np.array(CORNERS, dtype=float),
        [("hexahedron", [LOWER, UPPER]), ("quad", [TOP])],
        cell_data={mark: [np.array([1, 2], dtype=np.int32), np.array([3], dtype=np.int32)]},
    )
    path = tmp_path / f"part.{suffix}"
    formats = {"msh": {"file_format": "gmsh22", "binary": False}}
    meshio.write(path, mesh, **formats.get(suffix, {}))
    made = convert(path)
    names = {"mesh": "ref_{}", "msh": "volume_{}"}.get(suffix, "part_{}")
    assert made.names(3) == [names.format(1), names.format(2)]
    assert made.box(3, names.format(2)) == UPPER_BOX
    assert made.names(2) == [names.replace("volume", "surface").format(3)]
    assert made.box(2, made.names(2)[0]) == TOP_BOX


def as_22(mesh: Msh) -> str:
    """Returns the text of a mesh in format 2.2, where an element has one group."""
    groups = sorted(mesh.groups)
    elements = [(kind, i, nodes) for i, group in enumerate(groups, 1) for kind, nodes in mesh.groups[group]]
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(groups))]
    lines += [f'{n_dim} {i} "{name}"' for i, (n_dim, name) in enumerate(groups, 1)]
    lines += ["$EndPhysicalNames", "$Nodes", str(len(mesh.places))]
    lines += [f"{i} {x} {y} {z}" for i, (x, y, z) in enumerate(mesh.places.tolist(), 1)]
    lines += ["$EndNodes", "$Elements", str(len(elements))]
    for number, (kind, group, nodes) in enumerate(elements, 1):
        lines.append(f"{number} {kind} 2 {group} {group} {' '.join(map(str, from_one(nodes)))}")
    return "\n".join([*lines, "$EndElements", ""])


@pytest.mark.parametrize("form", ["4.1", "2.2"])
def test_names_and_split_of_a_mesh_of_gmsh(form: str, tmp_path: Path) -> None:
    """A .msh is read, too, to split what shares nodes: with its names, to another file."""
    write_unv(tmp_path / "part.unv")
    first = tmp_path / "first.msh"
    assert main(["convert", str(tmp_path / "part.unv"), "-o", str(first)]) == 0
    if form == "2.2":
        first.write_text(as_22(Msh(first)))
    mesh = convert(first, "--split", "lower", "upper")
    assert mesh.names(3) == ["lower", "upper"]
    assert {"lower_to_upper", "upper_to_lower", "top", "floor"} <= set(mesh.names(2))
    assert len(mesh.places) == 16
    assert main(["convert", str(first), "-o", str(first)]) == 2


def test_mesh_of_gmsh_without_groups(tmp_path: Path) -> None:
    """Its entities, the second tag of an element in format 2.2, take the place of groups, as in decks."""
    write_unv(tmp_path / "part.unv")
    assert main(["convert", str(tmp_path / "part.unv"), "-o", str(tmp_path / "part.msh")]) == 0
    text = as_22(Msh(tmp_path / "part.msh"))
    head, elements = text.split("$Elements\n")
    lines = [line.split() for line in elements.splitlines()]
    lines = [[*words[:3], "0", *words[4:]] if len(words) > 4 else words for words in lines]
    (tmp_path / "part.msh").write_text(head + "$Elements\n" + "\n".join(map(" ".join, lines)) + "\n")
    mesh = convert(tmp_path / "part.msh")
    assert [name.split("_")[0] for name in mesh.names(3)] == ["volume", "volume"]
    assert {name.split("_")[0] for name in mesh.names(2)} == {"surface"}


BAD = {
    "part.unv": {
        "no dataset": (b"squeeze: 0.2\n", ":1: error: this is not a universal file"),
        "cut off": (b"    -1\n  2411\n 1 1 1 11\n", ":1: error: this dataset does not end"),
        "a number": (b"    -1\n  2411\n 1 1 1 11\n 0. x 0.\n    -1\n", ":4: error: three coordinates"),
        "a node": (b"    -1\n  2412\n 1 111 2 1 7 4\n 1 2 3 4\n    -1\n", ":3: error: element 1 has node 1"),
    },
    "part.bdf": {
        "no card": (b"squeeze\n", "no GRID card"),
        "a node": (b"GRID,1,,0.,0.,0.\nCTETRA,1,1,1,2,3,4\n", ":2: error: CTETRA: element 1 has node 2"),
        "a number": (b"GRID,1,,0.,zero,0.\n", ":1: error: GRID: 'zero' is not a number"),
        "a system": (b"GRID,1,4,0.,0.,0.\n", ":1: error: GRID: the node is given in the coordinate system 4"),
    },
    "part.med": {"text": (b"squeeze: 0.2\n", "this is not a MED file")},
    "part.vtu": {"text": (b"squeeze: 0.2\n", "meshio cannot read it as VTK")},
    "part.mesh": {"text": (b"squeeze: 0.2\n", "meshio cannot read it as Medit")},
    "part.msh": {
        "format 1.0": (b"$NOD\n1\n1 0 0 0\n$ENDNOD\n", "let gmsh write it in format 4.1 first: gmsh")
    },
}
BAD_FILES = [(name, what) for name, cases in BAD.items() for what in cases]


@pytest.mark.parametrize(("name", "what"), BAD_FILES)
def test_bad_files(name: str, what: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data, words = BAD[name][what]
    (tmp_path / name).write_bytes(data)
    assert main(["convert", str(tmp_path / name), "-o", str(tmp_path / "made.msh")]) == 2
    said = capsys.readouterr().err
    assert said.startswith(str(tmp_path / name))
    assert words in said


@pytest.mark.parametrize("suffix", ["inp", "unv", "med", "bdf", "vtu", "vtk", "xdmf", "mesh", "msh"])
@pytest.mark.parametrize("data", [None, b"", bytes(range(256)) * 40, "folder"], ids=repr)
def test_garbage(
    suffix: str, data: bytes | str | None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """No file, an empty one, bytes that mean nothing, a folder: a sentence that names it, and no file is written."""
    path = tmp_path / f"part.{suffix}"
    if data == "folder":
        path.mkdir()
    elif data is not None:
        path.write_bytes(data)
    assert main(["convert", str(path), "-o", str(tmp_path / "made.msh")]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"{path}")
    assert ": error: " in said
    assert said.count("\n") == 1
    assert not (tmp_path / "made.msh").exists()


def test_suffixes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["convert", "part.step"]) == 2
    said = capsys.readouterr().err
    assert "the suffix '.step' is not known; allowed are: .inp .unv .med" in said
    write_unv(tmp_path / "part.unv")
    assert main(["convert", str(tmp_path / "part.unv"), "-o", str(tmp_path / "part.vtu")]) == 2
    assert "must end with .msh" in capsys.readouterr().err
    assert main(["convert", str(tmp_path / "part.unv"), "-o", str(tmp_path / "no" / "part.msh")]) == 2
    assert "cannot be written" in capsys.readouterr().err
