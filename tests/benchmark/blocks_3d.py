#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Two blocks of H8 in contact at growing size: time, memory and iterations of active_set with multigrid.

    build/venv/bin/python tests/benchmark/blocks_3d.py                 # 54 and 195 thousand dofs, 2 ranks
    build/venv/bin/python tests/benchmark/blocks_3d.py 54 195 1000     # a million too: 14 GB
    build/venv/bin/python tests/benchmark/blocks_3d.py --linear cholesky 54

A block 1 m wide and 0.5 m high lies on another one; the gap between them grows with the square of the distance to the
middle, and a pressure on the top closes part of it. Planes of symmetry hold both sideways, only contact holds the upper
one in height. Prints a table; times are wall clock but for CPU, which is that of all ranks together; memory is the sum
of the ranks' largest.
"""

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import yaml

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "support"))
from boxes import write_gmsh  # noqa: E402

from program import ENVIRONMENT, launcher  # noqa: E402

# thousand dofs: nodes along each side of the contact face, nodes along the height of a block; cells always twice as high
# as wide, because multigrid feels their shape
SIZES = {13: (19, 6), 54: (32, 9), 195: (50, 13), 1000: (86, 23)}
# of a deck with a parameter P, to be formatted
BODIES = """\
materials: {{steel: {{regions: [lower, upper], young_modulus: 210.0e9, poisson_ratio: 0.3}}}}
boundary_conditions:
  - {{boundary: bottom, displacement: {{x: 0, y: 0, z: 0}}}}
  - {{boundary: left, displacement: {{x: 0}}}}
  - {{boundary: front, displacement: {{y: 0}}}}
loads:
  - {{boundary: top, pressure: P}}
contact:
  - {{first: lower_face, second: upper_face, direction: [0, 0, 1], initial_gap: GAP}}
"""
DECK = """\
title: Two blocks, benchmark
mesh: {{file: blocks.msh, model: solid}}
parameters: {{P: {{min: 0.5e6, max: 2.0e6, unit: Pa}}}}
"""
DECK += BODIES.replace("GAP", '"6e-5 * (x^2 + y^2)"')
DECK += """\
solver: {{type: {solver}, linear: {linear}}}
output: {{points: [{{P: 1.0e6}}], fields: [displacement, contact]}}
"""


def block(n_side, n_high, bottom):
    """Nodes of a grid, its hexahedra and the nodes of its six sides, 0-based."""
    side, height = np.linspace(0, 1, n_side), bottom + np.linspace(0, 0.5, n_high)
    z, y, x = np.meshgrid(height, side, side, indexing="ij")
    number = np.arange(x.size).reshape(x.shape)
    foot = [number[:-1, :-1, :-1], number[:-1, :-1, 1:], number[:-1, 1:, 1:], number[:-1, 1:, :-1]]
    roof = [number[1:, :-1, :-1], number[1:, :-1, 1:], number[1:, 1:, 1:], number[1:, 1:, :-1]]
    cells = np.stack([corner.ravel() for corner in foot + roof], axis=1)
    faces = {
        name: quads(plane)
        for name, plane in (
            ("low", number[0]),
            ("high", number[-1]),
            ("front", number[:, 0]),
            ("left", number[:, :, 0]),
        )
    }
    return np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1), cells, faces


def quads(plane):
    """Quadrilaterals of a grid of nodes."""
    corners = (plane[:-1, :-1], plane[:-1, 1:], plane[1:, 1:], plane[1:, :-1])
    return np.stack([corner.ravel() for corner in corners], axis=1)


def write_mesh(path, n_side, n_high, n_side_of_upper=None):
    """As gmsh 2.2 binary."""
    nodes, cells, faces = block(n_side, n_high, 0.0)
    upper, upper_cells, upper_faces = block(n_side_of_upper or n_side, n_high, 0.5)
    n = len(nodes)
    groups = [
        ("H8", "lower", cells),
        ("H8", "upper", upper_cells + n),
        ("Q4", "bottom", faces["low"]),
        ("Q4", "lower_face", faces["high"]),
        ("Q4", "upper_face", upper_faces["low"] + n),
        ("Q4", "top", upper_faces["high"] + n),
        ("Q4", "front", np.vstack([faces["front"], upper_faces["front"] + n])),
        ("Q4", "left", np.vstack([faces["left"], upper_faces["left"] + n])),
    ]
    nodes = np.vstack([nodes, upper])
    write_gmsh(path, nodes, groups)
    return len(nodes), (n_side * n_side)


def peak_memory(process, peaks):
    """Largest resident memory so far of each rank below a process [GB], by process id."""
    for status in Path("/proc").glob("[0-9]*/status"):
        try:
            fields = dict(line.split(":", 1) for line in status.read_text().splitlines())
        except (OSError, ValueError):
            continue
        if (
            fields["Name"].strip().startswith("signorom")
            and "VmHWM" in fields
            and is_below(int(status.parent.name), process.pid)
        ):
            peaks[status.parent.name] = int(fields["VmHWM"].split()[0]) * 1024 / 1e9


def is_below(pid, ancestor):
    """Whether a process descends from another, or is it."""
    while pid > 1:
        if pid == ancestor:
            return True
        try:
            pid = int(Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[1])
        except OSError:
            return False
    return False


def run(arguments, folder, size, n_ranks, program, peaks):
    """Make the mesh, solve the point; returns the report, the wall time, and the number of pairs."""
    _, n_pairs = write_mesh(folder / "blocks.msh", *SIZES[size])
    (folder / "blocks.yaml").write_text(DECK.format(solver=arguments.solver, linear=arguments.linear))
    command = [*launcher(n_ranks), str(program), "solve", "blocks.yaml", *arguments.options.split()]
    start = time.monotonic()
    process = subprocess.Popen(command, cwd=folder, env=os.environ | ENVIRONMENT)
    while process.poll() is None:
        peak_memory(process, peaks)
        time.sleep(0.2)
    seconds = time.monotonic() - start
    if process.returncode != 0:
        sys.exit(f"exit code {process.returncode}: {' '.join(command)}")
    report = yaml.safe_load((folder / "results" / "blocks" / "report.yaml").read_text())
    return report, seconds, n_pairs


def main():
    """A line per size."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("sizes", nargs="*", type=int, default=[54, 195], help=f"thousand dofs: {[*SIZES]}")
    parser.add_argument("--ranks", type=int, default=2)
    parser.add_argument("--solver", default="active_set")
    parser.add_argument("--linear", default="gamg")
    parser.add_argument("--options", default="", help="PETSc options")
    arguments = parser.parse_args()
    program = Path(os.environ.get("SIGNOROM_EXECUTABLE", ROOT / "build" / "release" / "signorom")).resolve()
    print(f"{arguments.solver}, {arguments.linear}, {arguments.ranks} ranks; load {os.getloadavg()[0]:.1f}")
    print(
        "    dofs  pairs closed steps CG/step  total   mesh pairing partition assembly  set-up "
        "  solve output   GB    CPU  force balance"
    )
    for size in arguments.sizes:
        peaks = {}
        cpu = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        with tempfile.TemporaryDirectory() as folder:
            report, seconds, n_pairs = run(arguments, Path(folder), size, arguments.ranks, program, peaks)
        times, point = report["times"], report["points"]["1"]
        print(
            f"{report['sizes']['n_dofs']:8d} {n_pairs:6d} {point['n_active']:6d} {point['iterations']:5d} "
            f"{point['linear_iterations'] / point['iterations']:7.1f} {seconds:6.1f} {times['mesh']:6.2f} "
            f"{times['pairing']:7.2f} {times['partition']:9.2f} {times['assembly']:8.2f} {times['setup']:7.1f} "
            f"{point['seconds']:6.1f} {times['output']:6.1f} {sum(peaks.values()):4.1f} "
            f"{resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - cpu:6.1f} "
            f"{point['residuals']['force_balance']:.1e}",
            flush=True,
        )


if __name__ == "__main__":
    main()
