# SPDX-License-Identifier: BSD-3-Clause
"""Reads history.csv: forces of each contact of the deck over the time, one line per state."""

import re
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from signorom_post.arrays import FloatArray
from signorom_post.errors import InputError
from signorom_post.readers.csv_input import CsvInput


@dataclass(frozen=True)
class PointHistory:
    """The states of one point in the order of the times; numbers are nan at states without a solution."""

    #: name of a parameter of the deck -> value
    point: dict[str, float]
    #: shape (n_times)
    times: FloatArray
    #: name of a table -> its values, shape (n_times)
    tables: dict[str, FloatArray]
    #: area that touches and size of the resultant force of each contact of the deck, shape (n_times, n_contacts)
    areas: FloatArray
    forces: FloatArray


def read_histories(path: Path) -> list[PointHistory]:
    """Returns the histories of history.csv, one for each point of the parameters, in the order of the file.

    The columns before `time` are the deck's parameters, those between `time` and `status` the tables. InputError if the
    file is missing or cannot be used.
    """
    file = CsvInput(path, ("time", "status"))
    i_time, i_status = file.header.index("time"), file.header.index("status")
    if not 0 < i_time < i_status:
        raise InputError(path, "the columns must be the parameters, time, the tables, status, and the forces")
    n_contacts = sum(re.fullmatch(r"contact_\d+_area", name) is not None for name in file.header)
    parameters = {name: file.numbers(name) for name in file.header[:i_time]}
    times = file.numbers("time")
    tables = {name: file.numbers(name) for name in file.header[i_time + 1 : i_status]}
    areas, forces = np.zeros((len(times), n_contacts)), np.zeros((len(times), n_contacts))
    for k in range(n_contacts):
        areas[:, k] = file.numbers(f"contact_{k + 1}_area")
        names = [name for name in file.header if re.fullmatch(rf"contact_{k + 1}_force_\w", name)]
        forces[:, k] = np.linalg.norm([file.numbers(name) for name in names], axis=0)
    starts = [0, *(np.flatnonzero(np.diff(times) <= 0) + 1), len(times)]
    return [
        PointHistory(
            point={name: float(values[first]) for name, values in parameters.items()},
            times=times[first:last],
            tables={name: values[first:last] for name, values in tables.items()},
            areas=areas[first:last],
            forces=forces[first:last],
        )
        for first, last in pairwise(starts)
    ]
