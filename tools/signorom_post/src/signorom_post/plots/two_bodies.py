# SPDX-License-Identifier: BSD-3-Clause
"""Figure of pellet and cladding: a sketch with supports and load, and the mesh (paper, Figure 8)."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from signorom_post.arrays import BoolArray, FloatArray
from signorom_post.plots.drawing import draw_mesh, frame
from signorom_post.readers.fields import FieldFile
from signorom_post.style import INK, ORANGE, SKY_BLUE, VERMILLION, new_figure

N_ARROWS = 9


def two_bodies(fields: FieldFile, is_first: BoolArray, loaded_height: float) -> Figure:
    """Returns a figure. Left: a sketch of supports and load. Right: the mesh.

    `is_first`, shape (n_nodes), is true at the nodes of the pellet and false at those of the cladding. The sketch shows
    the pressure up to `loaded_height` [mm].
    """
    points = fields.mesh.coordinates[:, :2]
    figure = new_figure(7.6, 4.9, has_equal_axes=True)
    left, right = figure.subplots(1, 2, sharey=True)
    for nodes, color, name in ((is_first, ORANGE, "fuel"), (~is_first, SKY_BLUE, "cladding")):
        _body(left, points[nodes], color, name)
    radius = points[:, 0].max()
    _pressure(left, radius, loaded_height)
    _axis(left, points[:, 1].max())
    draw_mesh(right, fields.mesh, points)
    for axes in (left, right):
        frame(axes, points, fields.mesh.unit, ("r", "z"))
        axes.set_xlim(-0.7, radius + 1.9)
        axes.set_ylim(-0.9, points[:, 1].max() + 0.9)
    right.set_ylabel("")
    n_cells, n_nodes = fields.mesh.n_cells, fields.mesh.n_nodes
    left.set_title("load and supports")
    right.set_title(f"{n_nodes} nodes, {n_cells} cells")
    return figure


def _body(axes: Axes, points: FloatArray, color: str, name: str) -> None:
    low, high = points.min(axis=0), points.max(axis=0)
    width, height = high - low
    axes.add_patch(Rectangle(tuple(low), width, height, facecolor=color, edgecolor=INK, alpha=0.55))
    rotation = 90 if width < 1.0 else 0
    x, y = low[0] + 0.5 * width, low[1] + (0.75 if width < 1.0 else 0.5) * height
    axes.text(x, y, name, ha="center", va="center", rotation=rotation)
    n_rollers = max(3, round(4 * width))
    for z, text in ((low[1], "bottom"), (high[1], "top")):
        sign = -1 if text == "bottom" else 1
        axes.plot(
            np.linspace(low[0] + 0.08, high[0] - 0.08, n_rollers),
            np.full(n_rollers, z + sign * 0.1),
            "o",
            color=INK,
            markersize=3.0,
            markerfacecolor="white",
            gid="roller",
        )
    if width > 1.0:
        axes.text(x, low[1] - 0.3, "$u_z = 0$", ha="center", va="top", fontsize=9)
        axes.text(x, high[1] + 0.25, "$u_z = 0$", ha="center", va="bottom", fontsize=9)


def _pressure(axes: Axes, radius: float, height: float) -> None:
    for z in np.linspace(0.0, height, N_ARROWS):
        axes.annotate(
            "",
            xy=(radius, z),
            xytext=(radius + 0.8, z),
            arrowprops={"arrowstyle": "-|>", "color": VERMILLION, "linewidth": 1.0, "shrinkB": 0.0},
        )
    axes.plot([radius + 0.8, radius + 0.8], [0.0, height], color=VERMILLION, linewidth=1.0)
    axes.text(radius + 0.95, 0.5 * height, "$P_1$", color=VERMILLION, va="center")
    axes.text(radius + 0.15, height + 0.1, "$z = h_1$", color=VERMILLION, va="bottom")


def _axis(axes: Axes, height: float) -> None:
    axes.plot([0.0, 0.0], [-0.5, height + 0.5], color=INK, linewidth=0.8, linestyle="-.")
    axes.text(-0.15, 0.5 * height, "$u_r = 0$", rotation=90, ha="right", va="center", fontsize=9)
