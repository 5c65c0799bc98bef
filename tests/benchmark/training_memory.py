#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Memory of `train` on 1, 2 and 4 ranks: 1000 snapshots of two blocks with 13 824 dofs, 256 contacts and two parameters.

build/venv/bin/python tests/benchmark/training_memory.py [--ranks 1 2 4] [--models hhr fallback clusters modes]

Largest resident memory of each rank, their sum, and the sum with 16 snapshots. Ends with 1 where the sum is more than
2.5 bytes per byte of the snapshots and 200 MB per rank.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from blocks_3d import BODIES, ENVIRONMENT, ROOT, launcher, peak_memory, write_mesh

N_SIDE, N_HIGH = 16, 9
N_DOFS = 3 * 2 * N_SIDE**2 * N_HIGH
GRIDS = {"many": (40, 25), "few": (4, 4)}
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
DECK = """\
title: Two blocks with a tilt, benchmark
mesh: {{file: blocks.msh, model: solid}}
parameters:
  P: {{min: 0.5e6, max: 2.0e6, unit: Pa}}
  tilt: {{min: 0, max: 4.0e-5}}
"""
DECK += BODIES.replace("GAP", '"2e-5 * (x^2 + y^2) + tilt * x"')
DECK += """\
solver: {{type: condensed}}
training: {{grid: {{P: {grid[0]}, tilt: {grid[1]}}}}}
output: {{directory: results_{name}}}
{model}
"""


def write_deck(folder, name, model):
    """A deck whose results stand in a folder of its number of snapshots."""
    path = folder / f"{name}_{model}.yaml"
    path.write_text(DECK.format(grid=GRIDS[name], name=name, model=MODELS[model]))
    return path.name


def run(program, folder, n_ranks, *arguments):
    """Largest resident memory of each rank [bytes], in their order."""
    command = [*launcher(n_ranks), str(program), *arguments, "--quiet"]
    peaks = {}
    environment = os.environ | ENVIRONMENT
    process = subprocess.Popen(command, cwd=folder, env=environment, stderr=subprocess.PIPE, text=True)
    while process.poll() is None:
        peak_memory(process, peaks)
        time.sleep(0.02)
    if process.returncode != 0:
        sys.exit(f"exit code {process.returncode}: {' '.join(command)}\n{process.stderr.read()}")
    return [1e9 * peaks[pid] for pid in sorted(peaks, key=int)]


def main():
    """A line per model and number of ranks."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--ranks", nargs="+", type=int, default=[1, 2, 4])
    parser.add_argument("--models", nargs="+", choices=[*MODELS], default=[*MODELS])
    parser.add_argument("--folder", type=Path, help="where the snapshots stay for another run")
    arguments = parser.parse_args()
    program = Path(os.environ.get("SIGNOROM_EXECUTABLE", ROOT / "build" / "release" / "signorom")).resolve()
    n_bytes = 8 * N_DOFS * GRIDS["many"][0] * GRIDS["many"][1]
    print(f"{N_DOFS} dofs, {n_bytes / 1e6:.0f} MB of snapshots")
    print("model     ranks  MB per rank           sum  with few  allowed")
    is_fine = True
    with tempfile.TemporaryDirectory() as name:
        folder = arguments.folder or Path(name)
        folder.mkdir(exist_ok=True)
        write_mesh(folder / "blocks.msh", N_SIDE, N_HIGH)
        for grid in GRIDS:
            run(program, folder, 1, "sample", write_deck(folder, grid, "hhr"))
        for model in arguments.models:
            for n_ranks in arguments.ranks:
                few = sum(run(program, folder, n_ranks, "train", write_deck(folder, "few", model)))
                many = run(program, folder, n_ranks, "train", write_deck(folder, "many", model))
                allowed = PER_BYTE * n_bytes + n_ranks * PER_PROCESS
                is_fine = is_fine and sum(many) <= allowed
                print(
                    f"{model:9s} {n_ranks:5d}  {' '.join(f'{peak / 1e6:.0f}' for peak in many):17s} "
                    f"{sum(many) / 1e6:7.0f} {few / 1e6:9.0f} {allowed / 1e6:8.0f}",
                    flush=True,
                )
    return 0 if is_fine else 1


if __name__ == "__main__":
    sys.exit(main())
