# SPDX-License-Identifier: BSD-3-Clause
"""Reduced models of paper case b (sections 3 and 5.2.1) by an independent code.

Writes pellet_cladding_reduction_expected.json. Needs numpy and scipy. POD, DEIM on displacements and multipliers,
reduced domain, Algorithm 1, system (10), its complementarity problem and the reconstruction outside the domain, all
dense. Contact pairs are known by their height.
"""

import argparse
from pathlib import Path

import numpy as np

from contact_reference import solve_lcp
from enrichment_reference import enrich
from pellet_cladding import GAP, N_AXIAL, N_CLADDING, N_FUEL, PelletCladding, grid, lines_of
from reduction_reference import deim, pod, reconstruct

HERE = Path(__file__).resolve().parent
EXPECTED = HERE / "pellet_cladding_reduction_expected.json"

LOAD = "whole_edges"
POD_TOLERANCE = 1e-6
# section 5.2: RID of figure 9a, of figure 9b, of figure 12
DUAL_TOLERANCES = {"primal": None, "dual_4e-4": 4e-4, "dual_1e-4": 1e-4}
EXTRA_MODES = (0, 9)
# both points of table 1
POINTS = ((170.0, 3.2), (30.0, 5.25))
TABLE_1 = (0, 3, 6, 9, 12, 15, 18, 21, 23, 26)


class Model:
    """Snapshots of the 500 training points and what all reduced models share."""

    def __init__(self):
        """Solve the training points; both POD bases."""
        self.problem = problem = PelletCladding()
        answers = [problem.solve(*point, LOAD)[:2] for point in grid(10, 50)]
        self.displacements = np.array([u for u, _ in answers]).T
        self.multipliers = np.array([multipliers for _, multipliers in answers]).T
        self.modes, self.singular_values = pod(self.displacements, POD_TOLERANCE)
        self.all_modes = np.linalg.svd(self.displacements, full_matrices=False)[0]
        levels = np.arange(N_AXIAL + 1)
        first_of_cladding = (N_FUEL + 1) * len(levels)
        self.fuel_surface = levels * (N_FUEL + 1) + N_FUEL
        self.inner_surface = first_of_cladding + levels * (N_CLADDING + 1)
        self.cells = np.vstack([quadrangles(N_FUEL, 0), quadrangles(N_CLADDING, first_of_cladding)])
        # whole edges below h1 = 6 mm end at level 85
        self.loaded = problem.outer_surface[np.abs(problem.outer_forces(1.0, 6.0, LOAD)) > 0]

    def domain(self, dual_tolerance):
        """Cells, dofs of A, and rows of A_lambda (levels) of the domain with interpolation points and loaded nodes."""
        seeds = {dof // 2 for dof in deim(self.modes)} | set(self.loaded.tolist())
        if dual_tolerance is not None:
            levels = deim(pod(self.multipliers, dual_tolerance)[0])
            seeds |= set(self.fuel_surface[levels].tolist()) | set(self.inner_surface[levels].tolist())
        partner = dict(zip(self.fuel_surface.tolist(), self.inner_surface.tolist(), strict=True))
        partner |= {b: a for a, b in partner.items()}
        support = seeds | {partner[node] for node in seeds if node in partner}
        while True:
            is_inside = np.isin(self.cells, list(support)).any(axis=1)
            interior = set(self.cells[is_inside].ravel().tolist()) - set(
                self.cells[~is_inside].ravel().tolist()
            )
            missing = {partner[node] for node in interior if node in partner} - interior
            if not missing:
                break
            support |= missing
        nodes = np.array(sorted(interior))
        rows = np.flatnonzero(np.isin(self.fuel_surface, nodes))
        return int(is_inside.sum()), np.sort(np.concatenate([2 * nodes, 2 * nodes + 1])), rows


def quadrangles(n_radial, first):
    """Cells of a structured rectangle, r fastest."""
    i, j = np.meshgrid(np.arange(n_radial), np.arange(N_AXIAL))
    corner = first + (j * (n_radial + 1) + i).ravel()
    return np.stack([corner, corner + 1, corner + n_radial + 2, corner + n_radial + 1], axis=1)


class Reduced:
    """(10) on a domain with the modes and hats of a basis."""

    def __init__(self, model, dual_tolerance, n_extra, maximum, side):
        """Algorithm 1 with hats on the fuel (first) or on the cladding (second), then the projection."""
        self.model, self.problem = model, model.problem
        self.n_cells, self.interior, self.rows = model.domain(dual_tolerance)
        modes = model.all_modes[:, : model.modes.shape[1] + n_extra]
        contact = self.problem.rows[self.rows]
        entry = 1.0 if side == "first" else -1.0
        chosen, self.history = enrich(contact @ modes, np.full(len(contact), entry), maximum)
        self.chosen = self.rows[chosen]
        nodes = (model.fuel_surface if side == "first" else model.inner_surface)[self.chosen]
        hats = np.zeros((len(modes), len(chosen)))
        hats[2 * nodes, np.arange(len(chosen))] = 1.0
        self.basis = np.hstack([modes, hats])
        self.contact = contact @ self.basis
        self.stiffness = self.basis[self.interior].T @ (self.problem.stiffness[self.interior] @ self.basis)

    def solve(self, pressure, length):
        """Displacement everywhere and multipliers of the domain."""
        load = np.zeros(len(self.basis))
        load[2 * self.problem.outer_surface] = self.problem.outer_forces(pressure, length, LOAD)
        reduced_load = self.basis[self.interior].T @ load[self.interior]
        response = np.linalg.solve(self.stiffness, np.column_stack([self.contact.T, reduced_load]))
        compliance, free = self.contact @ response[:, :-1], response[:, -1]
        multipliers, _, _ = solve_lcp(compliance, GAP - self.contact @ free)
        return self.basis @ (free - response[:, :-1] @ multipliers), multipliers

    def errors(self, pressure, length):
        """(17), (18) on the domain, and (18) on all contacts after both reconstructions.

        Multipliers alone are fewer than snapshots: many combinations fit them, so two codes need not find the same one.
        """
        u, multipliers = self.solve(pressure, length)
        exact_u, exact, _ = self.problem.solve(pressure, length, LOAD)
        on_domain = np.linalg.norm(multipliers - exact[self.rows]) / np.linalg.norm(exact[self.rows])
        entry = {
            "e_u": float(np.linalg.norm(u - exact_u) / np.linalg.norm(exact_u)),
            "e_lambda_rid": float(on_domain),
        }
        normal_dofs = np.concatenate([2 * self.model.fuel_surface, 2 * self.model.inner_surface])
        for name, has_displacement in (("multipliers_and_displacements", True), ("multipliers", False)):
            everywhere = reconstruct(
                self.rows,
                multipliers,
                u,
                self.model.multipliers,
                self.model.displacements[normal_dofs],
                normal_dofs,
                GAP - self.problem.rows @ u,
                has_displacement,
            )
            entry[name] = float(np.linalg.norm(everywhere - exact) / np.linalg.norm(exact))
        return entry


def heights(model, levels):
    """Heights of some pairs in mm."""
    return [float(model.problem.heights[level]) for level in levels]


def describe(reduced):
    """Sizes and the path of Algorithm 1."""
    columns, kappas, ranks, ratios = zip(*reduced.history, strict=True)
    return {
        "n_cells": reduced.n_cells,
        "rows": heights(reduced.model, reduced.rows),
        "hats": heights(reduced.model, reduced.chosen),
        "n_columns": columns,
        "ranks": ranks,
        "condition_numbers": [kappa if np.isfinite(kappa) else None for kappa in kappas],
        "singular_ratios": ratios,
        "stiffness_condition": float(np.linalg.cond(reduced.stiffness)),
    }


def main():
    """Print sizes and errors; with --write replace the committed values."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true", help=f"write {EXPECTED.name}")
    arguments = parser.parse_args()
    model = Model()
    expected = {
        "script": "tests/reference/pellet_cladding_reduction.py",
        "n_modes": int(model.modes.shape[1]),
        "max_condition_number": 10.0,
        "domains": {},
        "table_1": {},
    }
    print("modes", expected["n_modes"])
    for name, tolerance in DUAL_TOLERANCES.items():
        expected["domains"][name] = {}
        for n_extra in EXTRA_MODES:
            reduced = Reduced(model, tolerance, n_extra, 10.0, "second")
            expected["domains"][name][str(n_extra)] = describe(reduced)
            kappa = reduced.history[-1][1]
            print(
                name,
                f"+{n_extra}",
                len(reduced.rows),
                "rows",
                reduced.history[-1][0],
                f"columns, kappa {kappa:.3g}",
            )
    for side in ("second", "first"):
        expected["table_1"][side] = {}
        for n_extra in TABLE_1:
            reduced = Reduced(model, DUAL_TOLERANCES["dual_4e-4"], n_extra, 1.0, side)
            errors = [reduced.errors(*point) for point in POINTS]
            expected["table_1"][side][str(n_extra)] = errors
            print(
                side,
                f"+{n_extra}",
                *(" ".join(f"{k} {100 * v:.2f} %" for k, v in e.items()) for e in errors),
                sep="\n  ",
            )
    if arguments.write:
        EXPECTED.write_text(lines_of(expected) + "\n")


if __name__ == "__main__":
    main()
