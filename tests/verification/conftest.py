# SPDX-License-Identifier: BSD-3-Clause
"""The program under test: SIGNOROM_EXECUTABLE, or build/ci/signorom."""

import os
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(HERE), str(ROOT / "tests" / "reference")]


@pytest.fixture(scope="session")
def signorom():
    """Callable that runs the program; a missing program is a failure, not a skip."""
    executable = Path(os.environ.get("SIGNOROM_EXECUTABLE", ROOT / "build" / "ci" / "signorom")).resolve()
    if not executable.is_file():
        pytest.fail(f"{executable} is missing: build it or set SIGNOROM_EXECUTABLE")
    from runs import Program

    return Program(executable)
