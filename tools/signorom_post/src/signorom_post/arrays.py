# SPDX-License-Identifier: BSD-3-Clause
"""Array types of the annotations, and values with their unit."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]
TextArray = NDArray[np.str_]


@dataclass(frozen=True)
class Quantity:
    """An array, its unit (empty where it has none) and what it is."""

    values: FloatArray
    unit: str = ""
    description: str = ""


def as_number(value: Any) -> float | None:
    """The number in a YAML value, or None; YAML 1.1 takes `1e8` and `1.0e8` for text, we do not."""
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
    """Four significant digits, without trailing zeros: 0.2, 3.217, 1.08e-05."""
    return f"{value:.4g}" if math.isfinite(value) else str(value)


def power_of_ten(value: float) -> str:
    """A positive number in mathtext, such as 10^{-8} or 2.5 x 10^{-8}."""
    mantissa, exponent = f"{value:.1e}".split("e")
    power = f"10^{{{int(exponent)}}}"
    return f"${power}$" if mantissa == "1.0" else rf"${mantissa}\times{power}$"


def with_unit(text: str, unit: str) -> str:
    """A label for an axis: `x [m]`, or the bare text where the quantity has no unit."""
    return f"{text} [{unit}]" if unit not in ("", "-", "1") else text
