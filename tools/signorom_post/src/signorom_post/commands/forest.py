# SPDX-License-Identifier: BSD-3-Clause
"""The command `signorom-post forest`: trains the random forest that chooses the cluster of a point."""

import argparse
from pathlib import Path

from signorom_post.arguments import at_least
from signorom_post.errors import InputError
from signorom_post.forest import need_scikit_learn, train_forest


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments of `signorom-post forest` to its parser."""
    parser.add_argument(
        "labels",
        metavar="LABELS.csv",
        type=Path,
        nargs="?",
        help="table with a column per parameter and the column 'cluster' (from 1)",
    )
    parser.add_argument(
        "--check", action="store_true", help="train nothing; only check that scikit-learn is installed"
    )
    parser.add_argument("--output", metavar="FILE", type=Path, help="default: forest.h5 beside LABELS.csv")
    parser.add_argument(
        "--trees", metavar="N", type=at_least(1), default=100, help="number of trees; default: 100"
    )
    parser.add_argument(
        "--seed", metavar="N", type=int, default=1, help="seed of the random numbers; default: 1"
    )


def run(options: argparse.Namespace) -> int:
    """Trains the forest, writes it, and prints its path and its out-of-bag accuracy, if it has one. Returns 0.

    With --check it only looks for scikit-learn, and writes and prints nothing. InputError if scikit-learn is missing,
    and without --check if LABELS.csv is not given, is missing or is not valid, or if the forest cannot be written.
    """
    if options.check:
        need_scikit_learn()
        return 0
    if options.labels is None:
        raise InputError("signorom-post forest", "give the table LABELS.csv, or --check")
    output = options.output or options.labels.with_name("forest.h5")
    accuracy = train_forest(options.labels, output, options.trees, options.seed)
    options.log.result(output)
    if accuracy is not None:
        options.log.result(f"out-of-bag accuracy: {100 * accuracy:.1f} %")
    return 0
