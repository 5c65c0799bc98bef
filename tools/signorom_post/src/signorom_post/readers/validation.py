# SPDX-License-Identifier: BSD-3-Clause
"""validation.csv: errors of the reduced model, one line per test point."""

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from signorom_post.arrays import FloatArray
from signorom_post.errors import InputError
from signorom_post.readers.hdf5_input import require_file

#: numbers; an error may be inf, or nan where it is not defined
NUMERIC_COLUMNS = (
    "cluster",
    "e_u",
    "e_lambda_rid",
    "e_lambda_all",
    "e_energy",
    "e_energy_rid",
    "n_active",
    "n_active_full_order",
)


@dataclass(frozen=True)
class Validation:
    """The table, one row per test point, in the order of the file."""

    path: Path
    parameter_names: list[str]
    #: shape (n_points, n_parameters)
    parameters: FloatArray
    #: numeric columns by name, shape (n_points) each; an error is nan where it is not defined
    columns: dict[str, FloatArray]
    #: what solved each point
    solvers: list[str]


def read_validation(path: Path) -> Validation:
    """Read and check validation.csv; its first columns, up to `cluster`, are the parameters."""
    require_file(path)
    try:
        with path.open(newline="", encoding="utf-8") as file:
            rows = [row for row in csv.reader(file) if row]
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(path, "this is not a CSV file") from error
    except OSError as error:
        raise InputError(path, f"the file cannot be read ({error.strerror})") from error
    header = [name.strip() for name in rows[0]] if rows else []
    missing = [name for name in (*NUMERIC_COLUMNS, "solver") if name not in header]
    if missing:
        raise InputError(path, f"the header lacks the columns {', '.join(missing)}")
    if len(rows) < 2:
        raise InputError(path, "there is a header but no point")
    n_parameters = header.index("cluster")
    if n_parameters == 0:
        raise InputError(path, "there is no parameter column before 'cluster'")
    names = header[:n_parameters]
    i_solver = header.index("solver")
    parameters = np.column_stack([_column(path, header, rows, name) for name in names])
    return Validation(
        path=path,
        parameter_names=names,
        parameters=parameters,
        columns={name: _column(path, header, rows, name) for name in NUMERIC_COLUMNS},
        solvers=[row[i_solver].strip() for row in rows[1:]],
    )


def _column(path: Path, header: list[str], rows: list[list[str]], name: str) -> FloatArray:
    i_column = header.index(name)
    values = np.empty(len(rows) - 1)
    for i_row, row in enumerate(rows[1:]):
        if len(row) != len(header):
            raise InputError(
                path,
                f"line {i_row + 2} has {len(row)} values for {len(header)} columns; is the file truncated?",
            )
        try:
            values[i_row] = float(row[i_column] or "nan")
        except ValueError as error:
            raise InputError(
                path, f"line {i_row + 2}, column '{name}': '{row[i_column]}' is not a number"
            ) from error
    return values
