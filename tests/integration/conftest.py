# SPDX-License-Identifier: BSD-3-Clause
"""The program under test and where the helpers are."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))


@pytest.fixture(scope="session")
def signorom():
    """Callable that runs the program and insists on success; `.run` takes any exit code."""
    from program import find_program

    return find_program()
