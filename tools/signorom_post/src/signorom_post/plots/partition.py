# SPDX-License-Identifier: BSD-3-Clause
"""Figure of scattered snapshots in clusters, and of the parts of the box that a random forest gives to each cluster.

Paper, Figure 20.
"""

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from signorom_post.arrays import FloatArray, IntArray
from signorom_post.style import INK, cluster_colors, new_figure

#: a point is hatched if the second-best cluster has at least this share of the votes of the best one
NEAR = 0.5


@dataclass(frozen=True)
class Partition:
    """The snapshots of each cluster, and the answers of the forest on a grid; clusters are numbered from 0."""

    #: [unit of each parameter] points of the snapshots of each cluster, shape (n_snapshots, 2)
    members: list[FloatArray]
    #: points of a full grid in any order, shape (n_points, 2)
    points: FloatArray
    #: the cluster that answers at each grid point, shape (n_points)
    labels: IntArray
    #: votes for the second-best cluster divided by votes for the best one, shape (n_points)
    ratios: FloatArray


def partition(shown: Partition, x_label: str = "$P_1$ [MPa]", y_label: str = "$h_1$ [mm]") -> Figure:
    """Returns a figure. Left: snapshots in the color of their cluster. Right: the cluster that answers.

    Hatching marks where the second-best cluster has at least half (`NEAR`) as many votes as the best one.
    """
    figure = new_figure(8.6, 4.3)
    left, right = figure.subplots(1, 2, sharex=True, sharey=True)
    colors = cluster_colors(len(shown.members))
    for i, (points, color) in enumerate(zip(shown.members, colors, strict=True)):
        text = f"cluster {i + 1}: {len(points)} snapshots"
        left.plot(*points.T, "o", color=color, markersize=3.0, label=text, gid=f"snapshots {i}")
    _draw_answers(right, shown, colors)
    for axes in (left, right):
        axes.set_xlabel(x_label)
    left.set_ylabel(y_label)
    left.set_title("snapshots")
    right.set_title("prediction of the forest")
    handles, texts = left.get_legend_handles_labels()
    text = f"second cluster: at least {100 * NEAR:.0f} % of the votes of the first"
    handles.append(Patch(facecolor="none", edgecolor=INK, hatch="////", linewidth=0.0, label=text))
    figure.legend(handles, [*texts, text], loc="outside upper center", ncols=2, columnspacing=1.4)
    return figure


def _draw_answers(axes: Axes, shown: Partition, colors: list[str]) -> None:
    x, i_x = np.unique(shown.points[:, 0], return_inverse=True)
    y, i_y = np.unique(shown.points[:, 1], return_inverse=True)
    labels, ratios = np.zeros((len(y), len(x))), np.zeros((len(y), len(x)))
    labels[i_y, i_x] = shown.labels
    ratios[i_y, i_x] = shown.ratios
    limits = {"vmin": -0.5, "vmax": len(colors) - 0.5}
    axes.pcolormesh(
        x, y, labels, cmap=ListedColormap(colors), gid="labels", rasterized=True, alpha=0.75, **limits
    )
    near = axes.contourf(x, y, ratios, levels=[NEAR, 2.0], colors="none", hatches=["////"])
    near.set_gid("near")
