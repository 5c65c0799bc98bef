# SPDX-License-Identifier: BSD-3-Clause
"""Reads the results of the verification tests: one CSV file per test file, one row per number that was compared."""

import csv
import math
from dataclasses import dataclass
from pathlib import Path

from signorom_post.errors import InputError

COLUMNS = (
    "problem",
    "quantity",
    "unit",
    "reference",
    "source",
    "found",
    "difference",
    "allowed",
    "kind",
    "is_passed",
)
#: kinds of comparison: relative or absolute difference from a reference, or a lower or upper limit of the number found;
#: empty: the test failed before the comparison
KINDS = ("relative", "absolute", "at_least", "at_most", "")
HOW_TO_MAKE = "`ctest --preset ci -L verification` makes them, in build/ci/verification"


@dataclass(frozen=True)
class VerifiedFigure:
    """One number that was compared; nan stands for numbers that the row does not have."""

    problem: str
    quantity: str
    unit: str
    reference: float
    #: where the reference comes from
    source: str
    found: float
    #: found / reference - 1 if `kind` is relative, found - reference if it is absolute
    difference: float
    #: largest size of the difference, or the limit of `found`
    allowed: float
    #: one of KINDS
    kind: str
    is_passed: bool


def read_verification(folder: Path) -> list[VerifiedFigure]:
    """Returns the rows of all CSV files of a folder, with the rows of one problem next to each other.

    Files are read in the order of their names. InputError if there are no rows, or if a file cannot be used.
    """
    if not folder.is_dir():
        raise InputError(folder, f"there are no verification results; {HOW_TO_MAKE}")
    figures = [figure for path in sorted(folder.glob("*.csv")) for figure in _read_file(path)]
    if not figures:
        raise InputError(folder, f"the folder has no verification results; {HOW_TO_MAKE}")
    problems = list(dict.fromkeys(figure.problem for figure in figures))
    return sorted(figures, key=lambda figure: problems.index(figure.problem))


def _read_file(path: Path) -> list[VerifiedFigure]:
    try:
        with path.open(newline="", encoding="utf-8") as file:
            rows = list(csv.reader(file))
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(path, "this is not a CSV file") from error
    except OSError as error:
        raise InputError(path, f"the file cannot be read ({error.strerror})") from error
    if not rows or tuple(rows[0]) != COLUMNS:
        raise InputError(path, f"the columns are not {', '.join(COLUMNS)}")
    return [_figure(path, i_line, row) for i_line, row in enumerate(rows[1:], start=2)]


def _figure(path: Path, i_line: int, row: list[str]) -> VerifiedFigure:
    if len(row) != len(COLUMNS):
        raise InputError(path, f"line {i_line} has {len(row)} values for {len(COLUMNS)} columns")
    cells = dict(zip(COLUMNS, row, strict=True))
    if cells["is_passed"] not in ("yes", "no"):
        raise InputError(path, f"line {i_line}, column 'is_passed': '{cells['is_passed']}' is not yes or no")
    if cells["kind"] not in KINDS:
        raise InputError(path, f"line {i_line}, column 'kind': '{cells['kind']}' is unknown")
    numbers = {}
    for name in ("reference", "found", "difference", "allowed"):
        try:
            numbers[name] = float(cells[name]) if cells[name] else math.nan
        except ValueError as error:
            raise InputError(
                path, f"line {i_line}, column '{name}': '{cells[name]}' is not a number"
            ) from error
    texts = {name: cells[name] for name in ("problem", "quantity", "unit", "source", "kind")}
    return VerifiedFigure(**texts, **numbers, is_passed=cells["is_passed"] == "yes")
