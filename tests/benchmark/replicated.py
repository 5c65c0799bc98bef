# SPDX-License-Identifier: BSD-3-Clause
"""What every rank keeps for itself: largest memory of two ranks beside the bytes that follow from the program's types.

`scaling.py --parts memory` prints the tables; input/CLUSTER.md says what they mean.
"""

import tempfile
from pathlib import Path

import blocks_3d
from training_memory import run

N_RANKS = 2
INTEGER, REAL = 4, 8
DECK = (
    blocks_3d.DECK
    + "training: {{grid: {{P: {n_points}}}, groups: {n_groups}}}\nreduction: {{method: {method}}}\n"
)


def bytes_per_node():
    """Of a mesh of H8, which has as many cells as nodes: mesh_t, material, one region; driving; rigid motions."""
    cell = INTEGER * (1 + 1 + 1 + 8) + INTEGER
    node = 3 * REAL + INTEGER
    region = 2 * INTEGER
    is_prescribed = 3 * INTEGER
    motions = 3 * REAL + INTEGER
    return cell + node + region + is_prescribed + motions


def peaks_of(program, command, sizes, n_ranks=N_RANKS, **changed):
    """Largest memory of each rank [bytes]; numbers of nodes and pairs of two blocks."""
    keys = {"solver": "auto", "linear": "auto", "n_points": 4, "n_groups": 1, "method": "auto"}
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        n_nodes, n_pairs = blocks_3d.write_mesh(folder / "blocks.msh", *sizes)
        (folder / "blocks.yaml").write_text(DECK.format(**(keys | changed)))
        return run(program, folder, n_ranks, command, "blocks.yaml"), n_nodes, n_pairs


def print_mesh(program):
    """What `check` keeps of a mesh; the second rank reads no file."""
    small, large = (peaks_of(program, "check", blocks_3d.SIZES[size]) for size in (54, 1000))
    n_nodes = large[1] - small[1]
    slopes = [(of_large - of_small) / n_nodes for of_large, of_small in zip(large[0], small[0], strict=True)]
    print(f"mesh of H8: {bytes_per_node()} bytes per node by the types;")
    print(
        f"    check, most at a time: {slopes[0]:.0f} on the rank that reads, {slopes[1]:.0f} on the other one"
    )


def print_condensed(program):
    """W of two thin plates: a few dofs for each pair, so that W weighs."""
    print(
        "condensed contact: H = 8 bytes * dofs * pairs, shared by the ranks of a group; W = 8 bytes * pairs^2 on each"
    )
    print("    pairs   dofs ranks   H/ranks + 3 W  largest rank, without that of 100 pairs   [MB]")
    for n_ranks in (1, N_RANKS):
        base = max(peaks_of(program, "sample", (10, 2), n_ranks, solver="condensed")[0])
        for n_side in (30, 42):
            peaks, n_nodes, n_pairs = peaks_of(program, "sample", (n_side, 2), n_ranks, solver="condensed")
            computed = REAL * (3 * n_nodes * n_pairs / n_ranks + 3 * n_pairs**2)
            print(
                f"    {n_pairs:5d} {3 * n_nodes:6d} {n_ranks:5d} {computed / 1e6:15.0f} "
                f"{(max(peaks) - base) / 1e6:13.0f}",
                flush=True,
            )


def print_snapshots(program):
    """The first rank gathers all displacements when the sampling ends."""
    few, many = 1000, 2000
    sizes = (19, 3)
    keys = {"solver": "condensed", "method": "hhr"}
    small, large = (peaks_of(program, "sample", sizes, n_points=n, **keys)[0] for n in (few, many))
    n_bytes = REAL * 3 * 2 * sizes[0] ** 2 * sizes[1] * (many - few)
    growth = [(of_large - of_small) / n_bytes for of_large, of_small in zip(large, small, strict=True)]
    print(f"snapshots: bytes of memory per byte of displacements, {n_bytes / 1e6:.0f} MB of them")
    print(f"    sample: {growth[0]:.2f} on the first rank, {growth[1]:.2f} on the other one")


def print_tables(program):
    """All of them."""
    print_mesh(program)
    print_condensed(program)
    print_snapshots(program)
