# SPDX-License-Identifier: BSD-3-Clause
"""Decks: the schema, the shipped ones, the effective deck read back, and messages for the invalid ones."""

import functools
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import jsonschema
import pytest
import yaml

from runs import write_deck

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
EXECUTABLE = Path(os.environ.get("SIGNOROM_EXECUTABLE", ROOT / "build" / "ci" / "signorom")).resolve()
VALID = sorted([*(ROOT / "input").glob("*.yaml"), *(HERE / "decks").glob("*.yaml")])
INVALID = sorted((HERE / "decks" / "invalid").glob("*.yaml"))
EXPECT = "# expect: "


@functools.cache
def schema():
    """The validator of input/deck.schema.json."""
    content = json.loads((ROOT / "input" / "deck.schema.json").read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator.check_schema(content)
    return jsonschema.Draft202012Validator(content)


def check(deck, folder):
    """What `signorom check` does with a deck."""
    return subprocess.run(
        [EXECUTABLE, "check", deck], cwd=folder, capture_output=True, text=True, timeout=120, check=False
    )


@pytest.mark.parametrize("deck", VALID, ids=lambda path: path.stem)
def test_valid_deck_meets_the_schema(deck):
    errors = [error.message for error in schema().iter_errors(yaml.safe_load(deck.read_text()))]
    assert errors == []


@pytest.mark.parametrize("deck", VALID, ids=lambda path: path.stem)
def test_effective_deck_reads_back_as_itself(deck, tmp_path):
    first = check(deck, tmp_path)
    assert first.returncode == 0, first.stderr
    # paths are relative to the deck: the copy needs a folder from which they mean the same
    copy = tmp_path / "copies" / deck.name
    copy.parent.mkdir()
    (tmp_path / "meshes").symlink_to(deck.parents[1] / "meshes")
    for table in deck.parent.glob("*.csv"):
        (copy.parent / table.name).symlink_to(table)
    copy.write_text(first.stdout)
    second = check(copy, tmp_path)
    assert second.returncode == 0, second.stderr
    assert second.stdout == first.stdout
    assert list(schema().iter_errors(yaml.safe_load(first.stdout))) == []


def test_effective_deck_holds_every_key_of_the_schema(tmp_path):
    content = json.loads((ROOT / "input" / "deck.schema.json").read_text(encoding="utf-8"))
    effective = yaml.safe_load(check(ROOT / "input" / "half_disks.yaml", tmp_path).stdout)
    # a history and the unit of its time have no defaults
    del content["properties"]["history"], content["properties"]["units"]["properties"]["time"]
    assert set(effective) == set(content["properties"])
    for section in ("units", "mesh", "solver", "reduction", "output"):
        assert set(effective[section]) == set(content["properties"][section]["properties"]), section


def test_every_number_of_the_schema_has_a_unit():
    """Descriptions begin with it, such as `[length]`; ranges and points have the units of the parameters."""
    content = json.loads((ROOT / "input" / "deck.schema.json").read_text(encoding="utf-8"))
    found = list(numbers_without_unit(content, content, "", has_unit=False))
    assert found == [
        ".parameters.*.min",
        ".parameters.*.max",
        ".history.tables.*.value[]",
        ".output.points[].*",
    ]


def numbers_without_unit(content, node, place, has_unit):
    """Places of numbers and expressions below a node of the schema for which no description tells a unit."""
    texts = [node.get("description", "")]
    is_number = False
    while "$ref" in node:
        name = node["$ref"].removeprefix("#/$defs/").split("/")[0]
        is_number = is_number or name in ("number", "expression", "field")
        node = content["$defs"][name] if "/properties/" not in node["$ref"] else {}
        texts.append(node.get("description", ""))
    has_unit = has_unit or any(text.startswith("[") for text in texts)
    if is_number:
        if not has_unit:
            yield place
        return
    for key, child in node.get("properties", {}).items():
        yield from numbers_without_unit(content, child, f"{place}.{key}", has_unit)
    for key, suffix in (("additionalProperties", ".*"), ("items", "[]")):
        if isinstance(node.get(key), dict):
            yield from numbers_without_unit(content, node[key], place + suffix, has_unit)
    for child in [*node.get("anyOf", []), *node.get("oneOf", [])]:
        yield from numbers_without_unit(content, child, place, has_unit)


def test_defaults_of_the_schema_are_those_of_the_program(tmp_path):
    content = json.loads((ROOT / "input" / "deck.schema.json").read_text(encoding="utf-8"))
    deck = write_deck("patch", tmp_path, **{"{method: hhr}": "{}"})
    effective = yaml.safe_load(check(deck, tmp_path).stdout)
    for section in ("units", "solver", "reduction"):
        for key, node in content["properties"][section]["properties"].items():
            if key != "enrichment" and "default" in node:
                assert effective[section][key] == node["default"], f"{section}.{key}"
    assert effective["output"]["fields"] == content["properties"]["output"]["properties"]["fields"]["default"]
    assert effective["output"]["directory"] == "auto"


def petsc_version():
    """Of the library that the program was built with."""
    command = ["pkg-config", "--modversion", "PETSc"]
    version = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    return tuple(int(number) for number in version.split("."))


@pytest.fixture(scope="module")
def refusals(tmp_path_factory):
    """Of `check` with each invalid deck: standard output, standard error and exit code. No file is written.

    All in one process; that the program itself ends with these exit codes is said by test_bad_input.
    """
    folder = tmp_path_factory.mktemp("empty")
    commands = tmp_path_factory.mktemp("commands") / "commands"
    commands.write_text("".join(f"check {deck}\n" for deck in INVALID))
    program = EXECUTABLE.parent / "tests" / "run_commands"
    done = subprocess.run(
        [program, commands], cwd=folder, capture_output=True, text=True, timeout=600, check=False
    )
    assert done.returncode == 0, done.stderr
    assert list(folder.iterdir()) == []
    outputs, errors = (re.split(r"(?m)^exit code (\d+)\n", stream) for stream in (done.stdout, done.stderr))
    # texts and exit codes take turns; the last text, behind the last code, is empty
    return dict(
        zip(INVALID, zip(outputs[::2], errors[::2], map(int, errors[1::2]), strict=False), strict=True)
    )


@pytest.mark.parametrize("deck", INVALID, ids=lambda path: path.stem)
def test_invalid_deck_gets_its_message(deck, refusals):
    first_line = deck.read_text().splitlines()[0]
    assert first_line.startswith(EXPECT)
    expected = first_line.removeprefix(EXPECT)
    if "needs PETSc 3.19" in expected and petsc_version() >= (3, 19):
        pytest.skip("this PETSc can do it")
    separator = ":" if expected[0].isdigit() else ": "
    stdout, stderr, exit_code = refusals[deck]
    assert stderr.splitlines()[0] == f"{deck}{separator}{expected}"
    assert exit_code == 2
    assert stdout == ""


def test_key_table_is_up_to_date():
    done = subprocess.run(
        [sys.executable, ROOT / "tools" / "deck_keys.py", "--check"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
