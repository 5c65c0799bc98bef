# SPDX-License-Identifier: BSD-3-Clause
"""Contact rows: the nodes of both sides and the area of each row."""

from dataclasses import dataclass

import numpy as np

from signorom_post.arrays import FloatArray, IntArray


@dataclass(frozen=True)
class ContactSide:
    """The nodes of one side of all contact rows; those of row i are `nodes[starts[i] : starts[i + 1]]`, i from 0."""

    #: first entry of each row, from 0, and the number of all entries at the end; shape (n_rows + 1)
    starts: IntArray
    #: nodes, from 0; on the first side, the node that carries the row's force comes first
    nodes: IntArray
    #: share of the row's force on each node, same shape as `nodes`; the shares of a row sum up to 1
    weights: FloatArray

    def of(self, row: int) -> IntArray:
        """Returns the nodes (from 0) of `row` (from 0) on this side; an obstacle, a second side, has none."""
        return self.nodes[self.starts[row] : self.starts[row + 1]]


@dataclass(frozen=True)
class Contact:
    """All contact rows of a problem."""

    first: ContactSide
    second: ContactSide
    #: area of each row, shape (n_rows): the force of a row over its area is the contact pressure
    areas: FloatArray

    @property
    def n_rows(self) -> int:
        """Number of contact rows, each of which has one contact force."""
        return len(self.areas)

    @property
    def owners(self) -> IntArray:
        """Node, from 0, that carries the force of each row (its owner), shape (n_rows)."""
        return self.first.nodes[self.first.starts[:-1]]

    def nodes_of(self, rows: IntArray | None = None) -> IntArray:
        """Returns the nodes (from 0) of rows, each once: those of the first side, then those of the second.

        `rows` are the numbers of the rows, from 0; default: all.
        """
        chosen = range(self.n_rows) if rows is None else rows
        nodes = [side.of(row) for side in (self.first, self.second) for row in chosen]
        return np.array(list(dict.fromkeys(np.concatenate(nodes))) if nodes else [], dtype=np.int64)
