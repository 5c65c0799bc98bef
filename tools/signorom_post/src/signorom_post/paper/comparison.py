# SPDX-License-Identifier: BSD-3-Clause
"""Comparison of a number of the paper with ours, that is, Signorom's, and the table of all comparisons."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from signorom_post.arrays import format_number

COLUMNS = ("where", "quantity", "paper", "ours", "allowed", "verdict", "ours, cut")
WITHIN, OUTSIDE, OUTSIDE_NOT_ROBUST, ABSENT = "within", "OUTSIDE", "outside, not robust", "-"


def percent(value: float) -> str:
    """Returns a share in percent with two significant digits, as the paper prints errors: 0.025 becomes `2.5 %`.

    Infinity and NaN become `inf` and `nan`.
    """
    return f"{float(f'{100 * value:.2g}'):g} %" if math.isfinite(value) else str(value)


def count(value: float) -> str:
    """Returns the text of a number rounded to a whole number."""
    return f"{value:.0f}"


def number(value: float) -> str:
    """Returns the text of a number rounded to two significant digits. Infinity and NaN become `inf` and `nan`."""
    return format_number(float(f"{value:.2g}"))


@dataclass(frozen=True)
class Comparison:
    """One number of the paper and ours."""

    #: figure or table of the paper
    where: str
    #: name of the number
    quantity: str
    #: the paper's number; None if the paper shows only a picture
    paper: float | None
    #: the number that Signorom finds
    ours: float
    #: returns the text of a number
    show: Callable[[float], str]
    #: lower and upper limit of `ours` that count as agreement; None if no limits were set
    allowed: tuple[float, float] | None = None
    #: False: the number depends on choices that the paper does not give, so a difference means little
    is_robust: bool = True
    #: False: the number in `paper` is not from the paper; the remark says where it is from
    is_published: bool = True
    #: our number if the pressure also acts on the part of an edge below the height (load `cut`); None: not run
    cut: float | None = None
    #: why ours differs, or what the number means
    remark: str = ""

    @property
    def verdict(self) -> str:
        """Whether `ours` lies within `allowed`, as one of the texts WITHIN, OUTSIDE, OUTSIDE_NOT_ROBUST and ABSENT.

        OUTSIDE_NOT_ROBUST: outside, but `is_robust` is False; ABSENT: `allowed` is None. A NaN lies outside.
        """
        if self.allowed is None:
            return ABSENT
        if self.allowed[0] <= self.ours <= self.allowed[1]:
            return WITHIN
        return OUTSIDE if self.is_robust else OUTSIDE_NOT_ROBUST

    def cells(self) -> list[str]:
        """Returns the row of the table: a text for each of COLUMNS, `-` if there is no number or there are no limits.

        In the column `paper`, a star marks a number that is not robust, parentheses one that is not from the paper.
        """
        cut = ABSENT if self.cut is None else self.show(self.cut)
        paper = ABSENT if self.paper is None else self.show(self.paper)
        paper = paper if self.is_published else f"({paper})"
        paper += "" if self.is_robust else " *"
        return [
            self.where,
            self.quantity,
            paper,
            self.show(self.ours),
            self._allowed_text(),
            self.verdict,
            cut,
        ]

    def _allowed_text(self) -> str:
        if self.allowed is None:
            return ABSENT
        low, high = self.allowed
        if low == high:
            return self.show(low)
        if low <= 0.0:
            return f"<= {self.show(high)}"
        return f"{self.show(low)} to {self.show(high)}"


def exactly(value: float) -> tuple[float, float]:
    """Returns limits that allow only `value`."""
    return value, value


def about(value: float, margin: float) -> tuple[float, float]:
    """Returns limits at a distance `margin` below and above `value`."""
    return value - margin, value + margin


def at_most(value: float, factor: float) -> tuple[float, float]:
    """Returns limits for an error: from 0 to `factor` times `value`."""
    return 0.0, factor * value


def text_table(comparisons: Sequence[Comparison]) -> str:
    """Returns the table with aligned columns for a terminal, and the counts, notes and remarks below it."""
    rows = [list(COLUMNS), *(comparison.cells() for comparison in comparisons)]
    widths = [max(len(row[i]) for row in rows) for i in range(len(COLUMNS))]
    lines = [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows
    ]
    return "\n".join([*lines, "", *_notes(comparisons)])


def markdown_table(comparisons: Sequence[Comparison]) -> str:
    """Returns the table in Markdown, and the counts, notes and remarks below it as a list."""
    rows = [list(COLUMNS), ["---"] * len(COLUMNS), *(comparison.cells() for comparison in comparisons)]
    lines = ["| " + " | ".join(cell.replace("*", "\\*") for cell in row) + " |" for row in rows]
    notes = [f"- {note}".replace("*", "\\*") for note in _notes(comparisons)]
    return "\n".join([*lines, "", *notes]) + "\n"


def rows_for_csv(comparisons: Sequence[Comparison]) -> list[dict[str, object]]:
    """Returns a row per comparison with all digits: column name -> number or text, empty for None."""
    return [
        {
            "where": item.where,
            "quantity": item.quantity,
            "paper": "" if item.paper is None else item.paper,
            "ours": item.ours,
            "allowed_min": "" if item.allowed is None else item.allowed[0],
            "allowed_max": "" if item.allowed is None else item.allowed[1],
            "verdict": item.verdict,
            "is_robust": item.is_robust,
            "ours_cut": "" if item.cut is None else item.cut,
            "remark": item.remark,
        }
        for item in comparisons
    ]


def _notes(comparisons: Sequence[Comparison]) -> list[str]:
    verdicts = [item.verdict for item in comparisons]
    notes = [
        f"{len(verdicts)} numbers: {verdicts.count(WITHIN)} within what is allowed, {verdicts.count(OUTSIDE)} "
        f"outside, {verdicts.count(OUTSIDE_NOT_ROBUST)} outside but not robust, {verdicts.count(ABSENT)} without "
        "an agreed range."
    ]
    if not all(item.is_robust for item in comparisons):
        notes.append(
            "* marks a number that depends on choices that the paper does not give; differences mean little."
        )
    if not all(item.is_published for item in comparisons):
        notes.append(
            "(...) marks a number that is not from the paper; the remark on it says where it is from."
        )
    remarks: dict[str, list[str]] = {}
    for item in comparisons:
        if item.remark:
            remarks.setdefault(item.remark, []).append(f"{item.where}, {item.quantity}")
    for remark, numbers in remarks.items():
        more = f" and {len(numbers) - 3} more" if len(numbers) > 3 else ""
        notes.append(f"{'; '.join(numbers[:3])}{more}: {remark}.")
    return notes
