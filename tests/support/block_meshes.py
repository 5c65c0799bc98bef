# SPDX-License-Identifier: BSD-3-Clause
"""Two stacked blocks of any element type, written as gmsh 2.2 ASCII: the meshes of the patch tests."""

import itertools

import numpy as np

GMSH_TYPES = {"P1": 15, "L2": 1, "T3": 2, "Q4": 3, "T4": 4, "H8": 5}
GMSH_TYPES |= {"W6": 6, "P5": 7, "W15": 18, "W18": 13, "P13": 19, "P14": 14}
GMSH_TYPES |= {"L3": 8, "T6": 9, "Q8": 16, "Q9": 10, "T10": 11, "H20": 17, "H27": 12}
DIMENSIONS = {"P1": 0, "L2": 1, "L3": 1, "T3": 2, "Q4": 2, "T6": 2, "Q8": 2, "Q9": 2}
DIMENSIONS |= dict.fromkeys(("T4", "H8", "T10", "H20", "H27", "W6", "W15", "W18", "P5", "P13", "P14"), 3)
# Corners (0-based) in whose middle the further nodes sit, in gmsh's order.
MIDDLES = {"L3": [(0, 1)], "T6": [(0, 1), (1, 2), (0, 2)], "Q8": [(0, 1), (1, 2), (2, 3), (0, 3)]}
MIDDLES["Q9"] = [*MIDDLES["Q8"], (0, 1, 2, 3)]
MIDDLES["T10"] = [(0, 1), (1, 2), (0, 2), (0, 3), (2, 3), (1, 3)]
MIDDLES["H20"] = [
    (0, 1),
    (0, 3),
    (0, 4),
    (1, 2),
    (1, 5),
    (2, 3),
    (2, 6),
    (3, 7),
    (4, 5),
    (4, 7),
    (5, 6),
    (6, 7),
]
FACES = [(0, 1, 2, 3), (0, 1, 4, 5), (0, 3, 4, 7), (1, 2, 5, 6), (2, 3, 6, 7), (4, 5, 6, 7)]
MIDDLES["H27"] = [*MIDDLES["H20"], *FACES, tuple(range(8))]
MIDDLES["W15"] = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 4), (2, 5), (3, 4), (3, 5), (4, 5)]
MIDDLES["W18"] = [*MIDDLES["W15"], (0, 1, 3, 4), (0, 2, 3, 5), (1, 2, 4, 5)]
MIDDLES["P13"] = [(0, 1), (0, 3), (0, 4), (1, 2), (1, 4), (2, 3), (2, 4), (3, 4)]
MIDDLES["P14"] = [*MIDDLES["P13"], (0, 1, 2, 3)]
# All solid elements in one block, by their numbers of nodes.
SOLIDS, SOLIDS_WITHOUT, SOLIDS_WITH = "T4 P5 W6 H8", "T10 P13 W15 H20", "T10 P14 W18 H27"
# By the element that fills the mesh: what its linear elements become.
QUADRATIC = {
    "T6": {"L2": "L3", "T3": "T6"},
    "Q8": {"L2": "L3", "Q4": "Q8"},
    "Q9": {"L2": "L3", "Q4": "Q9"},
    "T6 and Q8": {"L2": "L3", "T3": "T6", "Q4": "Q8"},
    "T10": {"L2": "L3", "T3": "T6", "T4": "T10"},
    "H20": {"L2": "L3", "Q4": "Q8", "H8": "H20"},
    "H27": {"L2": "L3", "Q4": "Q9", "H8": "H27"},
    "W15": {"L2": "L3", "T3": "T6", "Q4": "Q8", "W6": "W15"},
    "W18": {"L2": "L3", "T3": "T6", "Q4": "Q9", "W6": "W18"},
    "P13": {"L2": "L3", "T3": "T6", "Q4": "Q8", "P5": "P13"},
    "P14": {"L2": "L3", "T3": "T6", "Q4": "Q9", "P5": "P14"},
    SOLIDS_WITHOUT: {"T3": "T6", "Q4": "Q8", "T4": "T10", "P5": "P13", "W6": "W15", "H8": "H20"},
    SOLIDS_WITH: {"T3": "T6", "Q4": "Q9", "T4": "T10", "P5": "P14", "W6": "W18", "H8": "H27"},
}
LINEAR = {"T6": "T3", "Q8": "Q4", "Q9": "Q4", "T6 and Q8": "mixed", "T10": "T4", "H20": "H8", "H27": "H8"}
LINEAR |= {"W15": "W6", "W18": "W6", "P13": "P5", "P14": "P5", SOLIDS_WITHOUT: SOLIDS, SOLIDS_WITH: SOLIDS}
# Corners of a box by their 0/1 steps, in gmsh's order.
BOX = {1: [(0,), (1,)], 2: [(0, 0), (1, 0), (1, 1), (0, 1)]}
BOX[3] = [(*corner, 0) for corner in BOX[2]] + [(*corner, 1) for corner in BOX[2]]


def simplices(n_dim):
    """Yields the corners of the simplices into which Kuhn's rule divides a box, as 0/1 steps per axis.

    There is one simplex per way along the edges from the first corner to the last; faces of neighbors match.
    """
    for order in itertools.permutations(range(n_dim)):
        corner = np.zeros(n_dim, dtype=int)
        corners = [tuple(corner)]
        for axis in order:
            corner[axis] = 1
            corners.append(tuple(corner))
        yield corners


def has_triangles(element, position, axis):
    """Whether the faces across an axis of the box at `position` are divided into triangles.

    Prisms stand upright: their triangles are below and above. Of all solids together, every other column has triangles
    below and above.
    """
    if element == SOLIDS:
        return axis == 2 and sum(position[:2]) % 2 == 1
    return element == "T4" or (element == "W6" and axis == 2)


def around_middle(element, position):
    """Yields the pyramids and tetrahedra on the faces of a box, with an apex in its middle."""
    for axis in range(3):
        for side in range(2):
            for name, corners in split("T4" if has_triangles(element, position, axis) else "H8", 2, position):
                base = [(*c[:axis], side, *c[axis:]) for c in corners]
                yield {"T3": "T4", "Q4": "P5"}[name], [*base, (0.5, 0.5, 0.5)]


def split(element, n_dim, position):
    """Yields (type, corners as 0/1 steps) of each element of the box at `position` of the grid; 0.5 is its middle.

    `element` is the linear element of the mesh, `mixed` for T3 and Q4 in turn, or SOLIDS: columns of hexahedra and of
    prisms in turn, in which every other box has pyramids and tetrahedra.
    """
    name = {"mixed": ("T3", "Q4")[sum(position) % 2]}.get(element, element)
    if name == SOLIDS and n_dim == 3:
        name = "P5" if position[2] % 2 == 1 else ("H8", "W6")[sum(position[:2]) % 2]
    if name == "P5" and n_dim == 3:
        yield from around_middle(element, position)
    elif name == "W6" and n_dim == 3:
        for corners in simplices(2):
            yield "W6", [(*corner, height) for height in (0, 1) for corner in corners]
    elif name in ("Q4", "H8") or n_dim == 1:
        yield {1: "L2", 2: "Q4", 3: "H8"}[n_dim], BOX[n_dim]
    else:
        for corners in simplices(n_dim):
            yield {2: "T3", 3: "T4"}[n_dim], corners


class Mesh:
    """Coordinates of the nodes, shape (n_nodes, 3), and elements: (type, physical name, nodes from 0)."""

    def __init__(self):
        """Makes an empty mesh."""
        self.coordinates = np.zeros((0, 3))
        self.elements = []

    def add_block(self, region, lines, element, faces, moved=0.0, seed=0):
        """Adds a box of linear elements with own nodes between grid lines, an ascending array of places per axis.

        `region` is its physical name; `faces`: (axis, side 0 or 1) -> name of a face. `moved`: inner nodes are moved at
        random (`seed`) along each axis by at most this share of the smallest step of the grid along the axis.
        """
        n_dim = len(lines)
        first, counts = len(self.coordinates), [len(line) for line in lines]
        grid = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, n_dim)
        steps = np.array([np.diff(line).min() for line in lines])
        inner = np.all(
            [(grid[:, i] > line[0]) & (grid[:, i] < line[-1]) for i, line in enumerate(lines)], axis=0
        )
        noise = np.random.default_rng(seed).uniform(-moved, moved, grid.shape)
        grid = grid + noise * steps * inner[:, None]
        self.coordinates = np.vstack([self.coordinates, np.pad(grid, ((0, 0), (0, 3 - n_dim)))])

        def number(index):
            return first + int(np.ravel_multi_index(tuple(index), counts))

        def corner_of(position, corner):
            if 0.5 not in corner:
                return number(np.add(position, corner))
            if position not in middles:
                own = [number(np.add(position, steps)) for steps in BOX[n_dim]]
                middles[position] = len(self.coordinates)
                self.coordinates = np.vstack([self.coordinates, self.coordinates[own].mean(axis=0)])
            return middles[position]

        middles = {}
        for position in np.ndindex(*(n - 1 for n in counts)):
            for name, corners in split(element, n_dim, position):
                self.elements.append((name, region, [corner_of(position, corner) for corner in corners]))
        for (axis, side), face in faces.items():
            others = [i for i in range(n_dim) if i != axis]
            for position in np.ndindex(*(counts[i] - 1 for i in others)):
                kind = "L2"
                if n_dim == 3:
                    kind = "T4" if has_triangles(element, position, axis) else "H8"
                for name, corners in split(kind, n_dim - 1, position):
                    nodes = []
                    for corner in corners:
                        index = np.full(n_dim, side * (counts[axis] - 1))
                        index[others] = np.add(position, corner)
                        nodes.append(number(index))
                    self.elements.append(({"T4": "T3", "H8": "Q4"}.get(name, name), face, nodes))

    def make_quadratic(self, element, regions=None):
        """Gives the elements the further nodes of the quadratic mesh `element`, a key of QUADRATIC.

        These are in the middle of edges, faces and cells. `regions`: only elements with these physical names.
        """
        places, numbers = list(self.coordinates), {}
        for i, (kind, name, corners) in enumerate(self.elements):
            if (regions is not None and name not in regions) or kind not in QUADRATIC[element]:
                continue
            full, nodes = QUADRATIC[element][kind], list(corners)
            for middle in MIDDLES[full]:
                key = tuple(sorted(corners[j] for j in middle))
                if key not in numbers:
                    numbers[key] = len(places)
                    places.append(self.coordinates[list(key)].mean(axis=0))
                nodes.append(numbers[key])
            self.elements[i] = (full, name, nodes)
        self.coordinates = np.array(places)

    def nodes_of(self, name):
        """Returns the nodes (from 0) of a physical name, ascending."""
        return np.unique([node for _, group, nodes in self.elements if group == name for node in nodes])

    def facets_of(self, name):
        """Returns the nodes (from 0) of each element of a physical name."""
        return [nodes for _, group, nodes in self.elements if group == name]

    def write(self, path):
        """Writes the mesh as gmsh 2.2 ASCII with all digits; nodes and elements are numbered from 1."""
        groups = sorted({(DIMENSIONS[kind], name) for kind, name, _ in self.elements})
        lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(groups))]
        lines += [f'{n_dim} {i} "{name}"' for i, (n_dim, name) in enumerate(groups, 1)]
        lines += ["$EndPhysicalNames", "$Nodes", str(len(self.coordinates))]
        lines += [f"{i} {x!r} {y!r} {z!r}" for i, (x, y, z) in enumerate(self.coordinates.tolist(), 1)]
        lines += ["$EndNodes", "$Elements", str(len(self.elements))]
        for i, (kind, name, nodes) in enumerate(self.elements, 1):
            tag = groups.index((DIMENSIONS[kind], name)) + 1
            numbers = " ".join(str(node + 1) for node in nodes)
            lines.append(f"{i} {GMSH_TYPES[kind]} 2 {tag} {tag} {numbers}")
        path.write_text("\n".join([*lines, "$EndElements", ""]))


def stacked_blocks(element, n_dim, moved=0.25):
    """Returns a mesh of two blocks, 1 wide and 1 high each, that touch at height 0 with matching, separate nodes.

    Regions are lower and upper; faces are bottom, lower_face, upper_face, top, left and, in space, front. `element` is
    a linear element, `mixed`, or a key of QUADRATIC; `moved` is that of add_block.
    """
    across = np.array([0.0, 0.3, 0.55, 1.0])
    lines = [across] if n_dim == 2 else [across, np.array([0.0, 0.4, 1.0])]
    sides = {(0, 0): "left"} if n_dim == 2 else {(0, 0): "left", (1, 0): "front"}
    up = n_dim - 1
    mesh = Mesh()
    below = {(up, 0): "bottom", (up, 1): "lower_face"} | sides
    above = {(up, 0): "upper_face", (up, 1): "top"} | sides
    heights = np.array([-1.0, -0.6, -0.2, 0.0])
    mesh.add_block("lower", [*lines, heights], LINEAR.get(element, element), below, moved, seed=1)
    mesh.add_block(
        "upper", [*lines, np.array([0.0, 0.3, 1.0])], LINEAR.get(element, element), above, moved, seed=2
    )
    if element in QUADRATIC:
        mesh.make_quadratic(element)
    return mesh


def consistent_areas(mesh, name, is_round=False):
    """Returns the integral of each node's shape function over a named surface, by a formula per facet; (n_nodes).

    `is_round`: with 2 pi r, for edges of the plane r, z. Edges then: L 2 pi (2 r_1 + r_2) / 6. Triangles and
    parallelograms: equal parts. Three nodes in a line: Simpson's rule, with 2 pi r still exact; nine nodes: the same in
    both directions. Six nodes: nothing at the corners; eight nodes: -1/12 there.
    """
    areas = np.zeros(len(mesh.coordinates))
    for nodes in mesh.facets_of(name):
        x = mesh.coordinates[nodes]
        if len(nodes) == 2:
            length = np.linalg.norm(x[1] - x[0])
            r = x[:, 0]
            around = 2 * np.pi * np.array([2 * r[0] + r[1], r[0] + 2 * r[1]]) / 3 if is_round else np.ones(2)
            areas[nodes] += length / 2 * around
        elif len(nodes) == 3 and abs(np.cross(x[1] - x[0], x[2] - x[0])).max() < 1e-12:
            length = np.linalg.norm(x[1] - x[0])
            around = 2 * np.pi * x[:, 0] if is_round else np.ones(3)
            areas[nodes] += length * np.array([1, 1, 4]) / 6 * around
        elif len(nodes) == 6:
            areas[nodes[3:]] += np.linalg.norm(np.cross(x[1] - x[0], x[2] - x[0])) / 6
        elif len(nodes) == 8:
            area = np.linalg.norm(np.cross(x[1] - x[0], x[3] - x[0]))
            areas[nodes] += area * np.array([-1, -1, -1, -1, 4, 4, 4, 4]) / 12
        elif len(nodes) == 9:
            area = np.linalg.norm(np.cross(x[1] - x[0], x[3] - x[0]))
            areas[nodes] += area * np.array([1, 1, 1, 1, 4, 4, 4, 4, 16]) / 36
        else:
            area = np.linalg.norm(np.cross(x[1] - x[0], x[-1] - x[0])) / (2 if len(nodes) == 3 else 1)
            areas[nodes] += area / len(nodes)
    return areas
