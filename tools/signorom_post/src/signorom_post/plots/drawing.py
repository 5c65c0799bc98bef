# SPDX-License-Identifier: BSD-3-Clause
"""Procedures that draw meshes, arrows and nodal fields on axes; several figures use them."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection, TriMesh
from matplotlib.tri import Triangulation

from signorom_post.arrays import FloatArray, IntArray, with_unit
from signorom_post.mesh import Mesh
from signorom_post.style import BODY, INK, SEQUENTIAL


def draw_edges(axes: Axes, points: FloatArray, edges: IntArray, color: str, width: float) -> LineCollection:
    """Draws a line along each edge, and returns the lines.

    `edges`, shape (n_edges, 2), has the two nodes of each edge; `points`, shape (n_nodes, 2), are the places of the
    nodes in the picture; `width` is in typographic points.
    """
    lines = LineCollection(list(points[edges]), colors=color, linewidths=width, capstyle="round")
    axes.add_collection(lines)
    return lines


def draw_arrows(
    axes: Axes, points: FloatArray, arrows: FloatArray, color: str, name: str, **style: object
) -> None:
    """Draws `arrows` at `points`, both of shape (n, 2) and in the units of the axes.

    The layout of the figure does not make room for the arrows. `name` is their `gid`; `style` goes to `Axes.quiver`.
    """
    lengths = {"angles": "xy", "scale_units": "xy", "scale": 1.0, "units": "inches", "width": 0.013}
    axes.quiver(*points.T, *arrows.T, color=color, gid=name, **lengths, **style).set_in_layout(False)


def draw_cells(axes: Axes, points: FloatArray, cells: list[IntArray], color: str) -> PolyCollection:
    """Fills cells with one color, and returns the polygons.

    `cells` has the nodes of each cell; `points`, shape (n_nodes, 2), are the places of the nodes in the picture.
    """
    polygons = PolyCollection([points[cell] for cell in cells], facecolors=color, edgecolors="none")
    axes.add_collection(polygons)
    return polygons


def draw_mesh(axes: Axes, mesh: Mesh, points: FloatArray, fill: str = BODY) -> None:
    """Draws all cells in the color `fill`, their edges in gray, and the outline of the bodies in black.

    `points`, shape (n_nodes, 2), are the places of the nodes in the picture.
    """
    draw_cells(axes, points, mesh.cells, fill)
    draw_edges(axes, points, mesh.edges, "#BDBDBD", 0.4)
    draw_edges(axes, points, mesh.boundary_edges, INK, 0.9)


def draw_shaded(
    axes: Axes, mesh: Mesh, points: FloatArray, values: FloatArray, limits: tuple[float, float]
) -> TriMesh:
    """Draws `values`, shape (n_nodes), as smooth colors, with edges and outline on top, and returns the colored mesh.

    `points`, shape (n_nodes, 2), are the places of the nodes in the picture; `limits` are the values at the two ends of
    the color scale.
    """
    triangulation = Triangulation(points[:, 0], points[:, 1], mesh.triangles)
    low, high = limits
    shading = axes.tripcolor(
        triangulation, values, shading="gouraud", cmap=SEQUENTIAL, vmin=low, vmax=high, rasterized=True
    )
    draw_edges(axes, points, mesh.edges, "#00000038", 0.35)
    draw_edges(axes, points, mesh.boundary_edges, INK, 0.9)
    return shading


def frame(axes: Axes, points: FloatArray, unit: str, names: tuple[str, str] = ("x", "y")) -> None:
    """Gives the axes equal scales, limits with a margin around `points`, and labels with their names and the unit.

    `points` has the shape (n, 2) and is in `unit`.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    margin = 0.03 * float(np.max(high - low))
    axes.set_xlim(low[0] - margin, high[0] + margin)
    axes.set_ylim(low[1] - margin, high[1] + margin)
    axes.set_aspect("equal")
    axes.set_xlabel(with_unit(f"${names[0]}$", unit))
    axes.set_ylabel(with_unit(f"${names[1]}$", unit))


def marker_scale(mesh: Mesh, points: FloatArray, points_per_unit: float) -> float:
    """Returns a factor of 0.4 to 1 for the size of markers: smaller for a finer mesh, so that markers overlap less.

    It is the length of the median edge in the picture over 8 typographic points, limited to this range. `points`, shape
    (n_nodes, 2), are the coordinates of the nodes; `points_per_unit` is the number of typographic points per unit of
    these coordinates.
    """
    lengths = np.linalg.norm(np.diff(points[mesh.edges], axis=1)[:, 0], axis=1)
    return float(np.clip(np.median(lengths) * points_per_unit / 8.0, 0.4, 1.0))
