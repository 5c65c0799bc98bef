# SPDX-License-Identifier: BSD-3-Clause
"""Closed forms of contact with Coulomb friction, D21 to D26: cylinders, spheres, a bar, a block, a press fit.

f is the coefficient of friction. Loops between +-Q obey Masing's rules: behind a reversal at Q*, the change of the
displacement is twice that of the first loading under half the change of the load; so a cycle dissipates
4 Q* d(Q*) - 8 int_0^Q* d dQ, where d(Q) is the first loading.

`python3 tests/reference/friction_formulas.py` checks the formulas by quadrature, against each other and in limits.
"""

import itertools
from dataclasses import dataclass

import numpy as np

import hertz
import shrink_fit
from coulomb_steps import Steps, check


def half_ellipse(x, half_width):
    """sqrt(c^2 - x^2), 0 outside."""
    return np.sqrt(np.maximum(0.0, half_width**2 - np.asarray(x, dtype=float) ** 2))


@dataclass
class LineSlip:
    """D21, D22: cylinders of elastically similar materials in plane strain, pressed by P', then sheared.

    Cattaneo 1938, Mindlin 1949; Johnson, Contact Mechanics, 1985, 7.2; unloading: Mindlin and Deresiewicz 1953,
    Johnson 7.4. Forces per length; half-planes, so finite bodies differ by terms of the order (a / size)^2.
    """

    normal: hertz.Line
    friction: float

    @property
    def limit(self):
        """f P': all of the contact slips."""
        return self.friction * self.normal.load

    def stick_half_width(self, shear):
        """c = a sqrt(1 - Q' / (f P'))."""
        return self.normal.half_width * np.sqrt(1 - shear / self.limit)

    def traction(self, x, shear):
        """q = f p0 / a (sqrt(a^2 - x^2) - sqrt(c^2 - x^2))."""
        a, scale = self.normal.half_width, self.friction * self.normal.peak / self.normal.half_width
        return scale * (half_ellipse(x, a) - half_ellipse(x, self.stick_half_width(shear)))

    def slip(self, x, shear):
        """Slip in c < x < a: 2 f p0 / (a E*) int_c^x sqrt(t^2 - c^2) dt.

        The slope of the relative displacement is 2 / (pi E*) PV int q(s) / (x - s) ds, which two ellipses make
        2 f p0 / (a E*) sqrt(x^2 - c^2) there, and 0 in the stick zone.
        """
        x, c = np.abs(np.asarray(x, dtype=float)), self.stick_half_width(shear)
        scale = self.friction * self.normal.peak / (self.normal.half_width * self.normal.modulus)
        root = np.sqrt(np.maximum(0.0, x**2 - c**2))
        return scale * (x * root - c**2 * np.log((x + root) / np.minimum(x, c))) * (x > c)

    def reverse_half_width(self, largest, shear):
        """Unloaded from Q* to Q, beyond c' = a sqrt(1 - (Q* - Q) / (2 f P')) the contact slips back."""
        return self.normal.half_width * np.sqrt(1 - (largest - shear) / (2 * self.limit))

    def unloaded_traction(self, x, largest, shear):
        """q(Q*) - 2 f p0 / a (sqrt(a^2 - x^2) - sqrt(c'^2 - x^2))."""
        a, scale = self.normal.half_width, 2 * self.friction * self.normal.peak / self.normal.half_width
        back = half_ellipse(x, a) - half_ellipse(x, self.reverse_half_width(largest, shear))
        return self.traction(x, largest) - scale * back

    def dissipation(self, largest):
        """Of a cycle +-Q': (f P')^2 / (pi E*) (4 k (m log m + k) - 8 I), k = Q' / (f P'), m = 1 - k.

        The compliance is that of a flat punch as wide as the stick zone, -log(c^2) / (pi E*) but for a constant that a
        cycle does not feel: d = f P' / (pi E*) (m log m + k), I = int_0^k of (m log m + k).
        """
        k = largest / self.limit
        m = 1 - k
        integral = 0.25 - m**2 / 2 * np.log(m) + 0.75 * m**2 - m
        return self.limit**2 / (np.pi * self.normal.modulus) * (4 * k * (m * np.log(m) + k) - 8 * integral)


@dataclass
class PointSlip:
    """D23: spheres pressed by F, then sheared by Q along one axis. Mindlin 1949; Johnson 7.2, 7.4.

    Exact for nu = 0 apart from the slip across Q, which is neglected. `softness` is (2 - nu1) / G1 + (2 - nu2) / G2.
    """

    normal: hertz.Point
    friction: float
    softness: float

    @classmethod
    def of_materials(cls, first, second, radius, load, friction):
        """Materials as (E, nu), None for a rigid body."""
        bodies = [body for body in (first, second) if body]
        softness = sum((2 - nu) * 2 * (1 + nu) / modulus for modulus, nu in bodies)
        return cls(hertz.Point(hertz.contact_modulus(first, second), radius, load), friction, softness)

    @property
    def limit(self):
        """f F."""
        return self.friction * self.normal.load

    @property
    def scale(self):
        """3 f F / (16 a) ((2 - nu1) / G1 + (2 - nu2) / G2)."""
        return 3 * self.limit / (16 * self.normal.half_width) * self.softness

    def stick_radius(self, shear):
        """c = a (1 - Q / (f F))^(1/3)."""
        return self.normal.half_width * (1 - shear / self.limit) ** (1 / 3)

    def traction(self, r, shear):
        """As in the plane: q = f p0 / a (sqrt(a^2 - r^2) - sqrt(c^2 - r^2))."""
        scale = self.friction * self.normal.peak / self.normal.half_width
        ellipses = [half_ellipse(r, radius) for radius in (self.normal.half_width, self.stick_radius(shear))]
        return scale * (ellipses[0] - ellipses[1])

    def approach(self, shear):
        """Relative displacement of points far away: 3 f F / (16 a) (...) (1 - (1 - Q / (f F))^(2/3))."""
        return self.scale * (1 - (1 - shear / self.limit) ** (2 / 3))

    def reverse_radius(self, largest, shear):
        """c' = a (1 - (Q* - Q) / (2 f F))^(1/3)."""
        return self.normal.half_width * (1 - (largest - shear) / (2 * self.limit)) ** (1 / 3)

    def unloaded_approach(self, largest, shear):
        """Behind the reversal at Q*: 2 (1 - (Q* - Q) / (2 f F))^(2/3) - (1 - Q* / (f F))^(2/3) - 1 times the scale."""
        back = (1 - (largest - shear) / (2 * self.limit)) ** (2 / 3)
        return self.scale * (2 * back - (1 - largest / self.limit) ** (2 / 3) - 1)

    def dissipation(self, largest):
        """Of a cycle +-Q: 9 f^2 F^2 / (10 a) (...) (1 - m^(5/3) - 5 k / 6 (1 + m^(2/3))), k = Q / (f F), m = 1 - k."""
        k = largest / self.limit
        m = 1 - k
        scale = 0.9 * self.limit**2 / self.normal.half_width * self.softness
        return scale * (1 - m ** (5 / 3) - 5 * k / 6 * (1 + m ** (2 / 3)))


@dataclass
class Bar:
    """D24: a long bar of stiffness E A on a rough floor, pulled at its end; limit: friction per length, f p b.

    Equilibrium and Hooke's law: the normal force falls by the limit per length from P at the end, u'' = limit / (E A).
    """

    stiffness: float
    limit: float

    def slip_length(self, pull):
        """P / limit."""
        return np.abs(pull) / self.limit

    def end(self, pull):
        """P^2 / (2 E A limit), signed."""
        return np.sign(pull) * pull**2 / (2 * self.stiffness * self.limit)

    def displacement(self, x, pull):
        """At the distance x from the end: (l - x)^2 limit / (2 E A) up to the slip length l."""
        left = np.maximum(0.0, self.slip_length(pull) - np.asarray(x, dtype=float))
        return np.sign(pull) * left**2 * self.limit / (2 * self.stiffness)

    def unloaded_end(self, largest, pull):
        """From P* to P: end(P*) - 2 end((P* - P) / 2); at P = 0 there remains P*^2 / (4 E A limit)."""
        return self.end(largest) - 2 * self.end((largest - pull) / 2)

    def unloaded_displacement(self, x, largest, pull):
        """As unloaded_end, at the distance x."""
        return self.displacement(x, largest) - 2 * self.displacement(x, (largest - pull) / 2)

    def dissipation(self, largest):
        """Of a cycle +-P: 2 P^3 / (3 E A limit)."""
        return 2 * largest**3 / (3 * self.stiffness * self.limit)


def wedge(weight, angle, friction):
    """D25: block on a slope, by equilibrium: force normal to it and along it, and whether it stays: tan(angle) <= f."""
    return weight * np.cos(angle), weight * np.sin(angle), bool(np.tan(angle) <= friction)


@dataclass
class PressFit:
    """D26: two rings of one length, pressed onto each other by p (Lamé) at the radius r; the rest by equilibrium."""

    pressure: float
    radius: float
    length: float
    friction: float

    @classmethod
    def of_shrink_fit(cls, friction, length, ends="free"):
        """D12's rings, with another length."""
        return cls(shrink_fit.pressure(ends), shrink_fit.MIDDLE / 2, length, friction)

    @property
    def pull(self):
        """Axial force at which all slips: f p 2 pi r L."""
        return self.friction * self.pressure * 2 * np.pi * self.radius * self.length

    @property
    def moment(self):
        """Moment at which all slips: f p 2 pi r^2 L."""
        return self.pull * self.radius


@dataclass
class ShaftInHub:
    """A solid shaft in a hub of the same material, longer than the hub on one side, and pulled there; ends are free.

    Lamé: an interference d of the radius gives p0 = E d (b^2 - r^2) / (2 r b^2). Where an axial stress s has made the
    shaft thinner by nu s r / E, p = p0 - k s is left, with k = nu (b^2 - r^2) / (2 b^2). At full slip
    ds/dz = 2 f p / r along the length L. Left out: axial stress of the hub, and what both ends change in the pressure.
    """

    young: float
    poisson: float
    radius: float
    outside: float
    length: float

    @property
    def _share(self):
        return (self.outside**2 - self.radius**2) / (2 * self.outside**2)

    def pressure(self, interference):
        """p0."""
        return self.young * interference / self.radius * self._share

    def pull(self, interference, friction):
        """f p0 2 pi r L."""
        return friction * self.pressure(interference) * 2 * np.pi * self.radius * self.length

    def pull_of_thinner_shaft(self, interference, friction):
        """pi r^2 p0 / k (1 - exp(-2 f k L / r)): the solution of the equation above."""
        k = self.poisson * self._share
        largest = np.pi * self.radius**2 * self.pressure(interference) / k
        return -largest * np.expm1(-2 * friction * k * self.length / self.radius)


# D27: NAFEMS rounded punch (Konter 2006; code_aster SSNA122) [mm, MPa]; cross-code values, agreed with one code to six
# digits; f -> displacement DY(M), pressure p(M)
ROUNDED_PUNCH = {0.0: (-0.13073, -91.10), 0.1: (-0.12858, -88.67)}


def gauss(low, high, n=200):
    """Nodes and weights of Gauss-Legendre."""
    x, weights = np.polynomial.legendre.leggauss(n)
    return (low + high) / 2 + (high - low) / 2 * x, (high - low) / 2 * weights


def loop_area(loading, largest):
    """Of a cycle by Masing's rule, by quadrature of both branches: int of (upper - lower displacement) over the load.

    Loaded again from -Q*, the branch is that of unloading turned by 180 degrees.
    """
    load, weights = gauss(-largest, largest)
    down = loading(largest) - 2 * loading((largest - load) / 2)
    up = -loading(largest) + 2 * loading((largest + load) / 2)
    return np.sum(weights * (down - up))


def ellipse_rule(low, high, n=400):
    """Nodes and weights over (low, high) by x = middle + half width sin(angle): square roots at both ends are smooth."""
    angle, weights = gauss(-np.pi / 2, np.pi / 2, n)
    return (low + high) / 2 + (high - low) / 2 * np.sin(angle), weights * (high - low) / 2 * np.cos(angle)


def check_lines():
    """D21, D22."""
    line = LineSlip(hertz.Line(80e3, 12.0, 900.0), 0.35)
    a, shear = line.normal.half_width, 0.6 * line.limit
    c = line.stick_half_width(shear)
    # integrals over the pieces between the singular points
    for text, q, wanted, ends in (
        ("loaded", lambda x: line.traction(x, shear), shear, (-a, -c, c, a)),
        ("nothing", lambda x: line.traction(x, 0.0), 0.0, (-a, a)),
        (
            "unloaded",
            lambda x: line.unloaded_traction(x, shear, 0.1 * shear),
            0.1 * shear,
            (-a, -line.reverse_half_width(shear, 0.1 * shear), -c, c),
        ),
    ):
        total = sum(
            np.sum(weights * q(x))
            for x, weights in (ellipse_rule(*pair) for pair in itertools.pairwise(ends))
        )
        if text == "unloaded":
            # the outermost piece, on the other side
            x, weights = ellipse_rule(c, line.reverse_half_width(shear, 0.1 * shear))
            total += np.sum(weights * q(x))
            x, weights = ellipse_rule(line.reverse_half_width(shear, 0.1 * shear), a)
            total += np.sum(weights * q(x))
        check(f"cylinders, {text}: resultant", total / line.limit, wanted / line.limit, 1e-10)
    x = np.linspace(-a, a, 41)
    limit = line.friction * line.normal.pressure(x)
    check("cylinders: f p at full slip", line.traction(x, line.limit), limit, 1e-9)
    check("cylinders: loop closes", line.unloaded_traction(x, shear, -shear), -line.traction(x, shear), 1e-9)
    check("cylinders: no jump at Q*", line.unloaded_traction(x, shear, shear), line.traction(x, shear), 1e-9)
    check_slope(line, shear)
    # a cycle slips four times the slip of the first loading, on both sides of the middle
    x, weights = ellipse_rule(c, a)
    found = 8 * np.sum(weights * line.friction * line.normal.pressure(x) * line.slip(x, shear))
    check("cylinders: dissipation", found / line.dissipation(shear), 1, 1e-9)
    check("cylinders: dissipation, small Q", line.dissipation(1e-3 * line.limit) / small_loop(line), 1, 2e-3)


def small_loop(line):
    """(f P')^2 / (pi E*) 2 k^3 / 3 for small k: the series of the formula."""
    return line.limit**2 / (np.pi * line.normal.modulus) * 2e-9 / 3


def check_slope(line, shear):
    """Slope of the relative displacement from the traction by quadrature of the principal value: 0 in the stick zone."""
    a, c = line.normal.half_width, line.stick_half_width(shear)
    scale = 2 / (np.pi * line.normal.modulus) * line.friction * line.normal.peak / a

    def principal_value(x, half_width, n=20000):
        """PV int sqrt(c^2 - s^2) / (x - s) ds: what is regular by quadrature, and the rest by hand."""
        s, weights = ellipse_rule(-half_width, half_width, n // 50)
        if abs(x) >= half_width:
            return np.sum(weights * half_ellipse(s, half_width) / (x - s))
        own = half_ellipse(x, half_width)
        regular = np.sum(weights * (half_ellipse(s, half_width) - own) / (x - s))
        return regular + own * np.log((half_width + x) / (half_width - x))

    for x in (0.3 * c, 0.8 * c, c + 0.5 * (a - c), c + 0.8 * (a - c)):
        slope = scale * (principal_value(x, a) - principal_value(x, c))
        step = 1e-5 * a
        wanted = (line.slip(x + step, shear) - line.slip(x - step, shear)) / (2 * step) if x > c else 0.0
        check(f"cylinders: slope of the slip at {x / a:.2f} a", slope, wanted, 1e-6 * scale * a)


def check_points():
    """D23."""
    sphere = PointSlip.of_materials((70e3, 0.3), (210e3, 0.2), 8.0, 300.0, 0.4)
    a, shear = sphere.normal.half_width, 0.7 * sphere.limit
    c = sphere.stick_radius(shear)
    total = 0.0
    for ends in ((0, c), (c, a)):
        r, weights = ellipse_rule(*ends)
        total += np.sum(weights * 2 * np.pi * r * sphere.traction(r, shear))
    check("spheres: resultant", total / shear, 1, 1e-10)
    # no slip: Q ((2 - nu1) / G1 + (2 - nu2) / G2) / (8 a), Mindlin 1949
    small = 1e-6 * sphere.limit
    check("spheres: small Q", sphere.approach(small) / (small * sphere.softness / (8 * a)), 1, 1e-6)
    check("spheres: loop closes", sphere.unloaded_approach(shear, -shear) / sphere.approach(shear), -1)
    check("spheres: no jump at Q*", sphere.unloaded_approach(shear, shear) / sphere.approach(shear), 1)
    check("spheres: dissipation", loop_area(sphere.approach, shear) / sphere.dissipation(shear), 1, 1e-7)
    half = PointSlip.of_materials((70e3, 0.3), None, 8.0, 300.0, 0.4)
    check("spheres: rigid partner", half.softness, 1.7 * 2.6 / 70e3, 1e-15)


def check_bar():
    """D24: quadrature of the strain, the loop, and a chain of blocks solved by sweeps."""
    bar, pull = Bar(40.0, 1.5), 6.0
    x, weights = gauss(0, bar.slip_length(pull))
    check("bar: end", np.sum(weights * (pull - bar.limit * x) / bar.stiffness), bar.end(pull))
    check("bar: end of the profile", bar.displacement(0.0, pull), bar.end(pull))
    check("bar: residual", bar.unloaded_end(pull, 0.0), pull**2 / (4 * bar.stiffness * bar.limit))
    check("bar: loop closes", bar.unloaded_end(pull, -pull), -bar.end(pull))
    check("bar: dissipation", loop_area(bar.end, pull), bar.dissipation(pull))
    n, length = 60, 6.0
    step = length / n
    stiffness = bar.stiffness / step * (2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    stiffness[0, 0] /= 2
    compliance = np.zeros((2 * n, 2 * n))
    compliance[:n, :n] = np.eye(n)
    compliance[n:, n:] = np.linalg.inv(stiffness)
    press = np.full(n, step)
    press[0] /= 2
    chain = Steps(compliance, [(k, n + k) for k in range(n)], [bar.limit] * n)
    position, lost, ends = np.zeros(2 * n), 0.0, []
    for now in (
        *np.linspace(0, pull, 7)[1:],
        *np.linspace(pull, -pull, 13)[1:],
        *np.linspace(-pull, pull, 13)[1:],
    ):
        forces, _, slip = chain.step(np.append(-press, now * compliance[n:, n]))
        position += slip
        lost += (forces @ slip) * (len(ends) >= 6)
        ends.append(position[n])
    # nodes carry friction in lumps, half a lump at the end: exact where the slip length is a number of steps
    check("bar: chain of blocks, end", ends[5] / bar.end(pull), 1)
    check("bar: chain of blocks, residual", ends[11] / bar.unloaded_end(pull, 0.0), 1)
    check("bar: chain of blocks, loop", ends[29] / ends[5], 1, 1e-10)
    check("bar: chain of blocks, dissipation", lost / bar.dissipation(pull), 1, 1e-3)


def check_statics():
    """D25, D26."""
    normal, along, stays = wedge(5.0, 0.3, 0.31)
    check("wedge: weight", np.hypot(normal, along), 5.0)
    assert stays
    assert along <= 0.31 * normal
    assert not wedge(5.0, 0.3, 0.309)[2]
    fit = PressFit.of_shrink_fit(0.2, 2.0)
    # 5.742 MPa by D12; on 2 pi 20 mm 2 mm
    check("press fit: pull", fit.pull, 0.2 * 5.742 * 2 * np.pi * 20 * 2, 0.1)
    check("press fit: moment", fit.moment, 20 * fit.pull)
    check_shaft()


def check_shaft():
    """Interference as the sum of both displacements by Lamé, and the equation of the thinner shaft slice by slice."""
    shaft = ShaftInHub(210e3, 0.3, 10.0, 25.0, 30.0)
    p = shaft.pressure(0.01)
    squares = shaft.outside**2 + shaft.radius**2, shaft.outside**2 - shaft.radius**2
    hub = p * shaft.radius / shaft.young * (squares[0] / squares[1] + shaft.poisson)
    inside = p * shaft.radius / shaft.young * (1 - shaft.poisson)
    check("shaft in a hub: interference", (hub + inside) / 0.01, 1)
    stress, n = 0.0, 100000
    for _ in range(n):
        # the interference that is left makes the pressure
        left = 0.01 - shaft.poisson * stress * shaft.radius / shaft.young
        stress += 2 * 0.15 * shaft.pressure(left) / shaft.radius * shaft.length / n
    wanted = shaft.pull_of_thinner_shaft(0.01, 0.15)
    check("shaft in a hub: pull of the thinner shaft", np.pi * shaft.radius**2 * stress / wanted, 1, 1e-5)
    check(
        "shaft in a hub: small f", shaft.pull_of_thinner_shaft(0.01, 1e-6) / shaft.pull(0.01, 1e-6), 1, 1e-6
    )


if __name__ == "__main__":
    check_lines()
    check_points()
    check_bar()
    check_statics()
