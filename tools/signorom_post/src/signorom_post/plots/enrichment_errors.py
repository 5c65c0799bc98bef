# SPDX-License-Identifier: BSD-3-Clause
"""Figures of errors at one point while hat functions are added to the basis (paper, Figures 3 and 10)."""

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from signorom_post.arrays import FloatArray, IntArray
from signorom_post.style import BLUE, ORANGE, VERMILLION, finish_percent_axis, new_figure

COLORS = (BLUE, ORANGE)
MARKERS = ("o", "s")


@dataclass(frozen=True)
class ErrorSeries:
    """Errors before the first hat function and after each one; all arrays have the same length."""

    label: str
    #: number of columns of the basis
    sizes: IntArray
    #: kappa (11), infinite as long as the contact rows do not have full rank
    condition_numbers: FloatArray
    #: primal (displacement) and dual (contact force) errors; 1 is 100 %
    primal: FloatArray
    dual: FloatArray
    #: number of hats after which the contact rows have full rank for the first time; None: never
    first_solvable: int | None


def errors_and_kappa(series: ErrorSeries) -> Figure:
    """Returns a figure of both errors over kappa: dual error on the left, primal error on the right.

    Points are left out where kappa is infinite, or where the error is zero or not finite.
    """
    figure = new_figure(8.2, 3.6)
    left, right = figure.subplots(1, 2)
    for axes, values, text in (
        (left, series.dual, r"dual error $e_\lambda$ on the RID [%]"),
        (right, series.primal, "primal error $e_u$ [%]"),
    ):
        _draw(axes, series.condition_numbers, values, series, 0)
        axes.set_ylabel(text)
        finish_percent_axis(axes)
        _over_kappa(axes)
    return figure


def errors_and_size(all_series: list[ErrorSeries]) -> Figure:
    """Returns a figure of the dual errors of one or two series: over the size of the basis, and over kappa.

    Errors that are zero or not finite are left out, and over kappa those where kappa is infinite. Dashed lines mark the
    first full rank of each series.
    """
    figure = new_figure(8.2, 3.8)
    left, right = figure.subplots(1, 2, sharey=True)
    for i, series in enumerate(all_series):
        _draw(left, series.sizes.astype(np.float64), series.dual, series, i)
        _draw(right, series.condition_numbers, series.dual, series, i)
        if series.first_solvable is None:
            continue
        for axes, x in ((left, series.sizes), (right, series.condition_numbers)):
            line = axes.axvline(float(x[series.first_solvable]), color=VERMILLION, linewidth=1.0)
            line.set(linestyle="--", gid="solvable", zorder=1)
            if axes is left and i == 0:
                line.set_label("first full rank (11)")
    left.set_ylabel(r"dual error $e_\lambda$ on the RID [%]")
    left.set_xlabel(r"size of the basis, $\bar{\ell}$")
    left.xaxis.set_major_locator(MaxNLocator(integer=True))
    for axes in (left, right):
        finish_percent_axis(axes)
    _over_kappa(right)
    figure.legend(*left.get_legend_handles_labels(), loc="outside upper center", ncols=3, columnspacing=1.8)
    return figure


def _draw(axes: Axes, x: FloatArray, errors: FloatArray, series: ErrorSeries, i: int) -> None:
    shown = np.isfinite(x) & np.isfinite(errors) & (errors > 0.0)
    style = {"color": COLORS[i], "marker": MARKERS[i], "markersize": 4.0, "linewidth": 0.9}
    axes.plot(x[shown], 100.0 * errors[shown], label=series.label, gid=series.label, **style)


def _over_kappa(axes: Axes) -> None:
    axes.set_xscale("log")
    axes.set_xlabel(r"condition number $\kappa$ of the contact rows")
