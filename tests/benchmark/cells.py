#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Clusters of the cells of a regular grid, of the 500 snapshots of case b: CPU time of each step.

build/venv/bin/python tests/benchmark/cells.py [--ranks 2] [--grid 10 50]
"""

import tempfile
from pathlib import Path

from timing import INPUT, build, command_line, copy_deck, cpu_of, launcher, load_text, measure

NAME = "pellet_cladding_whole_edges"
N_CLUSTERS, POD_TOLERANCE = 3, 1e-6


def main():
    """Sample, then time the clusters."""
    parser = command_line(__doc__)
    parser.add_argument("--ranks", type=int, default=2)
    parser.add_argument("--grid", nargs=2, type=int, default=[10, 50], help="snapshots along each parameter")
    options = parser.parse_args()
    program, driver = build("signorom", "benchmark_cells")
    print(load_text())
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        grid = "P1: {}, h1: {}".format(*options.grid)
        cpu_of(
            [program, "sample", copy_deck(INPUT / f"{NAME}.yaml", folder, **{"P1: 10, h1: 50": grid})], folder
        )
        snapshots = folder / "results" / NAME / "snapshots.h5"
        command = [*launcher(options.ranks), driver, snapshots, N_CLUSTERS, POD_TOLERANCE, *options.grid]
        print(measure(command, folder).output, end="")


if __name__ == "__main__":
    main()
