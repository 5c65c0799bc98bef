# SPDX-License-Identifier: BSD-3-Clause
"""Reads history.csv: forces of each contact of the deck over the time, or any two columns, one line per state."""

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


@dataclass(frozen=True)
class Curve:
    """Two columns of the states of one point."""

    #: name of a parameter of the deck -> value
    point: dict[str, float]
    #: shape (n_times)
    x: FloatArray
    y: FloatArray


def read_curves(path: Path, x: str | None, y: str | None) -> tuple[list[Curve], tuple[str, str]]:
    """Returns column `y` over column `x` of history.csv, a curve for each point, and the names of both columns.

    Default of `x`: the first table, or the time without tables. Default of `y`: the tangential resultant of contact 1,
    that is, of its components the one with the largest range of those that change their sign, or of all if none does.
    InputError if the file is missing or cannot be used, or has no such column.
    """
    file = CsvInput(path, ("time", "status"))
    i_time, i_status = file.header.index("time"), file.header.index("status")
    known = [name for name in file.header if name != "status"]
    for name in (x, y):
        if name is not None and name not in known:
            raise InputError(path, f"there is no column '{name}' of numbers; there are {', '.join(known)}")
    along = x or file.header[i_time + 1 if i_status > i_time + 1 else i_time]
    over = y or _tangential(file)
    values, others = file.numbers(along), file.numbers(over)
    parameters = {name: file.numbers(name) for name in file.header[:i_time]}
    curves = [
        Curve(
            {name: float(v[first]) for name, v in parameters.items()}, values[first:last], others[first:last]
        )
        for first, last in _spans(file.numbers("time"))
    ]
    return curves, (along, over)


def _tangential(file: CsvInput) -> str:
    names = [name for name in file.header if re.fullmatch(r"contact_1_force_\w", name)]
    if not names:
        raise InputError(file.path, "there is no contact whose friction could be shown; give --y")
    columns = [file.numbers(name)[np.isfinite(file.numbers(name))] for name in names]
    turns = [bool(v.size) and v.min() < 0.0 < v.max() for v in columns]
    ranges = [
        np.ptp(v) if v.size and (turn or not any(turns)) else -1.0
        for v, turn in zip(columns, turns, strict=True)
    ]
    return names[int(np.argmax(ranges))]


def _spans(times: FloatArray) -> list[tuple[int, int]]:
    """Returns the first row of each history, and the one behind its last row."""
    return list(pairwise([0, *(int(i) + 1 for i in np.flatnonzero(np.diff(times) <= 0)), len(times)]))


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
    return [
        PointHistory(
            point={name: float(values[first]) for name, values in parameters.items()},
            times=times[first:last],
            tables={name: values[first:last] for name, values in tables.items()},
            areas=areas[first:last],
            forces=forces[first:last],
        )
        for first, last in _spans(times)
    ]
