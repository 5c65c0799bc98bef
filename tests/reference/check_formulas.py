# SPDX-License-Identifier: BSD-3-Clause
"""Checks that the closed forms of tests/verification agree with the NumPy reference on the same meshes.

usage: python check_formulas.py
"""

from pathlib import Path

import numpy as np

import bar_with_gap
import hertz
import patch_test
import punch
import shrink_fit
from contact_reference import build_problem, hooke_plane_strain
from gmsh_ascii import read_mesh
from lame import ThickCylinder
from reduction_reference import train

MESHES = Path(__file__).resolve().parents[1] / "verification" / "meshes"
FACES = ("lower_face", "upper_face", (0.0, 1.0), 1e-8)


def largest_difference(computed, expected):
    """Largest difference relative to the largest expected value."""
    return float(np.abs(computed - expected).max() / np.abs(expected).max())


def check_patch():
    """D1: uniform pressure and linear displacement."""
    mesh = read_mesh(MESHES / "patch_blocks.msh")
    hooke = hooke_plane_strain(patch_test.YOUNG_MODULUS, 0.0)
    conditions = [("lower_base", 0, (0.0, 0.0)), ("lower_base", 1, (0.0, 0.0))]
    conditions += [("upper_base", 0, (0.0, 0.0)), ("upper_base", 1, (0.0, -1.0))]
    problem = build_problem(mesh, {"lower": hooke, "upper": hooke}, conditions, FACES)
    u, multipliers, _ = problem.solve([1.0, 0.1])
    forces = patch_test.nodal_forces(mesh.coordinates[problem.pairs[:, 0], 0], 0.1)
    print("patch: lambda", largest_difference(multipliers, forces))
    print(
        "patch: u_y",
        largest_difference(u[1::2], patch_test.vertical_displacement(mesh.coordinates[:, 1], 0.1)),
    )
    print("patch: u_x", np.abs(u[0::2]).max())


def check_bar():
    """Springs in series behind a gap."""
    mesh = read_mesh(MESHES / "bar_with_gap.msh")
    lower = hooke_plane_strain(bar_with_gap.LOWER_MODULUS, 0.0)
    upper = hooke_plane_strain(bar_with_gap.UPPER_MODULUS, 0.0)
    share = bar_with_gap.LOWER_SHARE
    conditions = [("lower_base", 0, (0.0, 0.0)), ("lower_base", 1, (0.0, share))]
    conditions += [("upper_base", 0, (0.0, 0.0)), ("upper_base", 1, (0.0, share - 1))]
    problem = build_problem(mesh, {"lower": lower, "upper": upper}, conditions, FACES)
    is_lower = mesh.coordinates[:, 1] < bar_with_gap.GAP / 2
    lengths = patch_test.tributary_lengths(mesh.coordinates[problem.pairs[:, 0], 0])
    for stroke in (0.005, 0.01, 0.0101, 0.025):
        u, multipliers, is_active = problem.solve([1.0, stroke])
        expected = bar_with_gap.vertical_displacement(mesh.coordinates[:, 1], is_lower, stroke)
        forces = bar_with_gap.pressure(stroke) * lengths
        print(
            f"bar at {stroke}: active {is_active.sum()}, lambda", np.abs(multipliers - forces).max(), end=""
        )
        print(", u_y", largest_difference(u[1::2], expected))


def check_full_basis():
    """D13: a basis that spans all solutions on the whole mesh gives the full-order answer anywhere."""
    mesh = read_mesh(MESHES / "two_stamps.msh")
    hooke = hooke_plane_strain(100.0, 0.3)
    none, left, right = (0.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0)
    conditions = [("lower_base", 0, none), ("lower_base", 1, none), ("left_stamp", 0, none)]
    conditions += [("left_stamp", 1, left), ("right_stamp", 0, none), ("right_stamp", 1, right)]
    problem = build_problem(mesh, {"lower": hooke, "upper": hooke}, conditions, FACES)
    zones = ["lower_base", "lower_face", "upper_face", "left_stamp", "between_stamps", "right_stamp"]
    training = [(1.0, a, b) for a in np.linspace(0.01, 0.1, 6) for b in np.linspace(0.01, 0.1, 6)]
    solutions = [problem.solve(theta) for theta in training]
    snapshots = np.array([u for u, _, _ in solutions]).T
    print("full basis: active pairs", sorted({int(s[2].sum()) for s in solutions}), "of", len(problem.rows))
    for treatment in ("elastic_lifting", "multiplier"):
        model = train(problem, snapshots, training, 1e-20, treatment, zones)
        values = model.singular_values / model.singular_values[0]
        print(
            treatment,
            "modes",
            model.modes.shape[1],
            "cells",
            len(model.domain.cells),
            "of",
            len(mesh.cells),
            end=" ",
        )
        print("rows", len(model.domain.contact_rows), "kappa", round(model.kappa_of_modes, 2))
        print("   singular values", np.array2string(values[:12], precision=1))
        worst_u = worst_lambda = 0.0
        for theta in [(1.0, a, b) for a in np.linspace(0.01, 0.1, 9) for b in np.linspace(0.01, 0.1, 9)]:
            u, multipliers, _ = problem.solve(theta)
            u_r, multipliers_r, _ = model.solve(np.array(theta))
            worst_u = max(worst_u, np.linalg.norm(u_r - u) / np.linalg.norm(u))
            norm = np.linalg.norm(multipliers)
            if norm > 0:
                worst_lambda = max(worst_lambda, np.linalg.norm(multipliers_r - multipliers) / norm)
        print("   largest e_u", worst_u, "largest e_lambda", worst_lambda)


def insist(text, computed, expected, tolerance=1e-9):
    """Print a comparison and fail where it fails."""
    difference = largest_difference(np.asarray(computed), np.asarray(expected))
    print(text, difference)
    assert difference <= tolerance, text


def second_kind(n=400):
    """Nodes and weights for the integral of sqrt(1 - s^2) f(s) over [-1, 1] (Gauss-Chebyshev)."""
    angle = np.pi * np.arange(1, n + 1) / (n + 1)
    return np.cos(angle), np.pi / (n + 1) * np.sin(angle) ** 2


def check_hertz():
    """Printed figures of D2; force, and the bodies' profile, from the pressure by quadrature."""
    line = hertz.nafems_cylinder()
    insist("hertz D2: a", line.half_width, 6.2146, 1e-5)
    insist("hertz D2: p0", line.peak, 3585.37, 1e-5)
    s, weights = second_kind()
    insist("hertz line: force", weights.sum() * line.peak * line.half_width, line.load)
    # slope of the gap that the pressure closes at x: 2 / (pi E*) PV int p(s) / (x - s) ds = x / R, at points
    # midway between the nodes, where the rule is exact for the principal value
    t = np.cos(np.pi * (np.arange(40, 360) + 0.5) / 401)
    slopes = 2 / (np.pi * line.modulus) * line.peak * (1 / (t[:, None] - s) @ weights)
    insist("hertz line: profile", slopes, t * line.half_width / line.radius)
    x = np.linspace(0, line.half_width, 30)
    insist("hertz line: fit", hertz.fit(x, line.pressure(x)), (line.half_width, line.peak))
    point = hertz.Point(50e3, 8.0, 300.0)
    # dA = 2 pi r dr with r = a sqrt(1 - t^2): int p dA = 2 pi a^2 p0 int_0^1 t^2 dt
    insist("hertz point: force", 2 * np.pi * point.half_width**2 * point.peak / 3, point.load)
    # middle of the half-space: u = 1 / (pi E*) int p / r dA = 2 / E* int_0^a p dr
    depth = 2 / point.modulus * point.peak * point.half_width * weights.sum() / 2
    insist("hertz point: approach", depth, point.approach)
    insist("hertz point: load", hertz.Point.of_approach(50e3, 8.0, point.approach).load, point.load)


def check_rings():
    """Lamé's field is in equilibrium and compatible; the two rings of D12 close the interference."""
    for ends, printed in (("free", 5.74), ("held", 6.31)):
        modulus, ratio = shrink_fit.YOUNG_MODULUS, shrink_fit.POISSON_RATIO
        p = shrink_fit.pressure(ends)
        insist(f"shrink fit, {ends} ends: printed pressure", p, printed, 1e-3)
        radii = np.array([shrink_fit.INNER, shrink_fit.MIDDLE, shrink_fit.OUTER]) / 2
        inner = ThickCylinder(modulus, ratio, radii[0], radii[1], outer_pressure=p, ends=ends)
        outer = ThickCylinder(modulus, ratio, radii[1], radii[2], inner_pressure=p, ends=ends)
        closed = outer.displacement(radii[1]) - inner.displacement(radii[1])
        force = 2 * np.pi * shrink_fit.MIDDLE / 2 * p
        insist(f"shrink fit, {ends} ends: faces of the meshes", shrink_fit.force_of_meshes(ends), force, 2e-4)
        insist(f"shrink fit, {ends} ends: interference", closed, shrink_fit.INTERFERENCE / 2)
        insist(f"thick cylinder, {ends} ends: faces", outer.stress(radii[1:])[0], (-p, 0.0))
        r, step = np.linspace(21, 29, 9), 1e-3
        radial, circumferential, axial = outer.stress(r)
        slope = (outer.stress(r + step)[0] - outer.stress(r - step)[0]) / (2 * step)
        insist(f"thick cylinder, {ends} ends: equilibrium", slope, (circumferential - radial) / r, 1e-7)
        strain = (outer.displacement(r + step) - outer.displacement(r - step)) / (2 * step)
        hooke = (radial - ratio * (circumferential + axial)) / modulus
        insist(f"thick cylinder, {ends} ends: radial strain", strain, hooke, 1e-7)


def check_punch():
    """Total force; zero slope under the punch; nodal forces by fine quadrature."""
    a, load, n = 2.0, 7.0, 400
    s = np.cos(np.pi * (np.arange(n) + 0.5) / n)
    insist("punch: force", np.pi / n * np.sum(punch.pressure(a * s, a, load) * a * np.sqrt(1 - s**2)), load)
    t = np.cos(np.pi * np.arange(40, 360) / n)
    slopes = (1 / (t[:, None] - s)).sum(axis=1) / n
    print("punch: slope", np.abs(slopes).max())
    assert np.abs(slopes).max() < 1e-9
    x = np.linspace(-a, a, 11)
    angle = (np.arange(20000) + 0.5) * np.pi / 20000
    forces = [np.interp(a * np.cos(angle), x, hat).sum() * load / 20000 for hat in np.eye(len(x))]
    insist("punch: nodal forces", punch.nodal_forces(x, a, load), forces, 1e-7)


if __name__ == "__main__":
    check_hertz()
    check_rings()
    check_punch()
    check_patch()
    check_bar()
    check_full_basis()
