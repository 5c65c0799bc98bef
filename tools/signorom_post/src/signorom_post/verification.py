# SPDX-License-Identifier: BSD-3-Clause
"""Makes the table of the verification: as texts, in Markdown and as CSV."""

import csv
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from signorom_post.readers.verification import VerifiedFigure

HEADINGS = ("problem", "quantity", "reference", "source", "Signorom", "difference", "allowed", "")
PASSED, FAILED = "pass", "FAIL"


def table_of(figures: Sequence[VerifiedFigure]) -> list[list[str]]:
    """Returns one row of texts per verified number, with the columns of HEADINGS."""
    return [
        [
            figure.problem,
            figure.quantity,
            _value(figure.reference, figure.unit),
            figure.source,
            _value(figure.found, figure.unit),
            _difference(figure),
            _allowed(figure),
            PASSED if figure.is_passed else FAILED,
        ]
        for figure in figures
    ]


def worst_of_alike(figures: Sequence[VerifiedFigure]) -> list[VerifiedFigure]:
    """Returns the rows with groups of similar rows replaced by one row, which says how many there are.

    Similar rows have the kind `at_most`, have passed, and have the same problem, source and limit. The row that stays
    is the one with the largest number found; it takes the place of the first one of its group.
    """
    groups: dict[tuple[object, ...], list[VerifiedFigure]] = {}
    for i_row, figure in enumerate(figures):
        is_alike = figure.kind == "at_most" and figure.is_passed
        key = (figure.problem, figure.source, figure.allowed) if is_alike else (i_row,)
        groups.setdefault(key, []).append(figure)
    return [_worst(group) for group in groups.values()]


def _worst(group: list[VerifiedFigure]) -> VerifiedFigure:
    if len(group) == 1:
        return group[0]
    worst = max(group, key=lambda figure: figure.found)
    return replace(worst, quantity=f"{worst.quantity} (worst of {len(group)})")


def verdict(figures: Sequence[VerifiedFigure]) -> str:
    """Returns a text with the number of verified numbers, and how many of them failed; if none did, it says so."""
    n_failed = sum(not figure.is_passed for figure in figures)
    return f"{len(figures)} numbers, " + (f"{n_failed} FAILED" if n_failed else "all within what is allowed")


def format_markdown(figures: Sequence[VerifiedFigure]) -> str:
    """Returns the table in Markdown with aligned columns, and the verdict below it."""
    rows = [list(HEADINGS), *table_of(figures)]
    widths = [max(3, *(len(row[i]) for row in rows)) for i in range(len(HEADINGS))]
    lines = [
        "| " + " | ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) + " |"
        for row in rows
    ]
    lines.insert(1, "|" + "|".join("-" * (width + 2) for width in widths) + "|")
    return "\n".join([*lines, "", verdict(figures) + "."])


def write_csv(figures: Sequence[VerifiedFigure], path: Path) -> None:
    """Writes the texts of the whole table as CSV, with a header. OSError if the file cannot be written."""
    with path.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([HEADINGS[:-1] + ("result",), *table_of(figures)])


def _value(value: float, unit: str) -> str:
    if math.isnan(value):
        return ""
    # small numbers without a unit are differences, for which two digits are enough
    n_digits = 2 if abs(value) < 1e-3 and not unit else 6
    return f"{_number(value, n_digits)} {unit}".rstrip()


def _difference(figure: VerifiedFigure) -> str:
    if math.isnan(figure.difference):
        return ""
    if figure.kind == "relative":
        return _share(figure.difference, "+")
    return _number(figure.difference, 2, "+")


def _allowed(figure: VerifiedFigure) -> str:
    if math.isnan(figure.allowed):
        return ""
    if figure.kind == "relative":
        return "± " + _share(figure.allowed)
    sign = {"absolute": "±", "at_least": "≥", "at_most": "≤"}[figure.kind]
    return f"{sign} {_number(figure.allowed, 3)}"


def _share(value: float, sign: str = "") -> str:
    """Returns a share in percent, or as it is with one digit if its size is below 1e-5: 2 %, +0.013 %, -3e-11.

    `sign` is "+" if a positive number gets a sign, else empty.
    """
    is_legible = value == 0 or abs(value) >= 1e-5
    return f"{_number(100 * value, 2, sign)} %" if is_legible else _number(value, 1, sign)


def _number(value: float, n_digits: int, sign: str = "") -> str:
    """Returns a number with `n_digits` significant digits, and exponents without a zero in front: 1e-9, not 1e-09."""
    return f"{value:{sign}.{n_digits}g}".replace("e-0", "e-").replace("e+0", "e+")
