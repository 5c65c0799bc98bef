# SPDX-License-Identifier: BSD-3-Clause
"""Which tests run: `--all-points` adds those that take long, and asks others at more points."""


def pytest_addoption(parser):
    """Adds the option --all-points."""
    parser.addoption(
        "--all-points", action="store_true", help="run the tests marked long, and ask others at all points"
    )


def pytest_collection_modifyitems(config, items):
    """Without --all-points, leaves out the tests marked long; other tests of the same file test the same code."""
    if config.getoption("--all-points"):
        return
    left_out = [item for item in items if item.get_closest_marker("long")]
    if left_out:
        config.hook.pytest_deselected(items=left_out)
        items[:] = [item for item in items if item not in left_out]
