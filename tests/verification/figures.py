# SPDX-License-Identifier: BSD-3-Clause
"""Figures that the tests compare with known answers: checked, and written down for `signorom-post verification`.

Each test file writes its rows anew in each run, to verification/<test file>.csv beside the program.
"""

import csv
from dataclasses import astuple, dataclass, fields
from pathlib import Path

import numpy as np

from program import find_program


@dataclass
class Figure:
    """One row of the table."""

    problem: str
    quantity: str
    unit: str
    #: known answer; None where only a limit is known
    reference: float | None
    #: where the known answer comes from
    source: str
    found: float | None
    #: found / reference - 1 (relative) or found - reference (absolute); None for limits
    difference: float | None
    allowed: float | None
    #: relative or absolute: largest difference; at_least or at_most: limit of what is found
    kind: str
    is_passed: bool


class Figures:
    """Rows of one test file."""

    def __init__(self, path):
        """File to write, anew."""
        self.path = Path(path)
        self.has_failed = False
        self.path.parent.mkdir(parents=True, exist_ok=True)
        with self.path.open("w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerow(field.name for field in fields(Figure))

    def compare(self, problem, quantity, found, reference, allowed, source, unit="", kind="relative"):
        """Insist on a difference from a known answer of at most `allowed`."""
        difference = found / reference - 1 if kind == "relative" else found - reference
        is_passed = abs(difference) <= allowed
        self._insist(
            Figure(problem, quantity, unit, reference, source, found, difference, allowed, kind, is_passed)
        )

    def at_most(self, problem, quantity, found, allowed, source, unit=""):
        """Insist on an upper limit."""
        self._insist(
            Figure(problem, quantity, unit, None, source, found, None, allowed, "at_most", found <= allowed)
        )

    def at_least(self, problem, quantity, found, allowed, source, unit="", reference=None):
        """Insist on a lower limit, that of an order of convergence for example."""
        is_passed = found >= allowed
        self._insist(
            Figure(problem, quantity, unit, reference, source, found, None, allowed, "at_least", is_passed)
        )

    def _insist(self, figure):
        self.write(figure)
        assert figure.is_passed, figure

    def write(self, figure):
        """Append a row; nothing for None."""
        self.has_failed = self.has_failed or not figure.is_passed
        row = ["" if value is None else value for value in astuple(figure)]
        with self.path.open("a", newline="", encoding="utf-8") as file:
            csv.writer(file).writerow(
                [value if isinstance(value, str) else format_cell(value) for value in row]
            )


def format_cell(value):
    """Yes or no, or a number with all its digits."""
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    return repr(float(value))


def figures_of(test_file):
    """Beside the program: one build, one table."""
    return Figures(find_program().executable.parent / "verification" / f"{Path(test_file).stem}.csv")
