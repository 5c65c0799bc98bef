#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Stresses as ParaView's three XDMF readers show them: names of the components and every value, against known ones.

    apt-get install --no-install-recommends paraview python3-paraview
    build/venv/bin/python tests/paraview/check_stresses.py

CI does not run it: ParaView is about 200 MB of packages. It solves the decks of tests/support/known_stresses.py with the
program that SIGNOROM_EXECUTABLE names (default: build/ci/signorom) and starts pvpython. Exit code 1: a reader shows
something else.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "support")]
from known_stresses import COMPONENTS, NAMES, write_case  # noqa: E402
from program import find_program  # noqa: E402


def main():
    """Solve the decks, have ParaView read them."""
    program = find_program()
    n_failed = 0
    for name in NAMES:
        with tempfile.TemporaryDirectory() as folder:
            known = write_case(name, folder)
            program("solve", known.deck, folder=Path(folder))
            expected = Path(folder) / "expected.npz"
            np.savez(
                expected,
                names=COMPONENTS,
                cells=known.cells,
                nodes=known.nodes,
                limits=np.array(known.limits),
            )
            # Xdmf3ReaderS and T of ParaView 5.11 need an absolute path
            fields = (Path(folder) / "results" / known.deck.stem / "fields.xdmf").resolve()
            print(f"{name}:", flush=True)
            command = ["pvpython", "--force-offscreen-rendering", HERE / "read_stresses.py", fields, expected]
            done = subprocess.run(command, env=os.environ | {"QT_QPA_PLATFORM": "offscreen"}, check=False)
            n_failed += done.returncode != 0
    return int(n_failed > 0)


if __name__ == "__main__":
    sys.exit(main())
