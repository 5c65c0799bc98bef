# SPDX-License-Identifier: BSD-3-Clause
"""Conversions of arguments of the command line."""

import argparse
from collections.abc import Callable

import numpy as np

from signorom_post.arrays import FloatArray


def at_least(least: int) -> Callable[[str], int]:
    """Returns a function that converts a text to a whole number of at least `least`, for argparse.

    It raises ArgumentTypeError if the text has other characters than digits, also a sign, or if the number is smaller.
    """

    def convert(text: str) -> int:
        if not text.isdecimal() or int(text) < least:
            raise argparse.ArgumentTypeError(f"'{text}' is not a whole number of at least {least}")
        return int(text)

    return convert


def direction(text: str) -> FloatArray:
    """Converts a text such as `1,-2,1` to a direction, shape (3), for argparse.

    It raises ArgumentTypeError if the text is not three finite numbers, of which one at least is not zero.
    """
    try:
        values = np.array([float(word) for word in text.split(",")])
    except ValueError:
        values = np.empty(0)
    if values.shape != (3,) or not np.isfinite(values).all() or not values.any():
        raise argparse.ArgumentTypeError(
            f"'{text}' is not a direction; give three numbers, for instance 1,-2,1"
        )
    return values
