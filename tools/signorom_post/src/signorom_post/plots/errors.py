# SPDX-License-Identifier: BSD-3-Clause
"""Figure of the errors of the reduced model over the parameters (paper, Figure 7)."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator, NullFormatter

from signorom_post.arrays import FloatArray, with_unit
from signorom_post.plots.errors_of_each import errors_of_each
from signorom_post.plots.errors_of_pairs import drawable, errors_of_pairs
from signorom_post.readers.model import Model
from signorom_post.readers.validation import Validation
from signorom_post.style import (
    BLUE,
    GRAY,
    GREEN,
    INK,
    ORANGE,
    SEQUENTIAL,
    VERMILLION,
    add_grid,
    finish_log_axis,
    new_figure,
)

#: largest number of parameters whose pairs are shown; more panels could not be read
MOST_PAIRED = 4


@dataclass(frozen=True)
class Curve:
    """How one column of validation.csv is drawn on a panel."""

    column: str
    color: str
    marker: str
    legend: str


#: label of a panel -> its curves; the last one is drawn on top
PANELS = {
    "displacement error $e_u$": [Curve("e_u", BLUE, "o", "on $\\Omega$")],
    "multiplier error $e_\\lambda$": [
        Curve("e_lambda_all", ORANGE, "s", "on $\\Gamma^C$, reconstructed"),
        Curve("e_lambda_rid", BLUE, "o", "on the RID"),
    ],
    "energy error $e_\\mathrm{ener}$": [
        Curve("e_energy", ORANGE, "s", "on $\\Omega$"),
        Curve("e_energy_rid", BLUE, "o", "on the RID"),
    ],
}

#: column of validation.csv -> label of its map over two parameters
MAPS = {
    "e_u": "displacement error $e_u$",
    "e_energy": "energy error $e_\\mathrm{ener}$",
    "e_lambda_rid": "multiplier error $e_\\lambda$, RID",
    "e_lambda_all": "multiplier error $e_\\lambda$, all of $\\Gamma^C$",
}


def errors(validation: Validation, model: Model | None = None) -> Figure:
    """Returns a figure of the errors at all test points.

    One parameter: curves. Two: a map per error. Three or four: panels for each pair of parameters (`errors_of_pairs`).
    More: a panel for each parameter (`errors_of_each`). Errors on the RID are shown of hyper-reduced models only.
    Errors that are zero, infinite or not defined are left out of curves, and are crosses on maps. The units and, for
    one or two parameters, the training points come from `model`; without a model the figure shows neither.
    """
    if len(validation.parameter_names) == 1:
        return _over_one_parameter(validation, model)
    if len(validation.parameter_names) == 2:
        return _over_two_parameters(validation, model)
    texts = [_parameter_text(name, model) for name in validation.parameter_names]
    draw = errors_of_pairs if len(texts) <= MOST_PAIRED else errors_of_each
    return draw(validation, texts, _has_domain(model))


def _has_domain(model: Model | None) -> bool:
    """Returns whether the model is hyper-reduced, so that it has a RID; true also if the model is not known."""
    return model is None or bool(model.clusters)


def status_changes(parameter: FloatArray, n_active: FloatArray) -> FloatArray:
    """Returns the places where the contact status changes: midpoints of neighbors with different `n_active`.

    `parameter`, ascending, and `n_active`, the number of active pairs there, have the same shape (n_points).
    """
    is_change = np.diff(n_active) != 0
    return 0.5 * (parameter[:-1] + parameter[1:])[is_change]


def _over_one_parameter(validation: Validation, model: Model | None) -> Figure:
    order = np.argsort(validation.parameters[:, 0], kind="stable")
    parameter = validation.parameters[order, 0]
    columns = {name: values[order] for name, values in validation.columns.items()}
    training = _training_points(validation, model)[:, 0]
    changes = status_changes(parameter, columns["n_active_full_order"])

    figure = new_figure(8.6, 6.0)
    panels = figure.subplots(2, 2, sharex=True)
    for axes, (label, all_curves) in zip(panels.ravel(), PANELS.items(), strict=False):
        curves = all_curves if _has_domain(model) else _without_domain(all_curves)
        for curve in curves:
            _draw_curve(axes, parameter, columns[curve.column], curve)
        unit = model.energy_unit if model and "energy" in label else ""
        axes.set_ylabel(with_unit(label, unit))
        _finish_log_axis(axes, [columns[curve.column] for curve in curves])
    _draw_active(panels[1, 1], parameter, columns, _has_domain(model))
    for axes in panels.ravel():
        add_grid(axes)
        _mark(axes, training, changes)
    for axes in panels[1]:
        axes.set_xlabel(_parameter_text(validation.parameter_names[0], model))
    _add_key(figure, bool(training.size), bool(changes.size))
    return figure


def _without_domain(curves: list[Curve]) -> list[Curve]:
    """Returns the curves of a model without a RID: nothing is reconstructed."""
    kept = [curve for curve in curves if not curve.column.endswith("_rid")]
    return [replace(curve, legend=curve.legend.removesuffix(", reconstructed")) for curve in kept]


def _draw_curve(axes: Axes, parameter: FloatArray, values: FloatArray, curve: Curve) -> None:
    shown = np.where(drawable(values), values, np.nan)
    axes.plot(
        parameter,
        shown,
        marker=curve.marker,
        markersize=3.0,
        linewidth=1.0,
        color=curve.color,
        label=curve.legend,
        gid=curve.column,
    )


def _finish_log_axis(axes: Axes, curves: list[FloatArray]) -> None:
    axes.set_yscale("log")
    shown = np.concatenate([values[drawable(values)] for values in curves])
    if shown.size:
        low, high = np.floor(np.log10(shown.min())), np.ceil(np.log10(shown.max()))
        axes.set_ylim(10.0**low, 10.0 ** max(high, low + 1))
    axes.yaxis.set_minor_formatter(NullFormatter())
    _legend_above(axes)
    n_hidden = sum(int(np.sum(~drawable(values))) for values in curves)
    if n_hidden:
        text = f"{n_hidden} value{'s' if n_hidden > 1 else ''} zero, infinite or undefined: not shown"
        axes.text(0.5, 0.02, text, transform=axes.transAxes, ha="center", fontsize=8, color=VERMILLION)


def _draw_active(axes: Axes, parameter: FloatArray, columns: dict[str, FloatArray], has_domain: bool) -> None:
    text = "HHR, on the RID" if has_domain else "reduced model"
    full, reduced = columns["n_active_full_order"], columns["n_active"]
    axes.step(
        parameter,
        full,
        where="mid",
        color=INK,
        linewidth=1.1,
        label="full order, on $\\Gamma^C$",
        gid="n_active_full_order",
    )
    axes.plot(parameter, reduced, "o", color=BLUE, markersize=3.0, label=text, gid="n_active")
    axes.set_ylabel("active contact pairs")
    axes.yaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set_ylim(bottom=min(0.0, float(np.nanmin([full, reduced]))))
    _legend_above(axes)


def _legend_above(axes: Axes) -> None:
    """Puts the legend of a panel above it, where no curve can cross the legend."""
    style: dict[str, Any] = {"columnspacing": 1.5, "handletextpad": 0.5, "borderaxespad": 0.1}
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, **style)


def _mark(axes: Axes, training: FloatArray, changes: FloatArray) -> None:
    """Draws ticks on the x axis at training points, and dotted lines where the contact status changes."""
    if training.size:  # an empty artist in these coordinates would spoil the layout
        axes.plot(
            training,
            np.zeros_like(training),
            "|",
            transform=axes.get_xaxis_transform(),
            color=GREEN,
            markersize=9,
            markeredgewidth=1.2,
            clip_on=False,
            zorder=5,
            gid="training",
        )
    axes.vlines(
        changes,
        0.0,
        1.0,
        transform=axes.get_xaxis_transform(),
        color=GRAY,
        linewidth=0.7,
        linestyle=(0, (1, 2)),
        zorder=0.5,
        gid="status change",
    )


def _add_key(figure: Figure, has_training: bool, has_changes: bool) -> None:
    """Adds a legend above the panels for the marks that all panels have."""
    handles = []
    if has_training:
        style: dict[str, Any] = {"linestyle": "none", "markersize": 9, "markeredgewidth": 1.2}
        handles.append(Line2D([], [], marker="|", color=GREEN, label="training point", **style))
    if has_changes:
        handles.append(
            Line2D([], [], color=GRAY, linewidth=1.0, linestyle=(0, (1, 2)), label="change of contact status")
        )
    if handles:
        figure.legend(handles=handles, loc="outside upper center", ncols=len(handles), columnspacing=1.8)


def _over_two_parameters(validation: Validation, model: Model | None) -> Figure:
    x, y = validation.parameters[:, 0], validation.parameters[:, 1]
    training = _training_points(validation, model)
    figure = new_figure(8.6, 6.4)
    panels = figure.subplots(2, 2, sharex=True, sharey=True)
    maps = {name: text for name, text in MAPS.items() if _has_domain(model) or name != "e_lambda_rid"}
    for axes in panels.ravel()[len(maps) :]:
        axes.set_axis_off()
    for axes, (column, label) in zip(panels.ravel(), maps.items(), strict=False):
        values = validation.columns[column]
        shown = drawable(values)
        if shown.any():
            low, high = values[shown].min(), values[shown].max()
            norm = LogNorm(low, high if high > low else 10 * low)
            dots = axes.scatter(
                x[shown], y[shown], c=values[shown], s=16, cmap=SEQUENTIAL, norm=norm, gid=column
            )
            unit = model.energy_unit if model and column == "e_energy" else ""
            bar = figure.colorbar(dots, ax=axes, label=with_unit(label, unit))
            finish_log_axis(bar.ax.yaxis, values[shown])
        axes.plot(x[~shown], y[~shown], "x", color=VERMILLION, markersize=4, gid="not drawable")
        axes.plot(
            training[:, 0], training[:, 1], "+", color=INK, markersize=4, markeredgewidth=0.7, gid="training"
        )
    names = validation.parameter_names
    for axes in panels[1]:
        axes.set_xlabel(_parameter_text(names[0], model))
    for axes in panels[:, 0]:
        axes.set_ylabel(_parameter_text(names[1], model))
    handles = []
    if training.size:
        handles.append(Line2D([], [], marker="+", color=INK, linestyle="none", label="training point"))
    if any(not drawable(validation.columns[column]).all() for column in maps):
        text = "zero, infinite or undefined"
        handles.append(Line2D([], [], marker="x", color=VERMILLION, linestyle="none", label=text))
    if handles:
        figure.legend(handles=handles, loc="outside upper center", ncols=2)
    return figure


def _training_points(validation: Validation, model: Model | None) -> FloatArray:
    """Returns the training points, shape (n_points, n_parameters), with the parameters in the order of `validation`.

    There are none without a model, or if the model does not have all these parameters.
    """
    names = validation.parameter_names
    if model is None or not set(names) <= set(model.parameter_names):
        return np.empty((0, len(names)))
    return model.training_points[:, [model.parameter_names.index(name) for name in names]]


def _parameter_text(name: str, model: Model | None) -> str:
    return with_unit(name, model.unit_of(name) if model else "")
