#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""What ranks, groups and threads gain on two cores, and what every rank keeps for itself.

    build/venv/bin/python tests/benchmark/scaling.py
    build/venv/bin/python tests/benchmark/scaling.py --parts space threads

space: one problem in space, solved by multigrid on one rank and on two. groups: `groups.py`. threads: `predict` at many
points on one thread and on two. memory: bytes that grow on every rank, beside what the types of the program make of
them. Ratios are those of one run; wall and CPU times in seconds, memory in MB.
"""

import tempfile
from pathlib import Path

import blocks_3d
import groups
import numpy as np
import replicated
from timing import INPUT, build, command_line, copy_deck, load_text, measure, train, write_points

SEED = 1495
MODEL, GRID = "pellet_cladding", "P1: 10, h1: 50"


def print_space(program, options):
    """A line per size and number of ranks; ratios to one rank."""
    print("One problem in space, active_set with multigrid")
    print("    dofs ranks   wall  ratio    CPU  ratio   MB of the largest rank  ratio  load")
    for size in options.sizes:
        reference = None
        for n_ranks in (1, 2):
            with tempfile.TemporaryDirectory() as folder:
                report, done = blocks_3d.run(program, Path(folder), size, n_ranks)
            found = np.array([done.wall, done.cpu, max(done.peaks) / 1e6])
            reference = found if reference is None else reference
            ratios = reference / found
            print(
                f"{report['sizes']['n_dofs']:8d} {n_ranks:5d} {found[0]:6.1f} {ratios[0]:6.2f} {found[1]:6.1f} "
                f"{ratios[1]:6.2f} {found[2]:24.0f} {ratios[2]:6.2f}  {load_text()}",
                flush=True,
            )


def print_threads(program, options):
    """A line per number of threads; the quickest of several runs."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        copy_deck(INPUT / f"{MODEL}.yaml", folder, **({GRID: "P1: 10, h1: 10"} if options.small else {}))
        _, model = train(program, folder, MODEL)
        points = np.random.default_rng(SEED).uniform((5.0, 0.6), (200.0, 6.0), (options.points, 2))
        write_points(folder / "points.csv", ("P1", "h1"), points)
        command = [program, "predict", model, "--points", "points.csv", "--output", "out.csv"]
        print(f"predict of case b at {options.points} points")
        print("    threads   wall  ratio    CPU  ratio   load")
        reference = None
        for n_threads in (1, 2):
            runs = [measure([*command, "--threads", n_threads], folder) for _ in range(options.repeats)]
            cpu, wall = min(run.cpu for run in runs), min(run.wall for run in runs)
            reference = reference or (wall, cpu)
            print(
                f"    {n_threads:7d} {wall:6.2f} {reference[0] / wall:6.2f} {cpu:6.2f} {reference[1] / cpu:6.2f}   "
                f"{load_text()}",
                flush=True,
            )


def print_groups(program, options):
    """The tables of groups.py."""
    groups.print_cases(program, options.repeats, options.small)


def print_memory(program, options):
    """The tables of replicated.py."""
    replicated.print_tables(program, options.small)


PARTS = {"space": print_space, "groups": print_groups, "threads": print_threads, "memory": print_memory}


def main():
    """The chosen parts, one after the other."""
    parser = command_line(__doc__)
    parser.add_argument("--parts", nargs="+", choices=[*PARTS], default=[*PARTS])
    parser.add_argument("--sizes", nargs="+", type=int, default=[54, 195], help="thousand dofs, of space")
    parser.add_argument("--points", type=int, default=50_000, help="of threads")
    parser.add_argument("--repeats", type=int, default=3, help="of groups and threads")
    parser.add_argument("--small", action="store_true", help="all but space quickly, to see that it works")
    options = parser.parse_args()
    (program,) = build("signorom")
    print(load_text())
    for part in options.parts:
        PARTS[part](program, options)


if __name__ == "__main__":
    main()
