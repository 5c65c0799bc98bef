# SPDX-License-Identifier: BSD-3-Clause
"""Contact rows: the nodes of both sides of each, and the area that it stands for."""

from dataclasses import dataclass

import numpy as np

from signorom_post.arrays import FloatArray, IntArray


@dataclass(frozen=True)
class ContactSide:
    """Nodes of one side of all rows; those of row i are `nodes[starts[i] : starts[i + 1]]`."""

    #: shape (n_rows + 1)
    starts: IntArray
    #: 0-based; on the first side the one that carries the row's force comes first
    nodes: IntArray
    #: share of the row's force on each node, shape of `nodes`
    weights: FloatArray

    def of(self, row: int) -> IntArray:
        """Return the nodes of a row; empty for a rigid obstacle."""
        return self.nodes[self.starts[row] : self.starts[row + 1]]


@dataclass(frozen=True)
class Contact:
    """All contact rows of a problem."""

    first: ContactSide
    second: ContactSide
    #: force of a row over its area is the pressure there, shape (n_rows)
    areas: FloatArray

    @property
    def n_rows(self) -> int:
        """Number of contact forces."""
        return len(self.areas)

    @property
    def owners(self) -> IntArray:
        """Node that carries the force of each row, shape (n_rows)."""
        return self.first.nodes[self.first.starts[:-1]]

    def nodes_of(self, rows: IntArray | None = None) -> IntArray:
        """Return the nodes of some rows, or of all: first sides, then second sides, each node once."""
        chosen = range(self.n_rows) if rows is None else rows
        nodes = [side.of(row) for side in (self.first, self.second) for row in chosen]
        return np.array(list(dict.fromkeys(np.concatenate(nodes))) if nodes else [], dtype=np.int64)
