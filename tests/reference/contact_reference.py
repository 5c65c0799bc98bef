# SPDX-License-Identifier: BSD-3-Clause
"""Full-order contact in plain dense NumPy: T3 plane strain, node pairs, prescribed displacements, dense LCP.

Independent of the program. Natural dof number of node n, component c: 2 n + c (0-based).
Source: Le Berre et al. 2022, (3).
"""

from dataclasses import dataclass

import numpy as np

REACHED = 1e-12


def hooke_plane_strain(young_modulus, poisson_ratio):
    """Stress from (e_xx, e_yy, 2 e_xy): isotropic elasticity with e_zz = 0."""
    lame = young_modulus * poisson_ratio / ((1 + poisson_ratio) * (1 - 2 * poisson_ratio))
    shear = young_modulus / (2 * (1 + poisson_ratio))
    return np.array([[lame + 2 * shear, lame, 0], [lame, lame + 2 * shear, 0], [0, 0, shear]])


def cell_stiffnesses(mesh, hooke):
    """A B' C B of each T3, unit thickness; B from the constant gradients of the barycentric coordinates."""
    points = mesh.coordinates[mesh.cells]
    edges = points[:, [2, 0, 1]] - points[:, [1, 2, 0]]
    twice_area = points[:, 1] - points[:, 0]
    other = points[:, 2] - points[:, 0]
    twice_area = twice_area[:, 0] * other[:, 1] - twice_area[:, 1] * other[:, 0]
    slope_x = -edges[:, :, 1] / twice_area[:, None]
    slope_y = edges[:, :, 0] / twice_area[:, None]
    strain = np.zeros((len(mesh.cells), 3, 6))
    strain[:, 0, 0::2] = slope_x
    strain[:, 1, 1::2] = slope_y
    strain[:, 2, 0::2] = slope_y
    strain[:, 2, 1::2] = slope_x
    return 0.5 * twice_area[:, None, None] * np.einsum("cia,ij,cjb->cab", strain, hooke, strain)


def dofs_of_nodes(nodes):
    """Both components of each node, node by node."""
    nodes = np.asarray(nodes, dtype=int)
    return np.stack([2 * nodes, 2 * nodes + 1], axis=-1).reshape((*nodes.shape[:-1], -1))


def assemble(mesh, cell_matrices, cells=None):
    """Dense stiffness of the given cells (all by default)."""
    n_dofs = 2 * len(mesh.coordinates)
    stiffness = np.zeros((n_dofs, n_dofs))
    for i_cell in range(len(mesh.cells)) if cells is None else cells:
        dofs = dofs_of_nodes(mesh.cells[i_cell])
        stiffness[np.ix_(dofs, dofs)] += cell_matrices[i_cell]
    return stiffness


@dataclass
class Problem:
    """(3) with prescribed values `prescribed_values @ theta`; rows of B are the pairs that are not inert."""

    mesh: object
    cell_matrices: np.ndarray
    stiffness: np.ndarray
    prescribed_dofs: np.ndarray
    prescribed_values: np.ndarray
    dirichlet_surfaces: list
    pairs: np.ndarray
    rows: np.ndarray
    gaps: np.ndarray
    inert_pairs: np.ndarray

    def __post_init__(self):
        """Factor once: elastic response to the prescribed values, K^-1 B' and W."""
        n_dofs, n_terms = len(self.stiffness), self.prescribed_values.shape[1]
        self.free = np.setdiff1d(np.arange(n_dofs), self.prescribed_dofs)
        inner = np.ix_(self.free, self.free)
        self.free_response = np.zeros((n_dofs, n_terms))
        self.free_response[self.prescribed_dofs] = self.prescribed_values
        border = self.stiffness[np.ix_(self.free, self.prescribed_dofs)] @ self.prescribed_values
        self.free_response[self.free] = -np.linalg.solve(self.stiffness[inner], border)
        self.supremizers = np.zeros((n_dofs, len(self.rows)))
        self.supremizers[self.free] = np.linalg.solve(self.stiffness[inner], self.rows[:, self.free].T)
        self.compliance = self.rows @ self.supremizers

    def solve(self, theta):
        """u, lambda, active set of (3): u = u_free - K^-1 B' lambda turns it into an LCP of W = B K^-1 B'."""
        theta = np.asarray(theta, dtype=float)
        free = self.free_response @ theta
        multipliers, is_active, _ = solve_lcp(self.compliance, self.gaps - self.rows @ free)
        return free - self.supremizers @ multipliers, multipliers, is_active

    def energy(self, displacement, cells=None):
        """1/2 u' K u, on some cells or on all."""
        local = displacement[dofs_of_nodes(self.mesh.cells)]
        energies = 0.5 * np.einsum("ca,cab,cb->c", local, self.cell_matrices, local)
        return energies.sum() if cells is None else energies[cells].sum()


def find_pairs(mesh, first, second, direction, tolerance):
    """Facing nodes of two surfaces along a direction, ascending in the first node, by brute force."""
    normal = np.asarray(direction, dtype=float) / np.linalg.norm(direction)
    pairs = []
    for node in mesh.nodes_of[first]:
        difference = mesh.coordinates[mesh.nodes_of[second]] - mesh.coordinates[node]
        lateral = np.linalg.norm(difference - np.outer(difference @ normal, normal), axis=1)
        best = lateral.argmin()
        if lateral[best] > tolerance:
            raise ValueError(f"node {node} has no partner: nearest is {lateral[best]} away")
        pairs.append((node, mesh.nodes_of[second][best]))
    pairs = np.array(pairs)
    if len(set(pairs[:, 1])) != len(pairs):
        raise ValueError("a node is in two pairs")
    return pairs, normal


def build_problem(mesh, hooke_of_cell_group, boundary_conditions, contact):
    """Problem from materials, conditions and a contact.

    Materials: {region: Hooke matrix}; conditions: [(surface, component, values per term)];
    contact: (first surface, second surface, direction, tolerance as a length).
    """
    matrices = np.zeros((len(mesh.cells), 6, 6))
    for region, hooke in hooke_of_cell_group.items():
        matrices[mesh.cells_of[region]] = cell_stiffnesses(mesh, hooke)[mesh.cells_of[region]]
    prescribed = {}
    for surface, component, values in boundary_conditions:
        for node in mesh.nodes_of[surface]:
            prescribed[2 * node + component] = values
    dofs = np.array(sorted(prescribed))
    pairs, normal = find_pairs(mesh, *contact)
    all_rows = np.zeros((len(pairs), 2 * len(mesh.coordinates)))
    for row, (first, second) in zip(all_rows, pairs, strict=True):
        row[dofs_of_nodes(first)] = normal
        row[dofs_of_nodes(second)] = -normal
    all_gaps = np.array([(mesh.coordinates[b] - mesh.coordinates[a]) @ normal for a, b in pairs])
    is_inert = np.array([set(np.flatnonzero(row)) <= set(dofs) for row in all_rows])
    return Problem(
        mesh=mesh,
        cell_matrices=matrices,
        stiffness=assemble(mesh, matrices),
        prescribed_dofs=dofs,
        prescribed_values=np.array([prescribed[dof] for dof in dofs], dtype=float),
        dirichlet_surfaces=list(dict.fromkeys(surface for surface, _, _ in boundary_conditions)),
        pairs=pairs,
        rows=all_rows[~is_inert],
        gaps=all_gaps[~is_inert],
        inert_pairs=np.flatnonzero(is_inert),
    )


def checksum(values):
    """sum_i values_i sin(i), i from 1: changes when two entries are swapped."""
    return float(np.dot(values, np.sin(np.arange(1, len(values) + 1))))


def solve_lcp(matrix, q, max_steps=200):
    """0 <= x, w = matrix x + q >= 0, x'w = 0: primal-dual active set; Lemke when a set comes back.

    Returns x, the active set and the name of the method.
    """
    is_active, seen = q < 0, set()
    for _ in range(max_steps):
        if is_active.tobytes() in seen:
            break
        seen.add(is_active.tobytes())
        x = np.zeros(len(q))
        x[is_active] = np.linalg.solve(matrix[np.ix_(is_active, is_active)], -q[is_active])
        w = matrix @ x + q
        scale = np.abs(q).max()
        following = np.where(is_active, x > 0, w < -REACHED * scale)
        if (following == is_active).all():
            return x, is_active, "active_set"
        is_active = following
    x = lemke(matrix, q)
    return x, x > 0, "lemke"


def lemke(matrix, q):
    """Lemke's complementary pivoting with a lexicographic ratio test: Cottle, Pang, Stone 1992, 4.4."""
    n = len(q)
    if (q >= 0).all():
        return np.zeros(n)
    tableau = np.hstack([np.eye(n), -matrix, -np.ones((n, 1)), q[:, None]])
    basis = list(range(n))
    row, entering = int(q.argmin()), 2 * n
    for _ in range(50 * n):
        tableau[row] /= tableau[row, entering]
        for other in range(n):
            if other != row:
                tableau[other] -= tableau[other, entering] * tableau[row]
        leaving, basis[row] = basis[row], entering
        if leaving == 2 * n:
            x = np.zeros(2 * n + 1)
            x[basis] = tableau[:, -1]
            return x[n : 2 * n]
        entering = leaving + n if leaving < n else leaving - n
        column = tableau[:, entering]
        candidates = np.flatnonzero(column > 1e-12)
        if not len(candidates):
            raise ArithmeticError("secondary ray: Lemke found no solution")
        lexicographic = np.hstack([tableau[:, -1:], tableau[:, :n]])[candidates] / column[candidates, None]
        row = int(candidates[np.lexsort(lexicographic.T[::-1])[0]])
    raise ArithmeticError("Lemke did not end")
