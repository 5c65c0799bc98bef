# SPDX-License-Identifier: BSD-3-Clause
"""Hertz contact of elastic bodies: cylinder (line) and sphere (point); D2 is the NAFEMS cylinder (Konter 2006).

Source: Johnson, Contact Mechanics, 1985, 4.2. Half-spaces with parabolic gaps: finite bodies and round profiles
differ by terms of the order (a / R)^2 and (a / size)^2.
"""

from dataclasses import dataclass

import numpy as np


def contact_modulus(first, second):
    """1 / E* = (1 - nu1^2) / E1 + (1 - nu2^2) / E2; materials as (E, nu), None for a rigid body."""
    compliances = [(1 - nu**2) / modulus for modulus, nu in filter(None, (first, second))]
    return 1 / sum(compliances)


@dataclass
class Line:
    """Cylinder on a half-space, plane strain; load is the force per length P'."""

    modulus: float
    radius: float
    load: float

    @property
    def half_width(self):
        """a = sqrt(4 P' R / (pi E*))."""
        return np.sqrt(4 * self.load * self.radius / (np.pi * self.modulus))

    @property
    def peak(self):
        """p0 = 2 P' / (pi a)."""
        return 2 * self.load / (np.pi * self.half_width)

    def pressure(self, x):
        """p = p0 sqrt(1 - x^2 / a^2)."""
        return self.peak * np.sqrt(np.maximum(0.0, 1 - (np.asarray(x) / self.half_width) ** 2))


@dataclass
class Point:
    """Sphere on a half-space; load is the force F."""

    modulus: float
    radius: float
    load: float

    @classmethod
    def of_approach(cls, modulus, radius, approach):
        """F = 4/3 E* sqrt(R delta^3): from a^2 = R delta."""
        return cls(modulus, radius, 4 / 3 * modulus * np.sqrt(radius * approach**3))

    @property
    def half_width(self):
        """a = (3 F R / (4 E*))^(1/3)."""
        return (3 * self.load * self.radius / (4 * self.modulus)) ** (1 / 3)

    @property
    def approach(self):
        """delta = a^2 / R."""
        return self.half_width**2 / self.radius

    @property
    def peak(self):
        """p0 = 3 F / (2 pi a^2)."""
        return 1.5 * self.load / (np.pi * self.half_width**2)

    def pressure(self, r):
        """p = p0 sqrt(1 - r^2 / a^2)."""
        return self.peak * np.sqrt(np.maximum(0.0, 1 - (np.asarray(r) / self.half_width) ** 2))


def fit(position, pressure):
    """Half-width and peak from the closed nodes: p^2 = p0^2 (1 - x^2 / a^2) is a line in x^2 (least squares)."""
    position, pressure = np.asarray(position), np.asarray(pressure)
    is_closed = pressure > 0
    slope, constant = np.polyfit(position[is_closed] ** 2, pressure[is_closed] ** 2, 1)
    return np.sqrt(-constant / slope), np.sqrt(constant)


# D2: cylinder of R = 50 mm on a block, E = 210 and 70 GPa, nu = 0.3, 35 kN per mm; units mm, N, MPa
NAFEMS_MATERIALS = ((210e3, 0.3), (70e3, 0.3))
NAFEMS_RADIUS, NAFEMS_LOAD = 50.0, 35e3


def nafems_cylinder():
    """D2: a = 6.2146 mm, p0 = 3585.37 MPa."""
    return Line(contact_modulus(*NAFEMS_MATERIALS), NAFEMS_RADIUS, NAFEMS_LOAD)
