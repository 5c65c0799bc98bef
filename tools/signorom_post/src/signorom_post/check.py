# SPDX-License-Identifier: BSD-3-Clause
"""The command `signorom-post check`: pictures of the set-up that `signorom check DECK --fields` wrote."""

import argparse
from collections.abc import Iterator
from pathlib import Path

from signorom_post.errors import writing
from signorom_post.log import Log
from signorom_post.plots.check_bodies import check_bodies
from signorom_post.plots.check_contact import check_contact
from signorom_post.readers.check import CheckFile, find_check_file, read_check
from signorom_post.style import save, styled

FORMATS = ("png", "pdf", "svg")


def add_check_command(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the command `check` and its arguments."""
    check = commands.add_parser("check", help="draw the set-up that `signorom check DECK --fields` wrote")
    check.add_argument(
        "file", metavar="RESULTS_DIR|FILE", type=Path, help="results folder, check.h5 or check.xdmf"
    )
    check.add_argument("--output", metavar="DIR", type=Path, help="default: figures beside the file")
    check.add_argument("--format", choices=FORMATS, default="png", help="default: png")
    check.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    check = read_check(find_check_file(options.file))
    output = options.output or check.path.parent / "figures"
    with writing("pictures", output):
        output.mkdir(parents=True, exist_ok=True)
        for path in follow_pictures(options.log, check, output, options.format):
            options.log.result(path)
    return 0


def write_pictures(check: CheckFile, output: Path, file_format: str) -> Iterator[Path]:
    """Writes a picture of the bodies with supports and loads, then one of each contact; yields the path of each."""
    with styled():
        path = output / f"check_bodies.{file_format}"
        save(check_bodies(check), path)
        yield path
        for entry in range(1, len(check.names["contacts"]) + 1):
            path = output / f"check_contact_{entry}.{file_format}"
            save(check_contact(check, entry), path)
            yield path


def follow_pictures(log: Log, check: CheckFile, output: Path, file_format: str) -> Iterator[Path]:
    """Writes the pictures like `write_pictures`, and shows the progress."""
    n_pictures = 1 + len(check.names["contacts"])
    return log.follow("pictures", write_pictures(check, output, file_format), n_pictures)
