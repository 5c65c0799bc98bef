# SPDX-License-Identifier: BSD-3-Clause
"""Lines of facets in the plane: in which order their nodes follow, and where each stands along them."""

from itertools import pairwise

import numpy as np

from signorom_post.arrays import FloatArray, IntArray, with_unit

#: a coordinate is the position along lines if it covers at least this share of their length
SHARE = 0.5
#: room between two lines on an axis of lengths, as a share of the whole length
ROOM = 0.05


def chains_of(facets: list[IntArray], points: FloatArray) -> list[IntArray]:
    """Returns the nodes of each connected line of facets, one after the other; a closed line ends where it begins.

    `facets` have the nodes along each facet. A line begins at the end with the lower coordinate along which all nodes
    are longest; `points`, shape (n_nodes, 3).
    """
    neighbors: dict[int, list[int]] = {}
    for facet in facets:
        for a, b in pairwise(facet):
            neighbors.setdefault(int(a), []).append(int(b))
            neighbors.setdefault(int(b), []).append(int(a))
    axis = _longest(points, np.array(list(neighbors)))
    ends = sorted(neighbors, key=lambda node: (len(neighbors[node]) % 2 == 0, points[node, axis], node))
    chains = []
    for end in ends:
        while neighbors[end]:
            chain = [end]
            while neighbors[chain[-1]]:
                there = neighbors[chain[-1]].pop(0)
                neighbors[there].remove(chain[-1])
                chain.append(there)
            chains.append(np.array(chain))
    return chains


def positions_along(
    chains: list[IntArray], points: FloatArray, names: tuple[str, str], unit: str
) -> tuple[list[FloatArray], str]:
    """Returns the position of each node of each line, and the label of the axis that says what it is.

    It is the coordinate along which the lines are longest, if each position then belongs to one place; else the length
    along the lines, one after the other. `points`, shape (n_nodes, 3), are in `unit`; `names` are those of the axes.
    """
    axis = _longest(points, np.concatenate(chains))
    places = [points[chain, axis] for chain in chains]
    lengths = [_lengths(points[chain]) for chain in chains]
    total = sum(length[-1] for length in lengths)
    if _is_clear(places) and sum(np.ptp(place) for place in places) >= SHARE * total:
        return places, with_unit(f"position on the contact surface, ${names[axis]}$", unit)
    starts = np.cumsum([0.0] + [length[-1] + ROOM * total for length in lengths[:-1]])
    shifted = [start + length for start, length in zip(starts, lengths, strict=True)]
    return shifted, with_unit("length along the contact surface", unit)


def _longest(points: FloatArray, nodes: IntArray) -> int:
    return int(np.argmax(np.ptp(points[nodes, :2], axis=0)))


def _lengths(points: FloatArray) -> FloatArray:
    """Returns the length of the line from its begin to each of its points."""
    return np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))


def _is_clear(places: list[FloatArray]) -> bool:
    """Returns whether the coordinate ascends along each line and no two lines overlap."""
    if not all((np.diff(place) > 0.0).all() for place in places):
        return False
    ends = sorted((place[0], place[-1]) for place in places)
    return all(first[1] <= second[0] for first, second in pairwise(ends))
