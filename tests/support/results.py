# SPDX-License-Identifier: BSD-3-Clause
"""What the program writes, as arrays and dictionaries."""

import csv
import io
from pathlib import Path

import h5py
import numpy as np


def read_snapshots(path):
    """Returns some datasets of snapshots.h5: name -> array; term_texts is a list of texts."""
    with h5py.File(path) as file:
        names = ("parameters", "displacement", "multipliers", "reasons", "residuals", "free_response")
        snapshots = {name: file[name][()] for name in names}
        snapshots["term_texts"] = [text.decode() for text in file["term_texts"][()]]
    return snapshots


def read_table(path):
    """Returns the columns of a CSV file: name -> array, or list of texts if a value is no number."""
    return table_of(Path(path).read_text())


def table_of(text):
    """Returns the columns of the text of a CSV file as read_table does; there must be a row below the header."""
    rows = list(csv.DictReader(io.StringIO(text)))
    table = {}
    for name in rows[0]:
        values = [row[name] for row in rows]
        try:
            table[name] = np.array([float(value) for value in values])
        except ValueError:
            table[name] = values
    return table


def read_fields(path, point=1):
    """Returns the datasets of one point (from 1) of fields.h5: name -> array."""
    with h5py.File(path) as file:
        return {name: dataset[()] for name, dataset in file[f"points/{point:04d}"].items()}
