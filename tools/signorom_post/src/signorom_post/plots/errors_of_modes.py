# SPDX-License-Identifier: BSD-3-Clause
"""Figure of errors at two points over the number of extra POD modes, with all hat functions (paper, Table 1)."""

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from signorom_post.style import BLUE, INK, ORANGE, finish_percent_axis, new_figure

STYLES = ((INK, "x", "none"), (BLUE, "o", "-"), (ORANGE, "s", "-"))


@dataclass(frozen=True)
class ModeSeries:
    """Errors; 1 is 100 %. The first index is the point, the second one the number of extra modes."""

    label: str
    primal: list[list[float]]
    dual: list[list[float]]


def errors_of_modes(extra_modes: list[int], all_series: list[ModeSeries], titles: list[str]) -> Figure:
    """Returns a figure with a column of panels per parameter point: dual error above, primal error below.

    `extra_modes` are the values along x, and `titles` are the titles of the points. There must be three series, and
    each panel shows all of them. Errors that are zero or not finite are left out.
    """
    figure = new_figure(8.2, 5.6)
    panels = figure.subplots(2, len(titles), sharex=True, sharey="row", squeeze=False)
    for i_point, title in enumerate(titles):
        for series, (color, marker, line) in zip(all_series, STYLES, strict=True):
            for axes, errors in ((panels[0, i_point], series.dual), (panels[1, i_point], series.primal)):
                values = 100.0 * np.array(errors[i_point])
                shown = np.isfinite(values) & (values > 0.0)
                x = np.array(extra_modes)[shown]
                axes.plot(
                    x,
                    values[shown],
                    color=color,
                    marker=marker,
                    linestyle=line,
                    linewidth=0.9,
                    markersize=5.0,
                    label=series.label,
                    gid=series.label,
                )
        panels[0, i_point].set_title(title)
        panels[1, i_point].set_xlabel("POD modes added")
        panels[1, i_point].set_xticks(extra_modes)
    panels[0, 0].set_ylabel(r"dual error $e_\lambda$ on the RID [%]")
    panels[1, 0].set_ylabel("primal error $e_u$ [%]")
    for axes in panels.ravel():
        finish_percent_axis(axes)
    handles = panels[0, 0].get_legend_handles_labels()
    figure.legend(*handles, loc="outside upper center", ncols=len(all_series), columnspacing=1.8)
    return figure
