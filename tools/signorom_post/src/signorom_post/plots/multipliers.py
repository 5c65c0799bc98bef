# SPDX-License-Identifier: BSD-3-Clause
"""Figure of the multipliers (contact forces) of both models along the contact surface (paper, Figure 6b)."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from signorom_post.arrays import BoolArray, FloatArray, format_number, with_unit
from signorom_post.readers.fields import FieldFile, FieldPoint
from signorom_post.readers.model import Model
from signorom_post.style import GRAY, INK, add_grid, new_figure, ordered_colors

#: largest number of curves; the reader could not tell more of them apart
MAX_CURVES = 6


def multipliers(fields: FieldFile, model: Model | None = None, names: tuple[str, str] = ("x", "y")) -> Figure:
    """Returns a figure of the multipliers at up to six points of the field file that have full-order multipliers.

    Lines are full-order multipliers and markers are reduced ones. A filled marker is a contact in the RID, a pale one a
    reconstructed multiplier; it is left out where both multipliers are zero. The x axis is the coordinate along which
    the surface that carries the forces is longest. If there are more than six such points, six of them are drawn,
    spread over the file; at least one must be there. `model` only gives the units of the parameters; `names` are the
    names of the axes of the mesh.
    """
    points = [point for point in fields.points if "multipliers_full_order" in point.fields]
    chosen = points if len(points) <= MAX_CURVES else [points[i] for i in _spread(len(points), MAX_CURVES)]
    chosen = sorted(chosen, key=lambda point: tuple(point.parameters))
    axis, position = _positions(fields)
    order = np.argsort(position, kind="stable")
    is_shown = np.zeros(len(position), dtype=bool)

    figure = new_figure(7.2, 4.3)
    axes = figure.subplots()
    add_grid(axes)
    axes.axhline(0.0, color=GRAY, linewidth=0.8, zorder=1)
    handles = []
    for point, color in zip(chosen, ordered_colors(len(chosen)), strict=True):
        full = fields.field(point, "multipliers_full_order")
        is_reduced = np.isin(np.arange(len(position)), point.reduced_rows)
        is_shown |= is_reduced | (full.values != 0.0)
        handles += axes.plot(
            position[order],
            full.values[order],
            color=color,
            linewidth=1.5,
            label=_value_text(point),
            zorder=2,
        )
        if "multipliers_reduced" not in point.fields:
            continue
        reduced = fields.field(point, "multipliers_reduced").values
        is_other = ~is_reduced & ((reduced != 0.0) | (full.values != 0.0))
        pale: dict[str, Any] = {
            "markerfacecolor": "white",
            "markeredgewidth": 0.8,
            "alpha": 0.55,
            "markersize": 4.0,
        }
        axes.plot(
            position[is_other], reduced[is_other], "o", color=color, zorder=3, gid="reconstructed", **pale
        )
        axes.plot(
            position[is_reduced],
            reduced[is_reduced],
            "o",
            color=color,
            markersize=6.5,
            markeredgecolor="white",
            markeredgewidth=0.8,
            zorder=4,
            gid="reduced",
        )

    _limit(axes, position, is_shown)
    surface_unit = fields.field(chosen[0], "multipliers_full_order").unit
    name = (*names, "z")[axis]
    axes.set_xlabel(with_unit(f"position on the contact surface, ${name}$", fields.mesh.unit))
    axes.set_ylabel(with_unit(r"multiplier $\lambda$", surface_unit))
    figure.legend(handles=_kinds(chosen), loc="outside upper center", ncols=3, columnspacing=1.8)
    axes.legend(
        handles=handles, title=_parameter_text(chosen[0], model), loc="upper left", bbox_to_anchor=(1.0, 1.0)
    )
    return figure


def _kinds(points: list[FieldPoint]) -> list[Line2D]:
    """Returns the entries of the legend; markers have none if there is no reduced model."""
    kinds = [Line2D([], [], color=INK, linewidth=1.5, label="full order")]
    if any("multipliers_reduced" in point.fields for point in points):
        full: dict[str, Any] = {"marker": "o", "linestyle": "none", "color": INK}
        pale = full | {"markersize": 4, "markerfacecolor": "white", "alpha": 0.55}
        kinds.append(Line2D([], [], markersize=6.5, label="HHR, on the RID", **full))
        kinds.append(Line2D([], [], label="HHR, reconstructed", **pale))
    return kinds


def _spread(n_items: int, n_chosen: int) -> list[int]:
    return sorted({round(i) for i in np.linspace(0, n_items - 1, n_chosen)})


def _positions(fields: FieldFile) -> tuple[int, FloatArray]:
    """Returns the axis (0 to 2) along which the first surface is longest, and each contact's coordinate along it."""
    coordinates = fields.mesh.coordinates[fields.contact.owners]
    i_axis = int(np.argmax(np.ptp(coordinates, axis=0)))
    return i_axis, coordinates[:, i_axis]


def _limit(axes: Axes, position: FloatArray, is_shown: BoolArray) -> None:
    """Limits the x axis, with a margin, to the contacts that are closed in the full order or that are in the RID."""
    shown = position[is_shown] if is_shown.any() else position
    margin = 0.06 * max(float(np.ptp(shown)), 0.05 * float(np.ptp(position)))
    axes.set_xlim(shown.min() - margin, shown.max() + margin)


def _value_text(point: FieldPoint) -> str:
    return ", ".join(format_number(value) for value in point.parameters)


def _parameter_text(point: FieldPoint, model: Model | None) -> str:
    return ", ".join(with_unit(name, model.unit_of(name) if model else "") for name in point.parameter_names)
