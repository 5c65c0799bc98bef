# SPDX-License-Identifier: BSD-3-Clause
"""Figure of contact forces along the height: full order and reduced, one over the other (paper, Figure 14)."""

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from signorom_post.arrays import FloatArray, with_unit
from signorom_post.style import INK, VERMILLION, add_grid, new_figure


@dataclass(frozen=True)
class ContactForces:
    """The contact forces of the full order and of one reduced model at one point."""

    title: str
    #: [length_unit] height of each contact, shape (n_contacts)
    position: FloatArray
    #: [force_unit] force of each contact, shape (n_contacts)
    full_order: FloatArray
    #: the same two of the contacts in the reduced domain only, shape (n_contact_rows)
    reduced_position: FloatArray
    reduced: FloatArray
    force_unit: str
    length_unit: str


def contact_forces(panels: list[ContactForces]) -> Figure:
    """Returns a figure with one panel per model.

    Each active contact of the full order is a wide line as long as its force. A narrow line with a dot at its end is
    the reduced model's force. Only contacts in the reduced domain have one; of an open one there is only the dot.
    """
    figure = new_figure(8.2, 5.4)
    all_axes = figure.subplots(1, len(panels), sharex=True, sharey=True, squeeze=False)[0]
    for axes, panel in zip(all_axes, panels, strict=True):
        _arrows(axes, panel.position, panel.full_order, INK, 2.4, "full order")
        _arrows(axes, panel.reduced_position, panel.reduced, VERMILLION, 1.1, "reduced")
        axes.plot(panel.reduced, panel.reduced_position, "o", color=VERMILLION, markersize=3.6, gid="reduced")
        axes.set_title(panel.title)
        axes.set_xlabel(with_unit(r"contact force $\lambda$", panel.force_unit))
        add_grid(axes)
    all_axes[0].set_ylabel(with_unit("height $z$", panels[0].length_unit))
    all_axes[0].set_xlim(left=0.0)
    handles = [
        Line2D([], [], color=INK, linewidth=2.4, label="full order, every contact"),
        Line2D(
            [],
            [],
            color=VERMILLION,
            linewidth=1.1,
            marker="o",
            markersize=3.6,
            label="HHR, contacts of the RID",
        ),
    ]
    figure.legend(handles=handles, loc="outside upper center", ncols=2, columnspacing=1.8)
    return figure


def _arrows(axes: Axes, position: FloatArray, force: FloatArray, color: str, width: float, gid: str) -> None:
    is_active = force != 0.0
    starts = np.zeros(int(is_active.sum()))
    axes.hlines(position[is_active], starts, force[is_active], color=color, linewidth=width, gid=gid)
