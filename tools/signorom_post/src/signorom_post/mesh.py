# SPDX-License-Identifier: BSD-3-Clause
"""The mesh as data, with the triangles and edges that drawing needs."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from signorom_post.arrays import FloatArray, IntArray


@dataclass(frozen=True)
class Mesh:
    """Nodes and cells; all indices here are 0-based."""

    #: [unit] shape (n_nodes, 3)
    coordinates: FloatArray
    #: nodes of each cell, around the cell in two dimensions; shape (n_cells)[3 or 4 or 8]
    cells: list[IntArray]
    #: dimension of the cells: 2 or 3
    n_dim: int
    #: unit of the coordinates
    unit: str = ""

    @property
    def n_nodes(self) -> int:
        """Number of nodes."""
        return len(self.coordinates)

    @property
    def n_cells(self) -> int:
        """Number of cells."""
        return len(self.cells)

    @property
    def size(self) -> float:
        """Largest side of the box around the mesh [unit]."""
        return float(np.ptp(self.coordinates, axis=0).max())

    @cached_property
    def triangles(self) -> IntArray:
        """Plane cells cut into triangles, shape (n_triangles, 3)."""
        fans = [(cell[0], cell[i], cell[i + 1]) for cell in self.cells for i in range(1, len(cell) - 1)]
        return np.array(fans, dtype=np.int64).reshape(-1, 3)

    @cached_property
    def _edges_and_counts(self) -> tuple[IntArray, IntArray]:
        pairs = [np.column_stack([cell, np.roll(cell, -1)]) for cell in self.cells]
        edges, counts = np.unique(np.sort(np.vstack(pairs), axis=1), axis=0, return_counts=True)
        return edges, counts

    @property
    def edges(self) -> IntArray:
        """Edges of plane cells, each once, shape (n_edges, 2)."""
        return self._edges_and_counts[0]

    @property
    def boundary_edges(self) -> IntArray:
        """Edges with a cell on one side only, shape (n_boundary_edges, 2)."""
        edges, counts = self._edges_and_counts
        return edges[counts == 1]
