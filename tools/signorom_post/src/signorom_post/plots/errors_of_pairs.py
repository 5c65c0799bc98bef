# SPDX-License-Identifier: BSD-3-Clause
"""Figure of the errors of the reduced model over three parameters or more."""

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from signorom_post.arrays import BoolArray, FloatArray
from signorom_post.plots.pairs import PairPanels
from signorom_post.readers.validation import Validation
from signorom_post.style import BLUE, ORANGE, SEQUENTIAL, VERMILLION, finish_log_axis


def texts_of(has_domain: bool) -> dict[str, tuple[str, str]]:
    """Returns the columns of validation.csv that are drawn: multiplier error -> color and label, displacement error.

    `has_domain`: the model is hyper-reduced, and its multiplier error is that on the RID.
    """
    multiplier = ("e_lambda_rid", ", RID") if has_domain else ("e_lambda_all", "")
    return {
        multiplier[0]: (ORANGE, f"multiplier error $e_\\lambda${multiplier[1]}"),
        "e_u": (BLUE, "displacement error $e_u$"),
    }


def errors_of_pairs(validation: Validation, texts: list[str], has_domain: bool) -> Figure:
    """Returns a square of panels, one row and one column per parameter; `texts` are the labels of the parameters.

    Below the diagonal: multiplier errors over each pair of parameters. Above it: displacement errors. On the diagonal:
    both errors over one parameter. Where points overlap, the larger error is on top. Off the diagonal, a cross is a
    point whose error is zero, infinite or not defined. `has_domain`: multiplier errors are those on the RID.
    """
    panels = PairPanels(texts, "error")
    points = validation.parameters
    kinds = texts_of(has_domain)
    for column, places in zip(kinds, (panels.below(), panels.above()), strict=True):
        values = validation.columns[column]
        shown = drawable(values)
        norm = LogNorm(*_limits(values[shown]))
        order = np.flatnonzero(shown)[np.argsort(values[shown], kind="stable")]
        for x, y, axes in places:
            style = {"c": values[order], "s": 11, "cmap": SEQUENTIAL, "norm": norm, "linewidths": 0}
            axes.scatter(points[order, x], points[order, y], gid=column, **style)
            axes.plot(
                points[~shown, x], points[~shown, y], "x", color=VERMILLION, markersize=4, gid="not drawable"
            )
        bar = panels.figure.colorbar(
            ScalarMappable(norm, SEQUENTIAL), ax=panels.axes, label=kinds[column][1], pad=0.01, aspect=40
        )
        bar.ax.set_in_layout(True)
        finish_log_axis(bar.ax.yaxis, values[shown])
    for i, axes in panels.diagonal():
        for column, (color, _) in kinds.items():
            values = np.where(drawable(validation.columns[column]), validation.columns[column], np.nan)
            axes.plot(points[:, i], values, ".", color=color, markersize=2.5, gid=f"{column} alone")
        axes.set_yscale("log")
        every = np.concatenate([validation.columns[column] for column in kinds])
        finish_log_axis(axes.yaxis, every[drawable(every)])
    add_key(panels.figure, validation, kinds, (" (lower left)", " (upper right)"), "x")
    return panels.figure


def drawable(values: FloatArray) -> BoolArray:
    """Returns whether a logarithmic axis can show each value, that is, whether the value is finite and positive."""
    return np.isfinite(values) & (values > 0.0)


def _limits(values: FloatArray) -> tuple[float, float]:
    if not values.size:
        return 0.1, 1.0
    low, high = float(values.min()), float(values.max())
    return low, high if high > low else 10 * low


def add_key(
    figure: Figure,
    validation: Validation,
    kinds: dict[str, tuple[str, str]],
    places: tuple[str, str] = ("", ""),
    marker: str = "",
) -> None:
    """Adds a legend above the panels with the errors `kinds`, see `texts_of`, and where each stands.

    `marker` is that of errors that the axes cannot show; empty: they are left out.
    """
    handles = [
        Line2D([], [], marker=".", linestyle="none", color=color, label=text + where)
        for (color, text), where in zip(kinds.values(), places, strict=True)
    ]
    if not all(drawable(validation.columns[column]).all() for column in kinds):
        style = {"marker": marker, "linestyle": "none", "color": VERMILLION}
        text = "zero, infinite or undefined" + ("" if marker else ": not shown")
        handles.append(Line2D([], [], label=text, **style))
    figure.legend(handles=handles, loc="outside upper center", ncols=3, columnspacing=1.8)
