# SPDX-License-Identifier: BSD-3-Clause
"""The program under test and where the helpers are."""

import sys
from pathlib import Path

import pytest

HERE = Path(__file__).resolve().parent
TESTS = HERE.parent
sys.path[:0] = [str(HERE), str(TESTS / "support"), str(TESTS / "reference")]


@pytest.fixture(scope="session")
def signorom():
    """Callable that runs the program and insists on success."""
    from program import find_program

    return find_program()
