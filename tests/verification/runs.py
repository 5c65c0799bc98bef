# SPDX-License-Identifier: BSD-3-Clause
"""Runs of the program, bare or under mpirun, and what they write."""

import csv
import os
import subprocess
from pathlib import Path

import h5py
import numpy as np

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
TIME_LIMIT = 600

# One BLAS thread per rank; waiting ranks give their core away; Open MPI refuses root unless told twice.
ENVIRONMENT = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "OMPI_MCA_mpi_yield_when_idle": "1",
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
}


class Program:
    """The program under test."""

    def __init__(self, executable):
        """Executable as an absolute path."""
        self.executable = executable

    def __call__(self, *arguments, folder, n_ranks=1):
        """Run a command in a folder and insist on exit code 0; returns what it printed."""
        launcher = []
        if n_ranks > 1:
            launcher = ["mpirun", "--oversubscribe", "--bind-to", "none", "-n", str(n_ranks)]
        command = [*launcher, str(self.executable), *map(str, arguments)]
        done = subprocess.run(
            command,
            cwd=folder,
            env=os.environ | ENVIRONMENT,
            capture_output=True,
            text=True,
            timeout=TIME_LIMIT,
            check=False,
        )
        shown = " ".join(command)
        assert done.returncode == 0, f"{shown}\nexit code {done.returncode}\n{done.stdout}\n{done.stderr}"
        return done.stdout


def write_deck(name, folder, **replacements):
    """Copy decks/<name>.yaml into a folder with an absolute mesh path and `old` -> `new` texts replaced.

    The results of a deck in folder go to folder/results/<name> when the program runs there.
    """
    text = (HERE / "decks" / f"{name}.yaml").read_text()
    text = text.replace("../meshes", str(HERE / "meshes"))
    for old, new in replacements.items():
        assert old in text, f"{name}.yaml has no {old}"
        text = text.replace(old, new)
    path = Path(folder) / f"{name}.yaml"
    path.write_text(text)
    return path


def read_snapshots(path):
    """Datasets of snapshots.h5 by name."""
    with h5py.File(path) as file:
        names = ("parameters", "displacement", "multipliers", "reasons", "residuals", "free_response")
        snapshots = {name: file[name][()] for name in names}
        snapshots["term_texts"] = [text.decode() for text in file["term_texts"][()]]
    return snapshots


def read_table(path):
    """Columns of validation.csv: arrays of numbers, lists of words."""
    with Path(path).open() as file:
        rows = list(csv.DictReader(file))
    table = {}
    for name in rows[0]:
        values = [row[name] for row in rows]
        try:
            table[name] = np.array([float(value) for value in values])
        except ValueError:
            table[name] = values
    return table
