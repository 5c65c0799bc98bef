# SPDX-License-Identifier: BSD-3-Clause
"""Reads universal files (.unv) of I-DEAS, Salome and others: nodes, elements, groups.

Datasets: https://www.ceas3.uc.edu/sdrluff (2411, 781 and 15: nodes; 2412 and 780: elements; 2467 and older: groups).
"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from signorom_post.arrays import IntArray
from signorom_post.convert.elements import Kind, from_unv, kind_of
from signorom_post.convert.source import Elements, Source, TextLines, Unique

NODES = (15, 781, 2411)
ELEMENTS = (780, 2412)
#: number of a dataset of groups -> words for each member
GROUPS = {2417: 2, 2429: 2, 2430: 2, 2432: 2, 2435: 4, 2452: 4, 2467: 4, 2477: 4}
#: what members of groups are
NODE, ELEMENT = 7, 8
#: types of lines have lower numbers than this, those of plane elements and shells lower ones than 100
PLANE = 40


class _Reader:
    """Reads the datasets of one file."""

    def __init__(self, path: Path) -> None:
        self.text = TextLines(path)
        self.rows: dict[int, int] = {}
        self.places: list[list[float]] = []
        #: (type of the file, kind) -> numbers and nodes
        self.blocks: dict[tuple[int, Kind], tuple[list[int], list[list[int]], list[int]]] = {}
        #: name, node or element, numbers
        self.groups: list[tuple[str, int, list[int]]] = []
        self.unknown: dict[int, int] = {}

    def datasets(self) -> Iterator[tuple[int, int, int]]:
        """Yields number, first line and line behind the last one of each dataset; lines count from 0."""
        lines, i, has_any = self.text.lines, 0, False
        while i < len(lines):
            if lines[i].strip() != "-1" or i + 1 == len(lines):
                i += 1
                continue
            words = lines[i + 1].split()
            if not words or not words[0].rstrip("b").isdecimal():
                raise self.text.error(i + 1, "the number of a dataset is expected here")
            end = i + 2
            while end < len(lines) and lines[end].strip() != "-1":
                end += 1
            if end == len(lines):
                raise self.text.error(i, "this dataset does not end with a line -1; is the file complete?")
            has_any = True
            yield int(words[0].rstrip("b")), i + 2, end
            i = end + 1
        if not has_any:
            raise self.text.error(0, "this is not a universal file: it has no dataset between two lines -1")

    def integers(self, i_line: int) -> list[int]:
        """Returns the whole numbers of a line; InputError if there is another word."""
        try:
            return [int(word) for word in self._line(i_line).split()]
        except ValueError:
            raise self.text.error(i_line, "whole numbers are expected here") from None

    def reals(self, i_line: int, first: int = 0) -> list[float]:
        """Returns the three coordinates of a line, behind `first` other words."""
        try:
            numbers = [
                float(word.replace("D", "E").replace("d", "e")) for word in self._line(i_line).split()[first:]
            ]
        except ValueError:
            raise self.text.error(i_line, "three coordinates are expected here") from None
        if len(numbers) != 3:
            raise self.text.error(i_line, "three coordinates are expected here")
        return numbers

    def _line(self, i_line: int) -> str:
        if i_line >= len(self.text.lines):
            raise self.text.error(len(self.text.lines) - 1, "the file ends here within a dataset")
        return self.text.lines[i_line]

    def nodes(self, dataset: int, i: int, end: int) -> None:
        """Reads a dataset of nodes: one line each in the oldest one, else two."""
        while i < end:
            words = self._line(i).split()
            place = self.reals(i, 4) if dataset == 15 else self.reals(i + 1)
            self.rows[self.integers_of(words[:1], i)[0]] = len(self.places)
            self.places.append(place)
            i += 1 if dataset == 15 else 2

    def integers_of(self, words: list[str], i_line: int) -> list[int]:
        """Converts words to whole numbers; InputError if there is none, or another word."""
        try:
            numbers = [int(word) for word in words]
        except ValueError:
            numbers = []
        if not numbers:
            raise self.text.error(i_line, "whole numbers are expected here")
        return numbers

    def elements(self, i: int, end: int) -> None:
        """Reads a dataset of elements."""
        while i < end:
            head = self.integers(i)
            if len(head) < 6:
                raise self.text.error(i, "six or more whole numbers are expected here: an element")
            number, descriptor, n_nodes = head[0], head[1], head[-1]
            at, i = i, i + (2 if self._has_section(descriptor, n_nodes, i + 1) else 1)
            nodes: list[int] = []
            while len(nodes) < n_nodes and i < end:
                nodes += self.integers(i)
                i += 1
            if len(nodes) != n_nodes:
                raise self.text.error(at, f"element {number} has {len(nodes)} nodes instead of {n_nodes}")
            self._add(number, descriptor, nodes, at)

    def _has_section(self, descriptor: int, n_nodes: int, i: int) -> bool:
        """Whether line i is about the section of a beam: three numbers. Some programs write it for rods, too."""
        return descriptor < PLANE and (n_nodes == 3 or len(self._line(i).split()) == 3)

    def _add(self, number: int, descriptor: int, nodes: list[int], at: int) -> None:
        n_dim = 1 if descriptor < PLANE else 2 if descriptor < 100 else 3
        try:
            kind = kind_of(n_dim, len(nodes))
        except KeyError:
            self.unknown[descriptor] = self.unknown.get(descriptor, 0) + 1
            return
        numbers, rows, lines = self.blocks.setdefault((descriptor, kind), ([], [], []))
        numbers.append(number)
        rows.append(nodes)
        lines.append(at)

    def all_groups(self, dataset: int, i: int, end: int) -> None:
        """Reads a dataset of groups: two lines, then the members."""
        width = GROUPS[dataset]
        while i < end:
            head = self.integers(i)
            name = self._line(i + 1).strip() or f"group_{head[0]}"
            i, members = i + 2, []
            while len(members) < width * head[-1] and i < end:
                members += self.integers(i)
                i += 1
            if len(members) < width * head[-1]:
                raise self.text.error(
                    i - 1, f"the group {name} has fewer members than the {head[-1]} announced"
                )
            table = np.array(members[: width * head[-1]], dtype=np.int64).reshape(-1, width)
            for what in (NODE, ELEMENT):
                numbers = table[table[:, 0] == what, 1].tolist()
                if numbers:
                    self.groups.append((name, what, numbers))


def read_universal(path: Path) -> Source:
    """Reads a universal file.

    InputError, with the line where there is one: a file that is missing or of another kind, a dataset that is not
    complete, an element with a node that is not there.
    """
    reader = _Reader(path)
    others: dict[int, int] = {}
    for dataset, start, end in reader.datasets():
        if dataset in NODES:
            reader.nodes(dataset, start, end)
        elif dataset in ELEMENTS:
            reader.elements(start, end)
        elif dataset in GROUPS:
            reader.all_groups(dataset, start, end)
        elif dataset not in (151, 164):  # header, units
            others[dataset] = others.get(dataset, 0) + 1
    source = Source(path, np.array(reader.places, dtype=float).reshape(-1, 3))
    index = _add_elements(reader, source)
    _add_groups(reader, source, index)
    for descriptor, n in reader.unknown.items():
        source.leave_out(f"elements of type {descriptor} ({n})", "elements of this type are not read")
    for dataset in others:
        source.leave_out(f"dataset {dataset}", "only nodes, elements and groups are read")
    return source


def _add_elements(reader: _Reader, source: Source) -> dict[int, int]:
    """Adds the elements to the source, and returns the index of each number."""
    index: dict[int, int] = {}
    for (descriptor, kind), (numbers, rows, lines) in reader.blocks.items():
        nodes = np.empty((len(rows), kind.n_nodes), dtype=np.int64)
        for i, row in enumerate(rows):
            for j, node in enumerate(row):
                if node not in reader.rows:
                    sentence = f"element {numbers[i]} has node {node}, which is not defined"
                    raise reader.text.error(lines[i], sentence)
                nodes[i, j] = reader.rows[node]
        start = source.n_elements
        index |= {number: start + i for i, number in enumerate(numbers)}
        source.elements.append(Elements(f"type {descriptor}", kind, nodes[:, from_unv(kind)]))
    return index


def _add_groups(reader: _Reader, source: Source, index: dict[int, int]) -> None:
    node_names, element_names = Unique(), Unique()
    for name, what, numbers in reader.groups:
        table = reader.rows if what == NODE else index
        members: IntArray = np.array([table[number] for number in numbers if number in table], dtype=np.int64)
        if what == NODE:
            source.node_sets[node_names.take(name)] = members
        else:
            source.element_sets[element_names.take(name)] = members
