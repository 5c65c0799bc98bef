#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Writes the list of deck keys in input/README.md from input/deck.schema.json; with --check only compares."""

import json
import sys
import textwrap
from pathlib import Path

INPUT = Path(__file__).resolve().parents[1] / "input"
START, END = "<!-- keys: made by tools/deck_keys.py -->", "<!-- end of keys -->"


def resolve(node, schema):
    """Returns a node of the schema with the members of what it refers to, over any steps; its own members win."""
    if "$ref" not in node:
        return node
    target = schema
    for part in node["$ref"].removeprefix("#/").split("/"):
        target = target[part]
    return {**resolve(target, schema), **{key: value for key, value in node.items() if key != "$ref"}}


def limits(node):
    """Returns the limits of a number as text, such as `≥ 0, < 1`; empty if it has none."""
    words = [
        ("exclusiveMinimum", "> "),
        ("minimum", "≥ "),
        ("exclusiveMaximum", "< "),
        ("maximum", "≤ "),
    ]
    return ", ".join(f"{sign}{node[key]}" for key, sign in words if key in node)


def kind(node, schema):
    """Returns which values a node of the schema allows, in a few words."""
    if "enum" in node:
        return ", ".join(f"`{word if isinstance(word, str) else json.dumps(word)}`" for word in node["enum"])
    if "anyOf" in node and "type" not in node:
        return " or ".join(kind(resolve(choice, schema), schema) for choice in node["anyOf"])
    if "const" in node:
        return f"`{node['const']}`"
    if node.get("type") == "array":
        items = resolve(node["items"], schema)
        plural = "mappings" if items.get("type") == "object" else kind(items, schema)
        if plural == "name or mapping":
            plural = "names or mapping"
        return f"list of {plural}" + (
            "s" if plural in ("name", "number", "expression", "names or mapping") else ""
        )
    if "expression of the parameters" in node.get("description", "") or node.get("type") == "object":
        return "mapping" if node["type"] == "object" else "expression"
    names = {
        "string": "text",
        "integer": "whole number",
        "number": "number",
        "boolean": "`true`, `false`",
        "object": "mapping",
    }
    types = node["type"] if isinstance(node["type"], list) else [node["type"]]
    word = "name" if types == ["string", "number"] else names[types[0]]
    return " ".join(filter(None, [word, limits(node)]))


def default(node, is_required):
    """Returns `required`, or the default as it would stand in a deck, or an empty text if there is none."""
    if is_required:
        return "required"
    if "default" not in node:
        return ""
    value = node["default"]
    if value == "":
        return "empty"
    if isinstance(value, bool):
        return f"`{json.dumps(value)}`"
    if isinstance(value, float):
        return f"`{value:g}`".replace("e-0", "e-")
    if isinstance(value, str) and (" " in value):
        return value
    return f"`{json.dumps(value) if isinstance(value, list) else value}`".replace('"', "")


def rows(node, schema, path=""):
    """Yields a list entry for each key of a mapping and of the mappings below it; `path` is the key of the mapping."""
    keys = list(node.get("properties", {}).items())
    if isinstance(node.get("additionalProperties"), dict) and path in ("parameters", "materials"):
        keys.append(("<name>", node["additionalProperties"]))
    for key, raw in keys:
        value = resolve(raw, schema)
        own_kind = (
            "expression" if raw.get("$ref", "").endswith(("/expression", "/field")) else kind(value, schema)
        )
        name = f"{path}.{key}" if path else key
        if key != "<name>":
            needed = default(value, key in node.get("required", []))
            needed = needed if needed in ("", "required") else f"default {needed}"
            told = "; ".join(filter(None, [own_kind, needed]))
            yield wrapped(f"- `{name}` ({told}): {value['description']}")
        yield from rows(value, schema, name)
        if value.get("type") == "array":
            items = resolve(value["items"], schema)
            if "properties" in items:
                yield from rows(items, schema, name + "[]")


def wrapped(text):
    """Returns a list entry, wrapped to lines of at most 132 characters."""
    return textwrap.fill(text, 132, subsequent_indent="  ", break_long_words=False, break_on_hyphens=False)


def list_of_keys():
    """Returns the Markdown list of all keys of the deck."""
    schema = json.loads((INPUT / "deck.schema.json").read_text(encoding="utf-8"))
    return "\n".join(rows(schema, schema))


def main():
    """Writes the list into input/README.md; with --check it only compares, with exit code 1 if they differ."""
    path = INPUT / "README.md"
    text = path.read_text(encoding="utf-8")
    before, rest = text.split(START)
    after = rest.split(END)[1]
    wanted = f"{before}{START}\n\n{list_of_keys()}\n\n{END}{after}"
    if "--check" not in sys.argv[1:]:
        path.write_text(wanted, encoding="utf-8")
    elif wanted != text:
        sys.exit("input/README.md does not show the keys of input/deck.schema.json: run tools/deck_keys.py")


if __name__ == "__main__":
    main()
