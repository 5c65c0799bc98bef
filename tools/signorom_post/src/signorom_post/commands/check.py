# SPDX-License-Identifier: BSD-3-Clause
"""The command `signorom-post check`: draws the set-up that `signorom check DECK --fields` wrote."""

import argparse
from pathlib import Path

from signorom_post.check import FORMATS, follow_pictures
from signorom_post.errors import writing
from signorom_post.readers.check import find_check_file, read_check


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments of `signorom-post check` to its parser."""
    parser.add_argument(
        "file", metavar="RESULTS_DIR|FILE", type=Path, help="results folder, check.h5 or check.xdmf"
    )
    parser.add_argument(
        "--output", metavar="DIR", type=Path, help="default: the folder 'figures' beside check.h5"
    )
    parser.add_argument("--format", choices=FORMATS, default="png", help="default: png")


def run(options: argparse.Namespace) -> int:
    """Draws the pictures and prints the path of each. Returns 0.

    InputError if check.h5 is missing, damaged, or without a set-up or bodies, or if a picture cannot be written.
    """
    check = read_check(find_check_file(options.file))
    output = options.output or check.path.parent / "figures"
    with writing("pictures", output):
        output.mkdir(parents=True, exist_ok=True)
        for path in follow_pictures(options.log, check, output, options.format):
            options.log.result(path)
    return 0
