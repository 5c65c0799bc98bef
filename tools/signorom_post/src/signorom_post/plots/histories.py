# SPDX-License-Identifier: BSD-3-Clause
"""Figure of histories: tables, resultant force and area of each contact of the deck over the time."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from signorom_post.arrays import FloatArray, with_unit
from signorom_post.readers.histories import PointHistory
from signorom_post.style import add_grid, cluster_colors, new_figure

#: most points in one figure, each with its own style of line
LINES = ("-", "--", ":", "-.")


def histories(shown: Sequence[PointHistory], names: Sequence[str], units: dict[str, str]) -> Figure:
    """Returns panels over the time, one below the other: tables (if there are any), contact forces, contact areas.

    At most the first four points are shown, each with its own style of line; each contact of the deck, and each table,
    has its color. `names`: the contacts; `units`: of time, force and area, empty where they are not known.
    """
    points = shown[: len(LINES)]
    has_tables = bool(points[0].tables)
    figure = new_figure(6.4, 2.0 * (2 + has_tables) + 0.9)
    panels = figure.subplots(2 + has_tables, 1, sharex=True, squeeze=False)[:, 0]
    if has_tables:
        tables = list(points[0].tables)
        _draw(panels[0], points, [np.stack(list(p.tables.values()), axis=1) for p in points], tables)
        panels[0].set_ylabel("tables")
    _draw(panels[-2], points, [point.forces for point in points], names)
    panels[-2].set_ylabel(with_unit("contact force", units.get("force", "")))
    _draw(panels[-1], points, [point.areas for point in points], names)
    panels[-1].set_ylabel(with_unit("contact area", units.get("area", "")))
    panels[-1].set_xlabel(with_unit("time", units.get("time", "")))
    if len(shown) > 1:
        texts = [
            ", ".join(f"{name} = {value:.4g}" for name, value in point.point.items()) for point in points
        ]
        handles = [
            panels[-1].plot([], [], LINES[i], color="#262626", label=text)[0] for i, text in enumerate(texts)
        ]
        more = f"; {len(shown) - len(points)} more points are not shown" if len(shown) > len(points) else ""
        figure.legend(handles=handles, loc="outside lower center", ncols=1, title=f"points{more}")
    return figure


def _draw(
    axes: Axes, points: Sequence[PointHistory], values: Sequence[FloatArray], names: Sequence[str]
) -> None:
    """Draws the columns of the values of each point, shape (n_times, n_columns), with a legend of the names."""
    colors = cluster_colors(len(names))
    for i, (point, columns) in enumerate(zip(points, values, strict=True)):
        for k, name in enumerate(names):
            label = name if i == 0 else None
            axes.plot(
                point.times, columns[:, k], LINES[i], color=colors[k], label=label, marker=".", markersize=3
            )
    axes.legend(loc="best", fontsize="small")
    add_grid(axes)
