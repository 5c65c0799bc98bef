# SPDX-License-Identifier: BSD-3-Clause
"""The command `signorom-post`."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from signorom_post import __version__
from signorom_post.check import add_check_command
from signorom_post.compare.command import add_compare_command
from signorom_post.errors import InputError, writing
from signorom_post.figures import BUILDERS, COLORS, FORMATS, FigureOptions, follow_figures
from signorom_post.fmu import add_fmu_command
from signorom_post.forest import need_scikit_learn, train_forest
from signorom_post.log import Log
from signorom_post.page import add_report_command
from signorom_post.paper.command import add_paper_command
from signorom_post.plots.verification_table import verification_table
from signorom_post.readers.verification import read_verification
from signorom_post.results import Results
from signorom_post.style import save, styled
from signorom_post.summary import format_summary
from signorom_post.verification import format_markdown, write_csv
from signorom_post.view import add_view_command

EXIT_OK = 0
EXIT_NOT_PASSED = 1
EXIT_USER_ERROR = 2
EXIT_STOPPED = 130


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs one command of `arguments` (default: those of the process) and returns the exit code.

    0: success. 1: a number of the verification lies outside of its limits. 2: a file or an argument is wrong. 130: the
    user stopped the command.
    """
    options = _parser().parse_args(arguments)
    try:
        options.log = Log(options.log_file)
    except InputError as error:
        print(error, file=sys.stderr)
        return EXIT_USER_ERROR
    code = _run(options)
    options.log.close()
    if options.log.failure:
        print(f"{options.log.path}: error: cannot write everything: {options.log.failure}", file=sys.stderr)
        code = code or EXIT_USER_ERROR
    return code


def _run(options: argparse.Namespace) -> int:
    try:
        return int(options.run(options))
    except InputError as error:
        options.log.note(error)
        return EXIT_USER_ERROR
    except KeyboardInterrupt:
        options.log.note("stopped; the same command goes on")
        return EXIT_STOPPED
    except BrokenPipeError:  # the reader of a pipe has left, as `| head` does
        sys.stderr.close()
        return EXIT_OK


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="signorom-post", description="Figures and tables from the results folder of a Signorom deck."
    )
    parser.add_argument("--version", action="version", version=f"signorom-post {__version__}")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)

    figures = commands.add_parser("figures", help="draw every figure that the files in the folder allow")
    figures.add_argument("results", metavar="RESULTS_DIR", type=Path, help="for instance results/half_disks")
    figures.add_argument("--output", metavar="DIR", type=Path, help="default: RESULTS_DIR/figures")
    figures.add_argument("--format", choices=FORMATS, default="png", help="default: png")
    figures.add_argument(
        "--point", metavar="P", help="number or label of the point to draw; default: the middle one"
    )
    figures.add_argument("--color", choices=COLORS, default="displacement", help="of the deformed bodies")
    figures.add_argument(
        "--only",
        metavar="NAME",
        choices=BUILDERS,
        nargs="+",
        help=f"some of: {', '.join(BUILDERS)}; default: all",
    )
    figures.set_defaults(run=_run_figures)

    summary = commands.add_parser("summary", help="print a short table from report.yaml")
    summary.add_argument("results", metavar="RESULTS_DIR", type=Path, help="for instance results/half_disks")
    summary.set_defaults(run=_run_summary)

    add_report_command(commands)
    add_view_command(commands)
    add_check_command(commands)
    forest = commands.add_parser("forest", help="train the random forest that chooses the cluster of a point")
    forest.add_argument(
        "labels",
        metavar="LABELS.csv",
        type=Path,
        nargs="?",
        help="columns: the parameters, then 'cluster' (from 1)",
    )
    forest.add_argument("--check", action="store_true", help="train nothing; only see whether it could")
    forest.add_argument("--output", metavar="FILE", type=Path, help="default: forest.h5 beside LABELS.csv")
    forest.add_argument("--trees", metavar="N", type=_positive, default=100, help="default: 100")
    forest.add_argument("--seed", metavar="N", type=int, default=1, help="default: 1")
    forest.set_defaults(run=_run_forest)

    verification = commands.add_parser(
        "verification", help="draw and print the table of what the verification tests found"
    )
    verification.add_argument(
        "results",
        metavar="RESULTS_DIR",
        type=Path,
        nargs="?",
        default=Path("build/ci/verification"),
        help="folder beside the tested program; default: build/ci/verification",
    )
    verification.add_argument("--output", metavar="DIR", type=Path, help="default: RESULTS_DIR/table")
    verification.set_defaults(run=_run_verification)
    add_fmu_command(commands)
    add_compare_command(commands, _positive)
    add_paper_command(commands)
    for command in commands.choices.values():
        command.add_argument(
            "--log",
            metavar="FILE",
            dest="log_file",
            type=Path,
            help="add all that is said to a file, with dates",
        )
    return parser


def _positive(text: str) -> int:
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError(f"{number} is less than 1")
    return number


def _run_forest(options: argparse.Namespace) -> int:
    if options.check:
        need_scikit_learn()
        return EXIT_OK
    if options.labels is None:
        raise InputError("signorom-post forest", "the table LABELS.csv is missing")
    output = options.output or options.labels.with_name("forest.h5")
    accuracy = train_forest(options.labels, output, options.trees, options.seed)
    options.log.result(output)
    if accuracy is not None:
        options.log.result(f"out-of-bag accuracy: {100 * accuracy:.1f} %")
    return EXIT_OK


def _run_figures(options: argparse.Namespace) -> int:
    results = Results(options.results)
    output = options.output or options.results / "figures"
    choice = FigureOptions(options.point, options.color, tuple(options.only) if options.only else None)
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
        raise InputError(options.results, "the folder has nothing to draw")
    return EXIT_USER_ERROR if has_failed else EXIT_OK


def _run_summary(options: argparse.Namespace) -> int:
    options.log.result(format_summary(Results(options.results).report))
    return EXIT_OK


def _run_verification(options: argparse.Namespace) -> int:
    figures = read_verification(options.results)
    output = options.output or options.results / "table"
    with writing("the table", output):
        output.mkdir(parents=True, exist_ok=True)
        write_csv(figures, output / "verification.csv")
        with styled():
            save(verification_table(figures), output / "verification.png")
    options.log.result(format_markdown(figures))
    return EXIT_OK if all(figure.is_passed for figure in figures) else EXIT_NOT_PASSED
