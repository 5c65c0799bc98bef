# SPDX-License-Identifier: BSD-3-Clause
"""Figure of stick and slip: the status of each contact node over the time of one history."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from signorom_post.arrays import FloatArray, IntArray, with_unit
from signorom_post.plots.captions import surface_title
from signorom_post.plots.chains import chains_of, positions_along
from signorom_post.readers.fields import FieldFile, FieldPoint
from signorom_post.readers.surfaces import ContactSurface
from signorom_post.style import BLUE, GREEN, LIGHT_GRAY, ORANGE, new_figure

#: status in the field friction_status -> its name and color
STATES = {
    0: ("no contact row", "white"),
    1: ("open", LIGHT_GRAY),
    2: ("sticks", BLUE),
    3: ("slips", ORANGE),
    4: ("tied", GREEN),
}


def stick_slip(
    fields: FieldFile,
    history: Sequence[FieldPoint],
    surfaces: Sequence[ContactSurface],
    names: tuple[str, ...] = ("x", "y", "z"),
    unit: str = "",
) -> Figure:
    """Returns a panel for each surface: time to the right, places upwards, and the status of the step as color.

    `history`: the states of one point in the order of their times. In the plane the places are positions along the
    surface; in space all nodes stand in the order of the coordinate along which the surface is longest. A step is as
    wide as its time; the first one begins at 0. `names`: of the axes; `unit`: of the time. InputError if a state lacks
    the field friction_status.
    """
    times = np.array([0.0] + [point.parameters[point.parameter_names.index("time")] for point in history])
    status = np.stack([fields.field(point, "friction_status").values for point in history], axis=1)
    figure = new_figure(6.8, 1.0 + 1.9 * len(surfaces))
    panels = figure.subplots(len(surfaces), 1, sharex=True, squeeze=False)[:, 0]
    for axes, surface in zip(panels, surfaces, strict=True):
        _draw(axes, fields, surface, times, status, names)
    panels[-1].set_xlabel(with_unit("time", unit))
    shown = np.unique(np.concatenate([status[surface.nodes].ravel() for surface in surfaces]))
    handles = [
        Patch(facecolor=color, edgecolor=LIGHT_GRAY, label=text)
        for state, (text, color) in STATES.items()
        if state in shown
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=5)
    return figure


def _draw(
    axes: Axes,
    fields: FieldFile,
    surface: ContactSurface,
    times: FloatArray,
    status: FloatArray,
    names: tuple[str, ...],
) -> None:
    points, unit = fields.mesh.coordinates, fields.mesh.unit
    colors = ListedColormap([color for _, color in STATES.values()])
    lines: list[IntArray]
    if fields.mesh.n_dim == 2:
        lines = chains_of(surface.facets, points)
        places, label = positions_along(lines, points, (names[0], names[1]), unit)
        # the panels are too low for a long label
        label = label.removeprefix("position on the contact surface, ").replace(
            " along the contact surface", ""
        )
    else:
        axis = int(np.argmax(np.ptp(points[surface.nodes], axis=0)))
        lines = [surface.nodes[np.argsort(points[surface.nodes, axis], kind="stable")]]
        places = [np.arange(1.0, len(lines[0]) + 1)]
        label = f"contact nodes along ${names[axis]}$"
    for line, place in zip(lines, places, strict=True):
        style = {"cmap": colors, "vmin": -0.5, "vmax": len(STATES) - 0.5, "rasterized": True}
        axes.pcolormesh(times, _borders(place), status[line], gid="status", **style)
    axes.set_ylabel(label)
    axes.set_title(surface_title(surface.name))


def _borders(places: FloatArray) -> FloatArray:
    """Returns the middles between places, and the first and the last one; those of a place alone are 1 apart."""
    if len(places) == 1:
        return places[0] + np.array([-0.5, 0.5])
    return np.concatenate([places[:1], (places[1:] + places[:-1]) / 2, places[-1:]])
