# SPDX-License-Identifier: BSD-3-Clause
"""What a reader finds in the file of another program: nodes, elements, sets."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from signorom_post.arrays import FloatArray, IntArray
from signorom_post.convert.elements import Kind
from signorom_post.errors import InputError


@dataclass
class Elements:
    """Elements of one kind."""

    #: as the file names the type, such as `C3D10`
    label: str
    kind: Kind
    #: nodes of each element in gmsh's order, from 0; shape (n, n_nodes of the kind)
    nodes: IntArray


@dataclass
class Source:
    """Nodes, elements and sets of a file. An element's number counts through all `elements`, from 0."""

    path: Path
    #: [unit of the file] shape (n_nodes, 3)
    coordinates: FloatArray
    elements: list[Elements] = field(default_factory=list)
    #: name -> nodes, from 0
    node_sets: dict[str, IntArray] = field(default_factory=dict)
    #: name -> elements, from 0
    element_sets: dict[str, IntArray] = field(default_factory=dict)
    #: name -> (element, number of one of its sides as in Kind.sides) of each face, shape (n, 2)
    face_sets: dict[str, IntArray] = field(default_factory=dict)
    #: for cells that no set names: name -> elements; such as the instances of an assembly
    bodies: dict[str, IntArray] = field(default_factory=dict)
    #: what the reader left out: what -> why
    left_out: dict[str, str] = field(default_factory=dict)

    @property
    def n_elements(self) -> int:
        """Number of all elements."""
        return sum(len(elements.nodes) for elements in self.elements)

    def leave_out(self, what: str, why: str) -> None:
        """Notes what is left out, once."""
        self.left_out.setdefault(what, why)


class Unique:
    """Names that are not taken twice."""

    def __init__(self) -> None:
        """Begins without names."""
        self._taken: set[str] = set()

    def take(self, name: str) -> str:
        """Returns the name, with `_2`, `_3`, ... behind it if it is taken; what a .msh cannot hold is replaced."""
        name = "".join("_" if letter in '"\n\r\t' else letter for letter in name.strip()) or "unnamed"
        candidate, n = name, 1
        while candidate in self._taken:
            n += 1
            candidate = f"{name}_{n}"
        self._taken.add(candidate)
        return candidate


class TextLines:
    """The lines of a text file, with their numbers for messages."""

    def __init__(self, path: Path) -> None:
        """Reads the file; InputError if it cannot be read or is not a text."""
        self.path = path
        data = read_bytes(path)
        if b"\0" in data[:100_000]:
            raise InputError(path, "this is not a text file")
        try:
            text = data.decode("utf-8")
        except UnicodeDecodeError:
            text = data.decode("latin-1")
        self.lines = text.splitlines()

    def error(self, i_line: int, sentence: str) -> InputError:
        """Returns an InputError at a line, which counts from 0."""
        return InputError(f"{self.path}:{i_line + 1}", sentence)


def read_bytes(path: Path) -> bytes:
    """Returns the bytes of a file; InputError if there is none, or if it cannot be read or is empty."""
    if path.is_dir():
        raise InputError(path, "this is a folder; give the file of a mesh")
    try:
        data = path.read_bytes()
    except FileNotFoundError as error:
        raise InputError(path, "there is no such file") from error
    except OSError as error:
        raise InputError(path, f"cannot be read ({error.strerror})") from error
    if not data.strip():
        raise InputError(path, "the file is empty")
    return data


def element_numbers(groups: Iterable[IntArray]) -> IntArray:
    """Returns all numbers of some sets, ascending, each once."""
    found = [np.asarray(group, dtype=np.int64).ravel() for group in groups]
    return np.unique(np.concatenate(found)) if found else np.empty(0, dtype=np.int64)
