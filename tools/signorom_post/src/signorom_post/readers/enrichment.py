# SPDX-License-Identifier: BSD-3-Clause
"""Reads enrichment.csv: the hat functions of each reduced model in the order in which they were added to the basis."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from signorom_post.arrays import FloatArray, IntArray
from signorom_post.errors import InputError
from signorom_post.readers.csv_input import CsvInput

COUNTS = ("cluster", "hat", "pair", "node", "n_columns", "rank")
NUMBERS = ("condition_number", "singular_ratio", "stiffness_condition")


@dataclass(frozen=True)
class History:
    """The enrichment of one cluster. Arrays have the shape (n_hats + 1): before the first hat, and after each hat."""

    cluster: int
    #: contact row and node of each hat, from 1, in the order of the contacts and of the mesh file; 0 before the first
    #: hat
    pairs: IntArray
    nodes: IntArray
    #: number of POD modes and hats: l-bar of the paper
    n_columns: IntArray
    #: rank of the contact rows (11)
    ranks: IntArray
    #: kappa of the contact rows (11), infinite as long as they do not have full rank
    condition_numbers: FloatArray
    #: largest singular value of the contact rows over the smallest one that is not zero
    singular_ratios: FloatArray
    #: condition number of the reduced stiffness
    stiffness_conditions: FloatArray

    @property
    def n_hats(self) -> int:
        """Number of hat functions that were added in all."""
        return len(self.pairs) - 1

    def first_solvable(self) -> int | None:
        """Returns the number of hats with which the contact rows first have full rank (11).

        0: no hat is needed; None: never.
        """
        return self.first_below(np.inf)

    def first_below(self, condition_number: float) -> int | None:
        """Returns the number of hats with which kappa is first finite and at most `condition_number`.

        0: no hat is needed; None: never.
        """
        is_below = np.isfinite(self.condition_numbers) & (self.condition_numbers <= condition_number)
        return int(np.argmax(is_below)) if is_below.any() else None


def read_enrichment(path: Path) -> list[History]:
    """Returns the enrichment of each cluster in the order of enrichment.csv; InputError if the file cannot be used."""
    file = CsvInput(path, (*COUNTS, *NUMBERS))
    counts = {name: _integers(path, name, file.numbers(name)) for name in COUNTS}
    numbers = {name: file.numbers(name) for name in NUMBERS}
    histories = []
    for cluster in dict.fromkeys(counts["cluster"].tolist()):
        rows = np.flatnonzero(counts["cluster"] == cluster)
        if not np.array_equal(counts["hat"][rows], np.arange(len(rows))):
            raise InputError(path, f"the hats of cluster {cluster} are not numbered 0, 1, 2, ...")
        histories.append(
            History(
                cluster=cluster,
                pairs=counts["pair"][rows],
                nodes=counts["node"][rows],
                n_columns=counts["n_columns"][rows],
                ranks=counts["rank"][rows],
                condition_numbers=numbers["condition_number"][rows],
                singular_ratios=numbers["singular_ratio"][rows],
                stiffness_conditions=numbers["stiffness_condition"][rows],
            )
        )
    return histories


def _integers(path: Path, name: str, values: FloatArray) -> IntArray:
    if not np.all(np.isfinite(values)) or np.any(values != np.round(values)):
        raise InputError(path, f"column '{name}' has values that are not integers")
    return values.astype(np.int64)
