#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""check.xdmf and contact.xdmf as ParaView's three XDMF readers show them: cells and every value, against the HDF5 files.

    apt-get install --no-install-recommends paraview python3-paraview
    build/venv/bin/python tests/paraview/check_surfaces.py

CI does not run it: ParaView is about 200 MB of packages. It solves decks of `input`, in the plane with quadratic edges,
in axisymmetry and in space with lines and points among the cells, with the program that SIGNOROM_EXECUTABLE names
(default: build/ci/signorom), and starts pvpython. Exit code 1: a reader shows something else.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "support")]
from decks import copy_deck  # noqa: E402
from program import ROOT, find_program  # noqa: E402

DECKS = ("dovetail", "angle_bracket", "pellet_cladding", "saddle", "indenter")
# XDMF's numbers of cell types with their nodes; points and lines say how many they have
SIZES = {4: 3, 5: 4, 6: 4, 9: 8, 34: 3, 36: 6, 37: 8, 35: 9, 38: 10, 48: 20, 50: 27}


def main():
    """Solve the decks, have ParaView read their files."""
    program = find_program()
    n_failed = 0
    for name in DECKS:
        with tempfile.TemporaryDirectory() as folder:
            deck = copy_deck(ROOT / "input" / f"{name}.yaml", Path(folder))
            program("check", deck, "--fields", folder=Path(folder))
            program("solve", deck, folder=Path(folder))
            for kind in ("check", "contact"):
                path = Path(folder) / "results" / name / f"{kind}.xdmf"
                expected = path.with_suffix(".npz")
                np.savez(expected, **arrays_of(path.with_suffix(".h5")))
                print(f"{name}, {path.name}", flush=True)
                # Xdmf3ReaderS and T of ParaView 5.11 need an absolute path
                command = ["pvpython", "--force-offscreen-rendering", HERE / "read_fields.py"]
                done = subprocess.run(
                    [*command, path.resolve(), expected],
                    env=os.environ | {"QT_QPA_PLATFORM": "offscreen"},
                    check=False,
                )
                n_failed += done.returncode != 0
    return int(n_failed > 0)


def arrays_of(path):
    """What the readers are to show of the first point."""
    with h5py.File(path) as file:
        places, point = file["mesh/coordinates"][()], file["points/0001"]
        topology = file["mesh/topology"][()]
        sizes = np.full(len(topology), topology.shape[-1]) if topology.ndim == 2 else sizes_of(topology)
        arrays = {"places": places, "sizes": sizes}
        for name, values in point.items():
            if len(values) in (len(places), len(sizes)):
                arrays[f"{'node' if len(values) == len(places) else 'cell'}/{name}"] = values[()]
        return arrays


def sizes_of(flat):
    """Number of nodes of each cell of XDMF's mixed list."""
    sizes, start = [], 0
    while start < len(flat):
        size, n_words = (flat[start + 1], 2) if flat[start] <= 2 else (SIZES[flat[start]], 1)
        sizes.append(size)
        start += n_words + size
    return np.array(sizes)


if __name__ == "__main__":
    sys.exit(main())
