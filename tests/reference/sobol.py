# SPDX-License-Identifier: BSD-3-Clause
"""First points of Sobol's sequence in ten dimensions by SciPy, whose direction numbers are Joe and Kuo's too."""

from pathlib import Path

from scipy.stats.qmc import Sobol

N_POINTS, N_PARAMETERS = 64, 10

if __name__ == "__main__":
    points = Sobol(N_PARAMETERS, scramble=False).random(N_POINTS)
    lines = [" ".join(repr(float(value)) for value in point) for point in points]
    text = "\n".join([f"points {N_POINTS} {N_PARAMETERS}", *lines, ""])
    Path(__file__).with_suffix(".txt").write_text(text)
