# SPDX-License-Identifier: BSD-3-Clause
"""Reads decks of Abaqus and CalculiX (.inp): flat ones, and those of parts, instances and an assembly."""

import math
from collections import Counter
from pathlib import Path

import numpy as np

from signorom_post.arrays import FloatArray
from signorom_post.convert.abaqus_keywords import Keyword, read_keywords
from signorom_post.convert.abaqus_sets import Placed, Scope, resolve_sets
from signorom_post.convert.abaqus_types import dimension_and_nodes
from signorom_post.convert.elements import VTK_MIDDLES, from_middles, kind_of
from signorom_post.convert.source import Elements, Source
from signorom_post.errors import InputError

#: keywords of what is set up anew in the deck of Signorom -> what they are
ELSEWHERE = {
    "MATERIAL": "materials",
    "SOLID SECTION": "sections",
    "SHELL SECTION": "sections",
    "BEAM SECTION": "sections",
    "BOUNDARY": "supports",
    "CLOAD": "loads",
    "DLOAD": "loads",
    "DSLOAD": "loads",
    "TEMPERATURE": "loads",
    "STEP": "steps",
    "CONTACT PAIR": "contacts",
    "CONTACT": "contacts",
    "SURFACE INTERACTION": "contacts",
    "TIE": "ties",
    "EQUATION": "equations between displacements",
    "MPC": "equations between displacements",
    "RIGID BODY": "rigid bodies",
    "COUPLING": "couplings",
    "KINEMATIC": "couplings",
    "DISTRIBUTING": "couplings",
    "AMPLITUDE": "amplitudes",
    "ORIENTATION": "orientations",
}
#: keywords that make nodes, elements or sets of others
GENERATORS = ("NGEN", "NFILL", "NCOPY", "ELGEN", "ELCOPY", "NMAP", "SYSTEM")


class Deck:
    """The deck while its keywords are read."""

    def __init__(self) -> None:
        """Begins with a deck without parts."""
        self.root = self.scope = Scope("")
        self.parts: dict[str, Scope] = {}
        self.instances: list[tuple[Keyword, Scope]] = []
        self.left_out: Counter[str] = Counter()
        self.generators: list[Keyword] = []

    def take(self, keyword: Keyword) -> None:
        """Takes the next keyword; InputError for what it cannot mean."""
        name = keyword.name
        if name == "PART":
            self.scope = self.parts[keyword.need("NAME").upper()] = Scope(keyword.need("NAME"))
        elif name == "INSTANCE":
            self.scope = Scope(keyword.need("NAME"))
            self.instances.append((keyword, self.scope))
        elif name in ("END PART", "END INSTANCE"):
            self.scope = self.root
        elif name == "NODE":
            self.scope.add_nodes(keyword, _places(keyword))
        elif name == "ELEMENT":
            self._take_elements(keyword)
        elif name in ("NSET", "ELSET"):
            self.scope.add_set(name, keyword)
        elif name == "SURFACE":
            self.scope.add_surface(keyword)
        elif name in ELSEWHERE:
            self.left_out[name] += 1
        elif name in GENERATORS:
            self.generators.append(keyword)

    def _take_elements(self, keyword: Keyword) -> None:
        label = keyword.need("TYPE").upper()
        shape = dimension_and_nodes(label)
        if shape is None:
            self.left_out[f"ELEMENT, TYPE={label}"] += len(keyword.data)
            self.scope.skipped.update(
                keyword.whole_number(words[0], i_line) for i_line, words in keyword.data
            )
        else:
            self.scope.add_elements(keyword, label, kind_of(*shape))


def read_abaqus(path: Path) -> Source:
    """Reads a deck and the files that it includes.

    InputError, with file and line where there is one: a file that is missing or not a text, a number that is none, an
    element or set that names a node or element which is not there.
    """
    deck = Deck()
    for keyword in read_keywords(path):
        deck.take(keyword)
    source = Source(path, np.empty((0, 3)))
    placed = _place_all(deck, source)
    if len(source.coordinates) == 0:
        raise InputError(path, "the file has no nodes (*NODE): it is not a deck of Abaqus or CalculiX")
    resolve_sets(placed, source)
    for name, n in deck.left_out.items():
        why = ELSEWHERE.get(name, "elements of this type are not read")
        source.leave_out(f"*{name} ({n})", why)
    return source


def _places(keyword: Keyword) -> tuple[list[int], FloatArray]:
    """Returns numbers and places of the nodes of *NODE, also from cylindrical coordinates (SYSTEM=C)."""
    numbers, rows = [], []
    for i_line, words in keyword.data:
        numbers.append(keyword.whole_number(words[0], i_line))
        row = [keyword.number(word, i_line) for word in words[1:4]]
        if not all(map(math.isfinite, row)):
            raise keyword.error("the coordinates of a node must be finite", i_line)
        rows.append(row + [0.0] * (3 - len(row)))
    places = np.array(rows, dtype=float).reshape(-1, 3)
    system = keyword.parameters.get("SYSTEM", "R").upper()
    if system == "C":
        angles = np.radians(places[:, 1])
        places = np.column_stack([places[:, 0] * np.cos(angles), places[:, 0] * np.sin(angles), places[:, 2]])
    elif system != "R":
        raise keyword.error(f"nodes in the coordinates SYSTEM={system} cannot be read; allowed are R and C")
    return numbers, places


def _place_all(deck: Deck, source: Source) -> list[Placed]:
    """Adds the nodes and elements of the deck to the source: those outside of parts, then those of each instance.

    A deck with parts and no instance has each part once.
    """
    placed = [_place(deck, deck.root, "", None, source)]
    for keyword, scope in deck.instances:
        part = scope
        if not scope.node_numbers:
            part = deck.parts.get(keyword.need("PART").upper())
            if part is None:
                raise keyword.error(f"there is no part '{keyword.need('PART')}' above this instance")
        placed.append(_place(deck, part, keyword.need("NAME"), keyword, source))
    if not deck.instances:
        placed += [_place(deck, part, part.name, None, source) for part in deck.parts.values()]
    return placed


def _place(deck: Deck, scope: Scope, name: str, instance: Keyword | None, source: Source) -> Placed:
    n_before = len(source.coordinates)
    places = scope.all_places()
    if instance is not None:
        places = _moved(places, instance)
    source.coordinates = np.vstack([source.coordinates, places])
    rows = {number: n_before + i for i, number in enumerate(scope.node_numbers)}
    placed = Placed(name, scope, rows)
    first = source.n_elements
    for block in scope.blocks:
        nodes = np.empty((len(block.numbers), block.kind.n_nodes), dtype=np.int64)
        for i, (number, words, i_line) in enumerate(
            zip(block.numbers, block.nodes, block.lines, strict=True)
        ):
            for j, node in enumerate(words):
                row = rows.get(node)
                if row is None:
                    raise block.keyword.error(_no_node(number, node, deck), i_line)
                nodes[i, j] = row
            placed.elements[number] = source.n_elements + i
        order = from_middles(block.kind, VTK_MIDDLES)
        source.elements.append(Elements(block.label, block.kind, nodes[:, order]))
    if name and source.n_elements > first:
        source.bodies[name] = np.arange(first, source.n_elements)
    return placed


def _no_node(number: int, node: int, deck: Deck) -> str:
    sentence = f"element {number} has node {node}, which is not defined"
    if deck.generators:
        sentence += f"; *{deck.generators[0].name}, which makes nodes or elements of others, is not read"
    return sentence


def _moved(places: FloatArray, instance: Keyword) -> FloatArray:
    """Returns the places of an instance: its first data line is a shift, the second one a rotation about an axis.

    The rotation, of seven numbers, goes from a to b by an angle in degrees (Rodrigues' formula).
    """
    numbers = [[instance.number(word, i_line) for word in words] for i_line, words in instance.data]
    if numbers:
        shift = (numbers[0] + [0.0] * 3)[:3]
        places = places + np.array(shift)
    if len(numbers) > 1:
        if len(numbers[1]) != 7:
            raise instance.error("the rotation of an instance has seven numbers", instance.data[1][0])
        start, axis, angle = np.array(numbers[1][:3]), np.array(numbers[1][3:6]), math.radians(numbers[1][6])
        axis = axis - start
        if not np.any(axis):
            raise instance.error("the axis of the rotation has no length", instance.data[1][0])
        axis = axis / np.linalg.norm(axis)
        arms = places - start
        turned = arms * math.cos(angle) + np.cross(axis, arms) * math.sin(angle)
        places = start + turned + np.outer(arms @ axis, axis) * (1 - math.cos(angle))
    return places
