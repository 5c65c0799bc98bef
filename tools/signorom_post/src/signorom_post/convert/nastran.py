# SPDX-License-Identifier: BSD-3-Clause
"""Reads bulk data of Nastran (.bdf, .nas, .fem, .dat): nodes, elements by property, nodes of supports."""

import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from signorom_post.convert.elements import NASTRAN_MIDDLES, Kind, from_middles, kind_of
from signorom_post.convert.source import Elements, Source, TextLines, Unique
from signorom_post.errors import InputError

#: card -> dimension, and the numbers of nodes that it may have
CELLS = {
    "CTETRA": (3, (4, 10)),
    "CPYRAM": (3, (5, 13)),
    "CPYRA": (3, (5, 13)),
    "CPENTA": (3, (6, 15)),
    "CHEXA": (3, (8, 20)),
    "CTRIA3": (2, (3,)),
    "CTRIAR": (2, (3,)),
    "CPLSTN3": (2, (3,)),
    "CPLSTS3": (2, (3,)),
    "CTRAX3": (2, (3,)),
    "CTRIA6": (2, (6,)),
    "CPLSTN6": (2, (6,)),
    "CPLSTS6": (2, (6,)),
    "CTRAX6": (2, (6,)),
    "CQUAD4": (2, (4,)),
    "CQUADR": (2, (4,)),
    "CSHEAR": (2, (4,)),
    "CPLSTN4": (2, (4,)),
    "CPLSTS4": (2, (4,)),
    "CQUADX4": (2, (4,)),
    "CQUAD8": (2, (8,)),
    "CPLSTN8": (2, (8,)),
    "CPLSTS8": (2, (8,)),
    "CQUADX8": (2, (8,)),
    "CBAR": (1, (2,)),
    "CBEAM": (1, (2,)),
    "CROD": (1, (2,)),
}
#: cards that do not count as left out
SILENT = ("BEGIN", "ENDDATA", "PARAM", "CEND", "SOL", "GRID", "SPC1", "SPC", "INCLUDE", *CELLS)
#: names of properties in the comments of HyperMesh, Femap and others
NAMES = (
    re.compile(r"\$HMNAME\s+(?:PROP|COMP)\S*\s+(\d+)\s*\"([^\"]+)\""),
    re.compile(r"\$\s*Femap\s+(?:with\s+\S+\s+)?Property\s+(\d+)\s*:\s*(\S.*)", re.IGNORECASE),
)
REAL = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+))(?:[eEdD]?([+-]?\d+))?$")
MAX_INCLUDES = 20


class _Card:
    """A card with its continuations."""

    def __init__(self, text: TextLines, i_line: int, fields: list[str]) -> None:
        self.text, self.i_line = text, i_line
        self.name = fields[0].rstrip("*").strip().upper()
        self.fields = fields[1:]

    def error(self, sentence: str) -> InputError:
        """Returns an InputError at the card."""
        return self.text.error(self.i_line, f"{self.name}: {sentence}")

    def field(self, i: int) -> str:
        """Returns field i, where the field behind the name is the first; empty if the card is shorter."""
        return self.fields[i - 1] if i <= len(self.fields) else ""

    def whole(self, word: str) -> int:
        """Converts a word to a whole number; InputError if it is none."""
        try:
            return int(word)
        except ValueError:
            raise self.error(f"'{word}' is not a whole number") from None

    def real(self, word: str) -> float:
        """Converts a word to a number, also such as 1.5-3, which is 1.5e-3; an empty word is 0."""
        match = REAL.match(word or "0")
        if not match:
            raise self.error(f"'{word}' is not a number")
        return float(f"{match[1]}e{match[2] or 0}")


class _Reader:
    """Collects what the cards say."""

    def __init__(self) -> None:
        self.rows: dict[int, int] = {}
        self.places: list[list[float]] = []
        #: card, kind -> card, number, property and nodes of each element
        self.blocks: dict[tuple[str, Kind], list[tuple[_Card, int, list[int]]]] = {}
        self.supports: dict[int, list[int]] = {}
        self.names: dict[int, str] = {}
        self.others: Counter[str] = Counter()

    def take(self, card: _Card) -> None:
        """Takes a card."""
        if card.name == "GRID":
            self._take_node(card)
        elif card.name in CELLS:
            self._take_element(card)
        elif card.name == "SPC1":
            self._take_support(card.whole(card.field(1)), card, card.fields[2:])
        elif card.name == "SPC":
            self._take_support(card.whole(card.field(1)), card, [card.field(2), card.field(5)])
        elif card.name not in SILENT:
            self.others[card.name] += 1

    def _take_node(self, card: _Card) -> None:
        if card.field(2) not in ("", "0"):
            raise card.error(
                f"the node is given in the coordinate system {card.field(2)}; only the basic one is read"
            )
        self.rows[card.whole(card.field(1))] = len(self.places)
        self.places.append([card.real(card.field(i)) for i in (3, 4, 5)])

    def _take_element(self, card: _Card) -> None:
        n_dim, allowed = CELLS[card.name]
        words = card.fields[2 : 2 + allowed[-1]]
        while words and not words[-1]:
            words.pop()
        if len(words) not in allowed or "" in words:
            if not words or len(words) < allowed[0] or "" in words[: allowed[0]]:
                raise card.error(f"element {card.field(1)} has too few nodes")
            self.others[f"{card.name} with middle nodes on some edges only"] += 1
            return
        kind = kind_of(n_dim, len(words))
        nodes = [card.whole(word) for word in words]
        property_id = card.whole(card.field(2) or card.field(1))
        self.blocks.setdefault((card.name, kind), []).append((card, property_id, nodes))

    def _take_support(self, number: int, card: _Card, words: list[str]) -> None:
        nodes = self.supports.setdefault(number, [])
        words = [word for word in words if word]
        if len(words) == 3 and words[1].upper() == "THRU":
            nodes += range(card.whole(words[0]), card.whole(words[2]) + 1)
        else:
            nodes += [card.whole(word) for word in words]


def read_nastran(path: Path) -> Source:
    """Reads bulk data, in small, large and free fields, with or without executive and case control before it.

    InputError, with file and line: a field that is no number, a node in another coordinate system, an element with a
    node that is not there, a file without a card that is known.
    """
    reader = _Reader()
    _read_file(path, reader, 0)
    if not reader.places:
        raise InputError(path, "the file has no GRID card: it holds no bulk data of Nastran")
    source = Source(path, np.array(reader.places, dtype=float))
    _add_elements(reader, source)
    names = Unique()
    for number, nodes in reader.supports.items():
        members = [reader.rows[node] for node in nodes if node in reader.rows]
        source.node_sets[names.take(f"SPC_{number}")] = np.unique(np.array(members, dtype=np.int64))
    if reader.supports:
        source.leave_out("SPC, SPC1", "supports; their nodes became boundaries")
    if reader.others:
        cards = ", ".join(f"{name} ({n})" for name, n in sorted(reader.others.items()))
        source.leave_out("other cards", f"{cards}: materials, loads and others are not read")
    return source


def _add_elements(reader: _Reader, source: Source) -> None:
    regions: dict[int, list[int]] = {}
    for (name, kind), entries in reader.blocks.items():
        nodes = np.empty((len(entries), kind.n_nodes), dtype=np.int64)
        for i, (card, property_id, numbers) in enumerate(entries):
            for j, number in enumerate(numbers):
                if number not in reader.rows:
                    raise card.error(f"element {card.field(1)} has node {number}, which is not defined")
                nodes[i, j] = reader.rows[number]
            regions.setdefault(property_id, []).append(source.n_elements + i)
        source.elements.append(Elements(name, kind, nodes[:, from_middles(kind, NASTRAN_MIDDLES)]))
    names = Unique()
    for property_id in sorted(regions):
        name = names.take(reader.names.get(property_id, f"property_{property_id}"))
        source.element_sets[name] = np.array(regions[property_id], dtype=np.int64)


def _read_file(path: Path, reader: _Reader, depth: int) -> None:
    text = TextLines(path)
    for pattern in NAMES:
        for line in text.lines:
            if match := pattern.match(line):
                reader.names[int(match[1])] = match[2].strip()
    for card in _cards(text):
        if card.name.startswith("INCLUDE"):
            _include(card, path, reader, depth)
        else:
            reader.take(card)


def _include(card: _Card, path: Path, reader: _Reader, depth: int) -> None:
    line = card.text.lines[card.i_line].split("$")[0]
    name = line.strip()[len("INCLUDE") :].strip().strip("'\"")
    other = path.parent / name
    if depth >= MAX_INCLUDES or not other.is_file():
        raise card.error(f"the file '{name}' is not in the folder {path.parent}, or files include each other")
    _read_file(other, reader, depth + 1)


def _cards(text: TextLines) -> Iterator[_Card]:
    """Yields the cards behind BEGIN BULK, or of the whole file if it has no such line, up to ENDDATA."""
    lines = [line.upper().split() for line in text.lines]
    starts = [
        i + 1
        for i, words in enumerate(lines)
        if words[:2] == ["BEGIN", "BULK"] or words[:1] == ["BEGIN,BULK"]
    ]
    fields: list[str] = []
    first = 0
    for i in range(starts[0] if starts else 0, len(text.lines)):
        line = text.lines[i].split("$")[0].rstrip()
        if not line.strip():
            continue
        if line.upper().startswith("ENDDATA"):
            break
        new = _fields(line)
        if new[0][:1].isalpha() and fields:
            yield _Card(text, first, fields)
            fields = []
        if not fields:
            fields, first = new, i
        else:  # some programs leave out the empty name of a continuation in free fields
            fields += new if new[0][:1].isdecimal() else new[1:]
    if fields:
        yield _Card(text, first, fields)


def _fields(line: str) -> list[str]:
    """Returns the fields of a line: its name (empty, + or * in continuations), then 8 fields, or 4 large ones."""
    if "," in line:
        words = [word.strip() for word in line.split(",")]
        n = 4 if words[0].endswith("*") else 8
        return words[:1] + (words[1:] + [""] * n)[:n]
    line = line.expandtabs(8)
    name = line[:8].strip()
    if "*" in name:
        return [name] + [line[8 + 16 * i : 24 + 16 * i].strip() for i in range(4)]
    return [name] + [line[8 + 8 * i : 16 + 8 * i].strip() for i in range(8)]
