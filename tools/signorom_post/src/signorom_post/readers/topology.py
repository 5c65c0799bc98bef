# SPDX-License-Identifier: BSD-3-Clause
"""Cells in XDMF's mixed lists, and the nodes of a cell that pictures use."""

from collections.abc import Mapping

import numpy as np

from signorom_post.arrays import IntArray
from signorom_post.readers.hdf5_input import Hdf5Input

#: XDMF's number of a cell type -> (number of nodes, dimension)
XDMF_CELLS = {4: (3, 2), 5: (4, 2), 6: (4, 3), 9: (8, 3)}
XDMF_CELLS |= {36: (6, 2), 37: (8, 2), 35: (9, 2), 38: (10, 3), 48: (20, 3), 50: (27, 3)}
XDMF_CELLS |= {7: (5, 3), 8: (6, 3), 39: (13, 3), 40: (15, 3), 41: (18, 3)}
#: the same for points and lines; after a type below SIZED, the list has the number of nodes before the nodes
XDMF_EDGES = {1: (1, 0), 2: (2, 1), 34: (3, 1)}
SIZED = 3
#: number of nodes of a solid cell -> number of its corners, but for hexahedra
N_CORNERS = {4: 4, 10: 4, 5: 5, 13: 5, 6: 6, 15: 6, 18: 6}


def cells_of_mixed(
    file: Hdf5Input, flat: IntArray, known: Mapping[int, tuple[int, int]]
) -> tuple[list[IntArray], list[int]]:
    """Returns the nodes of each cell of XDMF's mixed list, and the dimension of each cell.

    `flat` is the list: for each cell the number of its type, of points and lines then the number of nodes, then the
    nodes from 0. `known` are the types that may occur: number -> (number of nodes, dimension). InputError, about
    `file`, for another type, or if the list ends too early.
    """
    cells, dimensions, start = [], [], 0
    while start < len(flat):
        kind = int(flat[start])
        n_nodes, dimension = known.get(kind, (0, 0))
        if n_nodes == 0:
            raise file.fail(f"'/mesh/topology' has the cell type {kind}; known are {sorted(known)}")
        first = start + (2 if kind < SIZED else 1)
        if first + n_nodes > len(flat):
            raise file.fail("'/mesh/topology' ends within a cell")
        cells.append(flat[first : first + n_nodes])
        dimensions.append(dimension)
        start = first + n_nodes
    return cells, dimensions


def drawn_nodes(nodes: IntArray, n_dim: int) -> IntArray:
    """Returns the nodes of a cell for pictures: along a line, around a plane cell, the corners of a solid cell.

    `nodes` are in gmsh's order, and `n_dim` is the dimension of the cell. Around a quadratic plane cell come middles of
    sides and corners in turn, beginning with the middle of the first side, without a node inside.
    """
    if n_dim == 3:
        return nodes[: N_CORNERS.get(len(nodes), 8)]
    if n_dim < 2:
        return nodes[[0, 2, 1]] if len(nodes) == 3 else nodes
    if len(nodes) <= 4:
        return nodes
    # corners and middles of sides in turn, beginning with the middle of the first side
    n_corners = 3 if len(nodes) == 6 else 4
    return np.column_stack([nodes[n_corners : 2 * n_corners], np.roll(nodes[:n_corners], -1)]).ravel()
