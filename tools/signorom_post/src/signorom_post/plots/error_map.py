# SPDX-License-Identifier: BSD-3-Clause
"""Figure of maps of an error over a grid of two parameters; all have one color scale (paper, Figures 11 and 13)."""

from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from signorom_post.arrays import FloatArray
from signorom_post.style import LIGHT_GRAY, SEQUENTIAL, VERMILLION, new_figure

#: [%] ends of the color scale; errors below or above have the color of the nearer end
LOWEST, HIGHEST = 0.3, 100.0


@dataclass(frozen=True)
class ErrorMap:
    """Errors at the points of a full grid, in any order; all arrays have the same length."""

    title: str
    #: [unit of each parameter] the points
    x: FloatArray
    y: FloatArray
    #: 1 is 100 %; nan: no contact in either model; infinite: contact in the reduced model only, or no answer
    errors: FloatArray


def error_maps(maps: list[ErrorMap], x_label: str = "$P_1$ [MPa]", y_label: str = "$h_1$ [mm]") -> Figure:
    """Returns a figure with one panel per map; each point is a cell in the color of its error.

    Points with the error nan are gray, and those with an infinite one are red.
    """
    figure = new_figure(8.6 if len(maps) > 1 else 5.6, 4.3)
    panels = figure.subplots(1, len(maps), sharex=True, sharey=True, squeeze=False)[0]
    for axes, item in zip(panels, maps, strict=True):
        cells = _draw(axes, item)
        axes.set_title(item.title)
        axes.set_xlabel(x_label)
    panels[0].set_ylabel(y_label)
    bar = figure.colorbar(
        cells, ax=list(panels), label=r"dual error $e_\lambda$ on the RID [%]", extend="both"
    )
    bar.ax.yaxis.set_major_formatter("{x:g}")
    kinds = {
        "no contact in either, or no full-order solution": (LIGHT_GRAY, np.isnan),
        "contact in the reduced model only, or no answer": (VERMILLION, np.isinf),
    }
    handles = [
        Patch(facecolor=color, label=text)
        for text, (color, is_kind) in kinds.items()
        if any(is_kind(item.errors).any() for item in maps)
    ]
    if handles:
        figure.legend(handles=handles, loc="outside lower center", ncols=2)
    return figure


def _draw(axes: Axes, item: ErrorMap) -> QuadMesh:
    x, i_x = np.unique(item.x, return_inverse=True)
    y, i_y = np.unique(item.y, return_inverse=True)
    percent = np.full((len(y), len(x)), np.nan)
    percent[i_y, i_x] = 100.0 * item.errors
    axes.set_facecolor(LIGHT_GRAY)
    infinite = np.ma.masked_where(~np.isinf(percent), np.ones_like(percent))
    axes.pcolormesh(
        x, y, infinite, cmap=mpl.colors.ListedColormap([VERMILLION]), gid="infinite", rasterized=True
    )
    finite = np.ma.masked_invalid(np.where(np.isfinite(percent), np.maximum(percent, 1e-9), np.nan))
    norm = LogNorm(LOWEST, HIGHEST)
    return axes.pcolormesh(x, y, finite, cmap=SEQUENTIAL, norm=norm, gid="errors", rasterized=True)
