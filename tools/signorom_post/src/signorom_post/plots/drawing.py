# SPDX-License-Identifier: BSD-3-Clause
"""Meshes on axes, shared by the figures."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection, TriMesh
from matplotlib.tri import Triangulation

from signorom_post.arrays import FloatArray, IntArray, with_unit
from signorom_post.mesh import Mesh
from signorom_post.style import BODY, INK, SEQUENTIAL


def draw_edges(axes: Axes, points: FloatArray, edges: IntArray, color: str, width: float) -> LineCollection:
    """Lines along edges, shape (n_edges, 2), of points, shape (n_nodes, 2)."""
    lines = LineCollection(list(points[edges]), colors=color, linewidths=width, capstyle="round")
    axes.add_collection(lines)
    return lines


def draw_arrows(
    axes: Axes, points: FloatArray, arrows: FloatArray, color: str, name: str, **style: object
) -> None:
    """Arrows at points, in the units of the axes; both have the shape (n, 2). The layout does not make room for them."""
    lengths = {"angles": "xy", "scale_units": "xy", "scale": 1.0, "units": "inches", "width": 0.013}
    axes.quiver(*points.T, *arrows.T, color=color, gid=name, **lengths, **style).set_in_layout(False)


def draw_cells(axes: Axes, points: FloatArray, cells: list[IntArray], color: str) -> PolyCollection:
    """Cells filled with one colour."""
    polygons = PolyCollection([points[cell] for cell in cells], facecolors=color, edgecolors="none")
    axes.add_collection(polygons)
    return polygons


def draw_mesh(axes: Axes, mesh: Mesh, points: FloatArray, fill: str = BODY) -> None:
    """All cells in a quiet tone with their edges, and the outline of the bodies."""
    draw_cells(axes, points, mesh.cells, fill)
    draw_edges(axes, points, mesh.edges, "#BDBDBD", 0.4)
    draw_edges(axes, points, mesh.boundary_edges, INK, 0.9)


def draw_shaded(
    axes: Axes, mesh: Mesh, points: FloatArray, values: FloatArray, limits: tuple[float, float]
) -> TriMesh:
    """Nodal values as smooth colour, with edges and outline on top."""
    triangulation = Triangulation(points[:, 0], points[:, 1], mesh.triangles)
    low, high = limits
    shading = axes.tripcolor(
        triangulation, values, shading="gouraud", cmap=SEQUENTIAL, vmin=low, vmax=high, rasterized=True
    )
    draw_edges(axes, points, mesh.edges, "#00000038", 0.35)
    draw_edges(axes, points, mesh.boundary_edges, INK, 0.9)
    return shading


def frame(axes: Axes, points: FloatArray, unit: str, names: tuple[str, str] = ("x", "y")) -> None:
    """Equal scales, a margin around the points, and axes named with the unit."""
    low, high = points.min(axis=0), points.max(axis=0)
    margin = 0.03 * float(np.max(high - low))
    axes.set_xlim(low[0] - margin, high[0] + margin)
    axes.set_ylim(low[1] - margin, high[1] + margin)
    axes.set_aspect("equal")
    axes.set_xlabel(with_unit(f"${names[0]}$", unit))
    axes.set_ylabel(with_unit(f"${names[1]}$", unit))


def marker_scale(mesh: Mesh, points: FloatArray, points_per_unit: float) -> float:
    """Smaller markers on fine meshes, so that neighbors stay apart; edges of 8 points or more get full size."""
    lengths = np.linalg.norm(np.diff(points[mesh.edges], axis=1)[:, 0], axis=1)
    return float(np.clip(np.median(lengths) * points_per_unit / 8.0, 0.4, 1.0))
