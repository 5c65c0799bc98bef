# SPDX-License-Identifier: BSD-3-Clause
"""The command `signorom-post report`: writes one HTML page with verdict, errors, pictures, deck and provenance."""

import argparse
from pathlib import Path

from signorom_post.errors import writing
from signorom_post.page import build_page
from signorom_post.results import Results


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments of `signorom-post report` to its parser."""
    parser.add_argument("results", metavar="RESULTS_DIR", type=Path, help="for instance results/half_disks")
    parser.add_argument("--output", metavar="FILE", type=Path, help="default: RESULTS_DIR/report.html")


def run(options: argparse.Namespace) -> int:
    """Writes the page and prints its path. Returns 0.

    Pictures that cannot be drawn are left out without a message. InputError if the folder is missing, if report.yaml is
    missing or damaged, if there is a check.h5 that cannot be used, or if the page cannot be written.
    """
    results = Results(options.results)
    output = options.output or options.results / "report.html"
    with writing("the page", output):
        page = build_page(results, options.log)
        output.write_text(page, encoding="utf-8")
    options.log.result(output)
    return 0
