# SPDX-License-Identifier: BSD-3-Clause
"""The common style of all figures: colors, sizes, and procedures that make and write a figure without a display."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import LogFormatterSciNotation, LogLocator, NullFormatter

from signorom_post.arrays import FloatArray
from signorom_post.palette import (  # noqa: F401, the colors belong to the style
    BLACK,
    BLUE,
    BODY,
    CLUSTER_COLORS,
    GRAY,
    GREEN,
    INK,
    LIGHT_GRAY,
    ORANGE,
    PURPLE,
    SEQUENTIAL,
    SKY_BLUE,
    VERMILLION,
    YELLOW,
)

#: [1/inch] resolution of png files, and of the shaded parts of pdf and svg files
RESOLUTION = 200

PARAMETERS: dict[str, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 9.5,
    "axes.labelsize": 10,
    "axes.titlesize": 10,
    "axes.titlelocation": "left",
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "xtick.labelsize": 9,
    "ytick.labelsize": 9,
    "legend.fontsize": 9,
    "legend.frameon": False,
    "legend.handlelength": 1.6,
    "grid.color": "#E6E6E6",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.6,
    "mathtext.fontset": "dejavusans",
    "pdf.fonttype": 42,
    "svg.fonttype": "none",
    "svg.hashsalt": "signorom",
}


@contextmanager
def styled() -> Iterator[None]:
    """Sets the style of the figures that are made and saved in its `with` block, then restores the settings."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(PARAMETERS)
        yield


def cluster_colors(n: int) -> list[str]:
    """Returns the colors of n clusters: fixed ones for up to six clusters, else colors spread over a color map."""
    if n <= len(CLUSTER_COLORS):
        return list(CLUSTER_COLORS[:n])
    return [mpl.colors.to_hex(mpl.colormaps["turbo"](value)) for value in np.linspace(0.05, 0.95, n)]


def new_figure(width: float, height: float, has_equal_axes: bool = False) -> Figure:
    """Returns an empty figure of this size [inch], which needs no display.

    `has_equal_axes`: the caller gives the axes equal scales; the layout then leaves no gaps between them.
    """
    figure = Figure(figsize=(width, height), layout="compressed" if has_equal_axes else "constrained")
    FigureCanvasAgg(figure)
    return figure


def save(figure: Figure, path: Path) -> None:
    """Writes the figure in the format of the path's ending: png, pdf or svg.

    The file has no date, so that two runs write the same bytes. OSError if it cannot be written.
    """
    metadata = {".png": {"Software": None}, ".pdf": {"CreationDate": None}, ".svg": {"Date": None}}
    layout = figure.get_layout_engine()
    if path.suffix == ".png" and layout is not None:
        # with a layout left to do, Matplotlib draws a figure twice
        figure.set_dpi(RESOLUTION)
        layout.execute(figure)
        figure.set_layout_engine(None)
    figure.savefig(path, dpi=RESOLUTION, metadata=metadata.get(path.suffix, {}))


def ordered_colors(n: int) -> list[tuple[float, float, float, float]]:
    """Returns the colors (RGBA) of n curves in the order of a parameter, without the palest colors of the map."""
    positions = np.linspace(0.0, 0.76, n) if n > 1 else np.array([0.25])
    return [tuple(color) for color in mpl.colormaps[SEQUENTIAL](positions)]


def finish_percent_axis(axes: Axes) -> None:
    """Makes the y axis logarithmic, with plain numbers at 1, 2, 5, 10, ..., and adds a grid."""
    axes.set_yscale("log")
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.yaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_formatter(NullFormatter())
    add_grid(axes)


def finish_log_axis(axis: Axis, values: FloatArray) -> None:
    """Sets the ticks of a logarithmic axis, so that labels do not overlap: of a short range at 1, 2 and 5.

    `values`: the positive ones that are shown.
    """
    is_short = not values.size or float(values.max()) < 100.0 * float(values.min())
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if is_short else (1.0,), numticks=9))
    axis.set_major_formatter(LogFormatterSciNotation(minor_thresholds=(np.inf, np.inf)))
    axis.set_minor_formatter(NullFormatter())


def add_grid(axes: Axes) -> None:
    """Adds a pale grid behind the curves."""
    axes.grid(visible=True, which="major")
