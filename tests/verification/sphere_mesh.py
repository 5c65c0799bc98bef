# SPDX-License-Identifier: BSD-3-Clause
"""Sphere on a block in the round or a quarter in space, or a cylinder on a block in the plane.

The sphere is a block with a spherical lower face.
"""

import numpy as np

from block_meshes import LINEAR, QUADRATIC, Mesh

# [mm]
RADIUS = 50.0
SIZE = 60.0


def graded(step, n_fine, size, growth):
    """Grid from 0: n_fine equal steps, then growing ones up to the size."""
    line = list(step * np.arange(n_fine + 1))
    while line[-1] < size:
        line.append(line[-1] + (line[-1] - line[-2]) * growth)
    # the last step may be short: move what follows the fine part so that it ends at the size
    line = np.array(line)
    coarse = line[n_fine:]
    line[n_fine:] = coarse[0] + (coarse - coarse[0]) * (size - coarse[0]) / (coarse[-1] - coarse[0])
    return line


def sphere_on_block(n_dim, step, n_fine, growth, n_sphere=None, element=None, size=SIZE):
    """Contact faces: the first n_fine steps along each axis, n_sphere on the sphere; names as in the deck.

    Nodes in the middle of the sphere's edges lie on it, too.
    """
    element = element or ("H8" if n_dim == 3 else "Q4")
    reach = step * n_fine
    mesh, ends = Mesh(), {}
    below, above = (n_dim - 1, 0), (n_dim - 1, 1)
    sides = dict(zip([(0, 0), (1, 0)], ["left", "front"], strict=True)) if n_dim == 3 else {(0, 0): "axis"}
    for name, n in (("block", n_fine), ("sphere", n_sphere or n_fine)):
        across = [graded(reach / n, n, size, growth)] * (n_dim - 1)
        up = graded(reach / n, n // 2, size, growth)
        faces = {below: "sphere_face", above: "sphere_top"}
        if name == "block":
            up, faces = -up[::-1], {below: "block_base", above: "block_face"}
        mesh.add_block(name, [*across, up], LINEAR.get(element, element), faces | sides)
        ends[f"{name}_face"] = reach * (1 + 0.5 / n)
    if element in QUADRATIC:
        mesh.make_quadratic(element)
    is_sphere = mesh.nodes_of("sphere")
    nodes = mesh.coordinates[is_sphere]
    squared = np.sum(nodes[:, : n_dim - 1] ** 2, axis=1)
    # beyond the contact any shape does that keeps the cells upright
    profile = np.minimum(squared / (RADIUS + np.sqrt(np.maximum(0.0, RADIUS**2 - squared))), size / 2)
    mesh.coordinates[is_sphere, n_dim - 1] += profile * (1 - nodes[:, n_dim - 1] / size)

    def is_kept(element):
        return element[1] not in ends or np.all(mesh.coordinates[element[2], : n_dim - 1] < ends[element[1]])

    mesh.elements = [element for element in mesh.elements if is_kept(element)]
    return mesh
