# SPDX-License-Identifier: BSD-3-Clause
"""Checks that the closed forms of tests/verification agree with the NumPy reference on the same meshes.

usage: python check_formulas.py
"""

from pathlib import Path

import numpy as np

import bar_with_gap
import patch_test
from contact_reference import build_problem, hooke_plane_strain
from gmsh_ascii import read_mesh
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


if __name__ == "__main__":
    check_patch()
    check_bar()
    check_full_basis()
