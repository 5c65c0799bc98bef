# SPDX-License-Identifier: BSD-3-Clause
"""Thick cylinder under pressure inside and outside: Lamé's solution; Timoshenko and Goodier, Theory of Elasticity, 28.

sigma_r = A - B / r^2, sigma_t = A + B / r^2. Axial: free ends (`free`, sigma_z = 0) or held (`held`, e_z = 0).
"""

from dataclasses import dataclass

import numpy as np


@dataclass
class ThickCylinder:
    """Radii in any length unit; pressures push."""

    young_modulus: float
    poisson_ratio: float
    inner_radius: float
    outer_radius: float
    inner_pressure: float = 0.0
    outer_pressure: float = 0.0
    ends: str = "held"

    @property
    def constants(self):
        """A, B of the stresses from sigma_r = -p on both faces."""
        inner, outer = self.inner_radius**2, self.outer_radius**2
        b = inner * outer * (self.inner_pressure - self.outer_pressure) / (outer - inner)
        return (self.inner_pressure * inner - self.outer_pressure * outer) / (outer - inner), b

    def stress(self, r):
        """Radial, circumferential and axial stress."""
        a, b = self.constants
        axial = 2 * self.poisson_ratio * a if self.ends == "held" else 0.0
        r = np.asarray(r, dtype=float)
        return a - b / r**2, a + b / r**2, axial + 0 * r

    def displacement(self, r):
        """u_r = r e_t = r (sigma_t - nu (sigma_r + sigma_z)) / E."""
        radial, circumferential, axial = self.stress(r)
        return np.asarray(r) * (circumferential - self.poisson_ratio * (radial + axial)) / self.young_modulus
