# SPDX-License-Identifier: BSD-3-Clause
"""Decks, meshes, expressions and tables: mutations that know what such a file is made of."""

import json
import random
import re
from pathlib import Path

from mutations import BINARY_MUTATIONS, TEXT_MUTATIONS, number_of, several

ROOT = Path(__file__).resolve().parents[2]
CORPUS = Path(__file__).resolve().parent / "corpus"
FUNCTIONS = "sin cos tan asin acos atan atan2 sinh log2 log10 ln exp sqrt sign rint abs sum avg min max _pi _e".split()
OPERATORS = [
    "+",
    "-",
    "*",
    "/",
    "^",
    "<",
    ">",
    "<=",
    ">=",
    "==",
    "!=",
    "&&",
    "||",
    "?",
    ":",
    ",",
    "(",
    ")",
    "=",
    "!",
    "+=",
    "%",
]
VALUES = [
    "[]",
    "{}",
    "~",
    "null",
    "true",
    "yes",
    "''",
    '""',
    "auto",
    "|",
    ">",
    "&a 1",
    "*a",
    "!!int 1",
    "- 1",
    "? 1",
    "[1, [2, [3]]]",
]


def schema_words() -> list[str]:
    """Every key and every choice of a deck, from its schema."""
    found = set()

    def walk(node: object) -> None:
        if isinstance(node, dict):
            found.update(node.get("properties", {}))
            found.update(word for word in node.get("enum", []) if isinstance(word, str))
            for child in node.values():
                walk(child)
        elif isinstance(node, list):
            for child in node:
                walk(child)

    walk(json.loads((ROOT / "input" / "deck.schema.json").read_text()))
    return sorted(found)


def expression(rng: random.Random, depth: int = 0) -> str:
    """An expression that is right more often than not."""
    kind = rng.random()
    if depth > 4 or kind < 0.3:
        return rng.choice(
            ["a", "squeeze", "x", number_of(rng), str(rng.randint(0, 9)), rng.choice(FUNCTIONS), "b", ""]
        )
    if kind < 0.6:
        return expression(rng, depth + 1) + rng.choice(OPERATORS) + expression(rng, depth + 1)
    if kind < 0.8:
        arguments = ",".join(expression(rng, depth + 1) for _ in range(rng.choice((0, 1, 1, 2, 2, 3))))
        return f"{rng.choice(FUNCTIONS)}({arguments})"
    if kind < 0.9:
        return f"({expression(rng, depth + 1)})"
    return f"{expression(rng, depth + 1)} ? {expression(rng, depth + 1)} : {expression(rng, depth + 1)}"


def mutate_expression(data: bytes, rng: random.Random) -> bytes:
    kind = rng.random()
    if kind < 0.4:
        data = expression(rng).encode()
    elif kind < 0.45:
        data = rng.choice([b"(", b"-", b"sin(", b"1?", b"a+", b"max(1,"]) * rng.choice((10, 150, 900)) + data
    return data if rng.random() < 0.3 else several(TEXT_MUTATIONS, data, rng)


class Deck:
    """Exchanges keys, values and whole sections."""

    key = re.compile(rb"[A-Za-z_]+(?=\s*:)")
    value = re.compile(rb"(?<=: )[^,\]}\n]+")

    def __init__(self) -> None:
        self.words = schema_words()

    def put(self, data: bytes, rng: random.Random, pattern: re.Pattern, new: str) -> bytes:
        found = list(pattern.finditer(data))
        if not found:
            return data
        match = rng.choice(found)
        return data[: match.start()] + new.encode() + data[match.end() :]

    def change_key(self, data: bytes, rng: random.Random) -> bytes:
        return self.put(data, rng, self.key, rng.choice(self.words))

    def change_value(self, data: bytes, rng: random.Random) -> bytes:
        new = rng.choice([rng.choice(self.words), rng.choice(VALUES), number_of(rng), f'"{expression(rng)}"'])
        return self.put(data, rng, self.value, new)

    def change_section(self, data: bytes, rng: random.Random) -> bytes:
        """Cuts, doubles or moves a section: a key in the first column and what stands below it."""
        sections = re.split(rb"(?m)^(?=[a-z_]+:)", data)
        i, j = rng.randrange(len(sections)), rng.randrange(len(sections))
        action = rng.randrange(3)
        if action == 0:
            del sections[i]
        elif action == 1:
            sections.insert(j, sections[i])
        else:
            sections.insert(j, sections.pop(i))
        return b"".join(sections)

    def nest(self, data: bytes, rng: random.Random) -> bytes:
        depth = rng.choice((3, 60, 2000))
        opening, closing = rng.choice([(b"[", b"]"), (b"{a: ", b"}"), (b"- ", b"")])
        return self.put(
            data, rng, self.value, (opening * depth + b"1" + closing * rng.choice((0, depth))).decode()
        )

    def mutate(self, data: bytes, rng: random.Random) -> bytes:
        own = [self.change_key, self.change_value, self.change_value, self.change_value, self.change_section]
        for _ in range(rng.choice((1, 1, 2, 4))):
            data = rng.choice(own)(data, rng)
        if rng.random() < 0.02:
            data = self.nest(data, rng)
        return several(TEXT_MUTATIONS, data, rng) if rng.random() < 0.4 else data


def mutate_mesh(data: bytes, rng: random.Random) -> bytes:
    """Exchanges whole sections, or numbers in one of them; in binary files the bytes of numbers."""
    sections = re.split(rb"(?m)^(?=\$(?!End))", data)
    if rng.random() < 0.15:
        i, j = rng.randrange(len(sections)), rng.randrange(len(sections))
        if rng.random() < 0.5:
            sections.insert(j, sections[i])
        else:
            sections.insert(j, sections.pop(i))
        return b"".join(sections)
    is_binary = re.match(rb"\$MeshFormat\s+\S+\s+1", data) is not None
    mutations = BINARY_MUTATIONS if is_binary and rng.random() < 0.8 else TEXT_MUTATIONS
    i = rng.randrange(len(sections))
    sections[i] = several(mutations, sections[i], rng)
    return b"".join(sections)


def mutate_table(data: bytes, rng: random.Random) -> bytes:
    """Exchanges cells, columns and what ends a line."""
    kind = rng.random()
    if kind < 0.1:
        return data.replace(b"\n", rng.choice([b"\r\n", b"\r", b"\n\n", b"", b",\n", b"\n#\n"]))
    if kind < 0.2:
        return data.replace(b",", rng.choice([b";", b"\t", b",,", b" , ", b'","', b""]))
    if kind < 0.3:
        return data * rng.choice((2, 30)) + b"," * rng.choice((0, 5000))
    if kind < 0.35:
        return data + b"0.5," + b"9" * 40000 + b"\n" + data
    return several(TEXT_MUTATIONS, data, rng)
