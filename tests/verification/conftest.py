# SPDX-License-Identifier: BSD-3-Clause
"""The program under test, where the helpers are, and the figures that tests write down."""

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


@pytest.fixture(scope="module", autouse=True)
def figures(request):
    """Where a test file writes what it compares with known answers."""
    from figures import figures_of

    return figures_of(request.path)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item):
    """A test that failed before it could write a figure has its row in the table too."""
    report = yield
    figures = getattr(item, "funcargs", {}).get("figures")
    if figures is not None:
        if report.failed and not figures.has_failed:
            from figures import Figure

            figures.write(Figure(item.path.stem, item.name, "", None, "", None, None, None, "", False))
        figures.has_failed = False
    return report
