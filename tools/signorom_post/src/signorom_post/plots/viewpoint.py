# SPDX-License-Identifier: BSD-3-Clause
"""Chooses from where a picture shows bodies, or one surface, best."""

import numpy as np

from signorom_post.arrays import FloatArray, IntArray
from signorom_post.mesh import Faces
from signorom_post.plots.depth_buffer import DepthBuffer
from signorom_post.plots.surface import AZIMUTH, ELEVATION, normals_of, triangles_of, view

#: (azimuth, elevation) of the corners of a box [degrees]: the standard view, the others from above, those from below
CORNERS = tuple((AZIMUTH + 90.0 * i, sign * ELEVATION) for sign in (1.0, -1.0) for i in range(4))
#: of views that show at least this share of what the best one shows, the first one in CORNERS is taken
ENOUGH = 0.95
#: number of points along a picture that is only counted
COARSE = 200
#: a surface is seen along its mean normal if that has at least this length; else the surface closes on itself
OPEN = 0.5
#: components of a direction below this size are taken as zero
SLANT = 0.02


def best_corner(points: FloatArray, faces: Faces) -> tuple[float, float]:
    """Returns azimuth and elevation [degrees] of the corner from which most is seen of all bodies together.

    What counts of a body is the visible part of its area, so that a small body counts as much as a large one. `points`,
    shape (n_nodes, 3), are the places of all nodes, and `faces` the outer faces of the bodies.
    """
    scores = [_visible_shares(points, faces, view(*corner)) for corner in CORNERS]
    return CORNERS[int(np.argmax(np.array(scores) >= ENOUGH * max(scores)))]


def _visible_shares(points: FloatArray, faces: Faces, towards: FloatArray) -> float:
    """Returns the sum over the bodies of the area in the picture that the viewer sees over the whole area."""
    areas = areas_of(points, faces)
    bodies = bodies_of(faces, len(points))
    front = np.flatnonzero(normals_of(points, faces) @ towards[2] > 0.0)
    triangles, owners = triangles_of(faces.take(front))
    buffer = DepthBuffer((points @ towards.T)[triangles], COARSE)
    seen = np.bincount(
        bodies[front[owners[buffer.owner[buffer.owner >= 0]]]], minlength=int(bodies.max(initial=0)) + 1
    )
    return float((seen * buffer.step**2 / np.bincount(bodies, areas)).sum())


def areas_of(points: FloatArray, faces: Faces) -> FloatArray:
    """Returns the area of each face, shape (n_faces); `points` are the places of all nodes, shape (n_nodes, 3)."""
    corners = points[faces.nodes]
    return 0.5 * np.linalg.norm(
        np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]), axis=1
    )


def bodies_of(faces: Faces, n_nodes: int) -> IntArray:
    """Returns the number, from 0, of the body of each face: faces that share a node are of one body."""
    labels = np.arange(n_nodes)
    while True:
        lowest = labels[faces.nodes].min(axis=1)
        joined = labels.copy()
        np.minimum.at(joined, faces.nodes, lowest[:, None])
        joined = joined[joined]
        if np.array_equal(joined, labels):
            return np.unique(lowest, return_inverse=True)[1]
        labels = joined


def corner_of_sheet(points: FloatArray, faces: Faces) -> tuple[float, float]:
    """Returns azimuth and elevation [degrees] of the corner, from above, from which a sheet looks largest.

    Both of its sides count. `points` are the places of all nodes, shape (n_nodes, 3).
    """
    areas, normals = areas_of(points, faces), normals_of(points, faces)
    above = [corner for corner in CORNERS if corner[1] > 0.0]
    sizes = np.array([float(areas @ np.abs(normals @ view(*corner)[2])) for corner in above])
    return above[int(np.argmax(sizes >= ENOUGH * sizes.max()))]


def is_open(points: FloatArray, faces: Faces) -> bool:
    """Returns whether most of a surface looks to one side; else it closes on itself, as a bore does."""
    return bool(np.linalg.norm(_mean_normal(points, faces)) >= OPEN)


def _mean_normal(points: FloatArray, faces: Faces) -> FloatArray:
    areas = areas_of(points, faces)
    return areas @ normals_of(points, faces) / max(float(areas.sum()), np.finfo(float).tiny)


def view_of_surface(points: FloatArray, faces: Faces, weights: FloatArray) -> FloatArray:
    """Returns the rotation, see `view`, from which an open surface is seen from its front.

    A surface that closes on itself, such as a bore, is seen from the corner to which most of its area turns, each face
    times its weight in `weights`, shape (n_faces).
    """
    if is_open(points, faces):
        return view_along(_mean_normal(points, faces))
    areas, normals = areas_of(points, faces) * weights, normals_of(points, faces)
    turned = [float(areas @ np.maximum(normals @ view(*corner)[2], 0.0)) for corner in CORNERS]
    return view(*CORNERS[int(np.argmax(np.array(turned) >= ENOUGH * max(turned)))])


def view_along(direction: FloatArray) -> FloatArray:
    """Returns the rotation, see `view`, of a viewer who stands in this direction; components near zero are zero."""
    x, y, z = np.where(np.abs(direction) < SLANT * np.linalg.norm(direction), 0.0, direction)
    azimuth = np.degrees(np.arctan2(y, x)) if x or y else -90.0
    return view(azimuth, np.degrees(np.arctan2(z, np.hypot(x, y))))
