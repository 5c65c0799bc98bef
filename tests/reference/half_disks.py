# SPDX-License-Identifier: BSD-3-Clause
"""Paper case a (section 5.1) by an independent code; writes half_disks_expected.json.

Needs numpy and scipy. Nodes, cells, dofs and rows in the output are natural numbers, 1-based, as in the
program's files.
"""

import argparse
import json
from pathlib import Path

import numpy as np

from contact_reference import build_problem, checksum, hooke_plane_strain
from gmsh_ascii import read_mesh
from reduction_reference import reconstruct, train

HERE = Path(__file__).resolve().parent
MESH = HERE.parents[1] / "meshes" / "half_disks.msh"
EXPECTED = HERE / "half_disks_expected.json"
BOX = (0.15, 0.45)
TRAINING_SAMPLES = (0, 1, 15, 25, 30)
E_LAMBDA_LIMIT = 8e-3


def grid(n_points):
    """Inclusive grid over the box: min + (max - min) i / (n - 1)."""
    return np.array([BOX[0] + (BOX[1] - BOX[0]) * i / (n_points - 1) for i in range(n_points)])


def theta(squeeze):
    """Terms `1` and `squeeze`: u_y = +squeeze below and -squeeze above."""
    return np.array([1.0, squeeze])


def half_disks(path):
    """E = 15 Pa, nu = 0.35, u_x = 0 and u_y = +-squeeze on the flat edges, contact along y: section 5.1."""
    mesh = read_mesh(path)
    hooke = hooke_plane_strain(15.0, 0.35)
    zero, up, down = (0.0, 0.0), (0.0, 1.0), (0.0, -1.0)
    conditions = [
        ("lower_base", 0, zero),
        ("lower_base", 1, up),
        ("upper_base", 0, zero),
        ("upper_base", 1, down),
    ]
    contact = ("lower_arc", "upper_arc", (0.0, 1.0), 1e-7)
    return build_problem(mesh, {"lower": hooke, "upper": hooke}, conditions, contact)


def mesh_hash(path):
    """FNV-1a, 64 bit, of the file's bytes as 16 hexadecimal digits: what the program writes as mesh_hash."""
    value = 0xCBF29CE484222325
    for byte in Path(path).read_bytes():
        value = (value ^ byte) * 0x100000001B3 % 2**64
    return f"{value:016x}"


def status_changes(problem, n_points=601):
    """Parameter values where the full-order active set changes, to 1e-9, with the rows that change."""

    def active_rows(squeeze):
        return problem.solve(theta(squeeze))[2]

    changes = []

    def bisect(low, high, set_low, set_high):
        if (set_low == set_high).all():
            return
        if high - low < 1e-9:
            changes.append((0.5 * (low + high), np.flatnonzero(set_low != set_high)))
            return
        middle = 0.5 * (low + high)
        set_middle = active_rows(middle)
        bisect(low, middle, set_low, set_middle)
        bisect(middle, high, set_middle, set_high)

    points = grid(n_points)
    sets = [active_rows(point) for point in points]
    for i in range(n_points - 1):
        bisect(points[i], points[i + 1], sets[i], sets[i + 1])
    return changes


def relative(difference, reference):
    """Norm of the difference relative to the reference."""
    return float(np.linalg.norm(difference) / np.linalg.norm(reference))


def measure_errors(problem, model, points, full_order, snapshots):
    """(17)-(19) of each test point; e_lambda on the reduced domain and everywhere by both reconstructions."""
    displacement_snapshots, dual_snapshots = snapshots
    normal_dofs = np.flatnonzero((problem.rows != 0).any(axis=0))
    normal_snapshots = displacement_snapshots[normal_dofs]
    rows, cells, errors = model.domain.contact_rows, model.domain.cells, []
    for point, (u, multipliers, is_active) in zip(points, full_order, strict=True):
        u_r, multipliers_r, method = model.solve(theta(point))
        openings = problem.gaps - problem.rows @ u_r
        blocks = (rows, multipliers_r, u_r, dual_snapshots, normal_snapshots, normal_dofs, openings)
        energy, energy_rid = problem.energy(u), problem.energy(u, cells)
        e_energy = abs(problem.energy(u_r) - energy)
        e_energy_rid = abs(problem.energy(u_r, cells) - energy_rid)
        errors.append(
            {
                "squeeze": float(point),
                "e_u": relative(u_r - u, u),
                "e_lambda_rid": relative(multipliers_r - multipliers[rows], multipliers[rows]),
                "e_lambda_all": relative(reconstruct(*blocks, True) - multipliers, multipliers),
                "e_lambda_all_multipliers_only": relative(
                    reconstruct(*blocks, False) - multipliers, multipliers
                ),
                "e_energy": float(e_energy),
                "e_energy_rid": float(e_energy_rid),
                "e_energy_relative": float(e_energy / energy),
                "e_energy_rid_relative": float(e_energy_rid / energy_rid),
                "n_active": int((multipliers_r > 0).sum()),
                "n_active_full_order_rid": int(is_active[rows].sum()),
                "n_active_full_order": int(is_active.sum()),
                "solver": method,
            }
        )
    return errors


def statistics(errors):
    """min, median, p95 (NumPy's linear interpolation), max of each error."""
    names = [name for name in errors[0] if name.startswith("e_")]
    values = {name: [point[name] for point in errors] for name in names}
    return {
        name: {
            "min": float(np.min(v)),
            "median": float(np.median(v)),
            "p95": float(np.percentile(v, 95)),
            "max": float(np.max(v)),
        }
        for name, v in values.items()
    }


def far_points(errors, changes, model):
    """Test points with e_lambda above the limit, and the nearest change of status in the reduced domain."""
    found = []
    in_domain = [(at, rows) for at, rows in changes if np.isin(rows, model.domain.contact_rows).any()]
    for point in errors:
        if point["e_lambda_rid"] > E_LAMBDA_LIMIT:
            at, rows = min(in_domain, key=lambda change: abs(change[0] - point["squeeze"]))
            found.append(
                {
                    "squeeze": point["squeeze"],
                    "e_lambda_rid": point["e_lambda_rid"],
                    "nearest_change_at": at,
                    "rows_that_change": (rows + 1).tolist(),
                    "n_active_reduced": point["n_active"],
                    "n_active_full_order_rid": point["n_active_full_order_rid"],
                }
            )
    return found


def describe_model(model):
    """Sizes and index sets, 1-based as in model.h5."""
    domain = model.domain
    return {
        "n_modes": model.modes.shape[1],
        "n_basis_columns": model.basis.shape[1],
        "n_contact_rows": len(domain.contact_rows),
        "n_prescribed_rows": model.n_prescribed_rows,
        "condition_number": model.kappa_of_modes,
        "condition_number_of_basis": model.kappa_of_basis,
        "stiffness_condition": model.stiffness_condition,
        "singular_values": model.singular_values.tolist(),
        "deim_dofs": [int(dof) + 1 for dof in model.deim_dofs],
        "seed_nodes": [node + 1 for node in domain.seed_nodes],
        "facing_nodes": [node + 1 for node in domain.facing_nodes],
        "contact_rows": (domain.contact_rows + 1).tolist(),
        "n_cells": len(domain.cells),
        "n_interior_dofs": len(domain.interior_dofs),
        "n_interface_dofs": len(domain.interface_dofs),
        "n_contact_dofs": len(domain.contact_dofs),
    }


def run(path):
    """The whole case: full order, both treatments of the prescribed values, errors at 101 points."""
    problem = half_disks(path)
    training, test = grid(31), grid(101)
    solutions = [problem.solve(theta(point)) for point in training]
    displacement = np.array([u for u, _, _ in solutions]).T
    dual = np.array([multipliers for _, multipliers, _ in solutions]).T
    full_order = [problem.solve(theta(point)) for point in test]
    changes = status_changes(problem)
    expected = {
        "script": "tests/reference/half_disks.py",
        "mesh_hash": mesh_hash(path),
        "n_nodes": len(problem.mesh.coordinates),
        "n_cells": len(problem.mesh.cells),
        "n_pairs": len(problem.pairs),
        "n_multipliers": len(problem.rows),
        "inert_pairs": (problem.inert_pairs + 1).tolist(),
        "status_changes": [{"squeeze": at, "rows": (rows + 1).tolist()} for at, rows in changes],
        "training_points": [describe_solution(training[i], solutions[i]) for i in TRAINING_SAMPLES],
    }
    for treatment in ("multiplier", "elastic_lifting"):
        model = train(problem, displacement, [theta(point) for point in training], 1e-8, treatment)
        errors = measure_errors(problem, model, test, full_order, (displacement, dual))
        expected[treatment] = describe_model(model) | {
            "errors": statistics(errors),
            "e_lambda_rid_of_points": [point["e_lambda_rid"] for point in errors],
            "e_lambda_above_limit": far_points(errors, changes, model),
            "solvers": sorted({point["solver"] for point in errors}),
        }
    return expected


def describe_solution(point, solution):
    """Norms, checksums and all multipliers of one full-order solution."""
    u, multipliers, is_active = solution
    return {
        "squeeze": float(point),
        "displacement_norm": float(np.linalg.norm(u)),
        "displacement_checksum": checksum(u),
        "multipliers_norm": float(np.linalg.norm(multipliers)),
        "multipliers_checksum": checksum(multipliers),
        "multipliers": multipliers.tolist(),
        "n_active": int(is_active.sum()),
    }


def main():
    """Print the figures; with --write replace the committed ones."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("mesh", nargs="?", default=MESH)
    parser.add_argument("--write", action="store_true", help=f"write {EXPECTED.name}")
    arguments = parser.parse_args()
    expected = run(arguments.mesh)
    text = json.dumps(expected, indent=1)
    print(text)
    if arguments.write:
        EXPECTED.write_text(text + "\n")


if __name__ == "__main__":
    main()
