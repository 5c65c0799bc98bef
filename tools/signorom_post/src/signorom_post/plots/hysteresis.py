# SPDX-License-Identifier: BSD-3-Clause
"""Figure of one column of history.csv over another one, such as friction over a displacement: a loop for a cycle."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from signorom_post.plots.histories import LINES
from signorom_post.readers.histories import Curve
from signorom_post.style import add_grid, cluster_colors, new_figure


def hysteresis(curves: Sequence[Curve], labels: tuple[str, str]) -> Figure:
    """Returns the curves of at most the first four points, each from its first state, a dot, to its last, an arrow.

    `labels`: of the two axes, with units.
    """
    points = curves[: len(LINES)]
    figure = new_figure(5.6, 4.2)
    axes = figure.subplots()
    colors = cluster_colors(len(points))
    for curve, line, color in zip(points, LINES, colors, strict=False):
        text = ", ".join(f"{name} = {value:.4g}" for name, value in curve.point.items())
        axes.plot(curve.x, curve.y, line, color=color, label=text or None, marker=".", markersize=3)
        axes.plot(curve.x[:1], curve.y[:1], "o", color=color, markersize=6)
        solved = np.column_stack([curve.x, curve.y])[np.isfinite(curve.x) & np.isfinite(curve.y)]
        if len(solved) > 1 and (solved[-1] != solved[-2]).any():
            axes.annotate("", solved[-1], solved[-2], arrowprops={"arrowstyle": "-|>", "color": color})
    axes.set_xlabel(labels[0])
    axes.set_ylabel(labels[1])
    add_grid(axes)
    if len(curves) > 1:
        n_left = len(curves) - len(points)
        more = f"; {n_left} more points are not shown" if n_left else ""
        figure.legend(loc="outside lower center", ncols=1, title=f"points{more}")
    return figure
