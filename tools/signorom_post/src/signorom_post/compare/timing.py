# SPDX-License-Identifier: BSD-3-Clause
"""Measures the processor time of a query by the library, with the forces of all contacts and the certificate."""

import time
import warnings
from pathlib import Path

import numpy as np

from signorom_post.answer import NotAcceptedWarning
from signorom_post.online import Model

#: number of timed calls with all points; one call before them is not timed
N_REPETITIONS = 5


def query_time(path: Path, n_points: int, seed: int) -> float:
    """Returns the processor time [s] of a query of the model file `path`.

    Each of several calls answers `n_points` random points in the trained box. The result is the median time of the
    calls divided by the number of points. Only the time of this thread counts, so that other work on the machine hardly
    changes it; the time of Python itself is small, because one call answers all points. LibraryError if the online
    library cannot be used, ModelError if the model cannot. It gives no NotAcceptedWarning.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", NotAcceptedWarning)
        model = Model(path)
    with model:
        low = np.array([parameter.minimum for parameter in model.parameters])
        high = np.array([parameter.maximum for parameter in model.parameters])
        points = low + (high - low) * np.random.default_rng(seed).random((n_points, len(low)))
        model.query_many(points)
        seconds = []
        for _ in range(N_REPETITIONS):
            start = time.thread_time()
            model.query_many(points)
            seconds.append(time.thread_time() - start)
    return float(np.median(seconds)) / n_points
