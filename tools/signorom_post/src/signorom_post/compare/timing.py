# SPDX-License-Identifier: BSD-3-Clause
"""What a query costs: processor time of the library, forces of all contacts and certificate included."""

import time
from pathlib import Path

import numpy as np

from signorom_post.online import Model

#: the batch is asked so often, after a first time that does not count
N_REPETITIONS = 5


def query_time(path: Path, n_points: int, seed: int) -> float:
    """[s] Mean over random points of the trained box, asked in one call: the median of the calls.

    Processor time of this thread: other work on the machine hardly counts, and Python's own part is one call.
    """
    with Model(path) as model:
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
