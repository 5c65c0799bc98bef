# SPDX-License-Identifier: BSD-3-Clause
"""Two stacked blocks of any element type, written as gmsh 2.2 ASCII: the meshes of the patch tests."""

import itertools

import numpy as np

GMSH_TYPES = {"P1": 15, "L2": 1, "T3": 2, "Q4": 3, "T4": 4, "H8": 5}
# Corners of a box by their 0/1 steps, in gmsh's order.
BOX = {1: [(0,), (1,)], 2: [(0, 0), (1, 0), (1, 1), (0, 1)]}
BOX[3] = [(*corner, 0) for corner in BOX[2]] + [(*corner, 1) for corner in BOX[2]]


def simplices(n_dim):
    """Kuhn's split of a box: one simplex per way from the first corner to the last; faces of neighbors match."""
    for order in itertools.permutations(range(n_dim)):
        corner = np.zeros(n_dim, dtype=int)
        corners = [tuple(corner)]
        for axis in order:
            corner[axis] = 1
            corners.append(tuple(corner))
        yield corners


def split(element, n_dim, position):
    """(element name, corners) of each element of a box of the grid."""
    name = {"mixed": ("T3", "Q4")[sum(position) % 2]}.get(element, element)
    if name in ("Q4", "H8") or n_dim == 1:
        yield {1: "L2", 2: "Q4", 3: "H8"}[n_dim], BOX[n_dim]
    else:
        for corners in simplices(n_dim):
            yield {2: "T3", 3: "T4"}[n_dim], corners


class Mesh:
    """Nodes, elements with their physical names, and the nodes of each name (0-based)."""

    def __init__(self):
        """Empty."""
        self.coordinates = np.zeros((0, 3))
        self.elements = []

    def add_block(self, region, lines, element, faces, moved=0.0, seed=0):
        """Box between the given grid lines per axis; faces: {(axis, side): name}; inner nodes off the grid by `moved`.

        `moved` is relative to the smallest step of the grid.
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

        for position in np.ndindex(*(n - 1 for n in counts)):
            for name, corners in split(element, n_dim, position):
                self.elements.append((name, region, [number(np.add(position, corner)) for corner in corners]))
        for (axis, side), face in faces.items():
            others = [i for i in range(n_dim) if i != axis]
            for position in np.ndindex(*(counts[i] - 1 for i in others)):
                for name, corners in split(element if n_dim == 3 else "L2", n_dim - 1, position):
                    nodes = []
                    for corner in corners:
                        index = np.full(n_dim, side * (counts[axis] - 1))
                        index[others] = np.add(position, corner)
                        nodes.append(number(index))
                    self.elements.append(({"T4": "T3", "H8": "Q4"}.get(name, name), face, nodes))

    def nodes_of(self, name):
        """Sorted nodes of a physical name."""
        return np.unique([node for _, group, nodes in self.elements if group == name for node in nodes])

    def facets_of(self, name):
        """Node lists of the facets of a physical name."""
        return [nodes for _, group, nodes in self.elements if group == name]

    def write(self, path):
        """As gmsh 2.2 ASCII, every number as it is."""
        dimensions = {"P1": 0, "L2": 1, "T3": 2, "Q4": 2, "T4": 3, "H8": 3}
        groups = sorted({(dimensions[kind], name) for kind, name, _ in self.elements})
        lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(groups))]
        lines += [f'{n_dim} {i} "{name}"' for i, (n_dim, name) in enumerate(groups, 1)]
        lines += ["$EndPhysicalNames", "$Nodes", str(len(self.coordinates))]
        lines += [f"{i} {x!r} {y!r} {z!r}" for i, (x, y, z) in enumerate(self.coordinates.tolist(), 1)]
        lines += ["$EndNodes", "$Elements", str(len(self.elements))]
        for i, (kind, name, nodes) in enumerate(self.elements, 1):
            tag = groups.index((dimensions[kind], name)) + 1
            numbers = " ".join(str(node + 1) for node in nodes)
            lines.append(f"{i} {GMSH_TYPES[kind]} 2 {tag} {tag} {numbers}")
        path.write_text("\n".join([*lines, "$EndElements", ""]))


def stacked_blocks(element, n_dim, moved=0.25):
    """Two blocks, 1 wide and 1 high each, that touch at height 0: bottom, top, lower_face, upper_face, left, front."""
    across = np.array([0.0, 0.3, 0.55, 1.0])
    lines = [across] if n_dim == 2 else [across, np.array([0.0, 0.4, 1.0])]
    sides = {(0, 0): "left"} if n_dim == 2 else {(0, 0): "left", (1, 0): "front"}
    up = n_dim - 1
    mesh = Mesh()
    below = {(up, 0): "bottom", (up, 1): "lower_face"} | sides
    above = {(up, 0): "upper_face", (up, 1): "top"} | sides
    mesh.add_block("lower", [*lines, np.array([-1.0, -0.6, -0.2, 0.0])], element, below, moved, seed=1)
    mesh.add_block("upper", [*lines, np.array([0.0, 0.3, 1.0])], element, above, moved, seed=2)
    return mesh


def consistent_areas(mesh, name, is_round=False):
    """Integral of each node's shape function over a named surface, by the formula of each facet.

    Edges with 2 pi r: L 2 pi (2 r_1 + r_2) / 6. Triangles and parallelograms: equal parts.
    """
    areas = np.zeros(len(mesh.coordinates))
    for nodes in mesh.facets_of(name):
        x = mesh.coordinates[nodes]
        if len(nodes) == 2:
            length = np.linalg.norm(x[1] - x[0])
            r = x[:, 0]
            around = 2 * np.pi * np.array([2 * r[0] + r[1], r[0] + 2 * r[1]]) / 3 if is_round else np.ones(2)
            areas[nodes] += length / 2 * around
        else:
            area = np.linalg.norm(np.cross(x[1] - x[0], x[-1] - x[0])) / (2 if len(nodes) == 3 else 1)
            areas[nodes] += area / len(nodes)
    return areas
