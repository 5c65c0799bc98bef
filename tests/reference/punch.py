# SPDX-License-Identifier: BSD-3-Clause
"""D10: flat frictionless rigid punch of width 2a on a half-plane under the force P' per length.

p = P' / (pi sqrt(a^2 - x^2)) whatever the material: Johnson, Contact Mechanics, 1985, 2.8. Singular at the edges.
"""

import numpy as np


def pressure(x, half_width, load):
    """p inside the punch."""
    return load / (np.pi * np.sqrt(half_width**2 - np.asarray(x) ** 2))


def force_up_to(x, half_width, load):
    """Integral of p from the middle to x: P' / pi asin(x / a)."""
    return load / np.pi * np.arcsin(np.clip(np.asarray(x) / half_width, -1, 1))


def nodal_forces(x, half_width, load):
    """Integral of p times each linear shape function over sorted nodes x within [-a, a]; exact.

    Antiderivatives: of p, P' / pi asin(x / a); of x p, -P' / pi sqrt(a^2 - x^2).
    """
    x = np.asarray(x, dtype=float)
    zeroth = force_up_to(x, half_width, load)
    first = -load / np.pi * np.sqrt(np.maximum(0.0, half_width**2 - x**2))
    steps = np.diff(x)
    # share of the right end: integral of (s - x_i) / h p
    right = (np.diff(first) - x[:-1] * np.diff(zeroth)) / steps
    left = np.diff(zeroth) - right
    return np.append(left, 0.0) + np.append(0.0, right)
