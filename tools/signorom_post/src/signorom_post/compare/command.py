# SPDX-License-Identifier: BSD-3-Clause
"""The command `signorom-post compare`: one table of several models of one problem."""

import argparse
import itertools
from collections.abc import Callable
from pathlib import Path

from signorom_post.arguments import at_least
from signorom_post.compare.entries import read_study
from signorom_post.compare.table import explanation, format_markdown, write_csv
from signorom_post.compare.timing import query_time
from signorom_post.compare.variants import run_variants
from signorom_post.errors import InputError, writing
from signorom_post.library import LibraryError
from signorom_post.log import Progress
from signorom_post.program import terminable


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments of `signorom-post compare` to its parser."""
    parser.add_argument(
        "results",
        metavar="RESULTS_DIR",
        type=Path,
        nargs="*",
        help="folder that `signorom run DECK --benchmark` left",
    )
    parser.add_argument(
        "--run",
        metavar="FILE",
        dest="variants",
        type=Path,
        help="make the models that this file lists, then compare them",
    )
    parser.add_argument(
        "--output",
        metavar="DIR",
        type=Path,
        help="folder of the models that --run makes; default: results/compare/<FILE without its ending>",
    )
    parser.add_argument(
        "--csv", metavar="FILE", type=Path, help="also write the numbers of the table to this file"
    )
    parser.add_argument(
        "--points",
        metavar="N",
        type=at_least(1),
        default=1000,
        help="number of random points at which a query is timed; default: 1000",
    )
    parser.add_argument(
        "--seed", metavar="N", type=at_least(1), default=1, help="seed of these points; default: 1"
    )
    parser.add_argument(
        "--no-times", action="store_true", help="leave out all times, which depend on the machine"
    )


def run(options: argparse.Namespace) -> int:
    """Prints the table of the models. With --csv it also writes the table, with --run it first makes the models.

    Returns 0. InputError if there are neither folders nor --run, or both; if a folder has no validated model, or one of
    another problem or with other test points; if the program is not found or a run fails; or if a file cannot be read
    or written. A missing online library is no error: the table then has no times of queries of models.
    """
    if bool(options.results) == bool(options.variants):
        raise InputError("signorom-post compare", "give either results folders or --run FILE, and not both")
    try:
        folders = options.results or _make(options)
        with Progress(options.log, "models", len(folders)) as progress:
            study = read_study(folders, _timer(options, progress))
    except OSError as error:
        raise InputError(
            error.filename or "signorom-post compare", f"cannot be used ({error.strerror})"
        ) from error
    has_times = not options.no_times
    options.log.result(format_markdown(study, has_times))
    options.log.result(f"\n{explanation(study, has_times, options.points, options.seed)}")
    if options.csv:
        with writing("the table", options.csv):
            write_csv(options.csv, [*study.full_order, *study.models])
    return 0


def _make(options: argparse.Namespace) -> list[Path]:
    output = options.output or Path("results/compare") / options.variants.stem
    with terminable():
        return run_variants(options.variants, output, options.log)


def _timer(options: argparse.Namespace, progress: Progress) -> Callable[[Path], float | None]:
    """Returns a function that returns the time [s] of a query of a model file.

    That function returns None if the user does not want times, or, with a note, if the library cannot be used. Each
    call advances `progress` by one model.
    """
    steps = itertools.count(1)

    def time_of(path: Path) -> float | None:
        if options.no_times:
            return None
        try:
            return query_time(path, options.points, options.seed)
        except LibraryError as error:
            options.log.note(f"queries are not timed: {error}")
            return None
        finally:
            progress.advance(next(steps))

    return time_of
