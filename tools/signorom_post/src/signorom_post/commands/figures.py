# SPDX-License-Identifier: BSD-3-Clause
"""The command `signorom-post figures`: draws every figure that the files in the folder allow."""

import argparse
from pathlib import Path

from signorom_post.errors import InputError, writing
from signorom_post.figures import BUILDERS, COLORS, FORMATS, FigureOptions, follow_figures
from signorom_post.results import Results


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments of `signorom-post figures` to its parser."""
    parser.add_argument("results", metavar="RESULTS_DIR", type=Path, help="for instance results/half_disks")
    parser.add_argument("--output", metavar="DIR", type=Path, help="default: RESULTS_DIR/figures")
    parser.add_argument("--format", choices=FORMATS, default="png", help="default: png")
    parser.add_argument(
        "--point",
        metavar="P",
        help="number (from 1) or label of the point of initial_and_deformed (default: the middle one), and of the one "
        "whose history stick_slip shows (default: the first one)",
    )
    parser.add_argument(
        "--x",
        metavar="COLUMN",
        help="column of history.csv to the right in hysteresis; default: the table in whose steps friction works most, "
        "or time",
    )
    parser.add_argument(
        "--y",
        metavar="COLUMN",
        help="column of history.csv upwards in hysteresis; default: the force along friction, where it works most",
    )
    parser.add_argument(
        "--color",
        choices=COLORS,
        default="displacement",
        help="what the colors of initial_and_deformed show: the size of the displacement, or the contact pressure; "
        "default: displacement",
    )
    parser.add_argument(
        "--only",
        metavar="NAME",
        choices=BUILDERS,
        nargs="+",
        help=f"some of: {', '.join(BUILDERS)}; default: all",
    )


def run(options: argparse.Namespace) -> int:
    """Writes the figures, prints the path of each, and tells which are left out and why.

    Returns 0, or 2 if a figure was left out because a file cannot be used or does not have the point of --point. A
    missing file does not count. InputError if the folder is missing, if all figures were left out for other reasons,
    such as missing files, or if a figure cannot be written.
    """
    results = Results(options.results)
    output = options.output or options.results / "figures"
    only = tuple(options.only) if options.only else None
    choice = FigureOptions(options.point, options.x, options.y, options.color, only)
    with writing("figures", output):
        output.mkdir(parents=True, exist_ok=True)
        outcomes = []
        for outcome in follow_figures(options.log, results, output, options.format, choice):
            outcomes.append(outcome)
            if outcome.path:
                options.log.result(outcome.path)
    for outcome in outcomes:
        if not outcome.path:
            options.log.result(f"left out: {outcome.name} ({outcome.reason})")
    for reason in dict.fromkeys(outcome.reason for outcome in outcomes if outcome.is_failure):
        options.log.note(reason)
    has_failed = any(outcome.is_failure for outcome in outcomes)
    if not has_failed and not any(outcome.path for outcome in outcomes):
        raise InputError(options.results, "nothing can be drawn; the lines 'left out' say why")
    return 2 if has_failed else 0
