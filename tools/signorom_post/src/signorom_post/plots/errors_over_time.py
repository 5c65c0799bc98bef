# SPDX-License-Identifier: BSD-3-Clause
"""Figure of the errors of contact forces over the time of all test histories, beside what the answers estimate."""

import numpy as np
from matplotlib.figure import Figure

from signorom_post.arrays import FloatArray, with_unit
from signorom_post.readers.validation import Validation
from signorom_post.style import BLUE, ORANGE, add_grid, finish_log_axis, new_figure


def errors_over_time(validation: Validation, unit: str = "") -> Figure:
    """Returns, over the time, the median and the range of the errors and of the estimates at the test histories.

    The estimate is one of the forces before they were corrected at all points of the materials; the error is that of
    the answer, which has the corrected ones. Times without contact have neither. The parameters of `validation` must
    have `time`, and there must be estimates. `unit`: of the time.
    """
    assert validation.estimates is not None
    times = validation.parameters[:, validation.parameter_names.index("time")]
    figure = new_figure(6.4, 4.0)
    axes = figure.subplots()
    shown = {
        "estimate (before the correction)": (validation.estimates, ORANGE),
        "error of the answer, $e_\\lambda$": (validation.columns["e_lambda_all"], BLUE),
    }
    drawn = []
    for label, (values, color) in shown.items():
        places, low, middle, high = _range_of(times, values)
        axes.fill_between(places, low, high, color=color, alpha=0.25, linewidth=0)
        axes.plot(places, middle, color=color, marker=".", markersize=3, label=label)
        drawn += [low[np.isfinite(low)], high[np.isfinite(high)]]
    axes.set_yscale("log")
    finish_log_axis(axes.yaxis, np.concatenate(drawn))
    axes.set_xlabel(with_unit("time", unit))
    axes.set_ylabel("relative error of the contact forces")
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2)
    add_grid(axes)
    return figure


def _range_of(times: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Returns the times, and least, median and largest of the positive numbers at each; nan where there is none."""
    places = np.unique(times)
    rows = np.full((3, len(places)), np.nan)
    for i, time in enumerate(places):
        there = values[times == time]
        there = there[np.isfinite(there) & (there > 0)]
        if there.size:
            rows[:, i] = there.min(), np.median(there), there.max()
    return places, rows[0], rows[1], rows[2]
