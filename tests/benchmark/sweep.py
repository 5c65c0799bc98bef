#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The sweep of case b (500 points, set-up, u and lambda stored) against factoring the saddle point in each step.

    build/venv/bin/python tests/benchmark/sweep.py              # a minute
    build/venv/bin/python tests/benchmark/sweep.py --points 50  # of the 500 for the slow methods, default 10

Prints CPU milliseconds per point on one core and what they are over those of the sweep, and the largest differences
between the methods. Targets: 1 ms per point, and the saddle point takes 300 times as long.
"""

import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np
from timing import (
    INPUT,
    build,
    command_line,
    copy_deck,
    cpu_of,
    load_text,
    measure,
    tell_target,
    write_points,
)

NAME = "pellet_cladding"
GRID = "{grid: {P1: 10, h1: 50}}"
# [ms], and ratio
MOST_PER_POINT, LEAST_RATIO = 1.0, 300.0
# [-] of the largest displacement or multiplier
SAME_ANSWER = 1e-8


def write_deck(folder, solver="condensed", training=GRID):
    """The deck with another solver and other training points."""
    folder.mkdir(exist_ok=True)
    return copy_deck(INPUT / f"{NAME}.yaml", folder, **{"type: condensed": f"type: {solver}", GRID: training})


def snapshots_of(folder):
    """Where a run of the deck left them."""
    return folder / "results" / NAME / "snapshots.h5"


def sweep(program, folder, n_repeats):
    """CPU and wall time of the quickest of several sweeps; the deck of the last one."""
    runs = []
    for i in range(n_repeats):
        deck = write_deck(folder / str(i))
        runs.append(measure([program, "sample", deck], deck.parent))
    return min(run.cpu for run in runs), min(run.wall for run in runs), deck


def active_set(program, folder, snapshots, chosen):
    """CPU time per point, without what one point takes before and after; answers compared with the sweep's."""
    with h5py.File(snapshots) as file:
        points = file["parameters"][()][chosen]
        expected = {name: file[name][()] for name in ("displacement", "multipliers")}
    times = []
    for n in (1, len(points)):
        deck = write_deck(folder / f"active_{n}", "active_set", "{file: points.csv}")
        write_points(deck.parent / "points.csv", ("P1", "h1"), points[:n])
        times.append(cpu_of([program, "sample", deck], deck.parent))
    with h5py.File(snapshots_of(deck.parent)) as file:
        worst = max(
            np.abs(file[name][()] - values[chosen]).max() / np.abs(values).max()
            for name, values in expected.items()
        )
    return (times[1] - times[0]) / (len(points) - 1), worst


def saddle_point(driver, deck, n_points):
    """CPU time and steps per point, largest difference from the sweep."""
    printed = measure([driver, deck, snapshots_of(deck.parent), n_points], deck.parent).output
    rows = np.array([[float(word) for word in line.split()] for line in printed.splitlines()])
    return rows[:, 1].mean(), rows[:, 0].mean(), rows[:, 2:].max()


def main():
    """Runs all, prints the table, and says whether the targets are met."""
    parser = command_line(__doc__)
    parser.add_argument("--points", type=int, default=10, help="of the slow methods")
    parser.add_argument("--repeats", type=int, default=5, help="of the sweep; the quickest counts")
    options = parser.parse_args()
    program, driver = build("signorom", "benchmark_saddle_point")
    with tempfile.TemporaryDirectory() as name:
        cpu, wall, deck = sweep(program, Path(name), options.repeats)
        chosen = np.round(np.linspace(0, 499, options.points)).astype(int)
        active, active_difference = active_set(program, Path(name), snapshots_of(deck.parent), chosen)
        saddle, n_steps, saddle_difference = saddle_point(driver, deck, options.points)
    per_point = 1e3 * cpu / 500
    print(f"case b, CPU time per point on one core; {load_text()}")
    print(f"{'method':58} {'ms':>9} {'ratio':>7} {'difference':>11}")
    print(f"{'condensed, 500 points, set-up and files included':58} {per_point:9.3f} {1:7.0f}")
    print(f"{'    the same in wall time':58} {1e3 * wall / 500:9.3f}")
    for text, seconds, difference in (
        (f"saddle point factored in each of {n_steps:.1f} steps", saddle, saddle_difference),
        ("active_set", active, active_difference),
    ):
        print(f"{text:58} {1e3 * seconds:9.1f} {1e3 * seconds / per_point:7.0f} {difference:11.1e}")
    tell_target(f"at most {MOST_PER_POINT:.0f} ms per point", per_point <= MOST_PER_POINT)
    tell_target(
        f"the saddle point takes {LEAST_RATIO:.0f} times as long", 1e3 * saddle >= LEAST_RATIO * per_point
    )
    is_same = max(saddle_difference, active_difference) <= SAME_ANSWER
    sys.exit(None if is_same else "the answers differ")


if __name__ == "__main__":
    main()
