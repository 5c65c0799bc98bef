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
    #: area that touches, of each contact of the deck, shape (n_times, n_contacts)
    areas: FloatArray
    #: resultant force of each contact, shape (n_times, n_axes, n_contacts), and the names of the axes
    forces: FloatArray
    axes: tuple[str, ...]
    #: number of a contact with friction, from 0 -> share of its area that slips, and work of its friction since the
    #: beginning, shape (n_times)
    slip_shares: dict[int, FloatArray]
    works: dict[int, FloatArray]
    #: [-] estimate of the error of the contact forces, relative to their size, shape (n_times); None: the table has none
    estimates: FloatArray | None = None


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

    Default of `x`: the table in whose steps friction works most, the first of equal ones, or the time without tables.
    Default of `y`: the resultant along the friction of the contact in which friction works most, see _tangential.
    InputError if the file is missing or cannot be used, or has no such column.
    """
    file = CsvInput(path, ("time", "status"))
    i_time, i_status = file.header.index("time"), file.header.index("status")
    known = [name for name in file.header if name != "status"]
    for name in (x, y):
        if name is not None and name not in known:
            raise InputError(path, f"there is no column '{name}' of numbers; there are {', '.join(known)}")
    along = x or _moving_table(
        file, [name for name in file.header[i_time + 1 : i_status] if name != "cluster"]
    )
    over = y or _tangential(file, file.numbers(along))
    values, others = file.numbers(along), file.numbers(over)
    parameters = {name: file.numbers(name) for name in file.header[:i_time]}
    curves = [
        Curve(
            {name: float(v[first]) for name, v in parameters.items()}, values[first:last], others[first:last]
        )
        for first, last in _spans(file.numbers("time"))
    ]
    return curves, (along, over)


def _moving_table(file: CsvInput, tables: list[str]) -> str:
    """Returns the table in whose steps, those in which it changes, friction works most; `time` without tables."""
    work = sum(
        (np.nan_to_num(np.abs(file.numbers(name))) for name in file.header if name.endswith("_dissipation")),
        np.zeros(len(file.numbers("time"))),
    )
    spans = _spans(file.numbers("time"))

    def work_of(table: str) -> float:
        values = file.numbers(table)
        return sum(float(work[i + 1 : k][np.diff(values[i:k]) != 0.0].sum()) for i, k in spans)

    return max(tables, key=work_of, default="time")


def _tangential(file: CsvInput, along: FloatArray) -> str:
    """Returns the column of the resultant along friction, of the contact with the largest sum of dissipation.

    It is the component that changes most in all steps in which `along` changes, so that what happens before, as
    pressing, does not count; of those that change their sign, if some do. Changes up to 1e-6 of the largest force are
    rounding. Without friction it is a component of contact 1.
    """
    work = {
        match.group(1): float(np.nansum(np.abs(file.numbers(name))))
        for name in file.header
        if (match := re.fullmatch(r"contact_(\d+)_dissipation", name))
    }
    contact = max(work, key=lambda number: work[number]) if work else "1"
    names = [name for name in file.header if re.fullmatch(rf"contact_{contact}_force_\w", name)]
    if not names:
        raise InputError(file.path, "there is no contact whose friction could be shown; give --y")
    spans = _spans(file.numbers("time"))
    columns = [file.numbers(name) for name in names]
    largest = max((float(np.abs(v[np.isfinite(v)]).max(initial=0.0)) for v in columns), default=0.0)
    changes, turns = [], []
    for values in columns:
        changes.append(sum(_variation(values[i:k], along[i:k]) for i, k in spans))
        shown = values[np.isfinite(values)]
        turns.append(bool(shown.size) and shown.min() < -1e-6 * largest and shown.max() > 1e-6 * largest)
    scores = [change if turn or not any(turns) else -1.0 for change, turn in zip(changes, turns, strict=True)]
    return names[int(np.argmax(scores))]


def _variation(values: FloatArray, along: FloatArray) -> float:
    """Returns the sum of the changes of `values` without sign, over the steps in which `along` changes."""
    return float(np.nansum(np.abs(np.diff(values))[np.diff(along) != 0.0]))


def _spans(times: FloatArray) -> list[tuple[int, int]]:
    """Returns the first row of each history, and the one behind its last row."""
    return list(pairwise([0, *(int(i) + 1 for i in np.flatnonzero(np.diff(times) <= 0)), len(times)]))


def read_histories(path: Path) -> list[PointHistory]:
    """Returns the histories of history.csv, one for each point of the parameters, in the order of the file.

    The columns before `time` are the deck's parameters, those between `time` and `status` the tables, and in a table of
    `predict` the cluster. InputError if the file is missing or cannot be used.
    """
    file = CsvInput(path, ("time", "status"))
    i_time, i_status = file.header.index("time"), file.header.index("status")
    if not 0 < i_time < i_status:
        raise InputError(path, "the columns must be the parameters, time, the tables, status, and the forces")
    n_contacts = sum(re.fullmatch(r"contact_\d+_area", name) is not None for name in file.header)
    parameters = {name: file.numbers(name) for name in file.header[:i_time]}
    times = file.numbers("time")
    between = [name for name in file.header[i_time + 1 : i_status] if name != "cluster"]
    tables = {name: file.numbers(name) for name in between}
    axes = tuple(
        match.group(1) for name in file.header if (match := re.fullmatch(r"contact_1_force_(\w)", name))
    )
    areas = np.zeros((len(times), n_contacts))
    forces = np.zeros((len(times), len(axes), n_contacts))
    for k in range(n_contacts):
        areas[:, k] = file.numbers(f"contact_{k + 1}_area")
        for i, axis in enumerate(axes):
            forces[:, i, k] = file.numbers(f"contact_{k + 1}_force_{axis}")
    rubbing = [k for k in range(n_contacts) if f"contact_{k + 1}_dissipation" in file.header]
    shares = {k: file.numbers(f"contact_{k + 1}_slip_share") for k in rubbing}
    works = {k: file.numbers(f"contact_{k + 1}_dissipation") for k in rubbing}
    has_estimates = "error_estimate" in file.header
    estimates = file.numbers_or_none("error_estimate") if has_estimates else None
    return [
        PointHistory(
            point={name: float(values[first]) for name, values in parameters.items()},
            times=times[first:last],
            tables={name: values[first:last] for name, values in tables.items()},
            areas=areas[first:last],
            forces=forces[first:last],
            axes=axes,
            slip_shares={k: values[first:last] for k, values in shares.items()},
            works={k: np.cumsum(values[first:last]) for k, values in works.items()},
            estimates=None if estimates is None else estimates[first:last],
        )
        for first, last in _spans(times)
    ]
