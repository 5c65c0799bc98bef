#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The sweep of case b (500 points, set-up, u and lambda stored) against factoring the saddle point in each step.

    build/venv/bin/python tests/benchmark/sweep.py              # a minute
    build/venv/bin/python tests/benchmark/sweep.py --points 50  # of the 500 for the slow methods, default 10

Prints CPU milliseconds per point on one core and what they are over those of the sweep, and the largest differences
between the methods. Fails above 1 ms per point, or where the saddle point is less than 300 times slower.
"""

import argparse
import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np
from timing import ROOT, build, cpu_of, load_text

DECK = ROOT / "input" / "pellet_cladding.yaml"
# [ms], and ratio
MOST_PER_POINT, LEAST_RATIO = 1.0, 300.0
# [-] of the largest displacement or multiplier
SAME_ANSWER = 1e-8


def copy_deck(folder, solver, training):
    """The deck with another solver and other training points."""
    text = DECK.read_text().replace("../meshes", str(ROOT / "meshes"))
    text = text.replace("type: condensed", f"type: {solver}")
    text = text.replace("training: {grid: {P1: 10, h1: 50}}", f"training: {training}")
    folder.mkdir(exist_ok=True)
    path = folder / "case_b.yaml"
    path.write_text(text)
    return path


def sweep(program, folder, n_repeats):
    """CPU and wall time of the quickest of several sweeps; the snapshots of the last one."""
    times = []
    for i in range(n_repeats):
        deck = copy_deck(folder / str(i), "condensed", "{grid: {P1: 10, h1: 50}}")
        times.append(cpu_of([program, "sample", deck], deck.parent)[:2])
    return np.min(times, axis=0), deck.parent / "results" / "case_b" / "snapshots.h5"


def active_set(program, folder, snapshots, chosen):
    """CPU time per point, without what one point takes before and after; answers compared with the sweep's."""
    with h5py.File(snapshots) as file:
        points = file["parameters"][()][chosen]
        expected = {name: file[name][()] for name in ("displacement", "multipliers")}
    times = []
    for n in (1, len(points)):
        deck = copy_deck(folder / f"active_{n}", "active_set", "{file: points.csv}")
        rows = [",".join(map(repr, map(float, point))) for point in points[:n]]
        (deck.parent / "points.csv").write_text("\n".join(["P1,h1", *rows, ""]))
        times.append(cpu_of([program, "sample", deck], deck.parent)[0])
    with h5py.File(deck.parent / "results" / "case_b" / "snapshots.h5") as file:
        worst = max(
            np.abs(file[name][()] - values[chosen]).max() / np.abs(values).max()
            for name, values in expected.items()
        )
    return (times[1] - times[0]) / (len(points) - 1), worst


def saddle_point(driver, deck, snapshots, n_points):
    """CPU time and steps per point, largest difference from the sweep."""
    printed = cpu_of([driver, deck, snapshots, str(n_points)], deck.parent)[2]
    rows = np.array([[float(word) for word in line.split()] for line in printed.splitlines()])
    return rows[:, 1].mean(), rows[:, 0].mean(), rows[:, 2:].max()


def main():
    """Runs all, prints the table, and says whether the targets are met."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--points", type=int, default=10, help="of the slow methods")
    parser.add_argument("--repeats", type=int, default=5, help="of the sweep; the quickest counts")
    options = parser.parse_args()
    program, driver = build("signorom", "benchmark_saddle_point")
    with tempfile.TemporaryDirectory() as name:
        (cpu, wall), snapshots = sweep(program, Path(name), options.repeats)
        chosen = np.round(np.linspace(0, 499, options.points)).astype(int)
        active, active_difference = active_set(program, Path(name), snapshots, chosen)
        deck = snapshots.parents[2] / "case_b.yaml"
        saddle, n_steps, saddle_difference = saddle_point(driver, deck, snapshots, options.points)
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
    failed = [
        f"{per_point:.2f} ms per point, above {MOST_PER_POINT}" if per_point > MOST_PER_POINT else "",
        f"the saddle point is less than {LEAST_RATIO:.0f} times slower"
        if 1e3 * saddle < LEAST_RATIO * per_point
        else "",
        "the answers differ" if max(saddle_difference, active_difference) > SAME_ANSWER else "",
    ]
    sys.exit("; ".join(filter(None, failed)) or None)


if __name__ == "__main__":
    main()
