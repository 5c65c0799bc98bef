#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""All 1000 cases of tests/verification/test_random_loads.py by active_set too: about five minutes of one core.

build/venv/bin/python tests/benchmark/random_cases.py [number of cases]
"""

import sys
import tempfile
from pathlib import Path

import numpy as np
from timing import build, load_text

import random_loads
from program import Program

# [s] active_set takes minutes, on a busy machine hours
TIME_LIMIT = 36000


class PatientProgram(Program):
    """A program that may take its time."""

    def run(self, *arguments, folder, n_ranks=1, time_limit=TIME_LIMIT):
        """As Program.run."""
        return super().run(*arguments, folder=folder, n_ranks=n_ranks, time_limit=time_limit)


def main():
    """Prints what both solvers leave and how far they are apart."""
    program = PatientProgram(build("signorom")[0])
    cases = random_loads.draw_cases()[: int(sys.argv[1]) if len(sys.argv) > 1 else None]
    with tempfile.TemporaryDirectory() as folder:
        found = {
            solver: random_loads.sample(program, Path(folder) / solver, solver, cases)
            for solver in ("condensed", "active_set")
        }
    print(f"{len(cases)} random load cases, seed {random_loads.SEED}; {load_text()}")
    for solver, snapshots in found.items():
        residual = np.abs(snapshots["residuals"]).max()
        n_failed = (snapshots["reasons"] < 0).sum()
        print(
            f"{solver:12} {n_failed} failed, largest residual {residual:.1e}, "
            f"smallest lambda {snapshots['multipliers'].min()}"
        )
    is_same = np.all(
        (found["condensed"]["multipliers"] > 0) == (found["active_set"]["multipliers"] > 0), axis=1
    )
    difference = random_loads.largest_difference(found["active_set"], found["condensed"])
    print(f"same closed pairs in {is_same.sum()}, largest difference of u and lambda {difference:.1e}")
    sys.exit(difference > random_loads.SAME_SOLUTION or any((s["reasons"] < 0).any() for s in found.values()))


if __name__ == "__main__":
    main()
