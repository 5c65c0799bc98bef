# SPDX-License-Identifier: BSD-3-Clause
"""What the procedures for the paper's figures and tables share: their argument, their result, and common numbers."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from matplotlib.figure import Figure

from signorom_post.errors import InputError
from signorom_post.paper.comparison import Comparison
from signorom_post.paper.runs import Runs
from signorom_post.paper.variants import LOADS, Variant
from signorom_post.readers.enrichment import History
from signorom_post.results import Results

Row = dict[str, object]


@dataclass(frozen=True)
class Study:
    """The argument of each procedure that makes a figure or table of the paper: it gives the results of runs."""

    runs: Runs
    #: points per parameter of the error maps
    n_map: int

    def both_loads(self, variants: Sequence[Variant]) -> tuple[list[Results], list[Results]]:
        """Returns the results of the variants under the load `whole_edges`, and under the load `cut`.

        The variants' own load does not count. Runs and errors as for `Runs.results`.
        """
        both = [replace(variant, load=load) for load in LOADS for variant in variants]
        results = self.runs.results(both)
        return results[: len(variants)], results[len(variants) :]


@dataclass(frozen=True)
class Outcome:
    """What such a procedure returns: tables, figures, and comparisons of numbers with the paper.

    The keys of tables and figures are names of files without their ending.
    """

    tables: dict[str, list[Row]]
    figures: dict[str, Figure]
    comparisons: list[Comparison] = field(default_factory=list)


Entry = Callable[[Study], Outcome]


def errors_at(results: Results, point: tuple[float, float]) -> tuple[float, float]:
    """Returns the primal error, and the dual error on the reduced domain, at a test point; 1 is 100 %.

    `point` is the pressure [MPa] and the height [mm]. InputError if it is not a test point.
    """
    validation = results.validation
    rows = np.flatnonzero(np.all(np.isclose(validation.parameters, point), axis=1))
    if rows.size == 0:
        raise InputError(validation.path, f"there is no test point {point}")
    return float(validation.columns["e_u"][rows[0]]), float(validation.columns["e_lambda_rid"][rows[0]])


def history_of(results: Results) -> History:
    """Returns the enrichment of a model without clusters, from enrichment.csv."""
    return results.enrichment[0]


def n_contact_rows(results: Results) -> int:
    """Returns the number of contact pairs in the reduced domain of a model without clusters, from the report."""
    return int(results.report["reduction"]["n_contact_rows"])


def point_text(point: tuple[float, float]) -> str:
    """Returns the text of a point, such as `(170 MPa, 3.2 mm)`."""
    return f"({point[0]:g} MPa, {point[1]:g} mm)"


def strategy_text(extra_modes: int) -> str:
    """Returns the name of an enrichment strategy as in the paper: `FE` without extra modes, or `POD + 9 and FE`."""
    return f"POD + {extra_modes} and FE" if extra_modes else "FE"
