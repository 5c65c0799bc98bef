# SPDX-License-Identifier: BSD-3-Clause
"""Resultants of loads for pictures: arrows of facets, because forces of single nodes mislead.

Nodal forces that stand for a pressure alternate on quadratic facets, and on a facet that a window cuts one of them
points against the load.
"""

from dataclasses import dataclass

import numpy as np

from signorom_post.arrays import BoolArray, FloatArray, IntArray
from signorom_post.readers.check import BODY, BOUNDARY, CheckFile

#: a force below this share of the largest force is taken as a rounding error
NEGLIGIBLE = 1e-9


@dataclass(frozen=True)
class Arrows:
    """Vectors with the places where they act; all arrays have the shape (n, 3)."""

    places: FloatArray
    vectors: FloatArray
    #: outward normals, not of unit length; zero inside of the bodies
    outward: FloatArray


def nodal_arrows(check: CheckFile, name: str, outward: FloatArray) -> Arrows:
    """Returns the vectors of the field `name` at the nodes where they are not zero.

    `outward`, shape (n_nodes, 3), are outward normals at the nodes, zero at nodes inside of the bodies.
    """
    nodes = np.flatnonzero(_is_loaded(check[name]))
    return Arrows(check.mesh.coordinates[nodes], check[name][nodes], outward[nodes])


def load_arrows(check: CheckFile, outward: FloatArray) -> Arrows:
    """Returns the forces of the loads on facets; their sum is that of the nodal forces.

    A node's force is divided among the facets around it that have loads at all their nodes, in proportion to their
    sizes. What no facet takes is divided in this way among cells, and the rest stays at its nodes, as the force of a
    point. `outward` is that of `nodal_arrows`.
    """
    loads, points = check["load"], check.mesh.coordinates
    is_loaded = _is_loaded(loads)
    is_left = is_loaded.copy()
    places, vectors, normals = [], [], []
    for kind in (BOUNDARY, BODY):
        found = [cell for cell in _distinct(check.of(kind)) if len(cell) > 1]
        cells = [cell for cell in found if is_loaded[cell].all() and is_left[cell].any()]
        for cell, share in zip(cells, _shares(check, cells, is_left), strict=True):
            places.append(points[cell].mean(axis=0))
            vectors.append(share @ loads[cell])
            normals.append(outward[cell].sum(axis=0) if kind == BOUNDARY else np.zeros(3))
        is_left[np.concatenate([*cells, np.empty(0, dtype=np.int64)])] = False
    nodes = np.flatnonzero(is_left)
    return Arrows(
        np.vstack([*places, points[nodes]]),
        np.vstack([*vectors, loads[nodes]]),
        np.vstack([*normals, outward[nodes]]),
    )


def _is_loaded(vectors: FloatArray) -> BoolArray:
    sizes = np.linalg.norm(vectors, axis=1)
    return sizes > NEGLIGIBLE * sizes.max(initial=0.0)


def _distinct(cells: list[IntArray]) -> list[IntArray]:
    """Returns the cells without those that have the nodes of an earlier one, as where two boundaries have one facet."""
    return list({tuple(sorted(cell)): cell for cell in reversed(cells)}.values())[::-1]


def _shares(check: CheckFile, cells: list[IntArray], is_left: BoolArray) -> list[FloatArray]:
    """Returns, for each cell, the share that it has in each of its nodes: its size over that of all cells there.

    The share is zero at nodes that are not left.
    """
    sizes = [_size(check.mesh.coordinates[cell], check.mesh.n_dim) for cell in cells]
    around = np.zeros(check.mesh.n_nodes)
    for cell, size in zip(cells, sizes, strict=True):
        around[cell] += size
    return [size * is_left[cell] / around[cell] for cell, size in zip(cells, sizes, strict=True)]


def _size(corners: FloatArray, n_dim: int) -> float:
    """Returns the area of a facet in space; else the length of the way along the corners, also of a cell in the plane.

    `corners`, shape (n, 3), are the places of the nodes along or around it.
    """
    if n_dim == 2 or len(corners) == 2:
        return float(np.linalg.norm(np.diff(corners, axis=0), axis=1).sum())
    around = corners - corners[0]
    return 0.5 * float(np.linalg.norm(np.cross(around, np.roll(around, -1, axis=0)).sum(axis=0)))
