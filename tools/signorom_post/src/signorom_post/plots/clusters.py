# SPDX-License-Identifier: BSD-3-Clause
"""Figure of clusters over any number of parameters: their snapshots, and which cluster answers where."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from signorom_post.arrays import FloatArray, IntArray, with_unit
from signorom_post.plots.pairs import PairPanels
from signorom_post.readers.model import Model
from signorom_post.readers.validation import Validation
from signorom_post.style import cluster_colors

#: number of bars over each parameter, on the diagonal
N_BARS = 20


def clusters(validation: Validation, model: Model) -> Figure:
    """Returns a square of panels, one row and one column per parameter; each cluster has its color.

    Below the diagonal: test points in the color of the cluster that was chosen. Above it: snapshots of each cluster. A
    ring is a snapshot that belongs to an earlier cluster, too. On the diagonal: the clusters' shares of the test points
    in each twentieth of the trained range. ValueError if `validation` lacks a parameter of the model.
    """
    names = model.parameter_names
    points = validation.parameters[:, [validation.parameter_names.index(name) for name in names]]
    labels = validation.columns["cluster"].astype(int) - 1
    colors = cluster_colors(len(model.clusters))
    texts = [with_unit(name, model.unit_of(name)) for name in names]
    panels = PairPanels(texts, "share of the answers")
    for i, axes in panels.diagonal():
        _draw_shares(axes, points[:, i], labels, (model.minimum[i], model.maximum[i]), colors)
    for x, y, axes in panels.below():
        axes.scatter(
            points[:, x], points[:, y], c=[colors[k] for k in labels], s=7, linewidths=0, gid="answers"
        )
    for x, y, axes in panels.above():
        _draw_snapshots(axes, model, (x, y), colors)
    if len(names) > 1:
        panels.axes[1, 0].set_title("answers")
        panels.axes[0, 1].set_title("snapshots")
    handles = [
        Line2D(
            [],
            [],
            marker="o",
            linestyle="none",
            color=color,
            label=f"cluster {cluster.name}: {len(cluster.training_points)} snapshots",
        )
        for cluster, color in zip(model.clusters, colors, strict=True)
    ]
    panels.figure.legend(handles=handles, loc="outside upper center", ncols=min(4, len(handles)))
    return panels.figure


def _draw_shares(
    axes: Axes, values: FloatArray, labels: IntArray, limits: tuple[float, float], colors: list[str]
) -> None:
    edges = np.linspace(*limits, N_BARS + 1)
    counts = np.array([np.histogram(values[labels == k], edges)[0] for k in range(len(colors))])
    shares = counts / np.maximum(counts.sum(axis=0), 1)
    bottom = np.zeros(N_BARS)
    for share, color in zip(shares, colors, strict=True):
        axes.bar(edges[:-1], share, np.diff(edges), bottom, color=color, align="edge", gid="share")
        bottom += share
    axes.set_ylim(0.0, 1.0)


def _draw_snapshots(axes: Axes, model: Model, places: tuple[int, int], colors: list[str]) -> None:
    seen = np.zeros(len(model.training_points), dtype=bool)
    for cluster, color in zip(model.clusters, colors, strict=True):
        members = cluster.training_points
        points = model.training_points[np.ix_(members, places)]
        is_more = seen[members]
        axes.scatter(*points[~is_more].T, c=color, s=7, linewidths=0, gid="snapshots")
        axes.scatter(
            *points[is_more].T, facecolors="none", edgecolors=color, s=24, linewidths=0.8, gid="more"
        )
        seen[members] = True
