# SPDX-License-Identifier: BSD-3-Clause
"""Figure of histories: tables, forces, areas, and with friction slip and work of each contact over the time."""

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from signorom_post.arrays import FloatArray, with_unit
from signorom_post.readers.histories import PointHistory
from signorom_post.style import add_grid, cluster_colors, finish_log_axis, new_figure

#: most points in one figure, each with its own style of line
LINES = ("-", "--", ":", "-.")
#: up to so many panels stand in one column; more of them in two
MOST_BELOW = 4
#: most characters in a line of a legend, 6 for each line beside its name
MOST_CHARACTERS = 66

#: label of y, and what the curves are: name -> values of a point, shape (n_times)
_Panel = tuple[str, dict[str, Callable[[PointHistory], FloatArray]]]


def histories(shown: Sequence[PointHistory], names: Sequence[str], units: dict[str, str]) -> Figure:
    """Returns panels over the time: one for each table, then one for the resultant force of each contact.

    Behind them all contacts share a panel of the areas that touch, and those with friction a panel of the share of this
    area that slips and one of the work of friction since the beginning. Where answers have an estimate of their error,
    forces have a band of this share of their size, and the last panel has the estimate. At most the first four points
    are shown, each with its own style of line. Colors are the components of forces (friction is in them), else the
    contacts of the deck. `names`: the contacts; `units`: of time, force, area and work, empty where they are not known.
    """
    points = shown[: len(LINES)]
    panels = _panels(points[0], names, units)
    n_columns = 1 if len(panels) <= MOST_BELOW else 2
    n_rows = -(-len(panels) // n_columns)
    figure = new_figure(0.9 + 4.8 * n_columns, 1.9 * n_rows + 0.9)
    grid = figure.subplots(n_rows, n_columns, sharex=True, squeeze=False)
    # column by column: the tables begin the first one
    places = [axes for column in grid.T for axes in column]
    for (label, curves), axes in zip(panels, places, strict=False):
        _draw(axes, points, curves)
        axes.set_ylabel(label)
    for k in range(len(names)):
        _draw_bands(places[len(points[0].tables) + k], points, k)
    if points[0].estimates is not None:
        axes = places[len(panels) - 1]
        axes.set_yscale("log")
        estimates = np.concatenate([_estimates(point) for point in points])
        finish_log_axis(axes.yaxis, estimates[np.isfinite(estimates)])
    for axes in places[len(panels) :]:
        axes.set_axis_off()
    for column in grid.T:
        last = [axes for axes in column if axes.axison][-1]
        last.set_xlabel(with_unit("time", units.get("time", "")))
        last.tick_params(labelbottom=True)
    if len(shown) > 1:
        texts = [
            ", ".join(f"{name} = {value:.4g}" for name, value in point.point.items()) for point in points
        ]
        handles = [
            places[0].plot([], [], LINES[i], color="#262626", label=text)[0] for i, text in enumerate(texts)
        ]
        more = f"; {len(shown) - len(points)} more points are not shown" if len(shown) > len(points) else ""
        figure.legend(handles=handles, loc="outside lower center", ncols=1, title=f"points{more}")
    return figure


def _panels(first: PointHistory, names: Sequence[str], units: dict[str, str]) -> list[_Panel]:
    panels: list[_Panel] = [(table, {"": lambda p, table=table: p.tables[table]}) for table in first.tables]
    force = with_unit("force", units.get("force", ""))
    for k in range(len(names)):
        curves = {
            f"${axis}$": lambda p, i=i, k=k: p.forces[:, i, k]  # type: ignore[misc]
            for i, axis in enumerate(first.axes)
        }
        panels.append((f"contact {k + 1}:\n{force}", curves))
    panels.append(
        (
            with_unit("contact area", units.get("area", "")),
            {name: lambda p, k=k: p.areas[:, k] for k, name in enumerate(names)},  # type: ignore[misc]
        )
    )
    if first.works:
        shares = {names[k]: lambda p, k=k: p.slip_shares[k] for k in first.slip_shares}  # type: ignore[misc]
        works = {names[k]: lambda p, k=k: p.works[k] for k in first.works}  # type: ignore[misc]
        panels.append(("share of the area\nthat slips", shares))
        panels.append((with_unit("work of friction", units.get("work", "")), works))
    if first.estimates is not None:
        panels.append(("estimate of the\nerror of forces", {"": _estimates}))
    return panels


def _estimates(point: PointHistory) -> FloatArray:
    """Returns the estimates that a logarithmic axis can show, nan at the other times."""
    assert point.estimates is not None
    return np.where(point.estimates > 0, point.estimates, np.nan)


def _draw_bands(axes: Axes, points: Sequence[PointHistory], contact: int) -> None:
    """Draws, around each component of a contact's force, its size times the estimate of the error."""
    colors = cluster_colors(len(points[0].axes))
    for point in points:
        if point.estimates is None:
            continue
        forces = point.forces[:, :, contact]
        half = point.estimates * np.linalg.norm(forces, axis=1)
        for force, color in zip(forces.T, colors, strict=True):
            axes.fill_between(point.times, force - half, force + half, color=color, alpha=0.25, linewidth=0)


def _draw(
    axes: Axes, points: Sequence[PointHistory], curves: dict[str, Callable[[PointHistory], FloatArray]]
) -> None:
    """Draws the curves of each point, with a legend above the panel of those that have names."""
    colors = cluster_colors(len(curves))
    for i, point in enumerate(points):
        for color, (name, values) in zip(colors, curves.items(), strict=True):
            label = name if i == 0 and name else None
            axes.plot(
                point.times, values(point), LINES[i], color=color, label=label, marker=".", markersize=3
            )
    if any(curves):
        axes.legend(
            loc="lower left",
            bbox_to_anchor=(0.0, 1.0),
            ncols=max(1, MOST_CHARACTERS // (max(map(len, curves)) + 6)),
            fontsize="small",
            borderaxespad=0.1,
        )
    add_grid(axes)
