# SPDX-License-Identifier: BSD-3-Clause
"""Sphere on a block in the round (Q4) or a quarter in space (H8): the sphere is a block with a spherical lower face."""

import numpy as np

from block_meshes import Mesh

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


def sphere_on_block(n_dim, step, n_fine, growth):
    """Contact faces: the first n_fine steps along each axis; names as in the deck."""
    across = [graded(step, n_fine, SIZE, growth)] * (n_dim - 1)
    up = graded(step, n_fine // 2, SIZE, growth)
    sides = dict(zip([(0, 0), (1, 0)], ["left", "front"], strict=True)) if n_dim == 3 else {(0, 0): "axis"}
    kind = "H8" if n_dim == 3 else "Q4"
    below, above = (n_dim - 1, 0), (n_dim - 1, 1)
    mesh = Mesh()
    mesh.add_block("block", [*across, -up[::-1]], kind, {below: "block_base", above: "block_face"} | sides)
    n_block = len(mesh.coordinates)
    mesh.add_block("sphere", [*across, up], kind, {below: "sphere_face", above: "sphere_top"} | sides)
    nodes = mesh.coordinates[n_block:]
    squared = np.sum(nodes[:, : n_dim - 1] ** 2, axis=1)
    # beyond the contact any shape does that keeps the cells upright
    profile = np.minimum(squared / (RADIUS + np.sqrt(np.maximum(0.0, RADIUS**2 - squared))), SIZE / 2)
    nodes[:, n_dim - 1] += profile * (1 - nodes[:, n_dim - 1] / SIZE)
    end = step * (n_fine + 0.5)

    def is_kept(element):
        return element[1] not in ("block_face", "sphere_face") or np.all(
            mesh.coordinates[element[2], : n_dim - 1] < end
        )

    mesh.elements = [element for element in mesh.elements if is_kept(element)]
    return mesh
