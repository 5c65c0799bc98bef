# SPDX-License-Identifier: BSD-3-Clause
"""Sets and surfaces of a deck of Abaqus or CalculiX, which may name other sets and those of instances."""

from collections import Counter
from dataclasses import dataclass, field

import numpy as np

from signorom_post.arrays import FloatArray, IntArray
from signorom_post.convert.abaqus_keywords import Keyword
from signorom_post.convert.elements import SIDES, Kind
from signorom_post.convert.source import Source, element_numbers

#: corners of the faces S1, S2, ... of each shape
FACES = {
    "triangle": ("01", "12", "02"),
    "quadrilateral": ("01", "12", "23", "03"),
    "tetrahedron": ("012", "013", "123", "023"),
    "pyramid": ("0123", "014", "124", "234", "034"),
    "prism": ("012", "345", "0134", "1245", "0235"),
    "hexahedron": ("0123", "4567", "0145", "1256", "2367", "0347"),
}
#: the sides of shells
SHELL_SIDES = ("SPOS", "SNEG", "SP", "SN")
#: in place of the number of a side: all outer faces of a cell, or a shell itself
WHOLE = -1


@dataclass
class Block:
    """The elements of one keyword *ELEMENT; the nodes are in the order of the file."""

    keyword: Keyword
    label: str
    kind: Kind
    numbers: list[int] = field(default_factory=list)
    nodes: list[list[int]] = field(default_factory=list)
    lines: list[int] = field(default_factory=list)


class Scope:
    """Nodes, elements and sets of a part, or of the deck outside of parts. Sets are found by their names in capitals."""

    def __init__(self, name: str) -> None:
        """Begins with nothing."""
        self.name = name
        #: numbers of the nodes, in the order of the file
        self.node_numbers: dict[int, int] = {}
        self._places: list[FloatArray] = []
        self.blocks: list[Block] = []
        self._element_numbers: set[int] = set()
        #: numbers of elements of types that are not read
        self.skipped: set[int] = set()
        #: NSET or ELSET, name -> keywords that fill it, and numbers from *NODE or *ELEMENT
        self.sets: dict[tuple[str, str], list[Keyword | list[int]]] = {}
        self.surfaces: dict[str, list[Keyword]] = {}
        #: name in capitals -> as written
        self.spelling: dict[str, str] = {}
        #: names that only the program which wrote the deck needs
        self.internal: set[str] = set()

    def add_nodes(self, keyword: Keyword, nodes: tuple[list[int], FloatArray]) -> None:
        """Adds the numbers and places of *NODE. A node that comes twice moves to the last place."""
        numbers, places = nodes
        start = sum(map(len, self._places))
        for i, number in enumerate(numbers):
            self.node_numbers[number] = start + i
        self._places.append(places)
        if keyword.parameters.get("NSET"):
            self._entries("NSET", keyword.parameters["NSET"]).append(numbers)

    def all_places(self) -> FloatArray:
        """Returns the places of the nodes in the order of `node_numbers`, shape (n, 3)."""
        if not self._places:
            return np.empty((0, 3))
        return np.vstack(self._places)[list(self.node_numbers.values())]

    def add_elements(self, keyword: Keyword, label: str, kind: Kind) -> None:
        """Adds the elements of *ELEMENT, each of one or more data lines. More nodes than the type has are ignored."""
        block = Block(keyword, label, kind)
        words: list[str] = []
        for i_line, line in keyword.data:
            if not words:
                start = i_line
            words += [word for word in line if word]
            if len(words) > kind.n_nodes:
                self._add_element(block, words, start)
                words = []
            elif kind.n_dim < 2:  # a line without its middle node: nothing hangs on it
                self.skipped.add(keyword.whole_number(words[0], i_line))
                words = []
        if words:
            n = len(words) - 1
            raise keyword.error(f"element {words[0]} has {n} nodes, and {label} needs {kind.n_nodes}", start)
        self.blocks.append(block)
        if keyword.parameters.get("ELSET"):
            self._entries("ELSET", keyword.parameters["ELSET"]).append(block.numbers)

    def _add_element(self, block: Block, words: list[str], i_line: int) -> None:
        number, *nodes = [
            block.keyword.whole_number(word, i_line) for word in words[: block.kind.n_nodes + 1]
        ]
        if number in self._element_numbers:
            raise block.keyword.error(f"element {number} is defined twice", i_line)
        self._element_numbers.add(number)
        block.numbers.append(number)
        block.nodes.append(nodes)
        block.lines.append(i_line)

    def add_set(self, kind: str, keyword: Keyword) -> None:
        """Adds *NSET or *ELSET, or what it adds to a set that is there."""
        name = keyword.need(kind)
        self._entries(kind, name).append(keyword)
        if "INTERNAL" in keyword.parameters:
            self.internal.add(_plain(name).upper())

    def add_surface(self, keyword: Keyword) -> None:
        """Adds *SURFACE."""
        name = _plain(keyword.need("NAME"))
        self.spelling.setdefault(name.upper(), name)
        self.surfaces.setdefault(name.upper(), []).append(keyword)
        if "INTERNAL" in keyword.parameters:
            self.internal.add(name.upper())

    def _entries(self, kind: str, name: str) -> list[Keyword | list[int]]:
        name = _plain(name)
        self.spelling.setdefault(name.upper(), name)
        return self.sets.setdefault((kind, name.upper()), [])

    def is_shown(self, name: str) -> bool:
        """Whether a name in capitals is meant for the user."""
        return name not in self.internal and not name.startswith("_")


@dataclass
class Placed:
    """A scope with its nodes and elements in the source: number -> node or element of the source."""

    name: str
    scope: Scope
    nodes: dict[int, int]
    elements: dict[int, int] = field(default_factory=dict)

    def rows(self, kind: str) -> dict[int, int]:
        """Returns nodes (NSET) or elements (ELSET)."""
        return self.nodes if kind == "NSET" else self.elements


def resolve_sets(placed: list[Placed], source: Source) -> None:
    """Adds all sets and surfaces that are meant for the user to the source. InputError for what is not there."""
    resolver = _Resolver(placed, source)
    counts = Counter(name for one in placed for name in one.scope.spelling)
    for one in placed:
        for kind, name in one.scope.sets:
            if one.scope.is_shown(name):
                target = source.node_sets if kind == "NSET" else source.element_sets
                target[_full_name(one, name, counts)] = resolver.members(one, kind, name)
        for name, keywords in one.scope.surfaces.items():
            if one.scope.is_shown(name):
                resolver.add_surface(one, keywords, _full_name(one, name, counts))


def _full_name(placed: Placed, name: str, counts: Counter[str]) -> str:
    """Returns the name as written, with that of the instance before it if other scopes have it, too."""
    spelling = placed.scope.spelling[name]
    return f"{placed.name}.{spelling}" if placed.name and counts[name] > 1 else spelling


class _Resolver:
    """Finds the members of sets and the faces of surfaces."""

    def __init__(self, placed: list[Placed], source: Source) -> None:
        self._placed = {one.name.upper(): one for one in placed}
        self._source = source
        self._kinds = [(elements.kind, len(elements.nodes)) for elements in source.elements]
        self._starts = np.cumsum([0] + [n for _, n in self._kinds])

    def members(
        self, placed: Placed, kind: str, name: str, above: tuple[tuple[str, str], ...] = ()
    ) -> IntArray:
        """Returns the nodes or elements of the source in a set, ascending."""
        entries = placed.scope.sets[kind, name]
        groups = []
        for entry in entries:
            if isinstance(entry, list):
                groups.append([placed.rows(kind)[number] for number in entry])
                continue
            if (placed.name, name) in above:
                raise entry.error(f"the set '{placed.scope.spelling[name]}' holds itself")
            groups.append(self._of_keyword(placed, kind, entry, (*above, (placed.name, name))))
        return element_numbers(groups)

    def _of_keyword(
        self, placed: Placed, kind: str, keyword: Keyword, above: tuple[tuple[str, str], ...]
    ) -> IntArray:
        instance = keyword.parameters.get("INSTANCE")
        owner = self._instance(keyword, instance) if instance else placed
        if kind == "NSET" and keyword.parameters.get("ELSET"):
            elements = self._named(placed, "ELSET", keyword.parameters["ELSET"], keyword, None, above)
            return self._nodes_of(elements)
        if "GENERATE" in keyword.parameters:
            return self._generated(owner, kind, keyword)
        groups = []
        for i_line, words in keyword.data:
            for word in words:
                if word:
                    groups.append(self._word(placed, owner, kind, word, keyword, i_line, above))
        return element_numbers(groups)

    def _generated(self, owner: Placed, kind: str, keyword: Keyword) -> IntArray:
        """Returns what lies in the ranges `first, last, step` of GENERATE, which may have gaps."""
        groups = []
        for i_line, words in keyword.data:
            numbers = [keyword.whole_number(word, i_line) for word in words]
            if len(numbers) == 2:
                numbers.append(1)
            if len(numbers) != 3 or numbers[2] < 1:
                raise keyword.error("a line of GENERATE is: first, last, step of at least 1", i_line)
            rows = owner.rows(kind)
            first, last, step = numbers
            groups.append(
                [
                    row
                    for number, row in rows.items()
                    if first <= number <= last and (number - first) % step == 0
                ]
            )
        return element_numbers(groups)

    def _word(
        self,
        placed: Placed,
        owner: Placed,
        kind: str,
        word: str,
        keyword: Keyword,
        i_line: int | None,
        above: tuple[tuple[str, str], ...],
    ) -> IntArray:
        """Returns the members that one word of a set means: a number, a set, or either of an instance behind a dot."""
        if word.isdecimal():
            return self._numbered(owner, kind, int(word), keyword)
        start, _, rest = word.rpartition(".")
        if rest.isdecimal() and start.upper() in self._placed:
            return self._numbered(self._placed[start.upper()], kind, int(rest), keyword)
        return self._named(
            owner if (kind, _plain(word).upper()) in owner.scope.sets else placed,
            kind,
            word,
            keyword,
            i_line,
            above,
        )

    def _numbered(self, owner: Placed, kind: str, number: int, keyword: Keyword) -> IntArray:
        row = owner.rows(kind).get(number)
        if row is not None:
            return np.array([row], dtype=np.int64)
        if kind == "NSET" or number not in owner.scope.skipped:
            thing = "node" if kind == "NSET" else "element"
            name = keyword.parameters.get(kind) or keyword.parameters.get("NAME", "")
            self._source.leave_out(
                f"numbers in {_plain(name)}", f"the file has no {thing} {number}, for instance"
            )
        return np.empty(0, dtype=np.int64)

    def _named(
        self,
        placed: Placed,
        kind: str,
        name: str,
        keyword: Keyword,
        i_line: int | None,
        above: tuple[tuple[str, str], ...],
    ) -> IntArray:
        plain = _plain(name)
        if (kind, plain.upper()) in placed.scope.sets:
            return self.members(placed, kind, plain.upper(), above)
        start, _, rest = plain.partition(".")
        owner = self._placed.get(start.upper())
        if owner is not None and (kind, rest.upper()) in owner.scope.sets:
            return self.members(owner, kind, rest.upper(), above)
        thing = "node set" if kind == "NSET" else "element set"
        raise keyword.error(f"there is no {thing} '{name}'", i_line)

    def _instance(self, keyword: Keyword, name: str) -> Placed:
        owner = self._placed.get(name.upper())
        if owner is None and len(self._placed) == 1:  # CalculiX has no instances, and ignores the word
            return next(iter(self._placed.values()))
        if owner is None:
            raise keyword.error(f"there is no instance '{name}'")
        return owner

    def _nodes_of(self, elements: IntArray) -> IntArray:
        """Returns the nodes of elements, ascending."""
        groups = []
        for i, block in enumerate(self._source.elements):
            inside = elements[(elements >= self._starts[i]) & (elements < self._starts[i + 1])]
            groups.append(block.nodes[inside - self._starts[i]])
        return element_numbers(groups)

    def add_surface(self, placed: Placed, keywords: list[Keyword], name: str) -> None:
        """Adds a surface to the source: of faces to its face sets, of nodes to its node sets."""
        faces, nodes = [], []
        for keyword in keywords:
            if keyword.parameters.get("TYPE", "ELEMENT").upper() == "NODE":
                for i_line, words in keyword.data:
                    nodes.append(self._word(placed, placed, "NSET", words[0], keyword, i_line, ()))
            elif (
                keyword.parameters.get("TYPE", "ELEMENT").upper() == "ELEMENT"
                and "COMBINE" not in keyword.parameters
            ):
                faces += [self._faces(placed, keyword, i_line, words) for i_line, words in keyword.data]
            else:
                self._source.leave_out(f"*SURFACE {name}", "only surfaces of elements or nodes are read")
        if nodes:
            self._source.node_sets[name] = element_numbers(nodes)
        if faces:
            self._source.face_sets[name] = np.unique(np.vstack(faces), axis=0)

    def _faces(self, placed: Placed, keyword: Keyword, i_line: int, words: list[str]) -> IntArray:
        """Returns the faces of one data line, shape (n, 2)."""
        label = words[1].upper() if len(words) > 1 else ""
        elements = self._word(placed, placed, "ELSET", words[0], keyword, i_line, ())
        if label[:1] == "E":
            self._source.leave_out(f"{label} of *SURFACE {keyword.parameters['NAME']}", "edges of shells")
            return np.empty((0, 2), dtype=np.int64)
        if not label or label in SHELL_SIDES:
            return np.column_stack([elements, np.full_like(elements, WHOLE)])
        if not (label[0] == "S" and label[1:].isdecimal()):
            raise keyword.error(f"'{label}' is not a face; allowed are S1 to S6, SPOS and SNEG", i_line)
        sides = [self._side(element, int(label[1:]), keyword, i_line) for element in elements]
        return np.column_stack([elements, np.array(sides, dtype=np.int64)])

    def _side(self, element: int, i_face: int, keyword: Keyword, i_line: int) -> int:
        """Returns the number of a side, as in Kind.sides, for the face S1, S2, ... of an element."""
        shape = self._kinds[int(np.searchsorted(self._starts, element, side="right")) - 1][0].shape
        faces = FACES.get(shape, ())
        if not 1 <= i_face <= len(faces):
            raise keyword.error(f"a {shape} has no face S{i_face}", i_line)
        return [set(side) for side in SIDES[shape]].index(set(faces[i_face - 1]))


def _plain(name: str) -> str:
    """Returns a name without the quotes around it."""
    return name.strip().strip('"').strip()
