# SPDX-License-Identifier: BSD-3-Clause
"""Reads a file that lists models of one deck, and runs the program for each of them. An example of such a file:

deck: ../half_disks.yaml
models:
  paper: {}                                   # the deck as it is
  condensed: {reduction: {method: condensed}} # these sections replace the deck's; null removes a section
"""

import re
import subprocess
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

import yaml

from signorom_post.errors import InputError
from signorom_post.log import LOOK_INTERVAL, Log, Progress, last_line
from signorom_post.program import USABLE, find_program, program_environment
from signorom_post.readers.report import read_sections

#: pattern of a model's name, which is also the name of its folder
NAME = re.compile(r"[A-Za-z0-9][\w.-]*")


def run_variants(path: Path, output: Path, log: Log) -> list[Path]:
    """Runs the program for each model that the file `path` lists, and returns the folders of the models in its order.

    The folder of a model has its name and lies in `output`. If a folder already has snapshots, the run uses them again;
    it fails if they belong to another problem. InputError if the file is wrong, if the program is not found, or if a
    run ends with another exit code than 0 and 3 (some points did not converge). OSError if a file cannot be read or
    written.
    """
    decks = read_variants(path)
    program = find_program()
    folders = [output / name for name in decks]
    with Progress(log, "runs", len(decks)) as progress:
        for i, (folder, (name, deck)) in enumerate(zip(folders, decks.items(), strict=True)):
            log.note(f"{name} ...")
            folder.mkdir(parents=True, exist_ok=True)
            (folder / "deck.yaml").write_text(yaml.safe_dump(deck, sort_keys=False), encoding="utf-8")
            _run(program, folder, partial(progress.advance, i))
    return folders


def read_variants(path: Path) -> dict[str, dict[str, Any]]:
    """Returns name -> deck of each model that the file `path` lists.

    The sections that the file gives for a model replace those of the deck that it names; null removes a section. Paths
    of files become absolute. The section `output` is always replaced by one that puts the results beside the deck.
    InputError if one of the two files is missing or is not YAML with sections, or if the list is not valid. The content
    of the decks is not checked.
    """
    file = read_sections(path, "list of models")
    if set(file) != {"deck", "models"} or not isinstance(file["models"], dict) or not file["models"]:
        raise InputError(
            path,
            "this needs two keys and no other: 'deck', the path of a deck, and 'models', which has at least one model "
            "as `name: {sections}`",
        )
    base_path = path.parent / str(file["deck"])
    base = read_sections(base_path, "deck")
    decks = {}
    for name, changes in file["models"].items():
        if not NAME.fullmatch(str(name)):
            raise InputError(
                path,
                f"the model's name '{name}' cannot be used; it needs a letter or digit, and then only letters, digits, "
                "'_', '.' and '-'",
            )
        if not isinstance(changes, dict):
            raise InputError(
                path, f"the model '{name}' needs the sections that it replaces in the deck, or {{}} for none"
            )
        deck = base | changes | {"output": {"directory": "."}}
        kept = {section: value for section, value in deck.items() if value is not None}
        decks[str(name)] = _with_whole_paths(kept, base_path.parent)
    return decks


def _with_whole_paths(part: Any, folder: Path) -> Any:
    """Returns a part of a deck in which all keys `file` have absolute paths; relative ones count from `folder`."""
    if isinstance(part, list):
        return [_with_whole_paths(entry, folder) for entry in part]
    if not isinstance(part, dict):
        return part
    return {
        key: str((folder / value).resolve())
        if key == "file" and isinstance(value, str)
        else _with_whole_paths(value, folder)
        for key, value in part.items()
    }


def _run(program: Path, folder: Path, advance: Callable[[str], None]) -> None:
    """Runs the program on deck.yaml in a folder, with log.txt for what it prints; InputError if the run fails.

    Calls `advance` with the last line that the program printed, again and again.
    """
    log = folder / "log.txt"
    with log.open("wb") as output:
        process = subprocess.Popen(
            [program, "run", "deck.yaml", "--benchmark"],
            cwd=folder,
            env=program_environment(),
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=subprocess.STDOUT,
        )
        try:
            while process.poll() is None:
                advance(last_line(log))
                with suppress(subprocess.TimeoutExpired):
                    process.wait(LOOK_INTERVAL)
        except BaseException:
            process.terminate()
            process.wait()
            raise
    code = process.returncode
    if code not in USABLE:
        said = log.read_text(encoding="utf-8", errors="replace").strip() or "it said nothing"
        raise InputError(log, f"{program.name} run ended with exit code {code}:\n{said}")
