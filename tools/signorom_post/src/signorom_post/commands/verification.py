# SPDX-License-Identifier: BSD-3-Clause
"""The command `signorom-post verification`: draws and prints the table of what the verification tests found."""

import argparse
from pathlib import Path

from signorom_post.errors import writing
from signorom_post.plots.verification_table import verification_table
from signorom_post.readers.verification import read_verification
from signorom_post.style import save, styled
from signorom_post.verification import format_markdown, write_csv


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments of `signorom-post verification` to its parser."""
    parser.add_argument(
        "results",
        metavar="RESULTS_DIR",
        type=Path,
        nargs="?",
        default=Path("build/ci/verification"),
        help="folder in which the verification tests left their results; default: build/ci/verification",
    )
    parser.add_argument("--output", metavar="DIR", type=Path, help="default: RESULTS_DIR/table")


def run(options: argparse.Namespace) -> int:
    """Writes the table as CSV and as a picture, and prints it.

    Returns 0, or 1 if a number lies outside of its limits, or is missing because its test failed before the comparison.
    InputError if the folder has no results, if a file cannot be used, or if the table cannot be written.
    """
    figures = read_verification(options.results)
    output = options.output or options.results / "table"
    with writing("the table", output):
        output.mkdir(parents=True, exist_ok=True)
        write_csv(figures, output / "verification.csv")
        with styled():
            save(verification_table(figures), output / "verification.png")
    options.log.result(format_markdown(figures))
    return 0 if all(figure.is_passed for figure in figures) else 1
