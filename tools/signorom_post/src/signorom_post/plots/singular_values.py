# SPDX-License-Identifier: BSD-3-Clause
"""Decay of the singular values of the snapshots, and the modes that are kept."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from signorom_post.arrays import FloatArray, power_of_ten
from signorom_post.readers.model import Cluster, Model
from signorom_post.style import GRAY, INK, add_grid, cluster_colors, new_figure

#: tails further below the tolerance are not shown: in the end they are round-off, squared
SHOWN_BELOW_TOLERANCE = 1e-8


def energy_tail(singular_values: FloatArray) -> FloatArray:
    """Share of the energy beyond the first l modes for l = 0..m, shape (m + 1): (20) of the paper."""
    squares = singular_values**2
    tail = np.append(np.cumsum(squares[::-1])[::-1], 0.0)
    return tail / tail[0] if tail[0] > 0 else tail


def kept_modes(cluster: Cluster, tolerance: float) -> int:
    """The smallest l whose tail is below the tolerance.

    Not the size of the basis in the model: imposing prescribed values on the basis takes modes away.
    """
    return int(np.argmax(energy_tail(cluster.singular_values) < tolerance))


def singular_values(model: Model) -> Figure:
    """Left: singular values relative to the first. Right: energy tail, tolerance, and the chosen l."""
    figure = new_figure(8.2, 3.5)
    left, right = figure.subplots(1, 2)
    tolerance = model.pod_tolerance
    floor = tolerance * SHOWN_BELOW_TOLERANCE
    n_shown = max(int(np.sum(energy_tail(cluster.singular_values) >= floor)) for cluster in model.clusters)
    size = float(np.clip(300.0 / n_shown, 2.0, 4.5))
    for cluster, color in zip(model.clusters, cluster_colors(len(model.clusters)), strict=True):
        prefix = f"cluster {cluster.name}: " if len(model.clusters) > 1 else ""
        _draw(left, right, cluster, kept_modes(cluster, tolerance), color, prefix, size)
    right.axhline(tolerance, color=GRAY, linewidth=1.0, linestyle="--", zorder=1, gid="tolerance")
    right.annotate(
        f"tolerance {power_of_ten(tolerance)}",
        (1.0, tolerance),
        xycoords=("axes fraction", "data"),
        xytext=(-2, 4),
        textcoords="offset points",
        ha="right",
        color="#5A5A5A",
        fontsize=9,
    )
    left.set_xlabel("mode $i$")
    left.set_ylabel(r"$\sigma_i\,/\,\sigma_1$")
    right.set_xlabel(r"number of modes $\ell$")
    right.set_ylabel(r"energy tail  $\sum_{i>\ell}\sigma_i^2\,/\,\sum_i\sigma_i^2$")
    for axes in (left, right):
        axes.set_yscale("log")
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        axes.set_xlim(-0.03 * n_shown, 1.03 * n_shown)
        add_grid(axes)
    shown = [cluster.singular_values[: n_shown + 1] for cluster in model.clusters]
    left.set_ylim(0.3 * min(values[values > 0.0].min() / values.max() for values in shown), 3.0)
    right.set_ylim(bottom=max(right.get_ylim()[0], floor))
    right.legend(loc="upper right")
    return figure


def _draw(
    left: Axes, right: Axes, cluster: Cluster, n_kept: int, color: str, prefix: str, size: float
) -> None:
    values = cluster.singular_values
    relative = np.where(values > 0.0, values, np.nan) / values.max(initial=np.finfo(float).tiny)
    modes = np.arange(1, len(values) + 1)
    tail = energy_tail(values)
    tail[tail <= 0.0] = np.nan
    for axes, x, y, first_open in (
        (left, modes, relative, n_kept),
        (right, np.arange(len(tail)), tail, n_kept + 1),
    ):
        style: dict[str, Any] = {"color": color, "markersize": size, "markeredgewidth": 0.22 * size}
        axes.plot(x, y, "-", color=color, linewidth=0.9, alpha=0.6)
        axes.plot(x[:first_open], y[:first_open], "o", gid="kept", **style)
        axes.plot(x[first_open:], y[first_open:], "o", markerfacecolor="white", gid="dropped", **style)
    right.plot(
        [n_kept],
        [tail[n_kept]],
        "o",
        color=color,
        markersize=9,
        markerfacecolor="none",
        markeredgewidth=1.6,
        markeredgecolor=INK if not prefix else color,
        label=rf"{prefix}$\ell = {n_kept}$",
        gid="chosen",
    )
