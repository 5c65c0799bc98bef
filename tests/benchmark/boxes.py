# SPDX-License-Identifier: BSD-3-Clause
"""Parts of any size for the benchmarks of solvers: two boxes, one on the other, of any element type.

A box 1 m wide lies on another one of another stiffness; planes of symmetry hold both sideways. The gap between them
grows with the square of the distance to the middle, and a pressure on the top closes part of it.
"""

import itertools
import math

import numpy as np

# corners in whose middle the further nodes sit, in gmsh's order, and gmsh's numbers of the types
EDGES = {
    "L3": [(0, 1)],
    "T6": [(0, 1), (1, 2), (0, 2)],
    "Q8": [(0, 1), (1, 2), (2, 3), (0, 3)],
    "T10": [(0, 1), (1, 2), (0, 2), (0, 3), (2, 3), (1, 3)],
    "H20": [(0, 1), (0, 3), (0, 4), (1, 2), (1, 5), (2, 3), (2, 6), (3, 7), (4, 5), (4, 7), (5, 6), (6, 7)],
}
GMSH = {"L2": 1, "T3": 2, "Q4": 3, "T4": 4, "H8": 5, "L3": 8, "T6": 9, "T10": 11, "Q8": 16, "H20": 17}
LINEAR = {"T6": "T3", "Q8": "Q4", "T10": "T4", "H20": "H8"}
FACETS = {"T3": "L2", "Q4": "L2", "T4": "T3", "H8": "Q4", "T6": "L3", "Q8": "L3", "T10": "T6", "H20": "Q8"}
# dofs of the box per cell of its grid, for many cells
NODES_PER_CELL = {"T3": 1, "Q4": 1, "T4": 1, "H8": 1, "T6": 4, "Q8": 3, "T10": 8, "H20": 4}
BOX = {1: [(0,), (1,)], 2: [(0, 0), (1, 0), (1, 1), (0, 1)]}
BOX[3] = [(*corner, 0) for corner in BOX[2]] + [(*corner, 1) for corner in BOX[2]]


# the last sections of a deck: one point
AT_ONE_POINT = "output: {points: [{P: 1.0e6}]}"


def simplices(n_dim):
    """Corners of the simplices into which Kuhn's rule divides a box, as 0/1 steps per axis; orientation positive."""
    found = []
    for order in itertools.permutations(range(n_dim)):
        steps = np.cumsum([np.zeros(n_dim, dtype=int), *np.eye(n_dim, dtype=int)[list(order)]], axis=0)
        if n_dim > 1 and np.linalg.det(np.diff(steps, axis=0)) < 0:
            steps[[-2, -1]] = steps[[-1, -2]]
        found.append([tuple(step) for step in steps])
    return found


def cells_of(number, element):
    """Cells of a grid of node numbers, any number of axes; linear elements."""
    n_dim = number.ndim
    splits = simplices(n_dim) if element in ("T3", "T4") and n_dim > 1 else [BOX[n_dim]]
    found = []
    for corners in splits:
        windows = [
            number[tuple(slice(step, n - 1 + step) for step, n in zip(corner, number.shape, strict=True))]
            for corner in corners
        ]
        found.append(np.stack([window.ravel() for window in windows], axis=1))
    return np.vstack(found)


class Box:
    """Nodes, cells and the sides of a box of linear elements; sides: (axis, 0 or 1) -> facets."""

    def __init__(self, element, sizes, counts, origin):
        """`counts`: cells along each axis."""
        lines = [np.linspace(0, size, n + 1) for size, n in zip(sizes, counts, strict=True)]
        self.nodes = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, len(sizes)) + origin
        number = np.arange(len(self.nodes)).reshape([n + 1 for n in counts])
        linear = LINEAR.get(element, element)
        self.cells = cells_of(number, linear)
        self.sides = {
            (axis, side): cells_of(np.take(number, side * counts[axis], axis=axis), FACETS[linear])
            for axis in range(len(sizes))
            for side in (0, 1)
        }


def with_middles(nodes, groups, element):
    """Adds mid-side nodes to cells and facets: [(kind, name, members)] -> nodes, groups."""
    quadratic = {LINEAR[element]: element, FACETS[LINEAR[element]]: FACETS[element]}
    pairs = [
        np.sort(members[:, edge], axis=1) for kind, _, members in groups for edge in EDGES[quadratic[kind]]
    ]
    unique, inverse = np.unique(np.vstack(pairs), axis=0, return_inverse=True)
    inverse = inverse.ravel() + len(nodes)
    full, first = [], 0
    for kind, name, members in groups:
        n_edges = len(EDGES[quadratic[kind]])
        middles = inverse[first : first + n_edges * len(members)].reshape(n_edges, -1).T
        first += n_edges * len(members)
        full.append((quadratic[kind], name, np.hstack([members, middles])))
    return np.vstack([nodes, nodes[unique].mean(axis=1)]), full


def grid_counts(element, n_dofs, aspect):
    """Cells along the sides and the height of one box so that both have about n_dofs; aspect: height over width."""
    n_dim = n_axes(element)
    cells = n_dofs / n_dim / NODES_PER_CELL[element] / 2
    n_side = max(2, round((cells / aspect) ** (1 / n_dim)))
    n_high = max(1, math.ceil(n_side * aspect))
    n_side = max(2, round((cells / n_high) ** (1 / (n_dim - 1))))
    return [n_side] * (n_dim - 1) + [n_high]


def n_axes(element):
    """2 of plane elements, 3 of solid ones."""
    return 2 if element in ("T3", "Q4", "T6", "Q8") else 3


def write_boxes(path, *arguments, **options):
    """Writes what make_boxes makes as gmsh 2.2 binary; returns the number of nodes."""
    nodes, groups = make_boxes(*arguments, **options)
    write_gmsh(path, nodes, groups)
    return len(nodes)


def make_boxes(element, counts, aspect=0.5, upper_counts=None):
    """Nodes of both boxes, and groups: [(kind, name, members from 0)].

    `counts`: cells of a box along each axis; `upper_counts` where the upper one has others, so that no nodes match.
    """
    up = len(counts) - 1
    sizes = [1.0] * up + [aspect]
    boxes = [
        Box(element, sizes, counts, [0.0] * up + [-aspect]),
        Box(element, sizes, upper_counts or counts, [0.0] * (up + 1)),
    ]
    n_lower = len(boxes[0].nodes)
    nodes = np.vstack([box.nodes for box in boxes])
    linear = LINEAR.get(element, element)
    facet = FACETS[linear]
    lower, upper = (
        {key: side + shift for key, side in box.sides.items()}
        for box, shift in zip(boxes, (0, n_lower), strict=True)
    )
    groups = [
        (linear, "lower", boxes[0].cells),
        (linear, "upper", boxes[1].cells + n_lower),
        (facet, "bottom", lower[up, 0]),
        (facet, "lower_face", lower[up, 1]),
        (facet, "upper_face", upper[up, 0]),
        (facet, "top", upper[up, 1]),
        (facet, "left", np.vstack([lower[0, 0], upper[0, 0]])),
    ]
    if up == 2:
        groups.append((facet, "front", np.vstack([lower[1, 0], upper[1, 0]])))
    if element in LINEAR:
        nodes, groups = with_middles(nodes, groups, element)
    return nodes, groups


def make_plates(lower_sizes, upper_sizes, lower_counts, upper_counts):
    """Nodes and groups of two plates of H8, the lower one below z = 0; the upper box and its first node number, too.

    Regions and sides: lower, upper; base, lower_face, upper_face, top.
    """
    lower = Box("H8", lower_sizes, lower_counts, [0.0, 0.0, -lower_sizes[2]])
    upper = Box("H8", upper_sizes, upper_counts, [0.0, 0.0, 0.0])
    n = len(lower.nodes)
    groups = [
        ("H8", "lower", lower.cells),
        ("H8", "upper", upper.cells + n),
        ("Q4", "base", lower.sides[2, 0]),
        ("Q4", "lower_face", lower.sides[2, 1]),
        ("Q4", "upper_face", upper.sides[2, 0] + n),
        ("Q4", "top", upper.sides[2, 1] + n),
    ]
    return np.vstack([lower.nodes, upper.nodes]), groups, upper, n


def write_gmsh(path, nodes, groups):
    """Writes gmsh 2.2 binary; groups: [(kind, name, members from 0)], the first ones of the cells."""
    nodes = np.pad(nodes, ((0, 0), (0, 3 - nodes.shape[1])))
    dimension = {"L": 1, "T3": 2, "T6": 2, "Q": 2}
    with path.open("wb") as file:
        file.write(b"$MeshFormat\n2.2 1 8\n" + np.int32(1).tobytes() + b"\n$EndMeshFormat\n$PhysicalNames\n")
        file.write(f"{len(groups)}\n".encode())
        for tag, (kind, name, _) in enumerate(groups, 1):
            file.write(f'{dimension.get(kind, dimension.get(kind[0], 3))} {tag} "{name}"\n'.encode())
        file.write(f"$EndPhysicalNames\n$Nodes\n{len(nodes)}\n".encode())
        table = np.zeros(len(nodes), dtype=[("tag", "<i4"), ("place", "<f8", 3)])
        table["tag"], table["place"] = np.arange(1, len(nodes) + 1), nodes
        file.write(table.tobytes())
        total = sum(len(members) for _, _, members in groups)
        file.write(f"\n$EndNodes\n$Elements\n{total}\n".encode())
        first = 1
        for tag, (kind, _, members) in enumerate(groups, 1):
            file.write(np.array([GMSH[kind], len(members), 2], dtype="<i4").tobytes())
            numbers = np.arange(first, first + len(members))[:, None]
            tags = np.full((len(members), 2), tag)
            file.write(np.hstack([numbers, tags, members + 1]).astype("<i4").tobytes())
            first += len(members)
        file.write(b"\n$EndElements\n")


def deck_text(
    element, *, ratio=1.0, aspect=0.5, gap=None, solver="type: auto", parameters="", rest=AT_ONE_POINT
):
    """The deck of the boxes in `boxes.msh`.

    `ratio`: Young's modulus of the upper box over that of the lower one. `gap`: another one, an expression.
    `parameters`: more of them, `, name: {...}`. `rest`: sections on points and models.
    """
    is_plane = n_axes(element) == 2
    distance = "x^2" if is_plane else "x^2 + y^2"
    front = "" if is_plane else "  - {boundary: front, displacement: {y: 0}}\n"
    clamped = "x: 0, y: 0" if is_plane else "x: 0, y: 0, z: 0"
    gap = gap or f"{12e-5 * aspect / ratio!r} * ({distance})"
    direction = "[0, 1]" if is_plane else "[0, 0, 1]"
    return f"""\
title: Two boxes, benchmark
mesh: {{file: boxes.msh, model: {"plane_strain" if is_plane else "solid"}}}
parameters: {{P: {{min: 0.5e6, max: 2.0e6, unit: Pa}}{parameters}}}
materials:
  lower: {{regions: [lower], young_modulus: 210.0e9, poisson_ratio: 0.3}}
  upper: {{regions: [upper], young_modulus: {210.0e9 * ratio!r}, poisson_ratio: 0.3}}
boundary_conditions:
  - {{boundary: bottom, displacement: {{{clamped}}}}}
  - {{boundary: left, displacement: {{x: 0}}}}
{front}loads:
  - {{boundary: top, pressure: P}}
contact:
  - {{first: lower_face, second: upper_face, direction: {direction}, initial_gap: "{gap}"}}
solver: {{{solver}}}
{rest}
"""
