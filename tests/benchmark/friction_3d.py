#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A history with friction in space where the dense matrix has no room: active_set, with friction and without.

    build/venv/bin/python tests/benchmark/friction_3d.py            # 54 and 195 thousand dofs
    build/venv/bin/python tests/benchmark/friction_3d.py 1 13 --linear cholesky --condensed

The boxes of boxes.py, pressed in 4 times, then pushed along and back in 12. CPU is user time of all ranks per time after
the first one; steps and iterations are those of the linear systems, per time.
"""

import tempfile
from pathlib import Path

import numpy as np
import yaml
from blocks_3d import SIZES
from boxes import write_boxes
from timing import build, command_line, launcher, load_text, measure, read_table, tell_target

FRICTION = 0.3
# [-] time of a step with friction over one without
LARGEST_RATIO = 3.0
PRESSED, PUSHED = 4, 12


def deck_text(friction, solver, n_times=None):
    """The deck of the boxes in `boxes.msh`; of all times, or only of the first ones."""
    law = f", friction: {friction}" if friction else ""
    steps = f"{{until: 1, increments: {PRESSED}}}, {{until: 3, increments: {PUSHED}}}"
    if n_times:
        steps = f"{{until: {n_times / PRESSED}, increments: {n_times}}}"
    return f"""\
title: Two boxes with friction, benchmark
units: {{time: s}}
mesh: {{file: boxes.msh, model: solid}}
parameters: {{P: {{min: 0.5e6, max: 2.0e6, unit: Pa}}}}
history:
  tables:
    press: {{time: [0, 1, 3], value: [0, 1, 1]}}
    slide: {{time: [0, 1, 2, 3], value: [0, 0, 4.0e-6, -1.0e-6]}}
  steps: [{steps}]
materials:
  steel: {{regions: [lower, upper], young_modulus: 210.0e9, poisson_ratio: 0.3}}
boundary_conditions:
  - {{boundary: bottom, displacement: {{x: 0, y: 0, z: 0}}}}
  - {{boundary: top, displacement: {{x: slide, y: 0}}}}
loads:
  - {{boundary: top, pressure: P * press}}
contact:
  - {{first: lower_face, second: upper_face, direction: [0, 0, 1], initial_gap: "6.0e-6 * (x^2 + y^2)"{law}}}
solver: {{{solver}}}
output: {{points: [{{P: 1.0e6}}], fields: [displacement]}}
"""


def run(program, folder, n_ranks, text):
    """Solve a deck; its report, its table, and the user time [s]."""
    (folder / "boxes.yaml").write_text(text)
    done = measure([*launcher(n_ranks), program, "solve", "boxes.yaml", "--quiet"], folder)
    results = folder / "results" / "boxes"
    return (
        yaml.safe_load((results / "report.yaml").read_text()),
        read_table(results / "history.csv"),
        done.user,
    )


def forces_of(table):
    """Normal and tangential forces at all times."""
    return np.array([table[name] for name in table if name.startswith(("lambda_", "tau_"))])


def measure_history(program, folder, n_ranks, friction, solver):
    """CPU time per time, report, table."""
    report, table, user = run(program, folder, n_ranks, deck_text(friction, solver))
    _, _, first = run(program, folder, n_ranks, deck_text(friction, solver, 1))
    return (user - first) / (PRESSED + PUSHED - 1), report, table


def main():
    """A line per size."""
    parser = command_line(__doc__)
    parser.add_argument("sizes", nargs="*", type=int, default=[54, 195], help=f"thousand dofs: {[*SIZES]}")
    parser.add_argument("--ranks", type=int, default=1)
    parser.add_argument("--linear", default="gamg")
    parser.add_argument("--condensed", action="store_true", help="compare with the condensed solver")
    options = parser.parse_args()
    (program,) = build("signorom")
    solver = f"type: active_set, linear: {options.linear}"
    print(f"active_set, {options.linear}, {options.ranks} ranks; {load_text()}")
    print("    dofs   rows | friction: steps iterations CPU [s] | without: steps iterations CPU [s] | ratio")
    ratios = []
    for size in options.sizes:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            side, high = SIZES[size]
            write_boxes(folder / "boxes.msh", "H8", [side, side, high])
            words, times = [], []
            for friction in (FRICTION, 0):
                seconds, report, table = measure_history(program, folder, options.ranks, friction, solver)
                points = report["points"].values()
                means = [np.mean([p[key] for p in points]) for key in ("iterations", "linear_iterations")]
                words.append(f"{means[0]:5.1f} {means[1]:10.1f} {seconds:7.2f}")
                times.append(seconds)
                if friction:
                    sizes, found = report["sizes"], forces_of(table)
            ratios.append(times[0] / times[1])
            print(
                f"{sizes['n_dofs']:8d} {sizes['n_multipliers']:6d} |           {words[0]} |          {words[1]} | "
                f"{ratios[-1]:5.2f}",
                flush=True,
            )
            if options.condensed:
                text = deck_text(FRICTION, "type: condensed")
                expected = forces_of(run(program, folder, options.ranks, text)[1])
                difference = np.abs(found - expected).max() / np.abs(expected).max()
                print(f"difference from condensed: {difference:.1e}")
    tell_target(
        f"a time with friction takes at most {LARGEST_RATIO:.0f} times one without",
        max(ratios) <= LARGEST_RATIO,
    )


if __name__ == "__main__":
    main()
