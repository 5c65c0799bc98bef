# SPDX-License-Identifier: BSD-3-Clause
"""The cells of a converted mesh, the bodies that they form, and their outer faces."""

from dataclasses import dataclass

import numpy as np

from signorom_post.arrays import BoolArray, FloatArray, IntArray
from signorom_post.convert.elements import BY_NAME, KINDS, Kind
from signorom_post.convert.source import Elements, Source
from signorom_post.errors import InputError

MAX_FACE_NODES = 9
#: [-] a plane mesh may leave its plane by this share of its size
FLAT = 1e-6
#: [degrees] faces whose normals differ by less belong to one side of a body
SMOOTH = 40.0
#: degenerate linear cells: kind, groups of nodes that are one -> kind and the nodes that it keeps
COLLAPSED = [
    ("H8", ((2, 3), (4, 5), (5, 6), (6, 7)), "T4", (0, 1, 2, 4)),
    ("H8", ((4, 5), (5, 6), (6, 7)), "P5", (0, 1, 2, 3, 4)),
    ("H8", ((2, 3), (6, 7)), "W6", (0, 1, 2, 4, 5, 6)),
    ("H8", ((0, 1), (4, 5)), "W6", (0, 2, 3, 4, 6, 7)),
    ("H8", ((1, 2), (5, 6)), "W6", (0, 1, 3, 4, 5, 7)),
    ("H8", ((0, 3), (4, 7)), "W6", (0, 1, 2, 4, 5, 6)),
    ("W6", ((3, 4), (4, 5)), "T4", (0, 1, 2, 3)),
    ("Q4", ((2, 3),), "T3", (0, 1, 2)),
    ("Q4", ((0, 1),), "T3", (0, 2, 3)),
    ("Q4", ((1, 2),), "T3", (0, 1, 3)),
    ("Q4", ((0, 3),), "T3", (0, 1, 2)),
]


@dataclass
class Cells:
    """Cells of the largest dimension, their volumes positive."""

    #: 2 or 3
    n_dim: int
    #: [unit of the file] shape (n_nodes, 3)
    coordinates: FloatArray
    #: kind of each cell, as an index of KINDS; shape (n_cells)
    kinds: IntArray
    #: nodes of each cell, from 0, filled up with -1; shape (n_cells, 27)
    nodes: IntArray
    #: number of the element in the source; shape (n_cells)
    element: IntArray
    #: node of the source that each node is, or was before bodies were split; shape (n_nodes)
    origin: IntArray
    #: number of cells that were mirrored in the file
    n_mirrored: int = 0
    #: number of cells that had nodes twice and have become simpler ones
    n_collapsed: int = 0

    @property
    def n_cells(self) -> int:
        """Number of cells."""
        return len(self.kinds)

    def blocks(self) -> list[tuple[Kind, IntArray]]:
        """Returns each kind that there is with the numbers of its cells."""
        return [(KINDS[i], np.flatnonzero(self.kinds == i)) for i in np.unique(self.kinds)]

    def used_nodes(self) -> BoolArray:
        """Whether each node belongs to a cell; shape (n_nodes)."""
        used = np.zeros(len(self.coordinates), dtype=bool)
        used[self.nodes[self.nodes >= 0]] = True
        return used

    def bodies(self) -> IntArray:
        """Returns the body of each cell, from 0: cells that share a node belong to one body. Shape (n_cells)."""
        nodes = np.where(self.nodes >= 0, self.nodes, self.nodes[:, :1])
        label = components(len(self.coordinates), nodes)
        return np.unique(label[nodes[:, 0]], return_inverse=True)[1].reshape(-1)


def components(n: int, joined: IntArray) -> IntArray:
    """Returns for each of n things the lowest one connected with it; each row of `joined` connects its things."""
    label = np.arange(n)
    while True:
        lowest = label[joined].min(axis=1)
        new = label.copy()
        np.minimum.at(new, joined, lowest[:, None])
        new = new[new]
        if np.array_equal(new, label):
            return label
        label = new


def find_cells(source: Source) -> Cells:
    """Returns the elements of the largest dimension as cells.

    InputError: there are no elements of dimension 2 or 3; plane ones that do not lie in a plane z = constant.
    """
    n_dim = max((elements.kind.n_dim for elements in source.elements if len(elements.nodes)), default=0)
    if n_dim < 2:
        found = [f"{elements.label}: {len(elements.nodes)}" for elements in source.elements] + list(
            source.left_out
        )
        what = f" (it has {', '.join(dict.fromkeys(found))[:200]})" if found else ""
        raise InputError(source.path, f"the file has no solid or plane elements that can become a body{what}")
    start, parts = 0, []
    n_mirrored = n_collapsed = 0
    for elements in source.elements:
        if elements.kind.n_dim == n_dim:
            numbers = np.arange(start, start + len(elements.nodes))
            for kind, nodes, which in _without_repeats(elements):
                nodes, n = _turned(kind, nodes, source.coordinates)
                n_mirrored += n
                n_collapsed += len(which) if kind is not elements.kind else 0
                parts.append((kind, nodes, numbers[which]))
        start += len(elements.nodes)
    nodes = np.vstack([_filled(nodes, 27) for _, nodes, _ in parts])
    kinds = np.concatenate([np.full(len(nodes), KINDS.index(kind)) for kind, nodes, _ in parts])
    element = np.concatenate([which for _, _, which in parts])
    order = np.argsort(element, kind="stable")
    cells = Cells(
        n_dim,
        source.coordinates,
        kinds[order],
        nodes[order],
        element[order],
        np.arange(len(source.coordinates)),
        n_mirrored,
        n_collapsed,
    )
    _check_places(cells, source)
    return cells


def _check_places(cells: Cells, source: Source) -> None:
    used = source.coordinates[cells.used_nodes()]
    if not np.isfinite(used).all():
        raise InputError(source.path, "a node of a cell has a coordinate that is not finite")
    spread = np.ptp(used, axis=0)
    if cells.n_dim == 2 and spread[2] > FLAT * spread.max():
        raise InputError(
            source.path,
            "the file has no solid elements, and its plane elements or shells are not in a plane z = constant "
            f"(z {used[:, 2].min():.6g} to {used[:, 2].max():.6g}): shells cannot become bodies",
        )


def _filled(nodes: IntArray, n: int) -> IntArray:
    """Returns the rows filled up with -1 to n columns."""
    full = np.full((len(nodes), n), -1, dtype=np.int64)
    full[:, : nodes.shape[1]] = nodes
    return full


def _without_repeats(elements: Elements) -> list[tuple[Kind, IntArray, IntArray]]:
    """Returns kind, nodes and rows of the elements: those that have nodes twice as the simpler kind that they are."""
    left = np.arange(len(elements.nodes))
    found = []
    for name, pairs, simpler, kept in COLLAPSED:
        if elements.kind.name != name:
            continue
        nodes = elements.nodes[left]
        is_one = np.all([nodes[:, i] == nodes[:, j] for i, j in pairs], axis=0)
        if is_one.any():
            found.append((BY_NAME[simpler], nodes[is_one][:, list(kept)], left[is_one]))
            left = left[~is_one]
    return [(elements.kind, elements.nodes[left], left), *found]


def _turned(kind: Kind, nodes: IntArray, coordinates: FloatArray) -> tuple[IntArray, int]:
    """Returns the nodes of elements, in another order where the volume was negative, and the number of these."""
    is_negative = kind.volumes(coordinates[nodes]) < 0
    nodes = nodes.copy()
    nodes[is_negative] = nodes[is_negative][:, kind.mirrored]
    return nodes, int(is_negative.sum())


@dataclass
class Faces:
    """The outer faces of the cells (edges in the plane)."""

    #: index of KINDS; shape (n_faces)
    kinds: IntArray
    #: nodes, filled up with -1; shape (n_faces, 9)
    nodes: IntArray
    #: shape (n_faces)
    cell: IntArray

    @property
    def n_faces(self) -> int:
        """Number of faces."""
        return len(self.kinds)

    def all_nodes_in(self, inside: BoolArray) -> IntArray:
        """Returns the faces all of whose nodes are inside (shape of `inside`: number of nodes)."""
        return np.flatnonzero((inside[self.nodes] | (self.nodes < 0)).all(axis=1))

    def any_node_in(self, inside: BoolArray) -> IntArray:
        """Returns the faces that have a node inside (shape of `inside`: number of nodes)."""
        return np.flatnonzero((inside[self.nodes] & (self.nodes >= 0)).any(axis=1))


def corner_key(nodes: IntArray, n_corners: int) -> IntArray:
    """Returns the corners of faces in ascending order, with -1 in front for missing ones; shape (n, 4)."""
    key = np.full((len(nodes), 4), -1, dtype=np.int64)
    key[:, 4 - n_corners :] = np.sort(nodes[:, :n_corners], axis=1)
    return key


def outer_faces(cells: Cells) -> Faces:
    """Returns the faces that belong to one cell only."""
    kinds, nodes, owner, keys = [], [], [], []
    for kind, which in cells.blocks():
        for side, places in kind.sides:
            of_side = cells.nodes[which][:, places]
            kinds.append(np.full(len(which), KINDS.index(side)))
            nodes.append(_filled(of_side, MAX_FACE_NODES))
            owner.append(which)
            keys.append(corner_key(of_side, side.n_corners))
    _, index, counts = np.unique(np.vstack(keys), axis=0, return_index=True, return_counts=True)
    outer = np.sort(index[counts == 1])
    cell = np.concatenate(owner)[outer]
    order = np.argsort(cell, kind="stable")
    outer = outer[order]
    return Faces(np.concatenate(kinds)[outer], np.vstack(nodes)[outer], cell[order])


def smooth_pieces(faces: Faces, coordinates: FloatArray) -> IntArray:
    """Returns for each face the lowest face of its piece: pieces end at edges where normals differ by 40 degrees."""
    normals = np.zeros((faces.n_faces, 3))
    edges, owner = [], []
    for i_kind in np.unique(faces.kinds):
        kind, which = KINDS[i_kind], np.flatnonzero(faces.kinds == i_kind)
        corners = faces.nodes[which, : kind.n_corners]
        normals[which] = _unit_normals(coordinates[corners])
        for side, places in kind.sides:
            edges.append(corner_key(corners[:, places[: side.n_corners]], side.n_corners))
            owner.append(which)
    edges, owner = np.vstack(edges), np.concatenate(owner)
    order = np.lexsort(edges.T)
    is_same = (edges[order[1:]] == edges[order[:-1]]).all(axis=1)
    # an edge of exactly two faces
    is_pair = is_same & ~np.append(is_same[1:], False) & ~np.append(False, is_same[:-1])
    first, second = owner[order[:-1][is_pair]], owner[order[1:][is_pair]]
    is_smooth = np.einsum("ni,ni->n", normals[first], normals[second]) > np.cos(np.radians(SMOOTH))
    return components(faces.n_faces, np.column_stack([first, second])[is_smooth])


def _unit_normals(corners: FloatArray) -> FloatArray:
    """Returns the outward unit normals of faces, or of edges in the plane; zero for faces without area."""
    if corners.shape[1] == 2:
        along = corners[:, 1] - corners[:, 0]
        normals = np.column_stack([along[:, 1], -along[:, 0], np.zeros(len(along))])
    else:
        from_first = corners - corners[:, :1]
        normals = np.cross(from_first[:, 1:-1], from_first[:, 2:]).sum(axis=1)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0)
