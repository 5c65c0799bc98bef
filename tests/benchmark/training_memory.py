#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Memory of `train` on 1, 2 and 4 ranks: 1000 snapshots of two blocks with 13 824 dofs, 256 contacts and two parameters.

build/venv/bin/python tests/benchmark/training_memory.py [--ranks 1 2 4] [--models hhr fallback clusters modes]

Largest resident memory of each rank, their sum, and the sum with 16 snapshots. Target:
2.5 bytes per byte of the snapshots and 200 MB per rank.
"""

import tempfile
from pathlib import Path

from boxes import deck_text, write_boxes
from timing import build, command_line, launcher, measure, tell_target

COUNTS = [15, 15, 8]
N_DOFS = 3 * 2 * 16**2 * 9
FEW = (4, 4)
REDUCTION = """\
reduction:
  method: hhr
  pod_tolerance: 1.0e-5
  zones_of_interest: [top, lower_face]
  enrichment: {type: greedy, max_hats: 10}
"""
ALONE = REDUCTION + "  max_full_order_size: 0\n"
MODELS = {
    "hhr": ALONE,
    "fallback": REDUCTION,
    "clusters": ALONE + "clusters: {number: 4, method: regular}",
    "modes": "reduction: {method: condensed, displacement: {boundaries: [top], elsewhere: modes}}",
}
# allowed: bytes for a byte of the snapshots, all ranks together, and for a process
PER_BYTE, PER_PROCESS = 2.5, 200e6
GAP = "2e-5 * (x^2 + y^2) + tilt * x"
TILT = ", tilt: {min: 0, max: 4.0e-5}"


def write_deck(folder, grid, model):
    """A deck whose results stand in a folder of its grid; its name."""
    name = "x".join(map(str, grid))
    rest = (
        f"training: {{grid: {{P: {grid[0]}, tilt: {grid[1]}}}}}\n"
        f"output: {{directory: results_{name}}}\n{MODELS[model]}"
    )
    path = folder / f"{name}_{model}.yaml"
    path.write_text(deck_text("H8", gap=GAP, solver="type: condensed", parameters=TILT, rest=rest))
    return path.name


def peaks_of(program, folder, n_ranks, *words):
    """Largest resident memory of each rank [bytes], in their order."""
    return measure([*launcher(n_ranks), program, *words, "--quiet"], folder).peaks


def main():
    """A line per model and number of ranks."""
    parser = command_line(__doc__)
    parser.add_argument("--ranks", nargs="+", type=int, default=[1, 2, 4])
    parser.add_argument("--models", nargs="+", choices=[*MODELS], default=[*MODELS])
    parser.add_argument("--grid", nargs=2, type=int, default=[40, 25], help="snapshots along each parameter")
    parser.add_argument("--folder", type=Path, help="where the snapshots stay for another run")
    options = parser.parse_args()
    (program,) = build("signorom")
    n_bytes = 8 * N_DOFS * options.grid[0] * options.grid[1]
    print(f"{N_DOFS} dofs, {n_bytes / 1e6:.0f} MB of snapshots")
    print("model     ranks  MB per rank           sum  with few  allowed")
    is_fine = True
    with tempfile.TemporaryDirectory() as name:
        folder = options.folder or Path(name)
        folder.mkdir(exist_ok=True)
        write_boxes(folder / "boxes.msh", "H8", COUNTS)
        for grid in (options.grid, FEW):
            peaks_of(program, folder, 1, "sample", write_deck(folder, grid, "hhr"))
        for model in options.models:
            for n_ranks in options.ranks:
                few, many = (
                    peaks_of(program, folder, n_ranks, "train", write_deck(folder, grid, model))
                    for grid in (FEW, options.grid)
                )
                allowed = PER_BYTE * n_bytes + n_ranks * PER_PROCESS
                is_fine = is_fine and sum(many) <= allowed
                print(
                    f"{model:9s} {n_ranks:5d}  {' '.join(f'{peak / 1e6:.0f}' for peak in many):17s} "
                    f"{sum(many) / 1e6:7.0f} {sum(few) / 1e6:9.0f} {allowed / 1e6:8.0f}",
                    flush=True,
                )
    tell_target(
        f"{PER_BYTE} bytes per byte of the snapshots and {PER_PROCESS / 1e6:.0f} MB per rank", is_fine
    )


if __name__ == "__main__":
    main()
