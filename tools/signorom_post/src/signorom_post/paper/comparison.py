# SPDX-License-Identifier: BSD-3-Clause
"""A number of the paper next to ours, what is allowed, and the table of all of them."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from signorom_post.arrays import format_number

COLUMNS = ("where", "quantity", "paper", "ours", "allowed", "verdict", "ours, cut")
WITHIN, OUTSIDE, OUTSIDE_NOT_ROBUST, ABSENT = "within", "OUTSIDE", "outside, not robust", "-"


def percent(value: float) -> str:
    """A share, two significant digits, as the paper prints errors: 2.5 %."""
    return f"{float(f'{100 * value:.2g}'):g} %" if math.isfinite(value) else str(value)


def count(value: float) -> str:
    """A whole number."""
    return f"{value:.0f}"


def number(value: float) -> str:
    """Two significant digits."""
    return format_number(float(f"{value:.2g}"))


@dataclass(frozen=True)
class Comparison:
    """One number."""

    #: figure or table of the paper
    where: str
    quantity: str
    #: None where the paper has a picture
    paper: float | None
    ours: float
    show: Callable[[float], str]
    #: range of ours that counts as agreement; None where none was agreed on
    allowed: tuple[float, float] | None = None
    #: False: depends on choices that the paper does not tell, so a difference means little
    is_robust: bool = True
    #: False: the number beside ours is not the paper's; the remark says whose
    is_published: bool = True
    #: the same with edges cut by the height; None where that was not run
    cut: float | None = None
    #: why ours differs, or how the number is meant
    remark: str = ""

    @property
    def verdict(self) -> str:
        """Whether ours lies in what is allowed."""
        if self.allowed is None:
            return ABSENT
        if self.allowed[0] <= self.ours <= self.allowed[1]:
            return WITHIN
        return OUTSIDE if self.is_robust else OUTSIDE_NOT_ROBUST

    def cells(self) -> list[str]:
        """Texts of the columns; with a star where a difference would mean little."""
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
    """The paper's number itself."""
    return value, value


def about(value: float, margin: float) -> tuple[float, float]:
    """The paper's number with a margin on both sides."""
    return value - margin, value + margin


def at_most(value: float, factor: float) -> tuple[float, float]:
    """Errors: anything up to so many times the paper's."""
    return 0.0, factor * value


def text_table(comparisons: Sequence[Comparison]) -> str:
    """For a terminal: columns under each other, then what the remarks say."""
    rows = [list(COLUMNS), *(comparison.cells() for comparison in comparisons)]
    widths = [max(len(row[i]) for row in rows) for i in range(len(COLUMNS))]
    lines = [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows
    ]
    return "\n".join([*lines, "", *_notes(comparisons)])


def markdown_table(comparisons: Sequence[Comparison]) -> str:
    """The same in Markdown."""
    rows = [list(COLUMNS), ["---"] * len(COLUMNS), *(comparison.cells() for comparison in comparisons)]
    lines = ["| " + " | ".join(cell.replace("*", "\\*") for cell in row) + " |" for row in rows]
    notes = [f"- {note}".replace("*", "\\*") for note in _notes(comparisons)]
    return "\n".join([*lines, "", *notes]) + "\n"


def rows_for_csv(comparisons: Sequence[Comparison]) -> list[dict[str, object]]:
    """The same with all digits."""
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
        notes.append("* depends on choices that the paper does not tell; a difference means little.")
    if not all(item.is_published for item in comparisons):
        notes.append("(...) is not a number of the paper; see the remark on it.")
    remarks: dict[str, list[str]] = {}
    for item in comparisons:
        if item.remark:
            remarks.setdefault(item.remark, []).append(f"{item.where}, {item.quantity}")
    for remark, numbers in remarks.items():
        more = f" and {len(numbers) - 3} more" if len(numbers) > 3 else ""
        notes.append(f"{'; '.join(numbers[:3])}{more}: {remark}.")
    return notes
