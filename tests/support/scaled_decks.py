# SPDX-License-Identifier: BSD-3-Clause
"""Copies of decks and their meshes with all lengths and all forces multiplied: the same problem in other numbers.

Which key has which unit is what deck.schema.json says of it; the unit of a parameter is its own key `unit`.
"""

import csv
import json
import re
from dataclasses import dataclass

import numpy as np
import yaml

from gmsh_mesh import write_moved_mesh
from program import ROOT

SCHEMA = json.loads((ROOT / "input" / "deck.schema.json").read_text())
# exponents of length and force
BASES = dict.fromkeys(("length", "m", "cm", "mm", "um"), (1, 0))
BASES |= dict.fromkeys(("force", "N", "kN", "MN"), (0, 1))
BASES |= dict.fromkeys(("Pa", "kPa", "MPa", "GPa"), (-2, 1))
# times and temperatures stay
BASES |= dict.fromkeys(("1", "time", "h", "s", "K"), (0, 0))
AXES = ("x", "y", "z", "r")


@dataclass(frozen=True)
class Scales:
    """Factors of all lengths and of all forces."""

    length: float
    force: float

    def of(self, unit):
        """Returns the factor of numbers with a unit, such as `force / length^2` or `N/mm2`; 1 if it has other words."""
        exponents = np.zeros(2)
        for sign, name, power in re.findall(r"([*/]?) *(1|[^ *^/\d]+)\^?(\d*)", unit):
            if name not in BASES:
                return 1.0
            exponents += (-1 if sign == "/" else 1) * int(power or 1) * np.array(BASES[name])
        return float(self.length ** exponents[0] * self.force ** exponents[1])


def write_scaled_deck(source, folder, scales, changes=None):
    """Writes a deck, its mesh and its lists of points into `folder`, scaled, and returns the path of the deck.

    `changes`: sections of the deck that another value replaces, or None to leave them out; they are meant unscaled.
    """
    deck = yaml.load(source.read_text(), Loader)
    for name, section in (changes or {}).items():
        deck.pop(name, None)
        if section is not None:
            deck[name] = section
    scaled = ScaledDeck(deck, scales)
    mesh = (source.parent / deck["mesh"]["file"]).resolve()
    write_moved_mesh(mesh, folder / mesh.name, factor=scales.length)
    text = scaled.walk(deck, SCHEMA, "")
    text["mesh"]["file"] = mesh.name
    for name in ("training", "test"):
        if "file" in deck.get(name, {}):
            scaled.write_points(source.parent / deck[name]["file"], folder / f"{name}.csv")
            text[name]["file"] = f"{name}.csv"
    path = folder / source.name
    path.write_text(yaml.safe_dump(text, sort_keys=False, width=10000))
    return path


class Loader(yaml.SafeLoader):
    """Reads 1e3 as a number, as the program does, and not as a text."""


Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(r"^[-+]?\d+\.?\d*[eE][-+]?\d+$"), list("-+0123456789")
)


class ScaledDeck:
    """The values of a deck with other numbers."""

    def __init__(self, deck, scales):
        """Takes the deck as dictionaries and lists."""
        self.scales = scales
        self.parameters = {
            name: scales.of(entry.get("unit", "1")) for name, entry in deck["parameters"].items()
        }

    def walk(self, node, schema, unit):
        """Returns a part of the deck, scaled; `unit` is that of the key above, unless this part has one of its own."""
        schema = resolve(schema)
        told = re.match(r"\[(.*?)\]", schema.get("description", ""))
        unit = told.group(1) if told else unit
        if isinstance(node, dict):
            return {key: self.entry(key, node, schema, unit) for key in node}
        if isinstance(node, list):
            return [self.walk(item, schema.get("items", {}), unit) for item in node]
        return self.expression(node, self.scales.of(unit)) if unit else node

    def entry(self, key, node, schema, unit):
        """Returns one value of a mapping, scaled."""
        if schema is SCHEMA and key == "parameters":
            return {name: self.range_of(name, entry) for name, entry in node[key].items()}
        if key == "points" and isinstance(node[key], list):
            return [self.point(point) for point in node[key]]
        if key == "coefficient" and "exponent" in node:
            n = node["exponent"]
            return self.expression(node[key], self.scales.of(f"1/time/force^{n}*length^{2 * n}"))
        return self.walk(
            node[key], schema.get("properties", {}).get(key, schema.get("additionalProperties") or {}), unit
        )

    def range_of(self, name, entry):
        """Returns the range of a parameter."""
        ends = {end: value_of(entry[end]) * self.parameters[name] for end in ("min", "max")}
        return entry | ends

    def point(self, point):
        """Returns a parameter point."""
        return {name: value_of(value) * self.parameters[name] for name, value in point.items()}

    def write_points(self, source, path):
        """Writes a list of points."""
        with source.open() as file:
            rows = list(csv.DictReader(file))
        with path.open("w") as file:
            table = csv.DictWriter(file, rows[0].keys())
            table.writeheader()
            table.writerows(self.point(row) for row in rows)

    def expression(self, value, factor):
        """Returns an expression of scaled parameters and coordinates, times a factor.

        Each term of the sum gets the factor, because a sum of products must stay one.
        """
        if not isinstance(value, str):
            return value * factor
        scaled = dict.fromkeys(AXES, self.scales.length) | self.parameters
        for name, scale in scaled.items():
            if scale != 1:
                value = re.sub(rf"(?<![\w.]){name}(?!\w)", f"({name} / {scale!r})", value)
        if factor == 1:
            return value
        if re.search(r"[?<>=&|]", value):
            return f"{factor!r} * ({value})"
        return " ".join(f"{sign} {factor!r} * {term}" for sign, term in terms_of(value))


def value_of(value):
    """Returns a constant of a deck as a number: these decks have no constant expressions that Python does not know."""
    return float(eval(value, {"__builtins__": {}})) if isinstance(value, str) else float(value)


def terms_of(expression):
    """Returns the terms of a sum as pairs of a sign and a text."""
    terms = []
    depth, start, sign = 0, 0, "+"
    for i, letter in enumerate(expression):
        depth += (letter == "(") - (letter == ")")
        before = expression[:i].rstrip()
        is_exponent = re.search(r"(?<![\w.])[\d.]+[eE]$", expression[:i])
        if depth == 0 and letter in "+-" and not is_exponent and not before.endswith(("*", "/", "^", ",")):
            if before:
                terms.append((sign, expression[start:i].strip()))
            sign, start = letter, i + 1
    return [*terms, (sign, expression[start:].strip())]


def resolve(schema):
    """Returns a schema with what it refers to; its own words come before those."""
    while isinstance(schema, dict) and "$ref" in schema:
        referred = SCHEMA
        for name in schema["$ref"].removeprefix("#/").split("/"):
            referred = referred[name]
        schema = referred | {key: value for key, value in schema.items() if key != "$ref"}
    return schema if isinstance(schema, dict) else {}
