# SPDX-License-Identifier: BSD-3-Clause
"""Elastic sphere on an elastic block, in the round (T3, Q4) and as a quarter in space (H8), against Hertz."""

from dataclasses import dataclass

import numpy as np
import pytest

import hertz
from block_meshes import consistent_areas
from gmsh_ascii import read_mesh
from runs import MESHES, solve_input
from sphere_mesh import RADIUS, SIZE, sphere_on_block

# [N] output points of the deck
LOADS = (20e3, 50e3, 100e3)
MESH_OF_DECK = str(MESHES / "sphere.msh")
BALANCE = 1e-9
# the other meshes are cut off by a disk or a square as large as the block
ROUND = {MESH_OF_DECK: "sphere.msh", "(_pi * 50^2)": f"(_pi * {SIZE}^2)"}
SOLID = {
    MESH_OF_DECK: "sphere.msh",
    "(_pi * 50^2)": f"(4 * {SIZE}^2)",
    "model: axisymmetric": "model: solid",
    "axis, displacement: {r: 0}}": "left, displacement: {x: 0}}\n  - {boundary: front, displacement: {y: 0}}",
    "direction: [0, 1]": "direction: [0, 0, 1]",
    "{load: 20.0e3}, {load: 50.0e3}, ": "",
}


@dataclass
class Case:
    """A mesh by steps near the contact [mm], their number, growth after them, or the deck's; allowed difference."""

    changes: dict
    n_dim: int
    tolerance: float
    # parts of the whole contact: a quarter, or all of it
    n_parts: int = 1
    grid: tuple = ()


# a / 19 to a / 32 (T3), a / 16 to a / 27 (Q4), a / 4 to a / 7 (H8)
CASES = {
    "T3 in the round": Case({}, 2, 0.02),
    "Q4 in the round": Case(ROUND, 2, 0.01, grid=(0.15, 40, 1.15)),
    "H8, a quarter": Case(SOLID, 3, 0.03, n_parts=4, grid=(0.55, 10, 1.6)),
}


def contact_nodes(case, folder):
    """Distance from the middle and consistent area of each node of the contact, in the order of the multipliers."""
    if not case.grid:
        mesh = read_mesh(MESHES / "sphere.msh")
        r = mesh.coordinates[mesh.nodes_of["block_face"], 0]
        return r, ring_areas(r)
    mesh = sphere_on_block(case.n_dim, *case.grid)
    mesh.write(folder / "sphere.msh")
    nodes = mesh.nodes_of("block_face")
    areas = consistent_areas(mesh, "block_face", is_round=case.n_dim == 2)[nodes]
    return np.linalg.norm(mesh.coordinates[nodes, : case.n_dim - 1], axis=1), areas


def ring_areas(r):
    """Integral of each node's hat function over the rings between the sorted radii."""
    order = np.argsort(r)
    low, high = r[order][:-1], r[order][1:]
    areas = np.zeros(len(r))
    areas[order[:-1]] += np.pi * (high - low) * (2 * low + high) / 3
    areas[order[1:]] += np.pi * (high - low) * (low + 2 * high) / 3
    return areas


@pytest.mark.parametrize("name", CASES)
def test_half_width_and_peak(signorom, tmp_path, figures, name):
    """Fitted half-width and peak, and the largest pressure, at each load."""
    case = CASES[name]
    distance, areas = contact_nodes(case, tmp_path)
    answers, _ = solve_input(signorom, "sphere", tmp_path, case.changes)
    problem = f"Hertz sphere on block, {name}"
    loads = LOADS[-len(answers) :]
    for load, fields in zip(loads, answers, strict=True):
        forces = fields["multipliers_full_order"]
        assert case.n_parts * forces.sum() == pytest.approx(load, rel=BALANCE)
        pressure = forces / areas
        half_width, peak = hertz.fit(distance, pressure)
        exact = hertz.Point(hertz.contact_modulus(*hertz.NAFEMS_MATERIALS), RADIUS, load)
        assert half_width == pytest.approx(exact.half_width, rel=case.tolerance)
        assert peak == pytest.approx(exact.peak, rel=case.tolerance)
        assert pressure.max() == pytest.approx(exact.peak, rel=case.tolerance)
        # nothing is closed beyond one cell outside the contact
        step = case.grid[0] if case.grid else 0.125
        assert distance[pressure > 0].max() <= exact.half_width + step
    figures.compare(
        problem, "radius a at 100 kN", half_width, exact.half_width, case.tolerance, "Hertz", "mm"
    )
    figures.compare(problem, "peak p0 of the fit", peak, exact.peak, case.tolerance, "Hertz", "MPa")
