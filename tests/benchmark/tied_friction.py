#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A clamped plate that is sheared in both directions: 1600 contacts with friction, whose whole matrix may not be formed.

build/venv/bin/python tests/benchmark/tied_friction.py
build/venv/bin/python tests/benchmark/tied_friction.py --nodes 14 --points 1     # a small one

Two plates of hexahedra with equal meshes: the upper one is pressed down, and its free edge is pulled and pushed, so that
slip comes in from there. Answers of the tied model against active_set along histories at other parameters, and CPU time
for each time.
"""

import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np
from boxes import make_plates, write_gmsh
from timing import build, command_line, load_text, measure, read_table, train, write_points

# of that of the matrix of all forces
ROOM = 0.6
N_TIMES = 8
LOW, HIGH = np.array([2.7e-3, 0.0, 0.3]), np.array([3.3e-3, 100.0, 0.4])
DECK = """\
title: A clamped plate that is sheared in both directions
units: {{length: mm, force: N, time: s}}
mesh: {{file: plate.msh, model: solid}}
parameters:
  press: {{min: {low[0]}, max: {high[0]}, unit: mm}}
  pull: {{min: {low[1]}, max: {high[1]}, unit: MPa}}
  mu: {{min: {low[2]}, max: {high[2]}}}
history:
  tables:
    load: {{time: [0, 1], value: [0, 1]}}
    end: {{time: [0, 1, 2, 4], value: [0, 0, 1, -1]}}
  steps:
    - {{until: 1, increments: 2}}
    - {{until: 4, increments: 6}}
materials:
  steel: {{regions: [lower, upper], young_modulus: 205.0e3, poisson_ratio: 0.29}}
boundary_conditions:
  - {{boundary: base, displacement: {{x: 0, y: 0, z: 0}}}}
  - {{boundary: top, displacement: {{z: "-press * load"}}}}
loads:
  - {{boundary: edge, traction: {{x: "pull * end", y: "0.3 * pull * end"}}}}
contact:
  - {{first: lower_face, second: upper_face, direction: [0, 0, 1], friction: mu}}
solver: {{type: active_set}}
training: {{grid: {{press: 2, pull: 2, mu: 2}}}}
test: {{sobol: {points}, seed: 3}}
reduction: {{max_full_order_size: {room}, displacement: {{boundaries: [edge]}}}}
"""


def write_case(folder, n_nodes, n_points):
    """Mesh and deck."""
    counts = [n_nodes - 1, n_nodes - 1]
    nodes, groups, upper, n = make_plates([80.0, 80.0, 6.0], [80.0, 80.0, 4.0], [*counts, 2], [*counts, 2])
    groups.append(("Q4", "edge", upper.sides[0, 1] + n))
    write_gmsh(folder / "plate.msh", nodes, groups)
    room = ROOM * 8e-6 * (3 * n_nodes**2) ** 2
    (folder / "plate.yaml").write_text(DECK.format(points=n_points, room=room, low=LOW, high=HIGH))


def answer(program, folder, model, n_points):
    """CPU time of `predict` for some histories [s]."""
    shares = np.linspace(0.1, 0.9, n_points)[:, None]
    write_points(folder / "points.csv", ["press", "pull", "mu"], LOW + shares * (HIGH - LOW))
    command = [
        program,
        "predict",
        model,
        "--points",
        "points.csv",
        "--threads",
        "1",
        "--output",
        "answers.csv",
    ]
    return measure(command, folder).cpu


def main():
    """Sample, train, compare."""
    parser = command_line(__doc__)
    parser.add_argument("--nodes", type=int, default=40, help="along each side")
    parser.add_argument("--points", type=int, default=3, help="histories that are compared")
    options = parser.parse_args()
    (program,) = build("signorom")
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        write_case(folder, options.nodes, options.points)
        times, model = train(program, folder, "plate")
        print("sample: {:.1f} s, train: {:.1f} s of CPU time".format(*times) + f"; {load_text()}", flush=True)
        with h5py.File(model) as file:
            status = file["clusters/1/tied/1/status"][()][: options.nodes**2]
        counts = np.bincount(status, minlength=3)
        print(f"model.h5: {model.stat().st_size / 1e6:.0f} MB; contacts open, stuck, changing: {counts}")
        compared = measure([program, "validate", "plate.yaml"], folder)
        table = read_table(folder / "results" / "plate" / "validation.csv")
        asked = options.points * N_TIMES
        print(f"full order, active_set: {compared.cpu / asked:.2f} s of CPU time for each time")
        once, often = (answer(program, folder, model, n) for n in (1, 6))
        print(f"tied model: {1e3 * (often - once) / 5 / N_TIMES:.1f} ms of CPU time for each time")
        print(f"answered: {sum(name == 'condensed' for name in table['solver'])} of {asked}", end="; ")
        print(f"largest error of the forces: {max(table['e_lambda_all']):.1e}")
    sys.exit(None if max(table["e_lambda_all"]) <= 1e-8 else "the answers differ")


if __name__ == "__main__":
    main()
