# SPDX-License-Identifier: BSD-3-Clause
"""tools/walk.py on calls that were written by hand."""

import importlib.util

from program import ROOT

# main calls read_deck (line 10) and, behind a line without a file, solve (line 12); solve calls qsort of the system,
# and that calls compare of ours
TRACE = """\
version: 1
positions: line
events: Ir

fl=(1) /build/place/src/main.F90
fn=(1) main
8 3
cfi=(2) /build/place/src/deck/deck_read.f90
cfn=(2) read_deck
calls=1 20
+2 7
fi=(4) ???
cfn=(3) __sig_full_order_MOD_solve
calls=4 30
12 9

fl=(2)
fn=(2)
20 5

fl=(3) /build/place/src/full_order/full_order.F90
fn=(3)
30 2
cfi=(4)
cfn=(4) qsort
calls=1 0
+1 2

fl=(4)
fn=(4)
0 1
cfi=(5) /build/place/src/base/ties.f90
cfn=(5) compare
calls=8 40
* 1

fl=(5)
fn=(5)
40 1
"""


def test_a_trace_is_walked_in_the_order_of_the_source():
    """Five calls, of which the one through the system counts for its caller; a file of `base` is no stop."""
    place = ROOT / "tools" / "walk.py"
    spec = importlib.util.spec_from_file_location("walk", place)
    walk = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(walk)
    calls = walk.inside_source(walk.read_calls(TRACE.splitlines()))
    main = ("main.F90", "main")
    read, solve, compare = (
        ("deck/deck_read.f90", "read_deck"),
        ("full_order/full_order.F90", "__sig_full_order_MOD_solve"),
        ("base/ties.f90", "compare"),
    )
    assert {caller: found for caller, found in calls.items() if found} == {
        main: [read, solve],
        solve: [compare],
    }
    assert walk.walk(calls) == [main, read, solve, compare]
    assert [walk.is_stop(procedure, calls) for procedure in (main, read, solve, compare)] == [
        True,
        False,
        False,
        False,
    ]
