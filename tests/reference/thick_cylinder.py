# SPDX-License-Identifier: BSD-3-Clause
"""Two concentric tubes that touch, the inner surface pushed outwards, the outer one held (Lame; no axial strain)."""

import numpy as np

RADII = (1.0, 1.5, 2.5)
YOUNG_MODULI = (200.0, 90.0)
POISSON_RATIOS = (0.3, 0.2)
PUSH = 0.01


def stress_factors(young_modulus, poisson_ratio):
    """sigma_rr of u = A r + B / r with eps_zz = 0 is a A - b B / r^2: (a, b) = (2 (lambda + mu), 2 mu)."""
    mu = young_modulus / (2 * (1 + poisson_ratio))
    lame = young_modulus * poisson_ratio / ((1 + poisson_ratio) * (1 - 2 * poisson_ratio))
    return 2 * (lame + mu), 2 * mu


def constants():
    """(A, B) of both tubes: u = push inside, 0 outside, u and sigma_rr continuous where they touch."""
    inner, middle, outer = RADII
    factors = [stress_factors(*pair) for pair in zip(YOUNG_MODULI, POISSON_RATIOS, strict=True)]
    (a1, b1), (a2, b2) = factors
    rows = [
        [inner, 1 / inner, 0, 0],
        [0, 0, outer, 1 / outer],
        [middle, 1 / middle, -middle, -1 / middle],
        [a1, -b1 / middle**2, -a2, b2 / middle**2],
    ]
    return np.linalg.solve(rows, [PUSH, 0, 0, 0]).reshape(2, 2)


def radial_displacement(r, is_inner):
    """u at the radii r, of the inner or of the outer tube."""
    coefficients = constants()[np.where(is_inner, 0, 1)]
    return coefficients[..., 0] * r + coefficients[..., 1] / r


def contact_pressure():
    """p = -sigma_rr where the tubes touch."""
    a, b = stress_factors(YOUNG_MODULI[0], POISSON_RATIOS[0])
    first = constants()[0]
    return -(a * first[0] - b * first[1] / RADII[1] ** 2)


def stresses(r, is_inner):
    """xx, yy, zz, xy, yz, xz = radial, axial, hoop and zero shears at the radii r, shape (n, 6); axial by eps_zz = 0."""
    i = np.where(is_inner, 0, 1)
    a, b = np.array([stress_factors(*pair) for pair in zip(YOUNG_MODULI, POISSON_RATIOS, strict=True)])[i].T
    first, second = constants()[i].T
    radial, hoop = a * first - b * second / r**2, a * first + b * second / r**2
    axial = np.array(POISSON_RATIOS)[i] * (radial + hoop)
    zero = np.zeros_like(radial)
    return np.column_stack([radial, axial, hoop, zero, zero, zero])
