# SPDX-License-Identifier: BSD-3-Clause
"""One look for all figures: colours, sizes, and how a figure is made and written without a display."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

# Okabe and Ito's palette, told apart by every common kind of colour vision
BLACK = "#000000"
ORANGE = "#E69F00"
SKY_BLUE = "#56B4E9"
GREEN = "#009E73"
YELLOW = "#F0E442"
BLUE = "#0072B2"
VERMILLION = "#D55E00"
PURPLE = "#CC79A7"

CLUSTER_COLORS = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY_BLUE)

INK = "#262626"
GRAY = "#8C8C8C"
LIGHT_GRAY = "#D4D4D4"
BODY = "#F1F1F1"

#: of quantities >= 0: perceptually uniform and safe for colour-blind readers
SEQUENTIAL = "viridis"

#: [1/inch] of png files and of the shaded parts of pdf and svg files
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
    """The style, for figures made and saved in this block; the process's own settings come back after it."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(PARAMETERS)
        yield


def cluster_colors(n: int) -> list[str]:
    """Colors of n clusters; beyond six they are spread over the wheel."""
    if n <= len(CLUSTER_COLORS):
        return list(CLUSTER_COLORS[:n])
    return [mpl.colors.to_hex(mpl.colormaps["turbo"](value)) for value in np.linspace(0.05, 0.95, n)]


def new_figure(width: float, height: float, has_equal_axes: bool = False) -> Figure:
    """An empty figure of this size [inch] that needs no display; axes of equal scales are moved together."""
    figure = Figure(figsize=(width, height), layout="compressed" if has_equal_axes else "constrained")
    FigureCanvasAgg(figure)
    return figure


def save(figure: Figure, path: Path) -> None:
    """Write the figure in the format of the path's ending; two runs write the same bytes."""
    metadata = {".png": {"Software": None}, ".pdf": {"CreationDate": None}, ".svg": {"Date": None}}
    figure.savefig(path, dpi=RESOLUTION, metadata=metadata.get(path.suffix, {}))


def ordered_colors(n: int) -> list[tuple[float, float, float, float]]:
    """Colours of n curves in the order of a parameter; the palest end of the map is left out."""
    positions = np.linspace(0.0, 0.76, n) if n > 1 else np.array([0.25])
    return [tuple(color) for color in mpl.colormaps[SEQUENTIAL](positions)]


def finish_percent_axis(axes: Axes) -> None:
    """A logarithmic y axis with plain numbers at 1, 2, 5, 10, ... and a grid."""
    axes.set_yscale("log")
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.yaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_formatter(NullFormatter())
    add_grid(axes)


def add_grid(axes: Axes) -> None:
    """A quiet grid behind the curves."""
    axes.grid(visible=True, which="major")
