# SPDX-License-Identifier: BSD-3-Clause
"""Hollow cylinder with a temperature that depends on the radius: Timoshenko and Goodier, Theory of Elasticity, 150-151.

The integral of T r from the inner radius to r is all that the profile enters by. `held`: e_z = 0; `thin`: sigma_z = 0.
"""

from dataclasses import dataclass

import numpy as np


@dataclass
class ThermalCylinder:
    """Temperatures are rises: no strain at 0."""

    young_modulus: float
    poisson_ratio: float
    expansion: float
    inner_radius: float
    outer_radius: float
    temperature: object
    #: integral of temperature(r) r from the inner radius to r
    moment: object
    ends: str = "held"

    def stress(self, r):
        """Radial, circumferential and axial stress."""
        a, b = self.inner_radius**2, self.outer_radius**2
        factor = self.expansion * self.young_modulus
        if self.ends == "held":
            factor /= 1 - self.poisson_ratio
        whole, part = self.moment(self.outer_radius), self.moment(r)
        radial = factor / r**2 * ((r**2 - a) / (b - a) * whole - part)
        hoop = factor / r**2 * ((r**2 + a) / (b - a) * whole + part - self.temperature(r) * r**2)
        axial = 0 * r
        if self.ends == "held":
            rise = self.expansion * self.temperature(r)
            axial = self.poisson_ratio * (radial + hoop) - self.young_modulus * rise
        return radial, hoop, axial

    def displacement(self, r):
        """u_r = r e_t = r ((sigma_t - nu (sigma_r + sigma_z)) / E + alpha T)."""
        radial, hoop, axial = self.stress(r)
        elastic = (hoop - self.poisson_ratio * (radial + axial)) / self.young_modulus
        return r * (elastic + self.expansion * self.temperature(r))


def parabolic(rise, inner, outer):
    """T = rise (1 - (r / outer)^2) as an expression of a deck, a function, and its moment."""
    return (
        f"{rise!r} * (1 - (r / {outer!r})^2)",
        lambda r: rise * (1 - (r / outer) ** 2),
        lambda r: rise * ((r**2 - inner**2) / 2 - (r**4 - inner**4) / (4 * outer**2)),
    )


def logarithmic(rise, inner, outer):
    """T = rise ln(outer / r) / ln(outer / inner), of steady conduction, likewise."""
    scale = rise / np.log(outer / inner)

    def primitive(r):
        """Of r ln(outer / r)."""
        return r**2 / 2 * np.log(outer / r) + r**2 / 4

    return (
        f"{rise!r} * ln({outer!r} / r) / ln({outer!r} / {inner!r})",
        lambda r: scale * np.log(outer / r),
        lambda r: scale * (primitive(r) - primitive(inner)),
    )


def bimetal_curvature(thicknesses, young_moduli, expansions, rise):
    """Timoshenko, J. Opt. Soc. Am. 11 (1925) 233, equation (4): strips 1 and 2, free, both heated."""
    m, n = thicknesses[0] / thicknesses[1], young_moduli[0] / young_moduli[1]
    height = sum(thicknesses)
    difference = (expansions[1] - expansions[0]) * rise
    return 6 * difference * (1 + m) ** 2 / (height * (3 * (1 + m) ** 2 + (1 + m * n) * (m**2 + 1 / (m * n))))
