# SPDX-License-Identifier: BSD-3-Clause
"""The kinds of elements: gmsh's numbers, where their nodes are, their faces, and the node orders of other programs.

A node is named by the corners in whose middle it is, counted from 0: `3` is a corner, `03` the middle of an edge,
`0123` the middle of a face. The order of a kind's nodes is such names in a row.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from signorom_post.arrays import FloatArray, IntArray

TRIANGLE = ("01", "12", "20")
QUADRILATERAL = ("01", "12", "23", "30")
#: name of a shape -> its sides, whose corners are counterclockwise for a viewer outside; an edge of a plane shape has
#: the shape on its left
SIDES = {
    "point": (),
    "line": ("0", "1"),
    "triangle": TRIANGLE,
    "quadrilateral": QUADRILATERAL,
    "tetrahedron": ("021", "013", "123", "032"),
    "pyramid": ("0321", "014", "124", "234", "304"),
    "prism": ("021", "345", "0143", "1254", "2035"),
    "hexahedron": ("0321", "4567", "0154", "1265", "2376", "3047"),
}
N_CORNERS = {
    "point": 1,
    "line": 2,
    "triangle": 3,
    "quadrilateral": 4,
    "tetrahedron": 4,
    "pyramid": 5,
    "prism": 6,
    "hexahedron": 8,
}
DIMENSION = {"point": 0, "line": 1, "triangle": 2, "quadrilateral": 2}
#: the corners of the mirrored shape
MIRRORED = {
    "triangle": "021",
    "quadrilateral": "0321",
    "tetrahedron": "0213",
    "pyramid": "03214",
    "prism": "021354",
    "hexahedron": "03214765",
}


def _key(name: str) -> str:
    """Returns the name of a node with its corners in ascending order."""
    return "".join(sorted(name))


@dataclass(frozen=True)
class Kind:
    """A kind of element; its nodes are in gmsh's order."""

    name: str
    shape: str
    gmsh: int
    #: names of the nodes behind the corners
    middles: str = ""

    @cached_property
    def nodes(self) -> list[str]:
        """Names of all nodes."""
        corners = [str(i) for i in range(N_CORNERS[self.shape])]
        return corners + [_key(name) for name in self.middles.split()]

    @property
    def n_nodes(self) -> int:
        """Number of nodes."""
        return len(self.nodes)

    @property
    def n_corners(self) -> int:
        """Number of corners, which are the first nodes."""
        return N_CORNERS[self.shape]

    @property
    def n_dim(self) -> int:
        """Dimension: 0 to 3."""
        return DIMENSION.get(self.shape, 3)

    @cached_property
    def sides(self) -> list[tuple["Kind", IntArray]]:
        """Kind and nodes of each side, which looks outward; the nodes count from 0 in the element."""
        found = []
        for side in SIDES[self.shape]:
            places = [i for i, name in enumerate(self.nodes) if set(name) <= set(side)]
            names = ["".join(str(side.index(corner)) for corner in self.nodes[i]) for i in places]
            kind = kind_of(self.n_dim - 1, len(places))
            found.append((kind, np.array(places)[kind.order_from([_key(name) for name in names])]))
        return found

    @cached_property
    def mirrored(self) -> IntArray:
        """The nodes of the mirrored element, which turns an element of negative volume."""
        renamed = [_key("".join(MIRRORED[self.shape][int(i)] for i in name)) for name in self.nodes]
        return self.order_from(renamed)

    def order_from(self, names: list[str]) -> IntArray:
        """Returns where each of the kind's nodes stands in a list of names of its nodes."""
        return np.array([names.index(name) for name in self.nodes], dtype=np.int64)

    def volumes(self, places: FloatArray) -> FloatArray:
        """Returns the volume (in the plane the area) of elements by their corners, negative where they are mirrored.

        `places` has the shape (n, n_nodes, 3). The formula is Gauss's theorem; curved sides count as those of the
        corners.
        """
        from_middle = places - places[:, : self.n_corners].mean(axis=1, keepdims=True)
        total = np.zeros(len(places))
        for side in SIDES[self.shape]:
            corners = from_middle[:, [int(i) for i in side]]
            if self.n_dim == 2:
                total += _cross(corners) / 2
                continue
            for i in range(1, len(side) - 1):
                normal = np.cross(corners[:, i], corners[:, i + 1])
                total += np.einsum("ni,ni->n", corners[:, 0], normal) / 6
        return total


def _cross(ends: FloatArray) -> FloatArray:
    """Returns the cross product of the two points of each plane edge."""
    return ends[:, 0, 0] * ends[:, 1, 1] - ends[:, 0, 1] * ends[:, 1, 0]


HEXAHEDRON_EDGES = "01 03 04 12 15 23 26 37 45 47 56 67"
KINDS = [
    Kind("point", "point", 15),
    Kind("L2", "line", 1),
    Kind("L3", "line", 8, "01"),
    Kind("T3", "triangle", 2),
    Kind("T6", "triangle", 9, "01 12 02"),
    Kind("Q4", "quadrilateral", 3),
    Kind("Q8", "quadrilateral", 16, "01 12 23 03"),
    Kind("Q9", "quadrilateral", 10, "01 12 23 03 0123"),
    Kind("T4", "tetrahedron", 4),
    Kind("T10", "tetrahedron", 11, "01 12 02 03 23 13"),
    Kind("P5", "pyramid", 7),
    Kind("P13", "pyramid", 19, "01 03 04 12 14 23 24 34"),
    Kind("P14", "pyramid", 14, "01 03 04 12 14 23 24 34 0123"),
    Kind("W6", "prism", 6),
    Kind("W15", "prism", 18, "01 02 03 12 14 25 34 35 45"),
    Kind("W18", "prism", 13, "01 02 03 12 14 25 34 35 45 0143 0253 1254"),
    Kind("H8", "hexahedron", 5),
    Kind("H20", "hexahedron", 17, HEXAHEDRON_EDGES),
    Kind("H27", "hexahedron", 12, f"{HEXAHEDRON_EDGES} 0123 0145 0347 1256 2367 4567 01234567"),
]
BY_NAME = {kind.name: kind for kind in KINDS}


def kind_of(n_dim: int, n_nodes: int) -> Kind:
    """Returns the kind of this dimension and number of nodes; KeyError if there is none."""
    for kind in KINDS:
        if kind.n_dim == n_dim and kind.n_nodes == n_nodes:
            return kind
    raise KeyError(n_dim, n_nodes)


#: the nodes behind the corners in the order of VTK, Abaqus, CalculiX, MED and meshio
VTK_MIDDLES = {
    "L3": "01",
    "T6": "01 12 02",
    "Q8": "01 12 23 03",
    "Q9": "01 12 23 03 0123",
    "T10": "01 12 02 03 13 23",
    "P13": "01 12 23 03 04 14 24 34",
    "P14": "01 12 23 03 04 14 24 34 0123",
    "W15": "01 12 02 34 45 35 03 14 25",
    "W18": "01 12 02 34 45 35 03 14 25 0134 1245 0235",
    "H20": "01 12 23 03 45 56 67 47 04 15 26 37",
    "H27": "01 12 23 03 45 56 67 47 04 15 26 37 0347 1256 0145 2367 0123 4567 01234567",
}
#: the same in the order of Nastran
NASTRAN_MIDDLES = VTK_MIDDLES | {
    "W15": "01 12 02 03 14 25 34 45 35",
    "H20": "01 12 23 03 04 15 26 37 45 56 67 47",
}
#: all nodes in the order of the universal file (UNV), which goes around each face
UNV_NODES = {
    "L3": "0 01 1",
    "T6": "0 01 1 12 2 02",
    "Q8": "0 01 1 12 2 23 3 03",
    "T10": "0 01 1 12 2 02 03 13 23 3",
    "W15": "0 01 1 12 2 02 03 14 25 3 34 4 45 5 35",
    "H20": "0 01 1 12 2 23 3 03 04 15 26 37 4 45 5 56 6 67 7 47",
}


def from_middles(kind: Kind, middles: dict[str, str]) -> IntArray:
    """Returns where gmsh's nodes of a kind stand in another program's order, corners first, then `middles[name]`."""
    return kind.order_from(kind.nodes[: kind.n_corners] + middles.get(kind.name, "").split())


def from_unv(kind: Kind) -> IntArray:
    """Returns where gmsh's nodes of a kind stand in the order of the universal file."""
    return kind.order_from(UNV_NODES.get(kind.name, " ".join(kind.nodes)).split())
