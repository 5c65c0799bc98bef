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
from signorom_post.style import BLUE, ORANGE, SEQUENTIAL, VERMILLION

#: columns of validation.csv
DISPLACEMENT, MULTIPLIER = "e_u", "e_lambda_rid"
#: column -> color of its dots on the diagonal, and label
TEXTS = {
    MULTIPLIER: (ORANGE, "multiplier error $e_\\lambda$, RID"),
    DISPLACEMENT: (BLUE, "displacement error $e_u$"),
}


def errors_of_pairs(validation: Validation, texts: list[str]) -> Figure:
    """Returns a square of panels, one row and one column per parameter; `texts` are the labels of the parameters.

    Below the diagonal: multiplier errors over each pair of parameters. Above it: displacement errors. On the diagonal:
    both errors over one parameter. Where points overlap, the larger error is on top. Off the diagonal, a cross is a
    point whose error is zero, infinite or not defined.
    """
    panels = PairPanels(texts, "error")
    points = validation.parameters
    for column, places in ((MULTIPLIER, panels.below()), (DISPLACEMENT, panels.above())):
        values = validation.columns[column]
        shown = _drawable(values)
        norm = LogNorm(*_limits(values[shown]))
        order = np.flatnonzero(shown)[np.argsort(values[shown], kind="stable")]
        for x, y, axes in places:
            style = {"c": values[order], "s": 11, "cmap": SEQUENTIAL, "norm": norm, "linewidths": 0}
            axes.scatter(points[order, x], points[order, y], gid=column, **style)
            axes.plot(
                points[~shown, x], points[~shown, y], "x", color=VERMILLION, markersize=4, gid="not drawable"
            )
        bar = panels.figure.colorbar(
            ScalarMappable(norm, SEQUENTIAL), ax=panels.axes, label=TEXTS[column][1], pad=0.01, aspect=40
        )
        bar.ax.set_in_layout(True)
    for i, axes in panels.diagonal():
        for column, (color, _) in TEXTS.items():
            values = np.where(_drawable(validation.columns[column]), validation.columns[column], np.nan)
            axes.plot(points[:, i], values, ".", color=color, markersize=2.5, gid=f"{column} alone")
        axes.set_yscale("log")
    _add_key(panels.figure, validation)
    return panels.figure


def _drawable(values: FloatArray) -> BoolArray:
    return np.isfinite(values) & (values > 0.0)


def _limits(values: FloatArray) -> tuple[float, float]:
    if not values.size:
        return 0.1, 1.0
    low, high = float(values.min()), float(values.max())
    return low, high if high > low else 10 * low


def _add_key(figure: Figure, validation: Validation) -> None:
    handles = [
        Line2D([], [], marker=".", linestyle="none", color=color, label=text + where)
        for (color, text), where in zip(TEXTS.values(), (" (lower left)", " (upper right)"), strict=True)
    ]
    if not all(_drawable(validation.columns[column]).all() for column in TEXTS):
        style = {"marker": "x", "linestyle": "none", "color": VERMILLION}
        handles.append(Line2D([], [], label="zero, infinite or undefined", **style))
    figure.legend(handles=handles, loc="outside upper center", ncols=3, columnspacing=1.8)
