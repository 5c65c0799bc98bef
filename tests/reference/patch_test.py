# SPDX-License-Identifier: BSD-3-Clause
"""Contact patch test: two blocks of the same material, nu = 0, pressed together over their whole faces."""

import numpy as np

YOUNG_MODULUS = 2.0e6
HEIGHT = 2.0


def pressure(stroke):
    """p = E U / H: uniaxial stress, nu = 0 (El-Abbasi and Bathe 2001; code_aster SSNP121)."""
    return YOUNG_MODULUS * stroke / HEIGHT


def vertical_displacement(y, stroke):
    """u_y = -U (y + H/2) / H with the interface at y = 0: linear, -U/2 at the interface."""
    return -stroke * (np.asarray(y) + HEIGHT / 2) / HEIGHT


def tributary_lengths(x):
    """Integral of each linear shape function over a line of nodes at x, in any order."""
    x = np.asarray(x, dtype=float)
    order = np.argsort(x)
    steps = np.diff(x[order])
    lengths = np.zeros(len(x))
    lengths[order] = 0.5 * (np.append(0.0, steps) + np.append(steps, 0.0))
    return lengths


def nodal_forces(x, stroke):
    """lambda_k = p times the tributary length: a uniform pressure on linear edges."""
    return pressure(stroke) * tributary_lengths(x)
