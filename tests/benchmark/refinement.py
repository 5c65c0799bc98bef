#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Case b with more clusters, with more snapshots where the model errs, with more on the grid: what each of them gains.

    build/venv/bin/python tests/benchmark/refinement.py            # 1600 test points, 10 minutes
    build/venv/bin/python tests/benchmark/refinement.py --map 80   # the paper's map

Prints a row per way: clusters, snapshots, reduced unknowns of the smallest and the largest cluster, and the error (18)
on the reduced domain at a grid of test points that no model was chosen by: median, 95 % of the points, share above 10 %.
"""

import tempfile
from pathlib import Path

import h5py
import numpy as np
from timing import INPUT, build, command_line, copy_deck, cpu_of, read_table

NAME = "pellet_cladding_clusters"
CANDIDATES = "candidates: {sobol: 512, seed: 1}"
# out of reach, so that all is tried
ALL = f"target: {{error: 1.0e-3, measure: e_lambda_rid, {CANDIDATES}}}"
PAPER, FINER, COARSER = "{P1: 10, h1: 50}", "{P1: 12, h1: 50}", "{P1: 8, h1: 25}"
MORE = "refine: {max_points: 100, points_per_round: 10}"
WAYS = {
    "one model": ("number: 1", PAPER),
    "three clusters (paper)": ("number: 3", PAPER),
    "best of 1 to 8 clusters": (f"number: auto, max_number: 8, {ALL}", PAPER),
    "one, split up to 6 times": (f"number: 1, max_number: 6, {ALL}, refine: {{max_points: 0}}", PAPER),
    "three, 100 snapshots added": (f"number: 3, max_number: 3, {ALL}, {MORE}", PAPER),
    "three, 100 added, split up to 6": (f"number: 3, max_number: 6, {ALL}, {MORE}", PAPER),
    "one, 100 added, split up to 6": (f"number: 1, max_number: 6, {ALL}, {MORE}", PAPER),
    "three, 600 on a finer grid": ("number: 3", FINER),
    "three, 200 on a coarser grid": ("number: 3", COARSER),
}


def run(program, folder, clusters, grid, n_map):
    """Errors at the test points, number of snapshots, reduced unknowns of each cluster."""
    folder.mkdir()
    deck = copy_deck(
        INPUT / f"{NAME}.yaml",
        folder,
        **{
            "clusters: {number: 3, method: regular}": f"clusters: {{{clusters}}}",
            "training: {grid: {P1: 10, h1: 50}}": f"training: {{grid: {grid}}}",
            "test: {grid: {P1: 80, h1: 80}}": f"test: {{grid: {{P1: {n_map}, h1: {n_map}}}}}",
        },
    )
    for command in ("sample", "train", "validate"):
        cpu_of([program, command, deck], folder)
    results = folder / "results" / NAME
    errors = read_table(results / "validation.csv")["e_lambda_rid"]
    with h5py.File(results / "model.h5") as model:
        n_snapshots = len(model["parameters/training_points"])
        sizes = [len(cluster["basis"]) for cluster in model["clusters"].values()]
    return errors[~np.isnan(errors)], n_snapshots, sizes


def main():
    """Runs all ways and prints their rows."""
    parser = command_line(__doc__)
    parser.add_argument("--map", type=int, default=40, help="test points per parameter")
    parser.add_argument("--ways", nargs="+", choices=[*WAYS], default=[*WAYS])
    options = parser.parse_args()
    (program,) = build("signorom")
    print("| clusters | how many | snapshots | l̄ | median % | 95 % of the points % | above 10 % % |")
    print("|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for i, name in enumerate(options.ways):
            errors, n_snapshots, sizes = run(program, Path(folder) / str(i), *WAYS[name], options.map)
            print(
                f"| {name} | {len(sizes)} | {n_snapshots} | {min(sizes)} to {max(sizes)} "
                f"| {100 * np.median(errors):.2f} | {100 * np.percentile(errors, 95):.1f} "
                f"| {100 * np.mean(errors > 0.1):.1f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
