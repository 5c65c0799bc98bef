#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Sampling where points do not share all work: one group of two ranks against two groups of one rank.

    build/venv/bin/python tests/benchmark/groups.py

Case b with a modulus of the fuel that is a parameter, and the three-dimensional blocks with active_set. Wall time of the
sampling, without the start of the program: of each arrangement a run with few points is taken from one with many.
Arrangements take turns, the quickest of several counts. Wants two idle cores. Fails where two groups are less than 1.7
times as fast.
"""

import argparse
import sys
import tempfile
from pathlib import Path

from timing import ROOT, build, cpu_of, load_text

from program import launcher

LEAST_RATIO = 1.7
# name: ranks, groups
ARRANGEMENTS = {"1 rank": (1, 1), "1 group of 2 ranks": (2, 1), "2 groups of 1 rank": (2, 2)}
FEW, MANY = 8, 88


def case_b(n_points):
    """A modulus for each four points; the solver is what the program chooses."""
    text = (ROOT / "input" / "pellet_cladding.yaml").read_text()
    text = text.replace("parameters:\n", "parameters:\n  E: {min: 100.0e3, max: 200.0e3, unit: MPa}\n", 1)
    text = text.replace("young_modulus: 190.0e3", "young_modulus: E").replace("type: condensed", "type: auto")
    text = text.replace("test: {grid: {P1: 80, h1: 80}}\n", "")
    text = text.replace("{P1: 10, h1: 50}}", f"{{E: {n_points // 4}, P1: 2, h1: 2}}, groups: GROUPS}}")
    return text.replace(
        "  points: [{P1: 170, h1: 3.2}, {P1: 30, h1: 5.25}]", "  points: [{E: 190.0e3, P1: 170, h1: 3.2}]"
    )


def blocks(n_points):
    """A pressure and an edge for each point; the stiffness is the same, but active_set factors it in each step."""
    text = (ROOT / "input" / "blocks.yaml").read_text() + "solver: {type: active_set}\n"
    return text + f"training: {{grid: {{P: 2, edge: {n_points // 2}}}, groups: GROUPS}}\n"


def wall(program, deck_text, n_ranks, n_groups):
    """Of one sampling run."""
    with tempfile.TemporaryDirectory() as folder:
        deck = Path(folder) / "deck.yaml"
        deck.write_text(deck_text.replace("../meshes", str(ROOT / "meshes")).replace("GROUPS", str(n_groups)))
        return cpu_of([*launcher(n_ranks), program, "sample", deck], folder)[1]


def compare(program, text_of, n_repeats):
    """Seconds per point of each arrangement."""
    best = {}
    for _ in range(n_repeats):
        for name, (n_ranks, n_groups) in ARRANGEMENTS.items():
            for n in (FEW, MANY):
                seconds = wall(program, text_of(n), n_ranks, n_groups)
                best[name, n] = min(seconds, best.get((name, n), seconds))
    return {name: (best[name, MANY] - best[name, FEW]) / (MANY - FEW) for name in ARRANGEMENTS}


CASES = {"case b, a stiffness per 4 points": case_b, "blocks in three dimensions, active_set": blocks}


def print_cases(program, n_repeats):
    """Both tables; returns by how much two groups are faster than one, in each."""
    ratios = []
    for title, text_of in CASES.items():
        seconds = compare(program, text_of, n_repeats)
        reference = seconds["1 group of 2 ranks"]
        print(f"{title}; {load_text()}")
        for name, value in seconds.items():
            ratio = f"{reference / value:5.2f} times as fast as 1 group of 2"
            print(f"    {name:20} {1e3 * value:8.1f} ms per point, {ratio}", flush=True)
        ratios.append(reference / seconds["2 groups of 1 rank"])
    return ratios


def main():
    """Prints both tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--repeats", type=int, default=3)
    options = parser.parse_args()
    program = build("signorom")[0]
    sys.exit(min(print_cases(program, options.repeats)) < LEAST_RATIO)


if __name__ == "__main__":
    main()
