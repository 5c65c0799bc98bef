# SPDX-License-Identifier: BSD-3-Clause
"""The mesh, with the triangles, edges and faces that pictures need."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from signorom_post.arrays import FloatArray, IntArray

#: number of corners of a solid cell -> corners of each of its faces
CELL_FACES = {
    4: ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)),
    5: ((0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)),
    6: ((0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)),
    8: ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
}


@dataclass(frozen=True)
class Faces:
    """Faces of solid cells; their corners are counterclockwise for a viewer outside of the body."""

    #: nodes at the corners of each face, from 0, shape (n_faces, 4); a triangle repeats its last corner
    nodes: IntArray
    #: the cell to which each face belongs, from 0, shape (n_faces)
    cells: IntArray

    @property
    def n_corners(self) -> IntArray:
        """Number of corners of each face, 3 or 4; shape (n_faces)."""
        return np.where(self.nodes[:, 2] == self.nodes[:, 3], 3, 4)

    @property
    def triangles(self) -> IntArray:
        """Nodes (from 0) of the triangles of the faces, two triangles for a quadrilateral; shape (n_triangles, 3)."""
        is_quad = self.n_corners == 4
        return np.vstack([self.nodes[:, :3], self.nodes[is_quad][:, [0, 2, 3]]])

    def take(self, which: IntArray) -> "Faces":
        """Returns the faces with the indices `which`, which count from 0, in this order."""
        return Faces(self.nodes[which], self.cells[which])


@dataclass(frozen=True)
class Mesh:
    """Nodes and cells; all indices count from 0."""

    #: coordinates of the nodes [unit], shape (n_nodes, 3), also in the plane
    coordinates: FloatArray
    #: nodes of each cell: of a plane cell in the order around it, of a solid cell its 4, 5, 6 or 8 corners only
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
        """Longest side of the box around the mesh [unit]."""
        return float(np.ptp(self.coordinates, axis=0).max())

    @cached_property
    def triangles(self) -> IntArray:
        """Nodes (from 0) of the triangles into which the plane cells are divided, shape (n_triangles, 3)."""
        fans = [(cell[0], cell[i], cell[i + 1]) for cell in self.cells for i in range(1, len(cell) - 1)]
        return np.array(fans, dtype=np.int64).reshape(-1, 3)

    @cached_property
    def _edges_and_counts(self) -> tuple[IntArray, IntArray]:
        pairs = [np.column_stack([cell, np.roll(cell, -1)]) for cell in self.cells]
        edges, counts = np.unique(np.sort(np.vstack(pairs), axis=1), axis=0, return_counts=True)
        return edges, counts

    @property
    def edges(self) -> IntArray:
        """Edges of plane cells, each once: their two nodes, ascending; shape (n_edges, 2).

        A side with a node in its middle gives two edges.
        """
        return self._edges_and_counts[0]

    @property
    def boundary_edges(self) -> IntArray:
        """Those of `edges` that belong to one cell only; shape (n_boundary_edges, 2)."""
        edges, counts = self._edges_and_counts
        return edges[counts == 1]

    @cached_property
    def outer_faces(self) -> Faces:
        """Faces that belong to only one of the solid cells, turned outwards."""
        return self.faces_of(np.arange(self.n_cells))

    def faces_of(self, cells: IntArray) -> Faces:
        """Returns the faces that belong to only one of these solid cells (indices from 0), turned outwards."""
        rows, owners = [], []
        for i in cells:
            for corners in CELL_FACES[len(self.cells[i])]:
                rows.append([self.cells[i][corner] for corner in (*corners, corners[-1])[:4]])
                owners.append(i)
        nodes, owner = np.array(rows, dtype=np.int64).reshape(-1, 4), np.array(owners, dtype=np.int64)
        # the repeated corner of a triangle must not count: two cells may repeat different corners of their common face
        key = np.sort(
            np.where((nodes[:, 2] == nodes[:, 3])[:, None] & (np.arange(4) == 3), -1, nodes), axis=1
        )
        _, first, counts = np.unique(key, axis=0, return_index=True, return_counts=True)
        alone = np.sort(first[counts == 1])
        return self._turned_outwards(Faces(nodes[alone], owner[alone]))

    def _turned_outwards(self, faces: Faces) -> Faces:
        """Returns the faces with their normals outwards, also for cells whose nodes are numbered inside out."""
        if not faces.cells.size:
            return faces
        corners = self.coordinates[faces.nodes]
        normals = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
        middles = np.array([self.coordinates[self.cells[i]].mean(axis=0) for i in faces.cells])
        is_inward = np.einsum("ij,ij->i", normals, corners.mean(axis=1) - middles) < 0.0
        order = np.where(is_inward[:, None], [0, 3, 2, 1], [0, 1, 2, 3])
        turned = np.take_along_axis(faces.nodes, order, axis=1)
        # a turned triangle is a, c, c, b here; it must be a, c, b, b
        is_triangle = faces.n_corners == 3
        turned[is_triangle & is_inward] = turned[is_triangle & is_inward][:, [0, 1, 3, 3]]
        return Faces(turned, faces.cells)
