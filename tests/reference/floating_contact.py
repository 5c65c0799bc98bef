# SPDX-License-Identifier: BSD-3-Clause
"""Contact of a body that only contact holds: T3 in plane strain and T4, a quadratic program in lambda.

Independent of the program: own assembly and loads. The body gets as many pins as it has free rigid motions R; they carry
nothing because R'B' lambda = R'F is a condition of the quadratic program. Lawson and Hanson's non-negative least squares
find the closed pairs, a bordered system their forces, and the conditions of (3) are verified.
"""

from dataclasses import dataclass, field

import numpy as np
import scipy.linalg
import scipy.optimize
import scipy.sparse
import scipy.sparse.linalg
import scipy.spatial

from gmsh_ascii import physical_tags, read_elements, sections_of

#: gmsh's element types by the number of dimensions: cell, facet
SIMPLICES = {2: (2, 1), 3: (4, 2)}
POINT = 15
# [-] conditions of (3), relative to the largest force or gap
REACHED = 1e-9
# [-] weight of the equations of equilibrium in the least squares, which only choose the closed pairs
WEIGHT = 1e4


@dataclass
class Mesh:
    """Nodes, cells (n, n_dim + 1) with their regions, facets and nodes by name; 0-based."""

    coordinates: np.ndarray
    cells: np.ndarray
    regions: list
    facets_of: dict = field(default_factory=dict)
    nodes_of: dict = field(default_factory=dict)


def read_simplices(path, n_dim):
    """Mesh of a gmsh 4.1 ASCII file; nodes that no cell uses are dropped, ascending in the rest."""
    sections = sections_of(path)
    words = [line.split(maxsplit=2) for line in sections["PhysicalNames"][1:]]
    names = {(int(d), int(tag)): name.strip().strip('"') for d, tag, name in words}
    groups = physical_tags(sections["Entities"])
    tags, places = read_places(sections["Nodes"])
    cells, regions, members = [], [], {}
    for dimension, entity, kind, nodes in read_elements(sections["Elements"]):
        own = [names[dimension, tag] for tag in groups.get((dimension, entity), [])]
        if kind == SIMPLICES[n_dim][0]:
            cells.append(nodes)
            regions.append(own[0])
        elif kind in (POINT, SIMPLICES[n_dim][1]):
            for name in own:
                members.setdefault(name, []).append(nodes)
    number_of = np.full(max(tags) + 1, -1)
    used = np.unique(cells)
    number_of[used] = np.arange(len(used))
    place_of = dict(zip(tags, places, strict=True))
    mesh = Mesh(
        np.array([place_of[tag][:n_dim] for tag in used.tolist()]), number_of[np.array(cells)], regions
    )
    mesh.facets_of = {name: number_of[np.array(facets)] for name, facets in members.items()}
    mesh.nodes_of = {name: np.unique(facets) for name, facets in mesh.facets_of.items()}
    return mesh


def read_places(lines):
    """Tags and all three coordinates in the order of the file."""
    tags, places, i_line = [], [], 1
    for _ in range(int(lines[0].split()[0])):
        n_block = int(lines[i_line].split()[3])
        tags += [int(line) for line in lines[i_line + 1 : i_line + 1 + n_block]]
        i_line += 1 + n_block
        places += [[float(w) for w in line.split()] for line in lines[i_line : i_line + n_block]]
        i_line += n_block
    return tags, places


def stiffness_of(mesh, materials):
    """K of {region: (E, nu)}: V (lambda g_a g_b' + mu (g_b g_a' + g_a.g_b I)), g the shape functions' gradients."""
    n_dim = mesh.coordinates.shape[1]
    corners = mesh.coordinates[mesh.cells]
    system = np.concatenate([np.ones((*corners.shape[:2], 1)), corners], axis=2)
    gradients = np.linalg.inv(system)[:, 1:, :]
    volume = np.abs(np.linalg.det(system)) / (2 if n_dim == 2 else 6)
    young, poisson = np.array([materials[region] for region in mesh.regions]).T
    mu = volume * young / (2 * (1 + poisson))
    lame = volume * young * poisson / ((1 + poisson) * (1 - 2 * poisson))
    blocks = np.einsum("c,cia,cjb->caibj", lame, gradients, gradients)
    blocks += np.einsum("c,cja,cib->caibj", mu, gradients, gradients)
    blocks += np.einsum("c,cka,ckb,ij->caibj", mu, gradients, gradients, np.eye(n_dim))
    dofs = (mesh.cells[:, :, None] * n_dim + np.arange(n_dim)).reshape(len(mesh.cells), -1)
    size = dofs.shape[1]
    rows, columns = np.repeat(dofs, size, axis=1).ravel(), np.tile(dofs, (1, size)).ravel()
    n_dofs = mesh.coordinates.size
    return scipy.sparse.csc_matrix((blocks.ravel(), (rows, columns)), shape=(n_dofs, n_dofs))


def clip(polygon, values, bound, sign):
    """The part of a convex polygon (weights of the corners, in rows) where sign * (values - bound) <= 0."""
    kept = []
    height = sign * (values - bound)
    for i in range(len(polygon)):
        j = (i + 1) % len(polygon)
        if height[i] <= 0:
            kept.append(polygon[i])
        if height[i] * height[j] < 0:
            share = height[i] / (height[i] - height[j])
            kept.append((1 - share) * polygon[i] + share * polygon[j])
    return np.array(kept).reshape(-1, polygon.shape[1])


def surface_load(mesh, name, density, axis=0, window=(-np.inf, np.inf)):
    """Nodal forces of a constant traction on the part of a surface inside a window, exact for linear shape functions."""
    forces = np.zeros(mesh.coordinates.shape)
    for nodes in mesh.facets_of[name]:
        part = np.eye(len(nodes))
        for bound, sign in ((window[0], -1), (window[1], 1)):
            if np.isfinite(bound) and len(part):
                part = clip(part, part @ mesh.coordinates[nodes, axis], bound, sign)
        for weights, size in pieces(part, mesh.coordinates[nodes]):
            forces[nodes] += size * np.outer(weights, density)
    return forces.ravel()


def pieces(part, places):
    """Middle and length, or middle and area, of the segments or triangles that make up a part of a facet."""
    corners = part @ places
    if len(places) == 2 and len(part) >= 2:
        yield part[:2].mean(axis=0), np.linalg.norm(corners[1] - corners[0])
    if len(places) == 3:
        for i in range(1, len(part) - 1):
            normal = np.cross(corners[i] - corners[0], corners[i + 1] - corners[0])
            yield part[[0, i, i + 1]].mean(axis=0), np.linalg.norm(normal) / 2


def facing_nodes(mesh, first, second, direction):
    """Pairs along a coordinate axis, ascending in the first node, and their distances."""
    others = [i for i in range(mesh.coordinates.shape[1]) if i != direction]
    upper = mesh.nodes_of[second]
    tree = scipy.spatial.cKDTree(mesh.coordinates[upper][:, others])
    lower = mesh.nodes_of[first]
    distance, place = tree.query(mesh.coordinates[lower][:, others])
    assert distance.max() < 1e-6
    assert len(np.unique(place)) == len(lower) == len(upper)
    pairs = np.stack([lower, upper[place]], axis=1)
    return pairs, np.diff(mesh.coordinates[pairs][:, :, direction], axis=1)[:, 0]


def rigid_motions(mesh, nodes):
    """Translations and rotations of some nodes, in columns."""
    n_dim = mesh.coordinates.shape[1]
    motions = []
    for i in range(n_dim):
        motion = np.zeros(mesh.coordinates.shape)
        motion[nodes, i] = 1
        motions.append(motion.ravel())
    for i in range(n_dim):
        for j in range(i):
            motion = np.zeros(mesh.coordinates.shape)
            motion[nodes, i] = mesh.coordinates[nodes, j]
            motion[nodes, j] = -mesh.coordinates[nodes, i]
            motions.append(motion.ravel())
    return np.array(motions).T


class FloatingContact:
    """(3) in lambda alone: W, and the motions that only contact holds."""

    def __init__(self, mesh, materials, floating, fixed_dofs, pairs, axes):
        """Pairs (n, 2) with the axis of each; `floating`: region of the body that contact holds; fixed dofs are 0."""
        n_dim, n_dofs = mesh.coordinates.shape[1], mesh.coordinates.size
        stiffness = stiffness_of(mesh, materials)
        nodes = np.unique(mesh.cells[np.array(mesh.regions) == floating])
        motions = rigid_motions(mesh, nodes)
        # what the fixed dofs leave
        _, sizes, right = np.linalg.svd(motions[fixed_dofs])
        rank = int((sizes > 1e-9 * np.abs(motions).max()).sum()) if len(fixed_dofs) else 0
        self.motions = motions @ right[rank:].T
        rows = np.arange(len(pairs))
        places = (
            np.concatenate([rows, rows]),
            np.concatenate([n_dim * pairs[:, 0] + axes, n_dim * pairs[:, 1] + axes]),
        )
        signs = np.concatenate([np.ones(len(rows)), -np.ones(len(rows))])
        self.rows = scipy.sparse.csr_matrix((signs, places), shape=(len(pairs), n_dofs))
        is_free = np.ones(n_dofs, dtype=bool)
        is_free[fixed_dofs] = False
        pins = scipy.linalg.qr((self.motions * is_free[:, None]).T, pivoting=True)[2][: self.motions.shape[1]]
        is_free[pins] = False
        self.free = np.flatnonzero(is_free)
        self.solve_stiffness = scipy.sparse.linalg.splu(stiffness[self.free][:, self.free].tocsc()).solve
        response = self.solve_stiffness(self.rows[:, self.free].T.toarray())
        self.compliance = self.rows[:, self.free] @ response
        self.compliance = (self.compliance + self.compliance.T) / 2
        self.work = (self.rows @ self.motions).T
        self.factor = np.linalg.cholesky(self.compliance)

    def forces(self, load, gaps):
        """Lambda: 0 <= lambda, w = W lambda + gaps - B K^-1 F + B R a >= 0, complementary, R'B' lambda = R'F."""
        q = gaps - self.rows[:, self.free] @ self.solve_stiffness(load[self.free])
        resultant = self.motions.T @ load
        size = np.abs(self.factor).max()
        scale = WEIGHT * size / np.abs(self.work).max(axis=1)
        matrix = np.vstack([self.factor.T, scale[:, None] * self.work])
        rhs = np.concatenate([-scipy.linalg.solve_triangular(self.factor, q, lower=True), scale * resultant])
        guess, _ = scipy.optimize.nnls(matrix, rhs, maxiter=100 * len(q))
        is_closed = guess > 0
        for _ in range(100):
            multipliers, opening = self.with_closed(is_closed, q, resultant)
            following = np.where(
                is_closed, multipliers > 0, opening < -1e-13 * max(np.abs(q).max(), np.abs(opening).max())
            )
            if (following == is_closed).all():
                break
            is_closed = following
        assert multipliers.min() >= -REACHED * multipliers.max()
        assert opening.min() >= -REACHED * np.abs(q).max()
        np.testing.assert_allclose(
            self.work @ multipliers, resultant, rtol=0, atol=REACHED * np.abs(resultant).max()
        )
        return np.maximum(multipliers, 0)

    def with_closed(self, is_closed, q, resultant):
        """Forces that close these pairs and balance the load, and the openings of all pairs."""
        n, n_closed = len(resultant), int(is_closed.sum())
        system = np.zeros((n_closed + n, n_closed + n))
        system[:n_closed, :n_closed] = self.compliance[np.ix_(is_closed, is_closed)]
        system[:n_closed, n_closed:] = self.work[:, is_closed].T
        system[n_closed:, :n_closed] = self.work[:, is_closed]
        size = np.sqrt(np.abs(np.diag(self.compliance)).max() / np.abs(self.work).max(axis=1) ** 2)
        scale = np.concatenate([np.ones(n_closed), size])
        solution = (
            np.linalg.solve(
                system * np.outer(scale, scale), np.concatenate([-q[is_closed], resultant]) * scale
            )
            * scale
        )
        multipliers = np.zeros(len(q))
        multipliers[is_closed] = solution[:n_closed]
        opening = self.compliance @ multipliers + q + self.work.T @ solution[n_closed:]
        opening[is_closed] = 0
        return multipliers, opening
