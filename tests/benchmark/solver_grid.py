#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""What the solver `auto` takes beside the best choice, over a grid of parts: time and memory of the whole command.

    build/venv/bin/python tests/benchmark/solver_grid.py                  # up to 70 thousand dofs
    build/venv/bin/python tests/benchmark/solver_grid.py --largest 300    # thousand dofs; takes hours
    build/venv/bin/python tests/benchmark/solver_grid.py --only T10 --largest 20

Two boxes of growing size, plane and solid, linear and quadratic, compact and thin, of equal stiffness and 1 : 1000, one
point and a hundred. Each solver that `auto` may take is tried, one after the other; times are user time of all ranks, so
that other work on the machine matters less. Target: `auto` takes at most 1.3 times the time of the best one.
"""

import math
import re
import sys
import tempfile
from pathlib import Path

from boxes import AT_ONE_POINT, deck_text, grid_counts, n_axes, write_boxes
from timing import build, command_line, launcher, load_text, measure, tell_target

SOLVERS = {
    "auto": "type: auto",
    "condensed": "type: condensed",
    "gamg": "type: active_set, linear: gamg",
    "cholesky": "type: active_set, linear: cholesky",
}
TARGET = 1.3
# element, height over width of a box, thousand dofs
PARTS = [
    ("T3", 0.5, (5, 40, 300)),
    ("T6", 0.5, (5, 40, 150, 300)),
    ("T6", 0.02, (40, 150)),
    ("Q8", 0.5, (40,)),
    ("T4", 0.5, (5, 20, 60)),
    ("H8", 0.5, (5, 20, 65, 200, 300)),
    ("H8", 2.0, (20, 65)),
    ("T10", 0.5, (5, 20, 65, 200)),
    ("T10", 0.05, (20, 65)),
    ("T10", 2.0, (20, 65)),
    ("H20", 0.5, (5, 20, 60)),
]
# Young's modulus of the upper box over that of the lower one, number of points
CASES = [(1.0, 1), (1.0, 100), (1e-3, 1)]


def run(program, folder, n_ranks, n_points):
    """User time of all ranks [s], memory of all ranks [MB], solver."""
    command = [*launcher(n_ranks), program, "solve" if n_points == 1 else "sample", "boxes.yaml"]
    done = measure(command, folder, may_fail=True)
    if done.code != 0:
        return float("inf"), float("nan"), "failed"
    chosen = re.search(r"solver: (\w+, \w+)", done.output)
    return done.user, done.megabytes, chosen.group(1) if chosen else "?"


def compare(program, part, case, n_ranks, solvers):
    """A line of the table; the ratio of `auto` to the best."""
    element, aspect, n_dofs = part
    ratio, n_points = case
    found = {}
    for name in solvers:
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place)
            counts = grid_counts(element, n_dofs, aspect)
            n_nodes = write_boxes(folder / "boxes.msh", element, counts, aspect)
            rest = AT_ONE_POINT if n_points == 1 else f"training: {{sobol: {n_points}}}"
            text = deck_text(element, aspect=aspect, ratio=ratio, solver=SOLVERS[name], rest=rest)
            (folder / "boxes.yaml").write_text(text)
            found[name] = run(program, folder, n_ranks, n_points)
    auto, chosen = found["auto"][0], found["auto"][2]
    ratio_of_best = auto / min(seconds for seconds, _, _ in found.values())
    times = " ".join(
        f"{name} {seconds:.1f} s {memory:.0f} MB;" for name, (seconds, memory, _) in found.items()
    )
    print(
        f"{element:3s} {n_axes(element) * n_nodes:7d} dofs, height {aspect:g}, moduli {ratio:g}, points {n_points:3d}, "
        f"ranks {n_ranks}: "
        f"{times} auto takes {chosen}: {ratio_of_best:.2f}",
        flush=True,
    )
    return ratio_of_best


def main():
    """All parts up to a size."""
    parser = command_line(__doc__)
    parser.add_argument("--largest", type=float, default=70, help="thousand dofs")
    parser.add_argument("--smallest", type=float, default=0, help="thousand dofs")
    parser.add_argument("--only", help="one element")
    parser.add_argument("--ranks", type=int, default=1)
    parser.add_argument("--points", type=int, help="only the cases with so many points")
    parser.add_argument(
        "--without", nargs="*", default=["cholesky"], choices=list(SOLVERS), help="solvers left out"
    )
    arguments = parser.parse_args()
    (program,) = build("signorom")
    print(load_text())
    solvers = [name for name in SOLVERS if name not in arguments.without]
    ratios = [
        compare(program, (element, aspect, 1e3 * size), case, arguments.ranks, solvers)
        for element, aspect, sizes in PARTS
        for size in sizes
        if arguments.smallest <= size <= arguments.largest and arguments.only in (None, element)
        for case in CASES
        if arguments.points in (None, case[1])
    ]
    if not all(math.isfinite(ratio) for ratio in ratios):
        sys.exit("`auto` failed on some part")
    print(f"auto over best: worst {max(ratios):.2f} of {len(ratios)}")
    tell_target(f"at most {TARGET} times the best", max(ratios) <= TARGET)


if __name__ == "__main__":
    main()
