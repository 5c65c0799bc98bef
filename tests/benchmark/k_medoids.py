#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""k-medoids of this code beside the PyPI package kmedoids: the same matrices, the same starts in number, one thread.

    build/venv/bin/python tests/benchmark/k_medoids.py            # 500 and 2000 items, half a minute
    build/venv/bin/python tests/benchmark/k_medoids.py 10000      # 0.8 GB, a few minutes

Prints the best loss and the CPU time of all starts as ratios, ours / theirs. Target: ours is not slower on the whole.
Fails where the loss of ours is larger on average by more than what a start decides.
"""

import ctypes
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import kmedoids
import numpy as np
from timing import ROOT, command_line, tell_target

RANDOM_START = 1
#: items: random starts, repeats
CASES = {100: (10, 1), 500: (10, 3), 2000: (10, 2), 10000: (3, 1)}
# two local optima of ten starts each may differ by this much on average, either way
LOSS_MARGIN = 1e-3


class Options(ctypes.Structure):
    """`sig_k_medoids_options` of include/signorom/k_medoids.h."""

    _fields_ = [(name, ctypes.c_int) for name in ("start", "n_starts", "seed")]


def build_library(folder):
    """k_medoids.c with the flags of a release build, as a library of its own."""
    library = Path(folder) / "k_medoids.so"
    sources = [
        str(ROOT / "src" / name) for name in ("reduction/clustering/k_medoids.c", "base/random_numbers.c")
    ]
    flags = ["-std=c11", "-O2", "-shared", "-fPIC", f"-I{ROOT / 'include'}", "-D_POSIX_C_SOURCE=200809L"]
    subprocess.run(["cc", *flags, *sources, "-o", str(library), "-lm"], check=True)
    return ctypes.CDLL(str(library))


def run_ours(library, dissimilarity, n_clusters, n_starts):
    """Best loss of the starts."""
    n = len(dissimilarity)
    medoids, labels = np.zeros(n_clusters, np.int32), np.zeros(n, np.int32)
    loss = ctypes.c_double()
    status = library.sig_find_medoids(
        n,
        dissimilarity.ctypes.data_as(ctypes.POINTER(ctypes.c_double)),
        n_clusters,
        ctypes.byref(Options(RANDOM_START, n_starts, 1)),
        medoids.ctypes.data_as(ctypes.POINTER(ctypes.c_int)),
        labels.ctypes.data_as(ctypes.POINTER(ctypes.c_int)),
        ctypes.byref(loss),
    )
    assert status == 0
    assert np.isclose(loss.value, dissimilarity[:, medoids].min(axis=1).sum(), rtol=1e-10)
    return loss.value


def run_theirs(dissimilarity, n_clusters, n_starts):
    """Best loss of the starts."""
    runs = (
        kmedoids.fasterpam(dissimilarity, n_clusters, init="random", random_state=seed, n_cpu=1)
        for seed in range(n_starts)
    )
    return min(run.loss for run in runs)


def best_time(function, *arguments, repeats=3):
    """Result and smallest CPU time [s]."""
    times = []
    for _ in range(repeats):
        start = time.process_time()
        result = function(*arguments)
        times.append(time.process_time() - start)
    return result, min(times)


def matrices(n_items):
    """Name and distances of: points of a square, a cloud in eight dimensions, twelve blobs."""
    random = np.random.default_rng(20)
    blobs = random.normal(size=(12, 5))[random.integers(0, 12, n_items)] * 4
    points = {
        "square": random.uniform(size=(n_items, 2)),
        "cloud": random.normal(size=(n_items, 8)),
        "blobs": blobs + random.normal(size=(n_items, 5)),
    }
    for name, x in points.items():
        squares = (x**2).sum(axis=1)
        distances = np.sqrt(np.maximum(squares[:, None] + squares - 2 * x @ x.T, 0))
        np.fill_diagonal(distances, 0)
        yield name, np.ascontiguousarray((distances + distances.T) / 2)


def compare(library, n_items, n_starts, repeats):
    """Prints a line per case; returns mean loss ratio and ratio of the total times, for as many and twice the starts."""
    losses, seconds, theirs_total = [], np.zeros(2), 0.0
    for name, dissimilarity in matrices(n_items):
        for n_clusters in (3, 10, 30):
            case = (dissimilarity, n_clusters)
            theirs, theirs_time = best_time(run_theirs, *case, n_starts, repeats=repeats)
            ours = [best_time(run_ours, library, *case, m * n_starts, repeats=repeats) for m in (1, 2)]
            losses.append([loss / theirs for loss, _ in ours])
            seconds += [time for _, time in ours]
            theirs_total += theirs_time
            print(
                f"{n_items:6d} {name:7s} {n_clusters:3d} clusters, {n_starts:2d} starts: loss {losses[-1][0]:.5f}"
                f"  time {ours[0][1] / theirs_time:.2f} ({ours[0][1]:.3f} s / {theirs_time:.3f} s);"
                f"  twice the starts: {losses[-1][1]:.5f}, {ours[1][1] / theirs_time:.2f}"
            )
    return np.mean(losses, axis=0), seconds / theirs_total


def main():
    """A line per case and size."""
    parser = command_line(__doc__)
    parser.add_argument("sizes", nargs="*", type=int, default=[500, 2000], help=f"items: {[*CASES]}")
    options = parser.parse_args()
    is_worse, is_slower = False, False
    with tempfile.TemporaryDirectory() as folder:
        library = build_library(folder)
        for n_items in options.sizes:
            loss, seconds = compare(library, n_items, *CASES[n_items])
            is_worse = is_worse or loss[0] > 1 + LOSS_MARGIN
            is_slower = is_slower or seconds[0] > 1
            print(
                f"{n_items:6d} items: mean loss ratio {loss[0]:.5f}, time ratio {seconds[0]:.2f};"
                f"  twice the starts: {loss[1]:.5f}, {seconds[1]:.2f}"
            )
    tell_target("ours is not slower", not is_slower)
    sys.exit("the loss of ours is larger" if is_worse else None)


if __name__ == "__main__":
    main()
