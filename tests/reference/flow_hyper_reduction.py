#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The paper's method and that of the program on a fuel rod whose cladding yields and creeps, by an independent code.

    build/venv/bin/python tests/reference/flow_hyper_reduction.py

A small part of the kind of input/pcmi.yaml (axisymmetric Q4 with mean dilatation, pairs of nodes, no outer pressure).
The full order, the hybrid hyper-reduced model on a reduced domain, and the model with exact elastic structure walk
through the same test histories. Prints, in Markdown, the errors of whole histories, first with a cladding that stays
elastic: there the paper's method is at home, which shows that it is done right here. Needs numpy and scipy; a minute.
"""

import argparse
from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from contact_reference import solve_lcp
from enrichment_reference import enrich
from pellet_cladding import hooke_axisymmetric, rectangle
from reduction_reference import deim, pod

# mm, N, MPa, h
RADIUS, GAP, THICKNESS, HEIGHT = 4.1, 0.02, 0.57, 6.0
N_FUEL, N_CLADDING, N_AXIAL = 8, 4, 16
FUEL, CLADDING, EXPANSION = (190e3, 0.31), (78e3, 0.34), 1e-5
HARDENING, EXPONENT = 2000.0, 4
#: parameters: power per length, gap, yield stress, coefficient of creep
LOWER, UPPER = np.array([28.0, 0.015, 230.0, 3e-14]), np.array([40.0, 0.030, 310.0, 1.4e-13])
TIMES = np.concatenate(
    [
        np.linspace(0, 10, 9)[1:],
        10 + 50 * (np.geomspace(1, 9, 9)[1:] - 1) / 8,
        np.linspace(60, 66, 5)[1:],
        np.linspace(66, 72, 5)[1:],
        72 + 50 * (np.geomspace(1, 9, 7)[1:] - 1) / 8,
    ]
)
POWER = np.interp(TIMES, [0, 10, 60, 66, 72, 122], [0, 1, 1, 0.2, 1, 1])
DEVIATORIC = np.diag([1.0, 1.0, 1.0, 0.5])
DEVIATORIC[:3, :3] -= 1 / 3
#: products of two stresses count the shear twice
TWICE = np.array([1.0, 1.0, 1.0, 2.0])
MOST_ITERATIONS, TOLERANCE = 40, 1e-8
WORK_TOLERANCE = 1e-3
MOST_KAPPA = 10


class Part:
    """Mesh, strains at 2 x 2 points of each cell, pairs of contact."""

    def __init__(self):
        heights = np.linspace(0, HEIGHT, N_AXIAL + 1)
        inner = RADIUS + GAP
        fuel, fuel_cells = rectangle(np.linspace(0, RADIUS, N_FUEL + 1), heights, 0)
        cladding, cladding_cells = rectangle(
            np.linspace(inner, inner + THICKNESS, N_CLADDING + 1), heights, len(fuel)
        )
        self.nodes = np.vstack([fuel, cladding])
        self.cells = np.vstack([fuel_cells, cladding_cells])
        self.flows = np.arange(len(self.cells)) >= len(fuel_cells)
        self.dofs = np.stack([2 * self.cells, 2 * self.cells + 1], axis=-1).reshape(len(self.cells), 8)
        self.hooke = np.where(
            self.flows[:, None, None], hooke_axisymmetric(*CLADDING), hooke_axisymmetric(*FUEL)
        )
        self.strains, self.weights, radii = strains_of(self.nodes[self.cells])
        #: free strain of a unit of power
        hot = EXPANSION * (12 + 26.5 * (1 - (radii / RADIUS) ** 2)) * ~self.flows[:, None]
        self.free_strain = hot[..., None] * np.array([1.0, 1.0, 1.0, 0.0])
        levels = np.arange(N_AXIAL + 1)
        self.sides = (levels * (N_FUEL + 1) + N_FUEL, len(fuel) + levels * (N_CLADDING + 1))
        self.cone = 0.0005 * heights
        n_dofs = 2 * len(self.nodes)
        self.rows = np.zeros((len(levels), n_dofs))
        self.rows[levels, 2 * self.sides[0]] = 1
        self.rows[levels, 2 * self.sides[1]] = -1
        r, z = self.nodes.T
        held = np.concatenate([2 * np.flatnonzero(r == 0), 2 * np.flatnonzero(z == 0) + 1])
        self.free = np.setdiff1d(np.arange(n_dofs), held)

    def forces_of(self, cells, stresses):
        """Nodal forces of the stresses at the points of some cells."""
        forces = np.zeros(2 * len(self.nodes))
        local = np.einsum("cg,cgia,cgi->ca", self.weights[cells], self.strains[cells], stresses)
        np.add.at(forces, self.dofs[cells], local)
        return forces

    def stiffness_of(self, cells, tangents):
        """Stiffness of some cells from the tangents at their points."""
        matrix = np.zeros((2 * len(self.nodes),) * 2)
        weighted = self.weights[cells][..., None, None] * tangents
        local = np.einsum("cgia,cgij,cgjb->cab", self.strains[cells], weighted, self.strains[cells])
        np.add.at(matrix, (self.dofs[cells][:, :, None], self.dofs[cells][:, None, :]), local)
        return matrix


def strains_of(corners):
    """Strain matrices (n_cells, 4, 4, 8) with the mean dilatation of each cell, weights and radii of the points."""
    strains, weights, radii = [], [], []
    at = 1 / np.sqrt(3)
    for a, b in ((-at, -at), (at, -at), (at, at), (-at, at)):
        shape = 0.25 * np.array([(1 - a) * (1 - b), (1 + a) * (1 - b), (1 + a) * (1 + b), (1 - a) * (1 + b)])
        local = 0.25 * np.array([[-(1 - b), 1 - b, 1 + b, -(1 + b)], [-(1 - a), -(1 + a), 1 + a, 1 - a]])
        jacobian = local @ corners
        slopes = np.linalg.solve(jacobian, np.broadcast_to(local, (len(corners), 2, 4)))
        radius = corners[:, :, 0] @ shape
        strain = np.zeros((len(corners), 4, 8))
        strain[:, 0, 0::2] = strain[:, 3, 1::2] = slopes[:, 0]
        strain[:, 1, 1::2] = strain[:, 3, 0::2] = slopes[:, 1]
        strain[:, 2, 0::2] = shape / radius[:, None]
        strains.append(strain)
        weights.append(2 * np.pi * radius * np.linalg.det(jacobian))
        radii.append(radius)
    strains, weights = np.stack(strains, axis=1), np.stack(weights, axis=1)
    dilatation = strains[:, :, :3].sum(axis=2)
    mean = (weights[..., None] * dilatation).sum(axis=1) / weights.sum(axis=1)[:, None]
    strains[:, :, :3] += ((mean[:, None] - dilatation) / 3)[:, :, None]
    return strains, weights, np.stack(radii, axis=1)


@dataclass
class State:
    """Of points, arrays (..., 4) and (...): inelastic strain, shear as angle, and equivalent plastic strain."""

    strain: np.ndarray
    plastic: np.ndarray


def flow(hooke, strain, old, dt, properties):
    """Backward Euler: J2 with linear hardening and Norton creep. Stress, tangent and state at points of one material."""
    limit, coefficient = properties
    shear = hooke[3, 3]
    trial = (strain - old.strain) @ hooke
    mean = trial[..., :3].mean(axis=-1)[..., None] * np.array([1.0, 1.0, 1.0, 0.0])
    deviator = trial - mean
    size = np.maximum(np.sqrt(1.5 * (TWICE * deviator**2).sum(axis=-1)), 1e-12)
    sigma = size.copy()
    # convex and rising: Newton's method from above
    for _ in range(100):
        yields = (sigma - limit) / HARDENING > old.plastic
        value = dt * coefficient * sigma**EXPONENT + yields * ((sigma - limit) / HARDENING - old.plastic)
        slope = 1 + 3 * shear * (dt * coefficient * EXPONENT * sigma ** (EXPONENT - 1) + yields / HARDENING)
        step = (sigma + 3 * shear * value - size) / slope
        sigma = sigma - step
        if np.abs(step).max() <= 1e-12 * size.max():
            break
    ratio = sigma / size
    stress = mean + ratio[..., None] * deviator
    bend = 3 * shear * (1 / slope - ratio) / size**2
    volumetric = hooke - 2 * shear * DEVIATORIC
    tangent = volumetric + 2 * shear * ratio[..., None, None] * DEVIATORIC
    tangent = tangent + (bend[..., None] * deviator)[..., None] * deviator[..., None, :]
    inelastic = old.strain + (1 - ratio)[..., None] * TWICE * deviator / (2 * shear)
    return stress, tangent, State(inelastic, np.maximum(old.plastic, (sigma - limit) / HARDENING))


class Law:
    """Stresses of some cells through a history: the fuel is elastic and hot, the cladding flows."""

    def __init__(self, part, cells, properties):
        self.part, self.cells, self.properties = part, cells, properties
        n = int(part.flows[cells].sum())
        self.old = self.new = State(np.zeros((n, 4, 4)), np.zeros((n, 4)))

    def evaluate(self, displacement, power, dt):
        """Stresses and tangents at the points of the cells."""
        part, cells, flows = self.part, self.cells, self.part.flows[self.cells]
        strain = np.einsum("cgia,ca->cgi", part.strains[cells], displacement[part.dofs[cells]])
        strain -= power * part.free_strain[cells]
        stress = np.einsum("cij,cgj->cgi", part.hooke[cells], strain)
        tangent = np.repeat(part.hooke[cells][:, None], 4, axis=1)
        if flows.any():
            stress[flows], tangent[flows], self.new = flow(
                hooke_axisymmetric(*CLADDING), strain[flows], self.old, dt, self.properties
            )
        return stress, tangent


def newton(internal, contact, gaps, start):
    """Newton's method with the contact problem of each linear step; None where it does not converge."""
    unknown = start
    for _ in range(MOST_ITERATIONS):
        force, tangent = internal(unknown)
        if not np.isfinite(force).all():
            return None
        try:
            responses = np.linalg.solve(tangent, np.column_stack([contact.T, force]))
            load = gaps - contact @ (unknown - responses[:, -1])
            multipliers = solve_lcp(contact @ responses[:, :-1], load)[0]
        except (np.linalg.LinAlgError, ArithmeticError):
            return None
        step = responses[:, -1] + responses[:, :-1] @ multipliers
        unknown = unknown - step
        if np.linalg.norm(step) <= TOLERANCE * np.linalg.norm(unknown):
            return unknown, multipliers
    return None


def walk(part, cells, basis, interior, rows, point, elastic):
    """Displacements and forces of the contacts `rows` at all times of a history; NaN from where there is no answer.

    The full order is the case of all cells and dofs.
    """
    power, gap, limit, coefficient = point
    law = Law(part, cells, (1e9, 0.0) if elastic else (limit, coefficient))
    contact = part.rows[rows] @ basis
    tested = basis[interior]
    unknown = np.zeros(basis.shape[1])
    displacements = np.full((len(TIMES), len(basis)), np.nan)
    forces = np.full((len(TIMES), len(rows)), np.nan)
    for i, (share, dt) in enumerate(zip(POWER, np.diff(TIMES, prepend=0), strict=True)):

        def internal(unknown, share=share, dt=dt):
            stress, tangent = law.evaluate(basis @ unknown, power * share, dt)
            stiffness = part.stiffness_of(cells, tangent)[interior]
            return tested.T @ part.forces_of(cells, stress)[interior], tested.T @ (stiffness @ basis)

        found = newton(internal, contact, (gap - part.cone)[rows], unknown)
        if found is None:
            break
        unknown, forces[i] = found
        displacements[i] = basis @ unknown
        law.old = law.new
    return displacements, forces


def full_order(part, point, elastic):
    """The full-order history."""
    n_dofs = 2 * len(part.nodes)
    return walk(
        part,
        np.arange(len(part.cells)),
        np.eye(n_dofs)[:, part.free],
        part.free,
        np.arange(len(part.rows)),
        point,
        elastic,
    )


class HyperReduced:
    """The paper's model: POD modes and hat functions, equations of equilibrium of the inner dofs of a reduced domain."""

    def __init__(self, part, displacements, forces, n_modes, n_layers):
        """`n_layers`: further layers of cells around the domain of the paper."""
        self.part, self.n_modes = part, n_modes
        modes = np.linalg.svd(displacements, full_matrices=False)[0][:, :n_modes]
        levels = deim(pod(forces, 1e-4)[0])
        support = {dof // 2 for dof in deim(modes)} | {
            int(node) for side in part.sides for node in side[levels]
        }
        partner = dict(zip(*(side.tolist() for side in part.sides), strict=True))
        partner |= {b: a for a, b in partner.items()}
        self.cells, interior = self.grow(support, partner)
        for _ in range(n_layers):
            self.cells, interior = self.grow(support | set(part.cells[self.cells].ravel().tolist()), partner)
        nodes = np.array(sorted(interior))
        self.interior = np.intersect1d(np.concatenate([2 * nodes, 2 * nodes + 1]), part.free)
        self.rows = np.flatnonzero(np.isin(part.sides[0], nodes))
        hats = enrich(part.rows[self.rows] @ modes, np.ones(len(self.rows)), MOST_KAPPA)[0]
        columns = np.zeros((len(modes), len(hats)))
        columns[2 * part.sides[0][self.rows[hats]], np.arange(len(hats))] = 1
        self.basis = np.hstack([modes, columns])

    def grow(self, support, partner):
        """Cells that touch a node of the support, and the nodes that no other cell has, with their partners."""
        while True:
            inside = np.isin(self.part.cells, list(support)).any(axis=1)
            interior = set(self.part.cells[inside].ravel().tolist())
            interior -= set(self.part.cells[~inside].ravel().tolist())
            missing = {partner[node] for node in interior if node in partner} - interior
            if not missing:
                return np.flatnonzero(inside), interior
            support = support | missing

    def size(self):
        """In words."""
        n_hats = self.basis.shape[1] - self.n_modes
        return f"{self.n_modes} modes, {n_hats} hats, {len(self.cells)} of {len(self.part.cells)} cells"

    def answer(self, point, elastic):
        """Forces on the domain, twice because there is no correction, and displacements."""
        displacements, forces = walk(
            self.part, self.cells, self.basis, self.interior, self.rows, point, elastic
        )
        return forces, forces, displacements


class Inelastic:
    """The program's model: exact elastic structure and contact, modes of inelastic strains, few points."""

    def __init__(self, part, displacements, forces, powers, stresses, n_modes):
        """`stresses`: what inelastic strains take away at the points of the cladding, (n_states, n_cells, 4, 4)."""
        self.part, self.rows = part, np.arange(len(part.rows))
        everything = np.arange(len(part.cells))
        free = part.free
        stiffness = part.stiffness_of(everything, np.repeat(part.hooke[:, None], 4, axis=1))[
            np.ix_(free, free)
        ]
        heat = part.forces_of(everything, np.einsum("cij,cgj->cgi", part.hooke, part.free_strain))
        responses = np.zeros((2 * len(part.nodes), 1 + len(part.rows)))
        responses[free] = np.linalg.solve(stiffness, np.column_stack([heat, part.rows.T])[free])
        self.of_power, self.of_forces = responses[:, 0], responses[:, 1:]
        inelastic = displacements - np.outer(self.of_power, powers) + self.of_forces @ forces
        factor = np.linalg.cholesky(stiffness)
        modes = np.linalg.svd(factor.T @ inelastic[free], full_matrices=False)[0][:, :n_modes]
        self.modes = np.zeros((len(inelastic), modes.shape[1]))
        self.modes[free] = np.linalg.solve(factor.T, modes)
        cladding = np.flatnonzero(part.flows)
        self.weights = part.weights[cladding].ravel()
        self.strain_power, self.strain_forces, self.strain_modes = (
            np.einsum("cgia,cak->cgik", part.strains[cladding], columns[part.dofs[cladding]]).reshape(
                len(self.weights), 4, -1
            )
            for columns in (self.of_power[:, None], self.of_forces, self.modes)
        )
        self.compliance = part.rows @ self.of_forces
        self.openings = part.rows @ self.modes
        self.choose(stresses.reshape(len(stresses), -1, 4))

    def choose(self, stresses):
        """Points and weights by non-negative least squares of the work on the modes."""
        columns = (self.weights[:, None] * stresses).reshape(len(stresses), -1).T
        vectors, values, _ = np.linalg.svd(columns, full_matrices=False)
        main = (vectors[:, :40] * values[:40]).reshape(len(self.weights), 4, -1)
        work = np.einsum("gik,gis->ksg", self.strain_modes, main).reshape(-1, len(self.weights))
        target = work.sum(axis=1)
        chosen, shares, residual = [], np.zeros(0), target
        while np.linalg.norm(residual) > WORK_TOLERANCE * np.linalg.norm(target):
            gradient = residual @ work
            gradient[chosen] = -np.inf
            if len(chosen) == len(self.weights):
                break
            chosen.append(int(gradient.argmax()))
            shares = nnls(work[:, chosen], target, maxiter=10000)[0]
            residual = target - work[:, chosen] @ shares
        self.chosen, self.shares = np.array(chosen)[shares > 0], shares[shares > 0]

    def size(self):
        """In words."""
        return f"{self.modes.shape[1]} modes, {len(self.chosen)} of {len(self.weights)} points"

    def update(self, points, old, dt, properties, amplitudes, power, forces):
        """Stress that flow takes away at some points, its derivative by strains, and the states."""
        hooke = hooke_axisymmetric(*CLADDING)
        strain = self.strain_power[points, :, 0] * power - self.strain_forces[points] @ forces
        strain = strain + self.strain_modes[points] @ amplitudes
        stress, tangent, new = flow(hooke, strain, old, dt, properties)
        return strain @ hooke - stress, hooke - tangent, new

    def answer(self, point, elastic):
        """Forces of all contacts before and behind the correction, and the displacements."""
        del elastic
        power, gap, *properties = point
        everything = np.arange(len(self.weights))
        few, many = (State(np.zeros((len(p), 4)), np.zeros(len(p))) for p in (self.chosen, everything))
        amplitudes = np.zeros(self.modes.shape[1])
        raw, corrected = (np.full((len(TIMES), len(self.rows)), np.nan) for _ in range(2))
        displacements = np.full((len(TIMES), len(self.modes)), np.nan)
        for i, (share, dt) in enumerate(zip(POWER, np.diff(TIMES, prepend=0), strict=True)):
            load = gap - self.part.cone - self.part.rows @ self.of_power * power * share
            found = self.step(few, dt, properties, amplitudes, power * share, load)
            if found is None:
                break
            amplitudes, raw[i], few = found
            taken, _, many = self.update(everything, many, dt, properties, amplitudes, power * share, raw[i])
            opened = np.einsum("gik,gi,g->k", self.strain_forces, taken, self.weights)
            corrected[i] = solve_lcp(self.compliance, load - opened)[0]
            displacements[i] = (
                self.of_power * power * share - self.of_forces @ corrected[i] + self.modes @ amplitudes
            )
        return raw, corrected, displacements

    def step(self, old, dt, properties, amplitudes, power, load):
        """Newton's method on the amplitudes; contact is exact for each of them."""
        modes = self.strain_modes[self.chosen]
        weights = self.weights[self.chosen] * self.shares
        for _ in range(MOST_ITERATIONS):
            forces = solve_lcp(self.compliance, load - self.openings @ amplitudes)[0]
            taken, softening, new = self.update(self.chosen, old, dt, properties, amplitudes, power, forces)
            residual = amplitudes - np.einsum("gik,gi,g->k", modes, taken, weights)
            if np.linalg.norm(residual) <= TOLERANCE * max(np.linalg.norm(amplitudes), 1e-6):
                return amplitudes, forces, new
            closed = np.flatnonzero(forces > 0)
            change = np.zeros((len(forces), len(amplitudes)))
            if len(closed) > 0:
                change[closed] = np.linalg.solve(
                    self.compliance[np.ix_(closed, closed)], self.openings[closed]
                )
            strains = modes - self.strain_forces[self.chosen] @ change
            matrix = np.einsum("gik,g,gij,gjl->kl", modes, weights, softening, strains)
            amplitudes = amplitudes - np.linalg.solve(np.eye(len(matrix)) - matrix, residual)
        return None


def taken_stresses(part, displacements, powers, points):
    """Stresses that inelastic strains take away at all states of full-order histories, one after the other."""
    cladding = np.flatnonzero(part.flows)
    found = []
    for history, power, point in zip(displacements, powers, points, strict=True):
        law = Law(part, cladding, point[2:])
        for u, share, dt in zip(history, power, np.diff(TIMES, prepend=0), strict=True):
            stress, _ = law.evaluate(u, share, dt)
            strain = np.einsum("cgia,ca->cgi", part.strains[cladding], u[part.dofs[cladding]])
            found.append(np.einsum("cij,cgj->cgi", part.hooke[cladding], strain) - stress)
            law.old = law.new
    return np.array(found)


def points_of(n, seed):
    """Points of the box, one in each of n layers of every parameter."""
    random = np.random.default_rng(seed)
    layers = np.array([random.permutation(n) for _ in LOWER]).T
    return LOWER + (layers + random.random(layers.shape)) / n * (UPPER - LOWER)


def over_history(found, exact):
    """Largest difference of all times over the largest size of all times; infinite without an answer at some time."""
    difference = np.linalg.norm(found - exact, axis=1).max() / np.linalg.norm(exact, axis=1).max()
    return difference if np.isfinite(difference) else np.inf


def tell(errors):
    """Median and largest, in words."""
    found = [np.quantile(errors, 0.5, method="higher"), max(errors)]
    return " / ".join("none" if not np.isfinite(value) else f"{100 * value:.2g} %" for value in found)


def table(part, models, tests, elastic):
    """Prints a row per model."""
    exact = [full_order(part, point, elastic) for point in tests]
    for name, model in models:
        errors, missing = [], []
        for point, (displacements, forces) in zip(tests, exact, strict=True):
            raw, corrected, found = model.answer(point, elastic)
            errors.append(
                [
                    over_history(found, displacements),
                    over_history(raw, forces[:, model.rows]),
                    over_history(corrected, forces[:, model.rows]),
                ]
            )
            missing.append(np.isnan(raw).any(axis=1).mean())
        u, before, behind = np.array(errors).T
        has_correction = isinstance(model, Inelastic)
        print(
            f"| {name} | {model.size()} | {np.mean(missing):.0%} | {tell(u)} | {tell(before)} | "
            f"{tell(behind) if has_correction else ''} |",
            flush=True,
        )


def main():
    """Both tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--training", type=int, default=10, help="number of training histories")
    parser.add_argument("--test", type=int, default=6, help="number of test histories")
    options = parser.parse_args()
    part = Part()
    training, tests = points_of(options.training, 1), points_of(options.test, 2)
    for elastic in (True, False):
        print("\nThe cladding stays elastic:\n" if elastic else "\nThe cladding yields and creeps:\n")
        print("| model | size | times without answer | displacements | forces | forces, corrected |")
        print("|---" * 6 + "|")
        histories = [full_order(part, point, elastic) for point in training]
        displacements = np.array([u for u, _ in histories])
        assert np.isfinite(displacements).all(), "a training history has no full-order answer"
        u = displacements.reshape(-1, displacements.shape[-1]).T
        forces = np.concatenate([found for _, found in histories]).T
        powers = training[:, :1] * POWER
        models = [
            (name, HyperReduced(part, u, forces, n_modes, n_layers))
            for name, n_modes, n_layers in (
                ("the paper's", 10, 0),
                ("two layers more", 10, 2),
                ("the paper's", 20, 0),
                ("two layers more", 20, 2),
                ("all cells", 20, N_FUEL + N_AXIAL),
            )
        ]
        if not elastic:
            stresses = taken_stresses(part, displacements, powers, training)
            models += [
                ("this program's", Inelastic(part, u, forces, powers.ravel(), stresses, n)) for n in (10, 20)
            ]
        table(part, models, tests, elastic)


if __name__ == "__main__":
    main()
