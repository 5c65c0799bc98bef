# SPDX-License-Identifier: BSD-3-Clause
"""Array types for annotations, values with their unit, and texts of numbers."""

import math
import re
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]
TextArray = NDArray[np.str_]

#: units of a number without a unit
NO_UNITS = ("", "-", "1")


@dataclass(frozen=True)
class Quantity:
    """An array, its unit (empty if it has none), and a description of the quantity."""

    values: FloatArray
    unit: str = ""
    description: str = ""


def as_number(value: Any) -> float | None:
    """Returns a YAML value as a number; None if it is true, false or no number.

    A text that Python's `float` converts counts as a number, for instance `1e8`, which is no number in YAML 1.1.
    """
    if isinstance(value, bool):
        return None
    if isinstance(value, int | float):
        return float(value)
    if isinstance(value, str):
        try:
            return float(value)
        except ValueError:
            return None
    return None


def format_number(value: float) -> str:
    """Returns a number with four significant digits and without trailing zeros: 0.2, 3.217, 1.08e-05; inf or nan."""
    return f"{value:.4g}" if math.isfinite(value) else str(value)


def power_of_ten(value: float) -> str:
    """Returns the text of a positive number with two digits in matplotlib's mathtext, dollar signs included.

    It shows 2.5 x 10^-8, or only 10^-8 if the digits are 1.0.
    """
    mantissa, exponent = f"{value:.1e}".split("e")
    power = f"10^{{{int(exponent)}}}"
    return f"${power}$" if mantissa == "1.0" else rf"${mantissa}\times{power}$"


def with_unit(text: str, unit: str) -> str:
    """Returns a label for an axis, such as `x [m]`, or only the text if the unit is empty, `-` or `1`."""
    return f"{text} [{unit}]" if unit not in NO_UNITS else text


def without_unit_one(text: str) -> str:
    """Returns a text of parameters without the unit 1: `nu = 0.3` for `nu = 0.3 1`."""
    return re.sub(r"(= [-+.\deE]+) 1(?=[,:;]|$)", r"\1", text)


def pressure_unit(force: str, length: str) -> str:
    """Returns the unit of a pressure: Pa or MPa, else such as kN/m²; empty without a unit of forces.

    `force` is the unit of a force or, in plane models, of a force per length, such as N/mm.
    """
    name = force.removesuffix(f"/{length}")
    known = {("N", "m"): "Pa", ("N", "mm"): "MPa"}
    return known.get((name, length), f"{name}/{length}²" if name else "")
