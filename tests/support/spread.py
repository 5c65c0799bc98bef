# SPDX-License-Identifier: BSD-3-Clause
"""Which combinations of parameters the test suite runs, and which only `--all-points`."""

import itertools

import pytest


def spread(*lists):
    """Returns all combinations of the entries of several lists, for pytest.mark.parametrize.

    The suite runs a few in which each entry occurs: the i-th entries of all lists, where shorter lists start again.
    The others are marked long.
    """
    longest = max(map(len, lists))
    few = {tuple(i % len(entries) for entries in lists) for i in range(longest)}
    found = []
    for numbers in itertools.product(*(range(len(entries)) for entries in lists)):
        values = tuple(entries[i] for entries, i in zip(lists, numbers, strict=True))
        found.append(pytest.param(*values, marks=[] if numbers in few else pytest.mark.long))
    return found
