# SPDX-License-Identifier: BSD-3-Clause
"""Warnings of answers."""

import warnings

import pytest

from signorom_post import InaccurateFieldsWarning
from signorom_post.points import warn_inaccurate


def test_large_errors_of_displacements_are_said() -> None:
    """The limit is 1 %; an unknown error is not large."""
    with pytest.warns(InaccurateFieldsWarning, match="may be 0.2 in the norm of the stiffness"):
        warn_inaccurate(0.2)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warn_inaccurate(0.01)
        warn_inaccurate(None)
