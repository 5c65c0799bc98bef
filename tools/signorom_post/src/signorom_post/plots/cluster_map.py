# SPDX-License-Identifier: BSD-3-Clause
"""Figure of clusters over two parameters: their snapshots, and where each cluster answers (paper, Figure 15)."""

from dataclasses import dataclass

import numpy as np
from matplotlib.colors import ListedColormap, to_rgb
from matplotlib.figure import Figure

from signorom_post.arrays import FloatArray, IntArray
from signorom_post.style import cluster_colors, new_figure


@dataclass(frozen=True)
class ClusterMap:
    """The cluster that answers at each point of a full grid, and the snapshots of each cluster."""

    #: [unit of each parameter] the points in any order, and the cluster that answers there, from 0; shape (n_points)
    x: FloatArray
    y: FloatArray
    labels: IntArray
    #: points of the snapshots of each cluster, shape (n_snapshots, 2); a snapshot may belong to several clusters
    members: list[FloatArray]


def cluster_map(shown: ClusterMap, x_label: str = "$P_1$ [MPa]", y_label: str = "$h_1$ [mm]") -> Figure:
    """Returns the figure: a pale color per cluster where it answers, and its snapshots as dots.

    A ring is a snapshot that belongs to an earlier cluster, too.
    """
    figure = new_figure(6.4, 4.6)
    axes = figure.subplots()
    x, i_x = np.unique(shown.x, return_inverse=True)
    y, i_y = np.unique(shown.y, return_inverse=True)
    labels = np.zeros((len(y), len(x)))
    labels[i_y, i_x] = shown.labels
    n = len(shown.members)
    colors = cluster_colors(n)
    pale = ListedColormap([tuple(0.7 + 0.3 * value for value in to_rgb(color)) for color in colors])
    axes.pcolormesh(x, y, labels, cmap=pale, vmin=-0.5, vmax=n - 0.5, gid="labels", rasterized=True)
    seen: set[tuple[float, ...]] = set()
    for i, points in enumerate(shown.members):
        is_second = np.array([tuple(point) in seen for point in points])
        seen |= {tuple(point) for point in points}
        text = f"cluster {i + 1}: {len(points)} snapshots"
        color = colors[i]
        axes.plot(*points[~is_second].T, "o", color=color, markersize=3.0, label=text, gid=f"first {i}")
        axes.plot(
            *points[is_second].T,
            "o",
            color=color,
            markersize=6.0,
            markerfacecolor="none",
            gid=f"second {i}",
            zorder=3,
        )
    axes.set_xlabel(x_label)
    axes.set_ylabel(y_label)
    figure.legend(*axes.get_legend_handles_labels(), loc="outside upper center", ncols=n, columnspacing=1.4)
    return figure
