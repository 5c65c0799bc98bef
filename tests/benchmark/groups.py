# SPDX-License-Identifier: BSD-3-Clause
"""Sampling where points do not share all work: one group of two ranks against two groups of one rank.

`scaling.py --parts groups` prints the tables. Case b with a modulus of the fuel that is a parameter, and the
three-dimensional blocks with active_set. Wall time of the sampling, without the start of the program: of each
arrangement a run with few points is taken from one with many. Arrangements take turns, the quickest of several counts.
Target: two groups are 1.7 times as fast.
"""

import tempfile
from pathlib import Path

from timing import INPUT, ROOT, launcher, load_text, measure, tell_target

LEAST_RATIO = 1.7
# name: ranks, groups; the others are compared with the first one
ARRANGEMENTS = {"1 group of 2 ranks": (2, 1), "1 rank": (1, 1), "2 groups of 1 rank": (2, 2)}
#: numbers of points, multiples of four
FEW, MANY = 8, 88


def case_b(n_points):
    """A modulus for each four points; the solver is what the program chooses."""
    text = (INPUT / "pellet_cladding.yaml").read_text()
    text = text.replace("parameters:\n", "parameters:\n  E: {min: 100.0e3, max: 200.0e3, unit: MPa}\n", 1)
    text = text.replace("young_modulus: 190.0e3", "young_modulus: E").replace("type: condensed", "type: auto")
    text = text.replace("test: {grid: {P1: 80, h1: 80}}\n", "")
    text = text.replace("{P1: 10, h1: 50}}", f"{{E: {n_points // 4}, P1: 2, h1: 2}}, groups: GROUPS}}")
    return text.replace(
        "  points: [{P1: 170, h1: 3.2}, {P1: 30, h1: 5.25}]", "  points: [{E: 190.0e3, P1: 170, h1: 3.2}]"
    )


def blocks(n_points):
    """A pressure and an edge for each point; the stiffness is the same, but active_set factors it in each step."""
    text = (INPUT / "blocks.yaml").read_text() + "solver: {type: active_set}\n"
    return text + f"training: {{grid: {{P: 2, edge: {n_points // 2}}}, groups: GROUPS}}\n"


def wall(program, deck_text, n_ranks, n_groups):
    """Of one sampling run."""
    with tempfile.TemporaryDirectory() as folder:
        deck = Path(folder) / "deck.yaml"
        deck.write_text(deck_text.replace("../meshes", str(ROOT / "meshes")).replace("GROUPS", str(n_groups)))
        return measure([*launcher(n_ranks), program, "sample", deck], folder).wall


def compare(program, text_of, n_repeats, many, names):
    """Seconds per point of each arrangement."""
    best = {}
    for _ in range(n_repeats):
        for name in names:
            n_ranks, n_groups = ARRANGEMENTS[name]
            for n in (FEW, many):
                seconds = wall(program, text_of(n), n_ranks, n_groups)
                best[name, n] = min(seconds, best.get((name, n), seconds))
    return {name: (best[name, many] - best[name, FEW]) / (many - FEW) for name in names}


CASES = {"case b, a stiffness per 4 points": case_b, "blocks in three dimensions, active_set": blocks}


def print_cases(program, n_repeats, is_small=False):
    """Both tables; `is_small`: quickly, to see that they work."""
    ratios, many, names = [], MANY, [*ARRANGEMENTS]
    if is_small:
        many, names = FEW + 4, names[1:]
    for title, text_of in CASES.items():
        seconds = compare(program, text_of, n_repeats, many, names)
        reference = seconds[names[0]]
        print(f"{title}; {load_text()}")
        for name, value in seconds.items():
            ratio = f"{reference / value:5.2f} times as fast as {names[0]}"
            print(f"    {name:20} {1e3 * value:8.1f} ms per point, {ratio}", flush=True)
        ratios.append(reference / seconds["2 groups of 1 rank"])
    tell_target(f"two groups are {LEAST_RATIO} times as fast as {names[0]}", min(ratios) >= LEAST_RATIO)
