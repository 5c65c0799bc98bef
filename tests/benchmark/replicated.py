# SPDX-License-Identifier: BSD-3-Clause
"""What every rank keeps for itself: largest memory of ranks beside the bytes that follow from the program's types.

`scaling.py --parts memory` prints the tables; input/CLUSTER.md says what they mean.
"""

import os
import tempfile
from pathlib import Path

import numpy as np
from blocks_3d import SIZES
from boxes import AT_ONE_POINT, deck_text, write_boxes
from timing import launcher, measure, waiting

N_RANKS = 2
INTEGER, REAL = 4, 8


def bytes_per_node():
    """Of a mesh of H8, which has as many cells as nodes: mesh_t, material, one region; driving; rigid motions."""
    cell = INTEGER * (1 + 1 + 1 + 8) + INTEGER
    node = 3 * REAL + INTEGER
    region = 2 * INTEGER
    is_prescribed = 3 * INTEGER
    motions = 3 * REAL + INTEGER
    return cell + node + region + is_prescribed + motions


def bytes_of_system():
    """Of what the solver of a group keeps of the whole mesh: numbering, supports, rigid motions."""
    numbering = INTEGER
    is_prescribed = 3 * INTEGER
    motions = 3 * REAL + INTEGER
    return numbering + is_prescribed + motions


def peaks_of(program, command, counts, n_ranks=N_RANKS, *, solver="auto", n_points=4, method="auto"):
    """Largest memory of each rank [bytes]; numbers of nodes and pairs of two boxes."""
    rest = f"training: {{grid: {{P: {n_points}}}}}\nreduction: {{method: {method}}}"
    if command == "solve":
        rest = AT_ONE_POINT
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        n_nodes = write_boxes(folder / "boxes.msh", "H8", counts)
        (folder / "boxes.yaml").write_text(deck_text("H8", solver=f"type: {solver}", rest=rest))
        done = measure([*launcher(n_ranks), program, command, "boxes.yaml", "--quiet"], folder)
    return done.peaks, n_nodes, (counts[0] + 1) * (counts[1] + 1)


def print_mesh(program, sizes):
    """What `check` keeps of a mesh; the second rank reads no file. `sizes`: small and large, keys of SIZES."""
    small, large = (
        peaks_of(program, "check", [SIZES[size][0], SIZES[size][0], SIZES[size][1]]) for size in sizes
    )
    n_nodes = large[1] - small[1]
    slopes = [(of_large - of_small) / n_nodes for of_large, of_small in zip(large[0], small[0], strict=True)]
    print(f"mesh of H8: {bytes_per_node()} bytes per node by the types;")
    print(
        f"    check, most at a time: {slopes[0]:.0f} on the rank that reads, {slopes[1]:.0f} on the other one"
    )


def solve_slopes(program, sizes, n_ranks):
    """Bytes per node of `solve` with multigrid, on the first rank and, mean, on the others."""
    os.environ.update(waiting(n_ranks))
    small, large = (
        peaks_of(program, "solve", [SIZES[size][0], *SIZES[size]], n_ranks, solver="active_set, linear: gamg")
        for size in sizes
    )
    n_nodes = large[1] - small[1]
    slopes = (np.array(large[0]) - np.array(small[0])) / n_nodes
    return slopes[0], slopes[1:].mean() if n_ranks > 1 else slopes[0]


def print_solve(program, sizes, rank_counts):
    """What of a solution by multigrid ranks share, and what each keeps. `sizes`: small and large, keys of SIZES."""
    print(f"solve by multigrid, bytes per node; {bytes_of_system()} of the system on each rank by the types")
    print("    ranks  first rank  others, mean")
    others = {}
    for n_ranks in rank_counts:
        first, others[n_ranks] = solve_slopes(program, sizes, n_ranks)
        print(f"    {n_ranks:5d} {first:11.0f} {others[n_ranks]:13.0f}", flush=True)
    few, many = sorted(others)[-2:]
    kept = (many * others[many] - few * others[few]) / (many - few)
    print(f"    if the rest is shared equally, each of {few} and of {many} ranks keeps {kept:.0f}")


def print_condensed(program, sides):
    """W of two thin plates: a few dofs for each pair, so that W weighs. `sides`: cells along each."""
    print(
        "condensed contact: H = 8 bytes * dofs * pairs, shared by the ranks of a group; W = 8 bytes * pairs^2 on each"
    )
    print("    pairs   dofs ranks   H/ranks + 3 W  largest rank, without that of 100 pairs   [MB]")
    for n_ranks in (1, N_RANKS):
        base = max(peaks_of(program, "sample", [9, 9, 1], n_ranks, solver="condensed")[0])
        for side in sides:
            peaks, n_nodes, n_pairs = peaks_of(
                program, "sample", [side, side, 1], n_ranks, solver="condensed"
            )
            computed = REAL * (3 * n_nodes * n_pairs / n_ranks + 3 * n_pairs**2)
            print(
                f"    {n_pairs:5d} {3 * n_nodes:6d} {n_ranks:5d} {computed / 1e6:15.0f} "
                f"{(max(peaks) - base) / 1e6:13.0f}",
                flush=True,
            )


def print_snapshots(program, few, many):
    """The first rank gathers all displacements when the sampling ends. `few`, `many`: numbers of snapshots."""
    (small, n_nodes, _), (large, _, _) = (
        peaks_of(program, "sample", [18, 18, 2], solver="condensed", method="hhr", n_points=n)
        for n in (few, many)
    )
    n_bytes = REAL * 3 * n_nodes * (many - few)
    growth = [(of_large - of_small) / n_bytes for of_large, of_small in zip(large, small, strict=True)]
    print(f"snapshots: bytes of memory per byte of displacements, {n_bytes / 1e6:.0f} MB of them")
    print(f"    sample: {growth[0]:.2f} on the first rank, {growth[1]:.2f} on the other one")


def print_tables(program, is_small=False):
    """All of them; `is_small`: quickly, to see that they work."""
    print_mesh(program, (1, 13) if is_small else (54, 1000))
    print_solve(program, *(((1, 13), (1, 2)) if is_small else ((13, 54), (1, 2, 4))))
    print_condensed(program, (5,) if is_small else (29, 41))
    print_snapshots(program, *((10, 20) if is_small else (1000, 2000)))
