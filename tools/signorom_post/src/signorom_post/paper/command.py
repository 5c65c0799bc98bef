# SPDX-License-Identifier: BSD-3-Clause
"""The command `signorom-post paper`: tables and figures of case b, and one table of all its numbers."""

import argparse
import csv
import os
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from signorom_post.arguments import at_least
from signorom_post.errors import InputError
from signorom_post.figures import FORMATS
from signorom_post.log import Log, duration
from signorom_post.paper.case import figure_8
from signorom_post.paper.clusters import figure_15, figure_17, figure_18, table_2
from signorom_post.paper.comparison import Comparison, markdown_table, rows_for_csv, text_table
from signorom_post.paper.convergence import figure_3, figure_10
from signorom_post.paper.decay import figure_16
from signorom_post.paper.domains import figure_9, figure_12
from signorom_post.paper.forces import figure_14
from signorom_post.paper.irregular import figure_19, figure_20, figure_21, figure_22
from signorom_post.paper.maps import figure_11, figure_13
from signorom_post.paper.outcome import Entry, Outcome, Row, Study
from signorom_post.paper.runs import Runs
from signorom_post.paper.table_1 import table_1
from signorom_post.program import find_base_deck, find_program, terminable
from signorom_post.style import save, styled

#: name of a figure or table of the paper -> procedure that makes it; in the paper's order
ENTRIES: dict[str, Entry] = {
    "fig03": figure_3,
    "fig08": figure_8,
    "fig09": figure_9,
    "fig10": figure_10,
    "table1": table_1,
    "fig11": figure_11,
    "fig12": figure_12,
    "fig13": figure_13,
    "fig14": figure_14,
    "fig15": figure_15,
    "fig16": figure_16,
    "fig17": figure_17,
    "table2": table_2,
    "fig18": figure_18,
    "fig19": figure_19,
    "fig20": figure_20,
    "fig21": figure_21,
    "fig22": figure_22,
}
TITLE = "Case b of the paper"
INTRODUCTION = (
    "Paper: S. Le Berre, I. Ramière, J. Fauque, D. Ryckelynck, Mathematics 10 (2022) 1495, section 5.2 (CC BY 4.0). "
    "Column `ours`: the pressure acts on the edges that are below the height as a whole, as in the paper. Column "
    "`ours, cut`: it also acts on the lower part of the edge that the height cuts."
)


@dataclass(frozen=True)
class PaperOptions:
    """The options of the command."""

    #: folder of all files
    output: Path
    #: keys of ENTRIES
    only: Sequence[str]
    file_format: str
    #: points per parameter of the error maps
    n_map: int
    #: number of runs that work at the same time
    n_jobs: int
    log: Log


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments of `signorom-post paper` to its parser."""
    parser.add_argument(
        "--output", metavar="DIR", type=Path, default=Path("results/paper"), help="default: results/paper"
    )
    parser.add_argument(
        "--only",
        metavar="NAME",
        choices=ENTRIES,
        nargs="+",
        default=list(ENTRIES),
        help=f"some of: {', '.join(ENTRIES)}; default: all",
    )
    parser.add_argument("--format", choices=FORMATS, default="png", help="default: png")
    parser.add_argument(
        "--map", metavar="N", type=at_least(2), default=80, help="error maps of N x N points; default: 80"
    )
    parser.add_argument(
        "--jobs",
        metavar="N",
        type=at_least(1),
        default=os.cpu_count() or 1,
        help="number of runs at the same time; default: number of cores",
    )


def run(options: argparse.Namespace) -> int:
    """Makes the figures and tables of the paper that the user chose. Returns 0, whatever the numbers are.

    InputError if the program or the deck is not found, if a run fails, or if a file cannot be read or written.
    """
    try:
        chosen = options.output, options.only, options.format, options.map, options.jobs, options.log
        make_paper(PaperOptions(*chosen))
    except OSError as error:
        raise InputError(error.filename or options.output, f"cannot be used ({error.strerror})") from error
    return 0


def make_paper(options: PaperOptions) -> list[Comparison]:
    """Makes the figures and tables of `options.only`, and returns the numbers of the printed table.

    It starts the runs that are needed and missing, and writes the files of the figures and tables, and a summary.

    InputError if the program or the deck is not found, or if a run fails. OSError if a file cannot be read or written.
    """
    start = time.monotonic()
    runs = Runs(options.output / "runs", find_program(), find_base_deck(), options.n_jobs, options.log)
    study = Study(runs, options.n_map)
    comparisons: list[Comparison] = []
    with terminable():
        names = [name for name in ENTRIES if name in options.only]
        for i, name in enumerate(names, start=1):
            options.log.note(f"{name} ({i} of {len(names)}) ...")
            with styled():
                outcome = ENTRIES[name](study)
                _write(outcome, options)
            comparisons += outcome.comparisons
    _write_csv(options.output / "summary.csv", rows_for_csv(comparisons))
    text = f"# {TITLE}\n\n{INTRODUCTION}\n\nMade: {', '.join(options.only)}.\n\n{markdown_table(comparisons)}"
    (options.output / "summary.md").write_text(text, encoding="utf-8")
    options.log.result(options.output / "summary.md")
    options.log.result(f"\n{text_table(comparisons)}")
    options.log.note(f"figures and tables made: {len(names)}, in {duration(time.monotonic() - start)}")
    return comparisons


def _write(outcome: Outcome, options: PaperOptions) -> None:
    for name, rows in outcome.tables.items():
        path = options.output / f"{name}.csv"
        _write_csv(path, rows)
        options.log.result(path)
    for name, figure in outcome.figures.items():
        path = options.output / f"{name}.{options.file_format}"
        save(figure, path)
        options.log.result(path)


def _write_csv(path: Path, rows: Sequence[Row]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, fieldnames=list(rows[0]) if rows else [], lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
