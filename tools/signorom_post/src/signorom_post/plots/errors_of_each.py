# SPDX-License-Identifier: BSD-3-Clause
"""Figure of the errors of the reduced model over each of many parameters."""

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, NullFormatter

from signorom_post.plots.errors_of_pairs import add_key, drawable, texts_of
from signorom_post.readers.validation import Validation
from signorom_post.style import add_grid, new_figure

#: number of panels side by side
N_COLUMNS = 4


def errors_of_each(validation: Validation, texts: list[str], has_domain: bool) -> Figure:
    """Returns a figure with a panel for each parameter: multiplier and displacement errors of all points over it.

    `texts` are the labels of the parameters. `has_domain`: multiplier errors are those on the RID. Errors that are
    zero, infinite or not defined are left out.
    """
    n = len(texts)
    n_rows = -(-n // N_COLUMNS)
    figure = new_figure(1.0 + 2.3 * min(n, N_COLUMNS), 0.8 + 2.1 * n_rows)
    panels = figure.subplots(n_rows, min(n, N_COLUMNS), sharey=True, squeeze=False).ravel()
    kinds = texts_of(has_domain)
    for i, axes in enumerate(panels[:n]):
        for column, (color, _) in kinds.items():
            values = validation.columns[column]
            shown = np.where(drawable(values), values, np.nan)
            axes.plot(validation.parameters[:, i], shown, ".", color=color, markersize=4, gid=column)
        axes.set_yscale("log")
        axes.yaxis.set_minor_formatter(NullFormatter())
        axes.xaxis.set_major_locator(MaxNLocator(3))
        axes.set_xlabel(texts[i])
        add_grid(axes)
    for axes in panels[n:]:
        axes.set_axis_off()
    for axes in panels[::N_COLUMNS]:
        axes.set_ylabel("error")
    add_key(figure, validation, kinds)
    return figure
