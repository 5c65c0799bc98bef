# SPDX-License-Identifier: BSD-3-Clause
"""Figure of the verification: all its numbers in one table."""

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from signorom_post.readers.verification import VerifiedFigure
from signorom_post.style import BODY, GRAY, GREEN, INK, LIGHT_GRAY, VERMILLION, new_figure
from signorom_post.verification import HEADINGS, PASSED, table_of, verdict, worst_of_alike

#: [inch] sizes of the table
ROW_HEIGHT = 0.2
COLUMN_GAP = 0.18
MARGIN = 0.2
#: columns whose texts are aligned on the right
RIGHT_ALIGNED = ("reference", "Signorom", "difference", "allowed")


def verification_table(figures: Sequence[VerifiedFigure]) -> Figure:
    """Returns a figure with a table of verified numbers; rows of one problem should stand next to each other.

    Of similar rows (`worst_of_alike`) it shows only the worst. The verdict of a row that fails is bold and red.
    """
    rows = table_of(worst_of_alike(figures))
    widths = _column_widths([list(HEADINGS), *rows])
    width = sum(widths) + COLUMN_GAP * (len(widths) - 1) + 2 * MARGIN
    height = ROW_HEIGHT * (len(rows) + 3) + 2 * MARGIN
    figure = new_figure(width, height)
    figure.set_layout_engine("none")
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_xlim(0, width)
    axes.set_ylim(height, 0)
    axes.set_axis_off()
    top = MARGIN + ROW_HEIGHT / 2
    axes.text(MARGIN, top, f"Verification: {verdict(figures)}", fontweight="bold", va="center")
    lefts = [MARGIN + sum(widths[:i]) + COLUMN_GAP * i for i in range(len(widths))]
    _draw_row(axes, top + 1.5 * ROW_HEIGHT, list(HEADINGS), lefts, widths, GRAY)
    is_shaded = False
    for i_row, row in enumerate(rows):
        y = top + (i_row + 2.7) * ROW_HEIGHT
        is_first = i_row == 0 or row[0] != rows[i_row - 1][0]
        if is_first:
            is_shaded = not is_shaded
            axes.plot([MARGIN, width - MARGIN], [y - ROW_HEIGHT / 2] * 2, color=LIGHT_GRAY, linewidth=0.6)
        if is_shaded:
            corner = (MARGIN / 2, y - ROW_HEIGHT / 2)
            axes.add_patch(
                Rectangle(corner, width - MARGIN, ROW_HEIGHT, facecolor=BODY, edgecolor="none", zorder=0)
            )
        _draw_row(axes, y, [row[0] if is_first else "", *row[1:]], lefts, widths, INK)
    return figure


def _draw_row(
    axes: Axes, y: float, cells: list[str], lefts: list[float], widths: list[float], color: str
) -> None:
    for heading, cell, left, width in zip(HEADINGS, cells, lefts, widths, strict=True):
        is_right = heading in RIGHT_ALIGNED
        is_verdict = heading == "" and cell != ""
        is_failed = is_verdict and cell != PASSED
        axes.text(
            left + width if is_right else left,
            y,
            cell,
            ha="right" if is_right else "left",
            va="center",
            fontsize=9,
            parse_math=False,
            color=(VERMILLION if is_failed else GREEN) if is_verdict else color,
            fontweight="bold" if is_failed else "normal",
        )


def _column_widths(rows: list[list[str]]) -> list[float]:
    """Returns the width [inch] of the widest text of each column, as matplotlib draws it."""
    figure = Figure()
    renderer = FigureCanvasAgg(figure).get_renderer()
    widths = []
    for i_column in range(len(HEADINGS)):
        texts = [
            figure.text(0, 0, row[i_column], fontsize=9, parse_math=False) for row in rows if row[i_column]
        ]
        pixels = max((text.get_window_extent(renderer).width for text in texts), default=0.0)
        widths.append(pixels / figure.dpi)
    return widths
