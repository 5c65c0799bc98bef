# SPDX-License-Identifier: BSD-3-Clause
"""Conversions of arguments of the command line."""

import argparse
from collections.abc import Callable


def at_least(least: int) -> Callable[[str], int]:
    """Returns a function that converts a text to a whole number of at least `least`, for argparse.

    It raises ArgumentTypeError if the text has other characters than digits, also a sign, or if the number is smaller.
    """

    def convert(text: str) -> int:
        if not text.isdecimal() or int(text) < least:
            raise argparse.ArgumentTypeError(f"'{text}' is not a whole number of at least {least}")
        return int(text)

    return convert
