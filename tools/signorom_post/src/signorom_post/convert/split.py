# SPDX-License-Identifier: BSD-3-Clause
"""Gives two regions that share nodes nodes of their own, so that they may come into contact."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from signorom_post.arrays import BoolArray, IntArray
from signorom_post.convert.cells import Cells
from signorom_post.errors import InputError


@dataclass
class Seam:
    """Where two regions were split."""

    #: the two names, for messages
    regions: str
    #: nodes of the source that both sides had, ascending
    nodes: IntArray
    #: for each side, the name of its new boundary and its cells
    sides: list[tuple[str, IntArray]]
    #: about a third region, or empty
    remark: str


def split(cells: Cells, regions: dict[str, IntArray], first: str, second: str, path: Path) -> Seam:
    """Gives the cells of the second region copies of the nodes that they share with the first one.

    Cells of a third region keep the nodes of the first one. InputError: a region that is not there, regions with a
    common cell, or without a common node.
    """
    for name in (first, second):
        if name not in regions:
            raise InputError(
                path, f"--split: there is no region '{name}'; the regions are: {', '.join(regions)}"
            )
    if len(np.intersect1d(regions[first], regions[second])):
        raise InputError(path, f"--split: the regions '{first}' and '{second}' have cells in common")
    shared = _of(cells, regions[first]) & _of(cells, regions[second])
    if not shared.any():
        raise InputError(
            path, f"--split: the regions '{first}' and '{second}' share no nodes: they are separate bodies"
        )
    others = np.setdiff1d(np.arange(cells.n_cells), np.concatenate([regions[first], regions[second]]))
    n_held = int((_of(cells, others) & shared).sum())
    remark = f"; a third region has {n_held} of them, too, and stays with {first} there" if n_held else ""
    nodes = np.unique(cells.origin[shared])
    _copy_nodes(cells, regions[second], np.flatnonzero(shared))
    sides = [(f"{first}_to_{second}", regions[first]), (f"{second}_to_{first}", regions[second])]
    return Seam(f"{first} and {second}", nodes, sides, remark)


def _of(cells: Cells, which: IntArray) -> BoolArray:
    """Whether each node belongs to one of these cells."""
    has = np.zeros(len(cells.coordinates), dtype=bool)
    nodes = cells.nodes[which]
    has[nodes[nodes >= 0]] = True
    return has


def _copy_nodes(cells: Cells, which: IntArray, shared: IntArray) -> None:
    """Gives some cells copies of the shared nodes."""
    new = np.arange(len(cells.coordinates) + 1)
    new[-1] = -1  # of places that are filled up
    new[shared] = len(cells.coordinates) + np.arange(len(shared))
    cells.nodes[which] = new[cells.nodes[which]]
    cells.coordinates = np.vstack([cells.coordinates, cells.coordinates[shared]])
    cells.origin = np.concatenate([cells.origin, cells.origin[shared]])
