# SPDX-License-Identifier: BSD-3-Clause
"""Figure of the errors of the reduced model over each of many parameters."""

import numpy as np
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.ticker import MaxNLocator

from signorom_post.plots.errors_of_pairs import add_key, drawable, texts_of
from signorom_post.readers.validation import Validation
from signorom_post.style import add_grid, finish_log_axis, new_figure

#: number of panels side by side
N_COLUMNS = 4


def errors_of_each(validation: Validation, texts: list[str], has_domain: bool) -> Figure:
    """Returns a figure with a panel for each parameter: multiplier and displacement errors of all points over it.

    `texts` are the labels of the parameters. `has_domain`: multiplier errors are those on the RID. Errors that are
    zero, infinite or not defined are left out.
    """
    n = len(texts)
    n_rows = -(-n // N_COLUMNS)
    figure = new_figure(1.2 + 2.4 * min(n, N_COLUMNS), 0.8 + 2.1 * n_rows)
    panels = figure.subplots(n_rows, min(n, N_COLUMNS), sharey=True, squeeze=False).ravel()
    kinds = texts_of(has_domain)
    every = np.concatenate([validation.columns[column] for column in kinds])
    for i, axes in enumerate(panels[:n]):
        for column, (color, _) in kinds.items():
            values = validation.columns[column]
            shown = np.where(drawable(values), values, np.nan)
            axes.plot(validation.parameters[:, i], shown, ".", color=color, markersize=4, gid=column)
        axes.set_yscale("log")
        finish_log_axis(axes.yaxis, every[drawable(every)])
        axes.xaxis.set_major_locator(MaxNLocator(3))
        axes.set_xlabel(texts[i])
        add_grid(axes)
    for axes in panels[n:]:
        axes.set_axis_off()
    for axes in panels[::N_COLUMNS]:
        axes.set_ylabel("error")
    # the last number below a panel must not touch the first one of the next panel
    layout = figure.get_layout_engine()
    assert isinstance(layout, ConstrainedLayoutEngine)
    layout.set(w_pad=0.12)
    add_key(figure, validation, kinds)
    return figure
