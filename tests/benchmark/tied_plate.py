#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A gasket plate with more than 7000 contact pairs, whose matrix of all contacts (420 MB) may not be formed.

build/venv/bin/python tests/benchmark/tied_plate.py
build/venv/bin/python tests/benchmark/tied_plate.py --nodes 30 --snapshots 20     # a small one

Two plates of hexahedra with equal meshes; the upper one is pressed down and tilted until one edge opens. Answers of the
condensed model against active_set at points between the training points, and the time of each.
"""

import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np
from boxes import make_plates, write_gmsh
from large_contact import error_text, predict, sample
from timing import build, command_line, load_text, train, write_points

SEED = 7225
# of that of the matrix of all contacts: 64 MB, the default, for 85 nodes along each side
ROOM = 0.153
NAMES = ["press", "tilt_x", "tilt_y"]
LOW, HIGH = np.array([0.024, 0.49, -0.01]), np.array([0.026, 0.51, 0.01])
DECK = """\
title: A gasket plate that opens along one edge
units: {{length: mm, force: N}}
mesh: {{file: plate.msh, model: solid}}
parameters:
  press: {{min: {low[0]}, max: {high[0]}, unit: mm}}
  tilt_x: {{min: {low[1]}, max: {high[1]}, unit: mm/m}}
  tilt_y: {{min: {low[2]}, max: {high[2]}, unit: mm/m}}
materials:
  steel: {{regions: [upper], young_modulus: 205.0e3, poisson_ratio: 0.29}}
  fiber: {{regions: [lower], young_modulus: 6.4e3, poisson_ratio: 0.24}}
boundary_conditions:
  - {{boundary: base, displacement: {{x: 0, y: 0, z: 0}}}}
  - {{boundary: top, displacement: {{x: 0, y: 0, z: "-press + 1e-3 * tilt_x * (x - 60) + 1e-3 * tilt_y * (y - 50)"}}}}
contact:
  - {{first: lower_face, second: upper_face, direction: [0, 0, 1]}}
training: {{latin_hypercube: {snapshots}}}
reduction: {{method: condensed, max_full_order_size: {room}, displacement: {{boundaries: [upper_face]}}}}
"""


def write_case(folder, n_nodes, n_snapshots):
    """Mesh and deck."""
    counts = [n_nodes - 1, n_nodes - 1]
    nodes, groups, *_ = make_plates([120.0, 100.0, 4.0], [120.0, 100.0, 3.0], [*counts, 2], [*counts, 1])
    write_gmsh(folder / "plate.msh", nodes, groups)
    room = ROOM * 8e-6 * n_nodes**4
    deck = DECK.format(low=LOW, high=HIGH, snapshots=n_snapshots, room=room)
    (folder / "plate.yaml").write_text(deck)


def main():
    """Sample, train, compare."""
    parser = command_line(__doc__)
    parser.add_argument("--nodes", type=int, default=85, help="along each side")
    parser.add_argument("--snapshots", type=int, default=40)
    parser.add_argument("--points", type=int, default=10)
    options = parser.parse_args()
    (program,) = build("signorom")
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        write_case(folder, options.nodes, options.snapshots)
        times, model = train(program, folder, "plate")
        print("sample: {:.1f} s, train: {:.1f} s of CPU time".format(*times) + f"; {load_text()}", flush=True)
        with h5py.File(model) as file:
            tied = file["clusters/1/tied"]
            counts = [np.bincount(cluster["status"][()], minlength=3) for cluster in tied.values()]
        print(
            f"model.h5: {model.stat().st_size / 1e6:.0f} MB; open, closed, changing in each cluster: {counts}"
        )
        points = np.random.default_rng(SEED).uniform(LOW, HIGH, (options.points, 3))
        write_points(folder / "points.csv", NAMES, points)
        found = predict(program, folder, model, options.nodes**2)
        expected, cpu = sample(program, folder, "plate", points, "active_set")
        print(f"full order, active_set: {cpu:.1f} s of CPU time per point")
        text, is_same = error_text(found, expected)
        print(f"predict against it at {len(points)} points: {text}")
        n_closed = (expected > 0).sum(axis=1)
        print(f"closed: {n_closed.min()} to {n_closed.max()} of {expected.shape[1]}")
    sys.exit(None if is_same else "the answers differ")


if __name__ == "__main__":
    main()
