# SPDX-License-Identifier: BSD-3-Clause
"""Estimates of the error where materials yield or creep: in tables of answers, over the time, and in figures."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib.collections import PolyCollection

from signorom_post.figures import FigureOptions, write_figures
from signorom_post.plots.errors_over_time import errors_over_time
from signorom_post.plots.histories import histories
from signorom_post.readers.histories import read_histories
from signorom_post.readers.validation import read_validation
from signorom_post.results import Results

#: of predict: a cluster stands between the tables and the status; the last time has no answer
ANSWERS = (
    "P,time,load,cluster,status,solver,error_bound,error_estimate,contact_1_area,contact_1_force_x,contact_1_force_y\n"
    '2,1,5,1,"answered",condensed,none,0.0,0.1,0,0\n'
    '2,2,6,1,"answered",condensed,none,1e-2,0.1,3,4\n'
    '2,3,7,1,"no answer",none,none,none,nan,nan,nan\n'
)
#: two histories of two times; at the first time one has no contact
ERRORS = (
    "P,time,cluster,e_u,e_lambda_rid,e_lambda_all,e_energy,e_energy_rid,n_active,n_active_full_order,solver,"
    "error_estimate,full_order\n"
    "2,1,1,0,nan,nan,0,0,0,0,condensed,0,converged\n2,2,1,0,1,1e-3,0,0,1,1,condensed,1e-2,converged\n"
    "3,1,1,0,1,4e-3,0,0,1,1,condensed,3e-2,converged\n3,2,1,0,1,2e-3,0,0,1,1,condensed,2e-2,converged\n"
)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Answers and errors, without fields and model."""
    (tmp_path / "history.csv").write_text(ANSWERS)
    (tmp_path / "validation.csv").write_text(ERRORS)
    return tmp_path


def test_answers_over_the_time(folder: Path) -> None:
    """The cluster is no table; forces have a band of the estimate times their size, which has a panel of its own."""
    (history,) = read_histories(folder / "history.csv")
    assert list(history.tables) == ["load"]
    assert history.estimates is not None
    np.testing.assert_array_equal(history.estimates, [0, 1e-2, np.nan])
    figure = histories([history], ["1: a - b"], {})
    panels = [axes for axes in figure.axes if axes.axison]
    assert [axes.get_ylabel() for axes in panels][-1] == "estimate of the\nerror of forces"
    assert panels[-1].get_yscale() == "log"
    (force,) = (axes for axes in panels if axes.get_ylabel() == "contact 1:\nforce")
    band = next(shape for shape in force.collections if isinstance(shape, PolyCollection))
    corners = np.concatenate([path.vertices for path in band.get_paths()])
    # 1 % of the force of 5 around its component of 3
    assert corners[corners[:, 0] == 2, 1].min() == pytest.approx(2.95)
    assert corners[corners[:, 0] == 2, 1].max() == pytest.approx(3.05)


def test_without_estimates(folder: Path) -> None:
    """Neither band nor panel."""
    (folder / "history.csv").write_text(ANSWERS.replace("error_estimate", "displacement_bound"))
    (history,) = read_histories(folder / "history.csv")
    figure = histories([history], ["1: a - b"], {})
    assert len([axes for axes in figure.axes if axes.axison]) == 3
    assert not any(isinstance(shape, PolyCollection) for axes in figure.axes for shape in axes.collections)
    (folder / "validation.csv").write_text(ERRORS.replace("error_estimate", "displacement_bound"))
    options = FigureOptions(only=("errors_over_time",))
    (outcome,) = write_figures(Results(folder), folder, "png", options)
    assert outcome.reason.endswith("there is no history whose answers have an estimate of their error")
    assert "errors_over_time" not in {
        o.name for o in write_figures(Results(folder), folder, "png", FigureOptions())
    }


def test_errors_beside_estimates(folder: Path) -> None:
    """Medians over the histories that have a number at that time."""
    figure = errors_over_time(read_validation(folder / "validation.csv"), "h")
    (axes,) = figure.axes
    assert axes.get_xlabel() == "time [h]"
    estimate, error = axes.lines
    np.testing.assert_allclose(estimate.get_ydata(), [3e-2, 1.5e-2])
    np.testing.assert_allclose(error.get_ydata(), [4e-3, 1.5e-3])
    options = FigureOptions(only=("errors_over_time",))
    (outcome,) = write_figures(Results(folder), folder, "png", options)
    assert outcome.path == folder / "errors_over_time.png"
