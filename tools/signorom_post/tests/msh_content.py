# SPDX-License-Identifier: BSD-3-Clause
"""Reads the .msh (4.1 ASCII) that `convert` writes, as far as the tests need it."""

from collections import defaultdict
from pathlib import Path

import numpy as np

N_NODES = {
    15: 1,
    1: 2,
    8: 3,
    2: 3,
    9: 6,
    3: 4,
    16: 8,
    10: 9,
    4: 4,
    11: 10,
    7: 5,
    19: 13,
    14: 14,
    6: 6,
    18: 15,
}
N_NODES |= {13: 18, 5: 8, 17: 20, 12: 27}


class Msh:
    """Places of the nodes, shape (n, 3), and for each (dimension, name) its elements: (gmsh's type, nodes from 0)."""

    def __init__(self, path: Path) -> None:
        lines = path.read_text().split("\n")
        names = {}
        start = lines.index("$PhysicalNames") + 1
        for line in lines[start + 1 : start + 1 + int(lines[start])]:
            n_dim, number, name = line.split(" ", 2)
            names[int(number)] = (int(n_dim), name.strip('"'))
        groups = {}
        at = lines.index("$Entities") + 1
        counts = [int(word) for word in lines[at].split()]
        for n_dim, count in enumerate(counts):
            for _ in range(count):
                at += 1
                words = lines[at].split()
                first = 5 if n_dim == 0 else 8
                groups[n_dim, int(words[0])] = [
                    names[int(word)] for word in words[first : first + int(words[first - 1])]
                ]
        at = lines.index("$Nodes")
        n_nodes = int(lines[at + 1].split()[1])
        self.places = np.array(
            [
                [float(word) for word in line.split()]
                for line in lines[at + 3 + n_nodes : at + 3 + 2 * n_nodes]
            ]
        )
        self.groups: dict[tuple[int, str], list[tuple[int, list[int]]]] = defaultdict(list)
        at = lines.index("$Elements") + 2
        while lines[at] != "$EndElements":
            n_dim, tag, kind, count = map(int, lines[at].split())
            for line in lines[at + 1 : at + 1 + count]:
                nodes = [int(word) - 1 for word in line.split()[1:]]
                assert len(nodes) == N_NODES[kind]
                for group in groups[n_dim, tag]:
                    self.groups[group].append((kind, nodes))
            at += 1 + count

    def names(self, n_dim: int) -> list[str]:
        """Names of the groups of a dimension, in alphabetical order, without the sides in no set."""
        return sorted(name for dimension, name in self.groups if dimension == n_dim and "_side_" not in name)

    def sides(self, n_dim: int) -> list[str]:
        """Names of the sides in no set, in the order of the file."""
        return [name for dimension, name in self.groups if dimension == n_dim and "_side_" in name]

    def box(self, n_dim: int, name: str) -> list[list[float]]:
        """Least and largest coordinates of a group."""
        nodes = [node for _, nodes in self.groups[n_dim, name] for node in nodes]
        return [self.places[nodes].min(axis=0).tolist(), self.places[nodes].max(axis=0).tolist()]

    def n_elements(self, n_dim: int, name: str) -> int:
        """Number of elements of a group."""
        return len(self.groups[n_dim, name])
