# SPDX-License-Identifier: BSD-3-Clause
"""Hyper-reduced contact model in plain dense NumPy: POD, DEIM, reduced domain, system (10), reconstruction.

Independent of the program. Source: Le Berre et al. 2022, (4)-(11), (20).
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from contact_reference import dofs_of_nodes, solve_lcp

TIE = 1e-8
RANK_TOLERANCE = 1e-10


def first_largest(values):
    """Lowest index whose value is the largest within 1e-8 relative."""
    values = np.asarray(values)
    return int(np.flatnonzero(values >= values.max() * (1 - TIE))[0])


def pod(snapshots, tolerance):
    """l left singular vectors, all values; (20): smallest l with sum_{i>l} s_i^2 < tolerance * sum s_i^2."""
    vectors, values, _ = np.linalg.svd(snapshots, full_matrices=False)
    tails = np.append(np.cumsum((values**2)[::-1])[::-1], 0.0) / (values**2).sum()
    n_modes = int(np.flatnonzero(tails < tolerance)[0])
    return vectors[:, :n_modes], values


def deim(basis):
    """Interpolation rows of a basis: Chaturantabut and Sorensen 2010, algorithm 1; ties: lowest number."""
    rows = [first_largest(abs(basis[:, 0]))]
    for i_mode in range(1, basis.shape[1]):
        coefficients = np.linalg.solve(basis[rows, :i_mode], basis[rows, i_mode])
        rows.append(first_largest(abs(basis[:, i_mode] - basis[:, :i_mode] @ coefficients)))
    return rows


def middle_node(mesh, surface):
    """Node of a surface nearest to the mean of its nodes, the lowest number on ties."""
    nodes = mesh.nodes_of[surface]
    distance = np.linalg.norm(mesh.coordinates[nodes] - mesh.coordinates[nodes].mean(axis=0), axis=1)
    return int(nodes[distance <= distance.min() + TIE * distance.max()][0])


@dataclass
class Domain:
    """(4)-(9), all 0-based and ascending but the seeds, which keep the order in which they were found."""

    seed_nodes: list
    facing_nodes: list
    cells: np.ndarray
    interior_dofs: np.ndarray
    interface_dofs: np.ndarray
    contact_dofs: np.ndarray
    contact_rows: np.ndarray


def partners_of(problem, nodes):
    """Facing nodes of the pairs that have a row in B."""
    live = np.delete(problem.pairs, problem.inert_pairs, axis=0)
    other = {int(a): int(b) for a, b in live} | {int(b): int(a) for a, b in live}
    return {other[node] for node in nodes if node in other}


def build_domain(problem, seed_nodes):
    """Reduced domain of a node list; partners of interior contact nodes join until none is missing."""
    mesh = problem.mesh
    seeds = list(dict.fromkeys(int(node) for node in seed_nodes))
    support = set(seeds) | partners_of(problem, seeds)
    while True:
        in_domain = np.isin(mesh.cells, list(support)).any(axis=1)
        outside = set(mesh.cells[~in_domain].ravel().tolist())
        interior = set(mesh.cells[in_domain].ravel().tolist()) - outside
        missing = partners_of(problem, interior) - interior
        if not missing:
            break
        support |= missing
    interior_dofs = dofs_of_nodes(sorted(interior)).ravel()
    touched = np.flatnonzero((problem.stiffness[interior_dofs] != 0).any(axis=0))
    contact_dofs = interior_dofs[(problem.rows[:, interior_dofs] != 0).any(axis=0)]
    return Domain(
        seed_nodes=seeds,
        facing_nodes=sorted(support - set(seeds)),
        cells=np.flatnonzero(in_domain),
        interior_dofs=interior_dofs,
        interface_dofs=np.setdiff1d(touched, interior_dofs),
        contact_dofs=contact_dofs,
        contact_rows=np.flatnonzero((problem.rows[:, contact_dofs] != 0).any(axis=1)),
    )


@dataclass
class ReducedModel:
    """(10) after the prescribed values are dealt with: u = lifting theta + basis y."""

    treatment: str
    singular_values: np.ndarray
    modes: np.ndarray
    deim_dofs: list
    domain: Domain
    basis: np.ndarray
    lifting: np.ndarray
    stiffness: np.ndarray
    contact: np.ndarray
    load: np.ndarray
    gap: np.ndarray
    kappa_of_modes: float
    kappa_of_basis: float
    stiffness_condition: float
    n_prescribed_rows: int

    def solve(self, theta):
        """Displacement everywhere, multipliers on the reduced domain, method of the LCP."""
        inverse = np.linalg.inv(self.stiffness)
        compliance = self.contact @ inverse @ self.contact.T
        load = self.load @ theta
        multipliers, _, method = solve_lcp(compliance, self.gap @ theta - self.contact @ inverse @ load)
        coordinates = inverse @ (load - self.contact.T @ multipliers)
        return self.lifting @ theta + self.basis @ coordinates, multipliers, method


def condition_number(matrix):
    """sigma_max / sigma_{rows}, infinite below full row rank: (11)."""
    values = np.linalg.svd(matrix, compute_uv=False)
    rank = int((values > RANK_TOLERANCE * values[0]).sum())
    return float(values[0] / values[-1]) if rank == len(matrix) else np.inf


def train(problem, snapshots, thetas, tolerance, treatment, zones=()):
    """Reduced model from displacement snapshots.

    `elastic_lifting`: modes of what contact adds to the elastic response to the prescribed values.
    `multiplier`: modes of the whole field; prescribed rows are equations on the coordinates (the paper).
    """
    n_terms = problem.prescribed_values.shape[1]
    lifting, extra = problem.free_response, []
    if treatment == "multiplier":
        lifting = np.zeros_like(lifting)
        extra = [middle_node(problem.mesh, surface) for surface in problem.dirichlet_surfaces]
    modes, singular_values = pod(snapshots - lifting @ np.transpose(thetas), tolerance)
    rows = deim(modes)
    zone_nodes = [node for zone in zones for node in problem.mesh.nodes_of[zone]]
    domain = build_domain(problem, [dof // 2 for dof in rows] + extra + zone_nodes)
    basis, n_prescribed_rows = modes, 0
    if treatment == "multiplier":
        # C coordinates = g on the prescribed dofs of A: least-norm solution plus the null space of C.
        is_interior = np.isin(problem.prescribed_dofs, domain.interior_dofs)
        constraint = modes[problem.prescribed_dofs[is_interior]]
        n_prescribed_rows = len(constraint)
        left, values, right = np.linalg.svd(constraint)
        rank = int((values > RANK_TOLERANCE * values[0]).sum())
        particular = left[:, :rank].T @ problem.prescribed_values[is_interior] / values[:rank, None]
        lifting = modes @ (right[:rank].T @ particular)
        basis = modes @ right[rank:].T
    inner, wide = domain.interior_dofs, np.union1d(domain.interior_dofs, domain.interface_dofs)
    rows_of_stiffness = basis[inner].T @ problem.stiffness[np.ix_(inner, wide)]
    contact_rows = problem.rows[np.ix_(domain.contact_rows, domain.contact_dofs)]
    stiffness = rows_of_stiffness @ basis[wide]
    gaps = np.zeros((len(contact_rows), n_terms))
    gaps[:, 0] = problem.gaps[domain.contact_rows]
    return ReducedModel(
        treatment=treatment,
        singular_values=singular_values,
        modes=modes,
        deim_dofs=rows,
        domain=domain,
        basis=basis,
        lifting=lifting,
        stiffness=stiffness,
        contact=contact_rows @ basis[domain.contact_dofs],
        load=-rows_of_stiffness @ lifting[wide],
        gap=gaps - problem.rows[domain.contact_rows] @ lifting,
        kappa_of_modes=condition_number(contact_rows @ modes[domain.contact_dofs]),
        kappa_of_basis=condition_number(contact_rows @ basis[domain.contact_dofs]),
        stiffness_condition=float(np.linalg.cond(stiffness)),
        n_prescribed_rows=n_prescribed_rows,
    )


def reconstruct(
    rows,
    multipliers,
    displacement,
    dual_snapshots,
    normal_snapshots,
    normal_dofs,
    openings,
    with_displacement,
):
    """Multipliers everywhere: kept on the reduced domain, elsewhere non-negative least squares.

    Of a force and an opening of one contact, both divided by the sizes below, the smaller one is taken for zero.

    Source: [9] as cited in section 2.3.2 of the paper. Each block is divided by the Frobenius norm of its own
    snapshots, so that the result does not depend on the units. Rows: those of the reduced domain.
    """
    block = dual_snapshots[rows]
    size = np.linalg.norm(block)
    matrix, target = block / size, multipliers / size
    if with_displacement:
        size = np.linalg.norm(normal_snapshots)
        matrix = np.vstack([matrix, normal_snapshots / size])
        target = np.append(target, displacement[normal_dofs] / size)
    coefficients, _ = nnls(matrix, target, maxiter=100 * matrix.shape[1])
    everywhere = dual_snapshots @ coefficients
    everywhere[everywhere / np.linalg.norm(block) <= openings / np.linalg.norm(normal_snapshots)] = 0
    everywhere[rows] = multipliers
    return everywhere
