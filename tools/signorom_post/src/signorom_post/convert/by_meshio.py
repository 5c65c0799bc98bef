# SPDX-License-Identifier: BSD-3-Clause
"""Reads the formats that meshio knows: sets by their names, and whole numbers on cells as sets."""

import contextlib
import io
from pathlib import Path
from typing import Any

import numpy as np

from signorom_post.arrays import IntArray
from signorom_post.convert.elements import BY_NAME, VTK_MIDDLES, from_middles
from signorom_post.convert.source import Elements, Source, read_bytes
from signorom_post.errors import InputError

#: suffix -> what it is
SUFFIXES = {
    ".vtu": "VTK",
    ".vtk": "VTK",
    ".xdmf": "XDMF",
    ".xmf": "XDMF",
    ".mesh": "Medit",
    ".meshb": "Medit",
    ".msh": "gmsh",
    ".vol": "Netgen",
    ".su2": "SU2",
    ".e": "Exodus",
    ".exo": "Exodus",
    ".ex2": "Exodus",
    ".cgns": "CGNS",
    ".ugrid": "UGRID",
    ".xml": "DOLFIN",
    ".avs": "AVS-UCD",
    ".f3grid": "FLAC3D",
    ".post": "PERMAS",
}
#: suffix -> what helps where meshio fails; it lacks some of gmsh's formats that signorom reads
OTHERWISE = {
    ".msh": "; let gmsh write it in format 4.1 first: gmsh part.msh -save -save_all -format msh41 -o new.msh"
}
#: names of meshio -> kinds
KINDS = {
    "vertex": "point",
    "line": "L2",
    "line3": "L3",
    "triangle": "T3",
    "triangle6": "T6",
    "quad": "Q4",
    "quad8": "Q8",
    "quad9": "Q9",
    "tetra": "T4",
    "tetra10": "T10",
    "pyramid": "P5",
    "pyramid13": "P13",
    "pyramid14": "P14",
    "wedge": "W6",
    "wedge15": "W15",
    "wedge18": "W18",
    "hexahedron": "H8",
    "hexahedron20": "H20",
    "hexahedron27": "H27",
}
#: more distinct numbers than these on the cells are not regions but the numbers of something else
MAX_MARKS = 200
#: numbers of gmsh's physical groups, 0 for none; and of its entities, which count where a mesh has no groups
GROUPS, ENTITIES = "gmsh:physical", "gmsh:geometrical"


def read_by_meshio(path: Path) -> Source:
    """Reads a file with meshio.

    InputError: the file is missing, meshio cannot read it, or needs a package that is not installed.
    """
    read_bytes(path)
    mesh = _meshio_mesh(path)
    points = np.asarray(mesh.points, dtype=float)
    if points.ndim != 2 or len(points) == 0:
        raise InputError(path, "the file has no nodes")
    source = Source(path, np.pad(points[:, :3], ((0, 0), (0, max(0, 3 - points.shape[1])))))
    index = _add_elements(mesh, source)
    _add_sets(mesh, source, index)
    return source


def _meshio_mesh(path: Path) -> Any:
    """Returns what meshio reads; whatever goes wrong in it becomes an InputError."""
    import meshio

    said = io.StringIO()
    try:
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said), np.errstate(all="ignore"):
            return meshio.read(path)
    except ImportError as error:
        name = error.name or str(error)
        raise InputError(path, f"this format needs the Python package {name}: pip install {name}") from error
    except (SystemExit, Exception) as error:  # meshio raises all kinds, and exits where a reader gives up
        words = " ".join(f"{said.getvalue()} {error}".split())
        reason = f" ({words[:200]})" if words and not isinstance(error, SystemExit) else ""
        suffix = path.suffix.lower()
        sentence = f"meshio cannot read it as {SUFFIXES[suffix]}{reason}{OTHERWISE.get(suffix, '')}"
        raise InputError(path, sentence) from error


def _add_elements(mesh: Any, source: Source) -> list[int | None]:
    """Adds the elements, and returns the number of the first element of each block; None for one that is not read."""
    index: list[int | None] = []
    for block in mesh.cells:
        name = KINDS.get(block.type)
        if name is None or len(block.data) == 0:
            index.append(None)
            if len(block.data):
                source.leave_out(f"{block.type} ({len(block.data)})", "elements of this type are not read")
            continue
        nodes = np.asarray(block.data, dtype=np.int64)
        if nodes.min() < 0 or nodes.max() >= len(source.coordinates):
            raise InputError(source.path, f"an element ({block.type}) has a node that is not in the file")
        index.append(source.n_elements)
        kind = BY_NAME[name]
        source.elements.append(Elements(block.type, kind, nodes[:, from_middles(kind, VTK_MIDDLES)]))
    return index


def _add_sets(mesh: Any, source: Source, index: list[int | None]) -> None:
    """Adds named sets, and a set for each whole number that the cells carry as a mark."""
    for name, nodes in mesh.point_sets.items():
        source.node_sets[str(name)] = np.unique(np.asarray(nodes, dtype=np.int64))
    for name, blocks in mesh.cell_sets.items():
        members = [
            start + np.asarray(cells, dtype=np.int64).ravel()
            for start, cells in zip(index, blocks, strict=True)
            if start is not None and cells is not None
        ]
        if str(name).startswith("gmsh:"):  # meshio's own
            continue
        _add_set(source, str(name), members)
    has_groups = any(np.any(block) for block in mesh.cell_data.get(GROUPS, []))
    for name, blocks in mesh.cell_data.items():
        if name != (ENTITIES if has_groups else GROUPS):
            _add_marks(mesh, source, name, blocks, index)
    others = [name for name in mesh.point_data if not name.startswith("gmsh:")]
    if others:
        source.leave_out(f"data at nodes: {', '.join(others)}", "only the mesh is read")


def _add_set(source: Source, name: str, members: list[IntArray]) -> None:
    if members and sum(map(len, members)):
        members = [*members, source.element_sets.get(name, np.empty(0, dtype=np.int64))]
        source.element_sets[name] = np.unique(np.concatenate(members))


def _add_marks(mesh: Any, source: Source, name: str, blocks: list[Any], index: list[int | None]) -> None:
    """Adds a set for each number of an array of whole numbers on the cells: with its name in the file if it has one.

    In gmsh's files a number means another group in each dimension.
    """
    arrays = [np.asarray(block) for block in blocks]
    if not all(array.ndim == 1 and np.issubdtype(array.dtype, np.integer) for array in arrays):
        source.leave_out(
            f"data on cells: {name}", "only whole numbers on cells are read, as marks of regions"
        )
        return
    marks: dict[tuple[int, int], list[IntArray]] = {}
    for array, start, block in zip(arrays, index, mesh.cells, strict=True):
        if start is None:
            continue
        for mark in np.unique(array).tolist():
            marks.setdefault((block.dim, mark), []).append(start + np.flatnonzero(array == mark))
    if len(marks) > MAX_MARKS:
        source.leave_out(
            f"data on cells: {name}", f"more than {MAX_MARKS} different numbers are no marks of regions"
        )
        return
    names = {
        (int(tag[1]), int(tag[0])): str(name) for name, tag in mesh.field_data.items() if np.size(tag) == 2
    }
    for (n_dim, mark), members in marks.items():
        if name == GROUPS and mark == 0:
            continue
        set_name = names.get((n_dim, mark)) if name == GROUPS else None
        if set_name is None:
            _add_set(source, _mark_name(name, n_dim, mark), members)
        elif not len(mesh.cell_sets.get(set_name, [])):  # meshio makes sets of format 4.1 only
            _add_set(source, set_name, members)


def _mark_name(array: str, n_dim: int, mark: int) -> str:
    """Returns the name of a set that has only a number; of gmsh's groups as in decks: `surface_5`."""
    if array.startswith("gmsh:"):
        return f"{('point', 'curve', 'surface', 'volume')[n_dim]}_{mark}"
    return f"{array.rpartition(':')[2] if array.endswith(':ref') else array}_{mark}"
