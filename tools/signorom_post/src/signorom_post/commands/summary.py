# SPDX-License-Identifier: BSD-3-Clause
"""The command `signorom-post summary`: prints a short table from report.yaml."""

import argparse
from pathlib import Path

from signorom_post.results import Results
from signorom_post.summary import format_summary


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments of `signorom-post summary` to its parser."""
    parser.add_argument("results", metavar="RESULTS_DIR", type=Path, help="for instance results/half_disks")


def run(options: argparse.Namespace) -> int:
    """Prints the table. Returns 0. InputError if the folder is missing, or if report.yaml is missing or damaged."""
    options.log.result(format_summary(Results(options.results).report))
    return 0
