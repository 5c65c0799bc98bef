# SPDX-License-Identifier: BSD-3-Clause
"""Two bars in a row with a gap between them, nu = 0: uniaxial stress, closed form.

Both ends move: the lower one by +stroke / 4, the upper one by -3 stroke / 4, towards each other by stroke.
"""

import numpy as np

LOWER_HEIGHT, UPPER_HEIGHT = 1.0, 0.5
LOWER_MODULUS, UPPER_MODULUS = 200.0, 50.0
GAP = 0.01
LOWER_SHARE = 0.25


def pressure(stroke):
    """p = max(0, stroke - gap) / (h1 / E1 + h2 / E2): springs in series once the gap is closed."""
    compliance = LOWER_HEIGHT / LOWER_MODULUS + UPPER_HEIGHT / UPPER_MODULUS
    return max(0.0, stroke - GAP) / compliance


def vertical_displacement(y, is_lower, stroke):
    """Rigid part plus strain p / E from the driven end; lower bar in [-h1, 0], upper in [gap, gap + h2]."""
    y = np.asarray(y)
    p = pressure(stroke)
    lower = LOWER_SHARE * stroke - p * (y + LOWER_HEIGHT) / LOWER_MODULUS
    upper = -(1 - LOWER_SHARE) * stroke + p * (GAP + UPPER_HEIGHT - y) / UPPER_MODULUS
    return np.where(is_lower, lower, upper)
