# SPDX-License-Identifier: BSD-3-Clause
"""Figure of condition numbers while hat functions are added to the basis (paper, Algorithm 1)."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from signorom_post.readers.enrichment import History
from signorom_post.style import GRAY, VERMILLION, add_grid, cluster_colors, new_figure


def enrichment(histories: list[History]) -> Figure:
    """Returns a figure. Left: kappa over the size of the basis. Right: the condition number of the reduced stiffness.

    Kappa is infinite until the contact rows have full rank. Open circles then show the ratio of the largest singular
    value to the smallest one that is not zero. For a model without clusters, a dashed line marks the first full rank if
    it needs hats.
    """
    figure = new_figure(8.2, 3.6)
    left, right = figure.subplots(1, 2)
    for history, color in zip(histories, cluster_colors(len(histories)), strict=True):
        label = f"cluster {history.cluster}" if len(histories) > 1 else r"$\kappa$, full rank"
        _draw_kappa(left, history, color, label)
        right.plot(
            history.n_columns, history.stiffness_conditions, "o-", color=color, markersize=3.5, linewidth=0.9
        )
    left.set_ylabel(r"condition number $\kappa$ of the contact rows")
    right.set_ylabel("condition number of $K_r$")
    for axes in (left, right):
        axes.set_yscale("log")
        axes.set_xlabel(r"size of the basis, $\bar{\ell}$")
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        add_grid(axes)
    first = histories[0].first_solvable()
    if len(histories) == 1 and first:
        place = float(histories[0].n_columns[first])
        left.axvline(place, color=VERMILLION, linewidth=1.0, linestyle="--", gid="solvable")
    handles, labels = left.get_legend_handles_labels()
    if any(np.isinf(history.condition_numbers).any() for history in histories):
        style: dict[str, Any] = {
            "marker": "o",
            "linestyle": "none",
            "markerfacecolor": "white",
            "markersize": 4.0,
        }
        handles.append(Line2D([], [], color=GRAY, **style))
        labels.append(r"$\sigma_1/\sigma_{\mathrm{rank}}$, rank too low")
    figure.legend(handles, labels, loc="outside upper center", ncols=4, columnspacing=1.8)
    return figure


def _draw_kappa(axes: Axes, history: History, color: str, label: str) -> None:
    is_full = np.isfinite(history.condition_numbers)
    axes.plot(history.n_columns, history.singular_ratios, "-", color=color, linewidth=0.9, alpha=0.6)
    if is_full.any():
        axes.plot(
            history.n_columns[is_full],
            history.condition_numbers[is_full],
            "o",
            color=color,
            markersize=4.0,
            label=label,
            gid="full rank",
        )
    if not is_full.all():
        axes.plot(
            history.n_columns[~is_full],
            history.singular_ratios[~is_full],
            "o",
            color=color,
            markerfacecolor="white",
            markersize=4.0,
            gid="rank too low",
        )
