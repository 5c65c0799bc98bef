# SPDX-License-Identifier: BSD-3-Clause
"""Closed forms of plasticity and creep, D29 to D34: relaxation, cylinders, a cyclic bar, a beam; and a material point.

`python3 tests/reference/flow_formulas.py` checks them against each other, by quadrature and in limits.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq, root


def relaxation(start, modulus, coefficient, exponent, times):
    """D29: stress of a bar held at the strain start / modulus, d sigma / dt = -E A sigma^n, integrated exactly."""
    n = exponent
    return (start ** (1 - n) + (n - 1) * coefficient * modulus * np.asarray(times)) ** (1 / (1 - n))


def relaxation_steps(start, modulus, coefficient, exponent, steps):
    """The same by backward Euler: sigma_i + E A dt sigma_i^n = sigma_(i - 1)."""
    stresses = []
    for dt in steps:
        drop = modulus * coefficient * dt
        start = brentq(
            lambda s, last=start, c=drop: s + c * s**exponent - last, 0, start, xtol=1e-300, rtol=1e-15
        )
        stresses.append(start)
    return np.array(stresses)


@dataclass
class CreepingCylinder:
    """D30: thick cylinder in plane strain under inner pressure, Norton's law, steady state (Odqvist 1966; Hult 1966)."""

    inner: float
    outer: float
    pressure: float
    coefficient: float
    exponent: float

    def stresses(self, r):
        """sigma_r, sigma_axial, sigma_hoop at the radii r: hoop by equilibrium, axial by eps_z = 0."""
        b, n = self.outer, self.exponent
        whole = (b / self.inner) ** (2 / n) - 1
        power = (b / np.asarray(r)) ** (2 / n)
        radial = -self.pressure * (power - 1) / whole
        hoop = self.pressure * (1 + (2 / n - 1) * power) / whole
        return np.stack([radial, (radial + hoop) / 2, hoop], axis=-1)

    def mean_stresses(self, first, last):
        """Their means over the ring between two radii."""
        area = (last**2 - first**2) / 2
        return np.array(
            [quad(lambda r, i=i: self.stresses(r)[i] * r, first, last)[0] / area for i in range(3)]
        )

    def velocity(self, r):
        """Radial velocity r sqrt(3)/2 A sigma_eq^n, sigma_eq = sqrt(3)/2 (hoop - radial): the volume stays."""
        radial, _, hoop = self.stresses(r).T
        equivalent = np.sqrt(3) / 2 * (hoop - radial)
        return r * np.sqrt(3) / 2 * self.coefficient * equivalent**self.exponent


@dataclass
class YieldingCylinder:
    """D31: thick cylinder in plane strain under inner pressure, perfectly plastic, incompressible (Hill 1950, V.2)."""

    inner: float
    outer: float
    yield_stress: float
    young_modulus: float
    poisson_ratio: float = 0.5

    @property
    def shear_strength(self):
        """k = sigma_y / sqrt 3."""
        return self.yield_stress / math.sqrt(3)

    @property
    def limit_pressure(self):
        """2 k ln(b / a): all yields."""
        return 2 * self.shear_strength * math.log(self.outer / self.inner)

    def pressure(self, front):
        """Pressure at which the material yields up to a radius."""
        return self.shear_strength * (2 * np.log(front / self.inner) + 1 - (front / self.outer) ** 2)

    def front(self, pressure):
        """Radius up to which the material yields; that of the bore where it does not."""
        if pressure <= self.pressure(self.inner):
            return self.inner
        return brentq(lambda c: self.pressure(c) - pressure, self.inner, self.outer, xtol=1e-14)

    def displacement_of_rim(self, pressure):
        """u(b): the elastic ring outside of the front has the pressure k (1 - c^2/b^2) inside."""
        c = self.front(pressure)
        strength = self.shear_strength
        if c <= self.inner:
            strength = pressure / (1 - (c / self.outer) ** 2)
        return 2 * strength * c**2 * (1 - self.poisson_ratio**2) / (self.young_modulus * self.outer)

    def stresses(self, r, pressure):
        """sigma_r, sigma_axial, sigma_hoop at the radii r."""
        r = np.asarray(r, dtype=float)
        c, b, k = self.front(pressure), self.outer, self.shear_strength
        if c <= self.inner:
            k = pressure / (1 - (c / b) ** 2)
        inside = -pressure + 2 * k * np.log(np.minimum(r, c) / self.inner)
        radial = np.where(r < c, inside, k * c**2 * (1 / b**2 - 1 / np.maximum(r, c) ** 2))
        hoop = np.where(r < c, inside + 2 * k, k * c**2 * (1 / b**2 + 1 / np.maximum(r, c) ** 2))
        return np.stack([radial, (radial + hoop) / 2, hoop], axis=-1)

    def residual_stresses(self, r, pressure):
        """The same when the pressure is gone again, without new yielding: an elastic change (Lame)."""
        power = (self.outer / np.asarray(r)) ** 2
        whole = (self.outer / self.inner) ** 2 - 1
        elastic = pressure / whole * np.stack([1 - power, np.ones_like(power), 1 + power], axis=-1)
        return self.stresses(r, pressure) - elastic


def cyclic_bar(modulus, yield_stress, hardening, strains):
    """D32: stress of a bar under a path of strains, kinematic hardening: moves with H eps_p, +-sigma_y around it."""
    plastic, stresses = 0.0, []
    for strain in strains:
        over = modulus * (strain - plastic) - hardening * plastic
        if abs(over) > yield_stress:
            plastic += np.sign(over) * (abs(over) - yield_stress) / (modulus + hardening)
        stresses.append(modulus * (strain - plastic))
    return np.array(stresses)


@dataclass
class CreepingBeam:
    """D34: a bent beam in its steady state; plane sections, so that sigma is M sign(y) |y|^(1/n) / int |y|^(1 + 1/n)."""

    height: float
    moment: float
    exponent: float

    def stress(self, y):
        """Along the beam, per unit thickness; y from the middle."""
        m = 1 / self.exponent
        inertia = 2 * (self.height / 2) ** (2 + m) / (2 + m)
        return self.moment * np.sign(y) * np.abs(y) ** m / inertia

    def mean_stress(self, first, last):
        """Its mean between two heights on one side of the middle."""
        m = 1 / self.exponent
        inertia = 2 * (self.height / 2) ** (2 + m) / (2 + m)
        whole = (abs(last) ** (1 + m) - abs(first) ** (1 + m)) / (1 + m)
        return self.moment * whole / inertia / (last - first)


@dataclass
class Point:
    """One material point: isotropic elasticity, J2 with linear isotropic hardening, Norton's creep, by backward Euler.

    Each step solves for the six components of the inelastic strain at once by a general root finder: another way than
    the radial return of the program. Strains are tensors as 3 x 3 matrices.
    """

    young_modulus: float
    poisson_ratio: float
    yield_stress: float = np.inf
    hardening: float = 0.0
    coefficient: float = 0.0
    exponent: float = 1.0

    def __post_init__(self):
        """The virgin state."""
        self.inelastic = np.zeros((3, 3))
        self.plastic_strain = 0.0
        self.creep_strain = 0.0

    def stress(self, strain):
        """Hooke's law of the elastic strain."""
        e, nu = self.young_modulus, self.poisson_ratio
        elastic = strain - self.inelastic
        return e / (1 + nu) * (elastic + nu / (1 - 2 * nu) * np.trace(elastic) * np.eye(3))

    def advance(self, strain, dt):
        """One step to a strain; returns the stress, and keeps the state."""
        shear = self.young_modulus / (2 * (1 + self.poisson_ratio))
        start, old = self.inelastic.copy(), self.plastic_strain

        def equivalent(stress):
            deviator = stress - np.trace(stress) / 3 * np.eye(3)
            return np.sqrt(1.5 * np.sum(deviator**2)), deviator

        def missing(unknowns, is_yielding):
            flow = np.array([[unknowns[0], unknowns[3], unknowns[5]], [unknowns[3], unknowns[1], unknowns[4]],
                             [unknowns[5], unknowns[4], unknowns[2]]])  # fmt: skip
            self.inelastic = start + flow
            q, deviator = equivalent(self.stress(strain))
            growth = unknowns[6] if is_yielding else 0.0
            rate = dt * self.coefficient * q**self.exponent
            wanted = 1.5 * (growth + rate) * deviator / max(q, 1e-300)
            rest = [(flow - wanted)[i] for i in ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))]
            limit = q - self.yield_stress - self.hardening * (old + growth) if is_yielding else 0.0
            return np.array([*rest, limit / (3 * shear) if is_yielding else unknowns[6]])

        for is_yielding in (False, True):
            answer = root(missing, np.zeros(7), args=(is_yielding,), method="hybr", tol=1e-15)
            missing(answer.x, is_yielding)
            q, _ = equivalent(self.stress(strain))
            if not is_yielding and q <= self.yield_stress + self.hardening * old:
                break
        self.plastic_strain = old + (answer.x[6] if is_yielding else 0.0)
        self.creep_strain += dt * self.coefficient * q**self.exponent
        return self.stress(strain)


def check(name, found, expected, allowed):
    """Prints a comparison, and insists on it."""
    difference = np.max(np.abs(np.asarray(found) - expected)) / np.max(np.abs(expected))
    print(f"{name}: {difference:.1e}")
    assert difference <= allowed, name


def main():
    """Checks the formulas."""
    a, e, n, start = 1e-12, 2e5, 4.0, 400.0
    steps = np.full(20000, 1 / 20000)
    check(
        "relaxation by many steps",
        relaxation_steps(start, e, a, n, steps)[-1],
        relaxation(start, e, a, n, 1),
        1e-3,
    )
    creeping = CreepingCylinder(1.0, 2.0, 50.0, 1e-12, 4.0)
    check("creeping cylinder: pressure", creeping.stresses(1.0)[0], -50.0, 1e-14)
    hoop = quad(lambda r: creeping.stresses(r)[2], 1.0, 2.0)[0]
    check("creeping cylinder: equilibrium of a half", hoop, 50.0, 1e-12)
    same = [creeping.velocity(np.array([r]))[0] * r for r in (1.0, 1.3, 2.0)]
    check("creeping cylinder: volume stays", same, same[0], 1e-12)
    yielding = YieldingCylinder(1.0, 2.0, 100.0, 2e5)
    for pressure in (20.0, 60.0, 75.0):
        hoop = quad(
            lambda r, p=pressure: yielding.stresses(r, p)[2], 1.0, 2.0, points=[yielding.front(pressure)]
        )[0]
        check("yielding cylinder: equilibrium of a half", hoop, pressure, 1e-9)
    check("yielding cylinder: limit", yielding.pressure(2.0), yielding.limit_pressure, 1e-14)
    beam = CreepingBeam(2.0, 3.0, 5.0)
    check("beam: moment", 2 * quad(lambda y: beam.stress(y) * y, 0, 1)[0], 3.0, 1e-9)
    check("beam: elastic limit", CreepingBeam(2.0, 3.0, 1.0).stress(1.0), 4.5, 1e-14)
    check("beam: mean", beam.mean_stress(0.2, 0.5), quad(beam.stress, 0.2, 0.5)[0] / 0.3, 1e-10)
    check(
        "cyclic bar",
        cyclic_bar(200.0, 1.0, 20.0, [0.004, 0.01, 0.0])[1],
        1 + 200 / 11 * (0.01 - 0.005),
        1e-12,
    )
    point = Point(2e5, 0.3, 250.0, 2000.0)
    shear = np.zeros((3, 3))
    shear[0, 1] = shear[1, 0] = 0.005
    # tau = G (gamma - sqrt 3 p), sqrt 3 tau = sigma_y + H p
    g = 2e5 / 2.6
    p = (np.sqrt(3) * g * 0.01 - 250) / (3 * g + 2000)
    check("point: shear", point.advance(shear, 0.0)[0, 1], (250 + 2000 * p) / np.sqrt(3), 1e-12)
    check("point: plastic strain", point.plastic_strain, p, 1e-10)


if __name__ == "__main__":
    main()
