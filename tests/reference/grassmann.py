# SPDX-License-Identifier: BSD-3-Clause
"""Dissimilarities (13)-(16) of cells and snapshots of a small grid, in full space; `--write` makes grassmann.txt.

Principal angles by SciPy's subspace_angles (Knyazev and Argentati 2002), which knows nothing of a QR of the snapshots.
"""

import sys
from pathlib import Path

import numpy as np
from scipy.linalg import subspace_angles

N_DOFS, GRID = 40, (3, 4)
# [-] energy tail of the POD of a cell: gives dimensions 1 to 3 here
POD_TOLERANCE = 3e-2


def snapshots():
    """Two smooth functions that turn with the grid point, and a ripple in some points; some are turned over."""
    x = np.arange(1, N_DOFS + 1)[:, None] / N_DOFS
    i = np.repeat(np.arange(GRID[0]), GRID[1])[None, :]
    j = np.tile(np.arange(GRID[1]), GRID[0])[None, :]
    ripple = 0.2 * np.maximum(i + j - 2, 0) * np.sin(9 * x * (1 + j))
    return (-1.0) ** (i * j) * (np.sin(2 * x + 0.3 * i) + 0.5 * np.cos(3 * x * (1 + 0.4 * j)) + ripple)


def cells():
    """Corners of each cell, 0-based point numbers; both count with the first parameter slowest."""
    n = GRID[1]
    return [
        [i * n + j, i * n + j + 1, (i + 1) * n + j, (i + 1) * n + j + 1]
        for i in range(GRID[0] - 1)
        for j in range(n - 1)
    ]


def pod(columns):
    """Fewest left singular vectors with an energy tail below the tolerance."""
    vectors, values, _ = np.linalg.svd(columns, full_matrices=False)
    tails = np.append(np.cumsum((values**2)[::-1])[::-1], 0.0) / (values**2).sum()
    return vectors[:, : int(np.flatnonzero(tails < POD_TOLERANCE)[0])]


def distance(a, b):
    """(14)."""
    return np.sqrt(np.pi**2 / 4 * abs(a.shape[1] - b.shape[1]) + (subspace_angles(a, b) ** 2).sum())


def results():
    """Name -> matrix."""
    matrix = snapshots()
    bases = [pod(matrix[:, corners]) for corners in cells()]
    directions = matrix / np.linalg.norm(matrix, axis=0)
    cosines = np.clip(directions.T @ directions, -1, 1)
    return {
        "dimensions": np.array([[basis.shape[1] for basis in bases]]),
        "cells": np.array([[distance(a, b) for b in bases] for a in bases]),
        "lines": np.array([[distance(a[:, None], b[:, None]) for b in directions.T] for a in directions.T]),
        "signed": np.arccos(cosines),
    }


if __name__ == "__main__":
    text = ""
    for name, values in results().items():
        text += f"{name} {values.shape[0]} {values.shape[1]}\n"
        text += "".join(" ".join(f"{value:.16e}" for value in row) + "\n" for row in values)
    if "--write" in sys.argv:
        Path(__file__).with_suffix(".txt").write_text(text)
    else:
        print(text, end="")
