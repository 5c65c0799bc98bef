# SPDX-License-Identifier: BSD-3-Clause
"""Reads validation.csv: errors of the reduced model, one line per test point."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from signorom_post.arrays import BoolArray, FloatArray
from signorom_post.errors import InputError
from signorom_post.readers.csv_input import CsvInput

#: columns of numbers that must be there; an error may be infinite, or nan if it is not defined
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
    #: values of the parameters, shape (n_points, n_parameters)
    parameters: FloatArray
    #: name, one of NUMERIC_COLUMNS -> column of numbers, shape (n_points); an error is nan if it is not defined
    columns: dict[str, FloatArray]
    #: solver that answered at each point; `none`: there is no answer
    solvers: list[str]
    #: whether the full-order model has a solution at each point, shape (n_points)
    has_solution: BoolArray
    #: [-] error_estimate of each answer, nan without one, shape (n_points); None: the model gives none
    estimates: FloatArray | None = None

    def counted_errors(self, name: str) -> FloatArray:
        """Returns the errors `name` as the verdict of the command `validate` counts them.

        A point without an answer counts as infinite. An undefined error (nan) counts as 0 if the full order has no
        closed contact, and else as infinite; for e_lambda_rid it also counts as 0 if the answer has no closed contact
        in the domain. Points without a full-order solution are left out.
        """
        errors = self.columns[name]
        is_open = self.columns["n_active_full_order"] == 0
        if name == "e_lambda_rid":
            is_open |= self.columns["n_active"] == 0
        errors = np.where(np.isnan(errors), np.where(is_open, 0.0, np.inf), errors)
        errors[[solver == "none" for solver in self.solvers]] = np.inf
        return errors[self.has_solution]


def read_validation(path: Path) -> Validation:
    """Returns the contents of validation.csv, whose columns before `cluster` are the parameters.

    Without the column `full_order` all points count as solved. InputError if the file is missing or cannot be used.
    """
    file = CsvInput(path, (*NUMERIC_COLUMNS, "solver"))
    n_parameters = file.header.index("cluster")
    if n_parameters == 0:
        raise InputError(path, "there is no parameter column before 'cluster'")
    names = file.header[:n_parameters]
    solvers = file.texts("solver")
    statuses = file.texts("full_order") if "full_order" in file.header else ["converged"] * len(solvers)
    return Validation(
        path=path,
        parameter_names=names,
        parameters=np.column_stack([file.numbers(name) for name in names]),
        columns={name: file.numbers(name) for name in NUMERIC_COLUMNS},
        solvers=solvers,
        has_solution=np.array([status == "converged" for status in statuses]),
        estimates=file.numbers_or_none("error_estimate") if "error_estimate" in file.header else None,
    )
