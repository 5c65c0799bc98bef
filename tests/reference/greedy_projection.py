# SPDX-License-Identifier: BSD-3-Clause
"""Greedy choice among columns by their distance from the span of those chosen, each from a QR of its own."""

from pathlib import Path

import numpy as np

N_ROWS, N_COLUMNS, N_CHOSEN = 60, 40, 24


def columns():
    """Unit vectors 1 / (1 + 8 (x - y)^2), x on [0, 1], y on [-0.2, 1.3]: smooth in y, so distances fall fast."""
    x = np.arange(N_ROWS)[:, None] / (N_ROWS - 1)
    y = -0.2 + 1.5 * np.arange(N_COLUMNS)[None, :] / (N_COLUMNS - 1)
    matrix = 1 / (1 + 8 * (x - y) ** 2)
    return matrix / np.linalg.norm(matrix, axis=0)


def distances(matrix, chosen):
    """Distance of each column from the span of the chosen ones, by Householder QR."""
    q, _ = np.linalg.qr(matrix[:, chosen])
    rest = matrix - q @ (q.T @ matrix)
    return np.linalg.norm(rest - q @ (q.T @ rest), axis=0)


def choose(matrix, chosen, n_chosen):
    """Column numbers from 0, and the distance of each at its choice (nan for those given)."""
    chosen, errors = list(chosen), [np.nan] * len(chosen)
    while len(chosen) < n_chosen:
        found = distances(matrix, chosen)
        found[chosen] = -1
        # the first of those that rounding cannot tell apart
        chosen.append(int(np.flatnonzero(found >= (1 - 1e-8) * found.max())[0]))
        errors.append(found[chosen[-1]])
    return chosen, errors


if __name__ == "__main__":
    numbers, errors = choose(columns(), [4], N_CHOSEN)
    lines = [
        f"{number + 1} {error!r}" for number, error in zip(numbers[1:], map(float, errors[1:]), strict=True)
    ]
    text = "\n".join([f"choices {N_CHOSEN - 1} 2", *lines, ""])
    Path(__file__).with_suffix(".txt").write_text(text)
