# SPDX-License-Identifier: BSD-3-Clause
"""Paper case b (section 5.2) by an independent code; writes pellet_cladding_expected.json.

Needs numpy and scipy. Axisymmetric Q4 by a formula of its own: sparse assembly with 2 pi r, the window's load by
the antiderivative of the shape functions, dense complementarity problem. Units: mm, N, MPa. Nodes are known by their
coordinates, multipliers by their height (ascending), so that any numbering of the same mesh can be compared.
"""

import argparse
import json
from pathlib import Path

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import splu

from contact_reference import solve_lcp
from reduction_reference import pod

HERE = Path(__file__).resolve().parent
EXPECTED = HERE / "pellet_cladding_expected.json"
LOADS = ("cut", "whole_edges")

FUEL_RADIUS, GAP, CLADDING_THICKNESS, HEIGHT = 4.1, 2e-3, 0.57, 7.0
INNER_RADIUS = FUEL_RADIUS + GAP
OUTER_RADIUS = INNER_RADIUS + CLADDING_THICKNESS
N_FUEL, N_CLADDING, N_AXIAL = 60, 8, 100
FUEL, CLADDING = (190e3, 0.3), (78e3, 0.34)
PRESSURES, LENGTHS = (5.0, 200.0), (0.6, 6.0)
EDGE_TOLERANCE = 1e-9

# (P1, h1): the two points of table 1, no contact, a window end inside an edge, the far corner
POINTS = ((170.0, 3.2), (30.0, 5.25), (5.0, 0.6), (102.5, 2.111), (200.0, 6.0))
# (r, z) on axis, fuel surface, both sides of the cladding, near the end of windows
PROBES = (
    (0.0, 3.5),
    (2.05, 1.75),
    (FUEL_RADIUS, 0.07),
    (FUEL_RADIUS, 3.15),
    (INNER_RADIUS, 3.15),
    (INNER_RADIUS, 5.25),
    (OUTER_RADIUS, 0.63),
    (OUTER_RADIUS, 3.22),
    (OUTER_RADIUS, 6.93),
)


def rectangle(radii, heights, first_number):
    """Nodes (r fastest) and Q4 cells, counterclockwise, of a structured rectangle."""
    nodes = np.array([(r, z) for z in heights for r in radii])
    i, j = np.meshgrid(np.arange(len(radii) - 1), np.arange(len(heights) - 1))
    corner = first_number + (j * len(radii) + i).ravel()
    return nodes, np.stack([corner, corner + 1, corner + 1 + len(radii), corner + len(radii)], axis=1)


def hooke_axisymmetric(young_modulus, poisson_ratio):
    """Stress from (e_rr, e_zz, e_tt, 2 e_rz): isotropic elasticity."""
    lame = young_modulus * poisson_ratio / ((1 + poisson_ratio) * (1 - 2 * poisson_ratio))
    shear = young_modulus / (2 * (1 + poisson_ratio))
    hooke = np.diag([2 * shear, 2 * shear, 2 * shear, shear])
    hooke[:3, :3] += lame
    return hooke


def cell_stiffnesses(corners, hooke):
    """Integral of B' C B 2 pi r by 2 x 2 Gauss points; corners (n_cells, 4, 2), result (n_cells, 8, 8)."""
    at = 1 / np.sqrt(3)
    stiffness = np.zeros((len(corners), 8, 8))
    for a, b in ((-at, -at), (at, -at), (at, at), (-at, at)):
        shape = 0.25 * np.array([(1 - a) * (1 - b), (1 + a) * (1 - b), (1 + a) * (1 + b), (1 - a) * (1 + b)])
        slope_a = 0.25 * np.array([-(1 - b), 1 - b, 1 + b, -(1 + b)])
        slope_b = 0.25 * np.array([-(1 - a), -(1 + a), 1 + a, 1 - a])
        jacobian = np.einsum("ik,ckj->cij", np.stack([slope_a, slope_b]), corners)
        slopes = np.linalg.solve(
            jacobian, np.broadcast_to(np.stack([slope_a, slope_b]), (len(corners), 2, 4))
        )
        radius = corners[:, :, 0] @ shape
        strain = np.zeros((len(corners), 4, 8))
        strain[:, 0, 0::2] = slopes[:, 0]
        strain[:, 1, 1::2] = slopes[:, 1]
        strain[:, 2, 0::2] = shape / radius[:, None]
        strain[:, 3, 0::2] = slopes[:, 1]
        strain[:, 3, 1::2] = slopes[:, 0]
        weight = 2 * np.pi * radius * np.linalg.det(jacobian)
        stiffness += weight[:, None, None] * np.einsum("cia,ij,cjb->cab", strain, hooke, strain)
    return stiffness


class PelletCladding:
    """(3) of case b: factored once, then one right-hand side and one complementarity problem per point."""

    def __init__(self):
        """Mesh, stiffness, K^-1 B', K^-1 of unit forces on the outer nodes, W."""
        self.heights = HEIGHT * np.arange(N_AXIAL + 1) / N_AXIAL
        fuel_radii = FUEL_RADIUS * np.arange(N_FUEL + 1) / N_FUEL
        cladding_radii = INNER_RADIUS + CLADDING_THICKNESS * np.arange(N_CLADDING + 1) / N_CLADDING
        fuel, fuel_cells = rectangle(fuel_radii, self.heights, 0)
        cladding, cladding_cells = rectangle(cladding_radii, self.heights, len(fuel))
        self.nodes = np.vstack([fuel, cladding])
        n_dofs, levels = 2 * len(self.nodes), np.arange(N_AXIAL + 1)
        fuel_surface = levels * (N_FUEL + 1) + N_FUEL
        inner_surface = len(fuel) + levels * (N_CLADDING + 1)
        self.outer_surface = inner_surface + N_CLADDING
        self.stiffness = self.assemble(((fuel_cells, FUEL), (cladding_cells, CLADDING)))
        r, z = self.nodes.T
        is_end = (z == 0) | (z == HEIGHT)
        fixed = np.concatenate([2 * np.flatnonzero(r == 0), 2 * np.flatnonzero(is_end) + 1])
        self.free = np.setdiff1d(np.arange(n_dofs), fixed)
        forces = np.zeros((n_dofs, 2 * len(levels)))
        forces[2 * fuel_surface, levels] = 1.0
        forces[2 * inner_surface, levels] = -1.0
        forces[2 * self.outer_surface, len(levels) + levels] = 1.0
        responses = np.zeros_like(forces)
        inner = self.stiffness[self.free][:, self.free].tocsc()
        factor = splu(inner)
        responses[self.free] = factor.solve(forces[self.free])
        responses[self.free] += factor.solve(forces[self.free] - inner @ responses[self.free])
        self.rows = forces[:, : len(levels)].T
        self.supremizers, self.unit_responses = np.hsplit(responses, 2)
        self.compliance = self.rows @ self.supremizers

    def assemble(self, parts):
        """Sparse stiffness of all dofs."""
        rows, columns, values = [], [], []
        for cells, material in parts:
            matrices = cell_stiffnesses(self.nodes[cells], hooke_axisymmetric(*material))
            dofs = np.stack([2 * cells, 2 * cells + 1], axis=-1).reshape(len(cells), 8)
            rows.append(np.repeat(dofs, 8, axis=1).ravel())
            columns.append(np.tile(dofs, (1, 8)).ravel())
            values.append(matrices.ravel())
        triplets = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
        return coo_matrix(triplets, shape=(2 * len(self.nodes),) * 2).tocsr()

    def outer_forces(self, pressure, length, load):
        """Radial nodal forces -P1 2 pi R times the integral of each shape function over z <= h1."""
        step = HEIGHT / N_AXIAL
        if load == "whole_edges":
            length = step * np.floor(length / step + EDGE_TOLERANCE)
        integrals = np.zeros(N_AXIAL + 1)
        for i_edge in range(N_AXIAL):
            # share of the edge inside the window: integral of 1 - t and of t from 0 to it
            share = np.clip((length - self.heights[i_edge]) / step, 0.0, 1.0)
            integrals[i_edge] += step * (share - share**2 / 2)
            integrals[i_edge + 1] += step * share**2 / 2
        return -pressure * 2 * np.pi * OUTER_RADIUS * integrals

    def solve(self, pressure, length, load):
        """u, lambda (by height) and the total force on the outer surface."""
        forces = self.outer_forces(pressure, length, load)
        free = self.unit_responses @ forces
        multipliers, _, _ = solve_lcp(self.compliance, GAP - self.rows @ free)
        return free - self.supremizers @ multipliers, multipliers, forces.sum()

    def residuals(self, displacement, multipliers, forces):
        """Equilibrium (relative), penetration [mm], complementarity (relative to the largest force and the gap)."""
        load = np.zeros_like(displacement)
        load[2 * self.outer_surface] = forces
        load -= self.rows.T @ multipliers
        equilibrium = np.abs((self.stiffness @ displacement - load)[self.free]).max() / np.abs(forces).max()
        slack = GAP - self.rows @ displacement
        return equilibrium, -slack.min(), np.abs(multipliers * slack).max() / (np.abs(forces).max() * GAP)


def node_at(nodes, point):
    """Number of the node at a point."""
    distance = np.linalg.norm(nodes - point, axis=1)
    assert distance.min() < 1e-9, f"no node at {point}"
    return int(distance.argmin())


def describe(problem, point, load):
    """Norms, multipliers and displacements at the probes of one solution."""
    u, multipliers, total = problem.solve(*point, load)
    probes = [2 * node_at(problem.nodes, probe) for probe in PROBES]
    return {
        "pressure": point[0],
        "length": point[1],
        "displacement_norm": float(np.linalg.norm(u)),
        "multipliers_norm": float(np.linalg.norm(multipliers)),
        "total_force": float(total),
        "n_active": int((multipliers > 0).sum()),
        "displacement_at_probes": [[float(u[dof]), float(u[dof + 1])] for dof in probes],
        "multipliers": multipliers.tolist(),
    }


def grid(n_pressures, n_lengths):
    """Inclusive grid of the box, pressures slowest."""
    return [(p, h) for p in np.linspace(*PRESSURES, n_pressures) for h in np.linspace(*LENGTHS, n_lengths)]


def n_modes(problem, load, tolerance=1e-6):
    """POD rank (20) of the 500 training points."""
    snapshots = np.array([problem.solve(*point, load)[0] for point in grid(10, 50)]).T
    return int(pod(snapshots, tolerance)[0].shape[1])


def lines_of(value, depth=0):
    """JSON text with lists of numbers on one line each."""
    if isinstance(value, dict):
        inside = [f"{' ' * (depth + 1)}{json.dumps(k)}: {lines_of(v, depth + 1)}" for k, v in value.items()]
        return "{\n" + ",\n".join(inside) + "\n" + " " * depth + "}"
    if isinstance(value, list) and value and isinstance(value[0], dict):
        inside = [" " * (depth + 1) + lines_of(v, depth + 1) for v in value]
        return "[\n" + ",\n".join(inside) + "\n" + " " * depth + "]"
    return json.dumps(value)


def main():
    """Print residuals and POD ranks; with --write replace the committed values."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true", help=f"write {EXPECTED.name}")
    arguments = parser.parse_args()
    problem = PelletCladding()
    expected = {
        "script": "tests/reference/pellet_cladding.py",
        "units": "mm, N, MPa",
        "n_nodes": len(problem.nodes),
        "n_cells": N_AXIAL * (N_FUEL + N_CLADDING),
        "probes": [list(probe) for probe in PROBES],
        "n_modes": {load: n_modes(problem, load) for load in LOADS},
    }
    for load in LOADS:
        expected[load] = [describe(problem, point, load) for point in POINTS]
    print("nodes", expected["n_nodes"], "POD modes at 1e-6", expected["n_modes"])
    for load in LOADS:
        for point, entry in zip(POINTS, expected[load], strict=True):
            u, multipliers, _ = problem.solve(*point, load)
            residuals = problem.residuals(u, multipliers, problem.outer_forces(*point, load))
            print(
                load,
                point,
                "active",
                entry["n_active"],
                "residuals",
                *(f"{value:.1e}" for value in residuals),
            )
    if arguments.write:
        EXPECTED.write_text(lines_of(expected) + "\n")


if __name__ == "__main__":
    main()
