# SPDX-License-Identifier: BSD-3-Clause
"""Reads meshes of Salome and code_aster (.med), which are HDF5 files: nodes, elements, groups of both."""

from pathlib import Path

import h5py
import numpy as np

from signorom_post.arrays import IntArray
from signorom_post.convert.elements import BY_NAME, VTK_MIDDLES, from_middles
from signorom_post.convert.source import Elements, Source, element_numbers, read_bytes
from signorom_post.errors import InputError

#: names of the file -> kinds
KINDS = {
    "PO1": "point",
    "SE2": "L2",
    "SE3": "L3",
    "TR3": "T3",
    "TR6": "T6",
    "QU4": "Q4",
    "QU8": "Q8",
    "QU9": "Q9",
    "TE4": "T4",
    "T10": "T10",
    "PY5": "P5",
    "P13": "P13",
    "PE6": "W6",
    "P15": "W15",
    "P18": "W18",
    "HE8": "H8",
    "H20": "H20",
    "H27": "H27",
}


def read_med(path: Path) -> Source:
    """Reads the mesh of a file, at its first time step; of several meshes the first one.

    InputError: a file that is missing or not HDF5, a file without a mesh, or a damaged one.
    """
    read_bytes(path)
    try:
        with h5py.File(path) as file:
            return _read(file, path)
    except OSError as error:
        raise InputError(path, "this is not a MED file: it is not HDF5") from error
    except (KeyError, ValueError, IndexError, TypeError) as error:
        raise InputError(path, f"this MED file is damaged, or of another version ({error})") from error


def _read(file: h5py.File, path: Path) -> Source:
    if "ENS_MAA" not in file or len(file["ENS_MAA"]) == 0:
        raise InputError(path, "the file has no mesh (ENS_MAA)")
    names = sorted(file["ENS_MAA"])
    mesh = file["ENS_MAA"][names[0]]
    n_dim = int(mesh.attrs["ESP"])
    step = mesh if "NOE" in mesh else mesh[sorted(key for key in mesh if "NOE" in mesh[key])[0]]
    places = np.zeros((step["NOE/COO"].size // n_dim, 3))
    places[:, :n_dim] = step["NOE/COO"][()].reshape(n_dim, -1).T
    source = Source(path, places)
    for name in names[1:]:
        source.leave_out(f"mesh {name}", f"only the first mesh, {names[0]}, is read")
    families = _families(file, names[0])
    if "FAM" in step["NOE"]:
        _add_sets(source.node_sets, families, step["NOE/FAM"][()], 0)
    for name in sorted(step.get("MAI", {})):
        _add_elements(source, name, step["MAI"][name], families)
    if "CHA" in file:
        source.leave_out("fields", "only the mesh is read")
    return source


def _add_elements(source: Source, name: str, group: h5py.Group, families: dict[int, list[str]]) -> None:
    label = KINDS.get(name)
    if label is None:
        source.leave_out(f"elements {name}", "elements of this type are not read")
        return
    kind, start = BY_NAME[label], source.n_elements
    nodes = group["NOD"][()].astype(np.int64).reshape(kind.n_nodes, -1).T - 1
    if nodes.size and not (nodes.min() >= 0 and nodes.max() < len(source.coordinates)):
        raise ValueError(f"elements {name} have nodes that are not there")
    source.elements.append(Elements(name, kind, nodes[:, from_middles(kind, VTK_MIDDLES)]))
    if "FAM" in group:
        _add_sets(source.element_sets, families, group["FAM"][()], start)


def _add_sets(
    sets: dict[str, IntArray], families: dict[int, list[str]], family: IntArray, start: int
) -> None:
    """Adds nodes or elements, the first of which has the number `start`, to the sets of their families."""
    for number in np.unique(family).tolist():
        members = start + np.flatnonzero(family == number)
        for name in families.get(number, []):
            sets[name] = element_numbers([sets.get(name, np.empty(0, dtype=np.int64)), members])


def _families(file: h5py.File, mesh: str) -> dict[int, list[str]]:
    """Returns the names of the groups of each family; nodes have positive numbers, elements negative ones."""
    found: dict[int, list[str]] = {}
    for kind in ("NOEUD", "ELEME"):
        for family in file.get(f"FAS/{mesh}/{kind}", {}).values():
            if "GRO" in family:
                texts = family["GRO/NOM"][()]
                names = [bytes(np.asarray(text, dtype=np.int8).tobytes()) for text in texts]
                found[int(family.attrs["NUM"])] = [_text(name) for name in names]
    return found


def _text(data: bytes) -> str:
    data = data.split(b"\0")[0].strip()
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        return data.decode("latin-1")
