# SPDX-License-Identifier: BSD-3-Clause
"""Figure of the decay of the singular values of the snapshots, and of the modes that are kept."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from signorom_post.arrays import FloatArray, power_of_ten
from signorom_post.readers.model import Cluster, Model
from signorom_post.style import GRAY, INK, add_grid, cluster_colors, new_figure

#: tails below this share of the tolerance are not shown: they are squares of rounding errors
SHOWN_BELOW_TOLERANCE = 1e-8


def energy_tail(singular_values: FloatArray) -> FloatArray:
    """Returns the share of the energy beyond the first l modes, for l = 0 to m; shape (m + 1); (20) of the paper.

    `singular_values`, descending, has the shape (m). The energy of a mode is its singular value squared. If all are 0,
    so is the result.
    """
    squares = singular_values**2
    tail = np.append(np.cumsum(squares[::-1])[::-1], 0.0)
    return tail / tail[0] if tail[0] > 0 else tail


def kept_modes(cluster: Cluster, tolerance: float) -> int:
    """Returns the smallest number of modes l beyond which the energy tail is below the tolerance, which is positive.

    The basis in the model may have fewer modes, because imposing the prescribed displacements on it removes some.
    """
    return int(np.argmax(energy_tail(cluster.singular_values) < tolerance))


@dataclass(frozen=True)
class Decay:
    """Singular values of a set of snapshots, and how many modes are kept."""

    singular_values: FloatArray
    #: number of modes l that are kept
    n_kept: int
    #: the energy tail beyond the kept modes is below this number
    tolerance: float
    #: text in front of l in the legend
    prefix: str = ""


def singular_values(model: Model) -> Figure:
    """Returns a figure of the singular values and energy tails of each cluster of a model, by `decays`."""
    return decays(
        [
            Decay(
                cluster.singular_values,
                kept_modes(cluster, model.pod_tolerance),
                model.pod_tolerance,
                f"cluster {cluster.name}: " if len(model.clusters) > 1 else "",
            )
            for cluster in model.clusters
        ]
    )


def decays(shown: list[Decay]) -> Figure:
    """Returns a figure. Left: singular values divided by the first one. Right: energy tails over the number of modes l.

    Filled dots are kept modes, open circles are dropped ones. On the right, dashed lines are the tolerances, and a ring
    marks the kept l.
    """
    figure = new_figure(8.2, 3.5)
    left, right = figure.subplots(1, 2)
    tolerances = sorted({decay.tolerance for decay in shown})
    floor = tolerances[0] * SHOWN_BELOW_TOLERANCE
    n_shown = max(int(np.sum(energy_tail(decay.singular_values) >= floor)) for decay in shown)
    size = float(np.clip(300.0 / n_shown, 2.0, 4.5))
    for decay, color in zip(shown, cluster_colors(len(shown)), strict=True):
        _draw(left, right, decay, color, size, INK if len(shown) == 1 else color)
    for tolerance in tolerances:
        _mark_tolerance(right, tolerance)
    left.set_xlabel("mode $i$")
    left.set_ylabel(r"$\sigma_i\,/\,\sigma_1$")
    right.set_xlabel(r"number of modes $\ell$")
    right.set_ylabel(r"energy tail  $\sum_{i>\ell}\sigma_i^2\,/\,\sum_i\sigma_i^2$")
    for axes in (left, right):
        axes.set_yscale("log")
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        axes.set_xlim(-0.03 * n_shown, 1.03 * n_shown)
        add_grid(axes)
    leading = [decay.singular_values[: n_shown + 1] for decay in shown]
    left.set_ylim(0.3 * min(values[values > 0.0].min() / values.max() for values in leading), 3.0)
    right.set_ylim(bottom=max(right.get_ylim()[0], floor))
    right.legend(loc="upper right")
    return figure


def _mark_tolerance(axes: Axes, tolerance: float) -> None:
    axes.axhline(tolerance, color=GRAY, linewidth=1.0, linestyle="--", zorder=1, gid="tolerance")
    axes.annotate(
        f"tolerance {power_of_ten(tolerance)}",
        (1.0, tolerance),
        xycoords=("axes fraction", "data"),
        xytext=(-2, 4),
        textcoords="offset points",
        ha="right",
        color="#5A5A5A",
        fontsize=9,
    )


def _draw(left: Axes, right: Axes, decay: Decay, color: str, size: float, ring: str) -> None:
    values, n_kept = decay.singular_values, decay.n_kept
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
        markeredgecolor=ring,
        label=rf"{decay.prefix}$\ell = {n_kept}$",
        gid="chosen",
    )
