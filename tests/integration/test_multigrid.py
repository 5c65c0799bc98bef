# SPDX-License-Identifier: BSD-3-Clause
"""Multigrid on quadratic elements, whose first coarse level are the linear elements with the same corners."""

import csv
import re

import numpy as np
import pytest
import yaml

from block_meshes import LINEAR, Mesh
from results import read_fields

# iterations of conjugate gradients for each active set, over those of linear elements with as many nodes
LARGEST_RATIO = 1.6
# conjugate gradients stop at 1e-12 of the energy
SAME_FORCES = 1e-8
DECK = """\
title: Two blocks
mesh: {{file: blocks.msh, model: solid}}
parameters: {{P: {{min: 0.5e6, max: 2.0e6, unit: Pa}}}}
materials: {{steel: {{regions: [lower, upper], young_modulus: 210.0e9, poisson_ratio: 0.3}}}}
boundary_conditions:
  - {{boundary: bottom, displacement: {{x: 0, y: 0, z: 0}}}}
  - {{boundary: left, displacement: {{x: 0}}}}
  - {{boundary: front, displacement: {{y: 0}}}}
loads:
  - {{boundary: top, pressure: P}}
contact:
  - {{first: lower_face, second: upper_face, direction: [0, 0, 1], initial_gap: "6e-5 * (x^2 + y^2)"}}
solver: {{type: {solver}}}
output: {{points: [{{P: 1.0e6}}], fields: [contact]}}
"""


def write_part(folder, element, n_side, n_high):
    """Two blocks, 1 wide and 0.5 high; cells along the sides and the height of each."""
    mesh = Mesh()
    across = np.linspace(0, 1, n_side + 1)
    for region, low, faces in (
        ("lower", -0.5, {(2, 0): "bottom", (2, 1): "lower_face"}),
        ("upper", 0.0, {(2, 0): "upper_face", (2, 1): "top"}),
    ):
        lines = [across, across, np.linspace(low, low + 0.5, n_high + 1)]
        sides = {(0, 0): "left", (1, 0): "front"}
        mesh.add_block(region, lines, LINEAR.get(element, element), faces | sides)
    if element in LINEAR:
        mesh.make_quadratic(element)
    mesh.write(folder / "blocks.msh")
    return len(mesh.coordinates)


def solve(signorom, folder, solver, n_ranks=1):
    """Iterations per active set, and contact forces."""
    (folder / "blocks.yaml").write_text(DECK.format(solver=solver))
    signorom("solve", "blocks.yaml", folder=folder, n_ranks=n_ranks)
    results = folder / "results" / "blocks"
    point = yaml.safe_load((results / "report.yaml").read_text())["points"]["1"]
    forces = read_fields(results / "fields.h5")["multipliers_full_order"]
    return point["linear_iterations"] / point["iterations"], forces


@pytest.mark.parametrize(
    ("element", "n_quadratic", "n_linear"), [("T10", (5, 3), (10, 6)), ("H20", (6, 4), (10, 6))]
)
def test_quadratic_elements(signorom, tmp_path, element, n_quadratic, n_linear):
    """Few more iterations than linear elements need, on any number of ranks; forces of a factorization."""
    linear, quadratic = tmp_path / "linear", tmp_path / "quadratic"
    linear.mkdir()
    quadratic.mkdir()
    n_nodes = write_part(linear, LINEAR[element], *n_linear), write_part(quadratic, element, *n_quadratic)
    assert abs(n_nodes[1] / n_nodes[0] - 1) < 0.2
    multigrid = "active_set, linear: gamg"
    per_set, _ = solve(signorom, linear, multigrid)
    _, expected = solve(signorom, quadratic, "condensed")
    for n_ranks in (1, 2, 4):
        found, forces = solve(signorom, quadratic, multigrid, n_ranks)
        assert found <= LARGEST_RATIO * per_set, (n_ranks, found, per_set)
        np.testing.assert_allclose(forces, expected, atol=SAME_FORCES * expected.max())


def test_bad_bounds(signorom, tmp_path):
    """Where the bounds of Chebyshev's smoother are far too small for the matrices, they are estimated anew."""
    write_part(tmp_path, "H8", 10, 6)
    (tmp_path / "blocks.yaml").write_text(DECK.format(solver="active_set, linear: gamg"))
    option = "-active_set_mg_levels_ksp_chebyshev_esteig_steps"
    forces, words = [], []
    for steps in ("10", "1"):
        words.append(
            signorom(
                "solve", "blocks.yaml", option, steps, "-active_set_ksp_converged_reason", folder=tmp_path
            )
        )
        forces.append(read_fields(tmp_path / "results" / "blocks" / "fields.h5")["multipliers_full_order"])
    assert [text.count("did not converge") for text in words] == [0, 1]
    np.testing.assert_allclose(forces[1], forces[0], atol=SAME_FORCES * forces[0].max())


def test_model_without_a_factor(signorom, tmp_path):
    """W by elimination, displacements by modes that multigrid solves for: exact forces, errors that answers tell."""
    write_part(tmp_path, "H8", 6, 3)
    text = DECK.format(solver="linear: gamg").replace("solver: {type: ", "solver: {")
    text = text.replace("output:", "training: {sobol: 6}\ntest: {latin_hypercube: 3}\noutput:")
    # [MB] W has room, the displacements of all nodes under each contact force have not
    text += "reduction: {max_full_order_size: 0.2}\n"
    (tmp_path / "blocks.yaml").write_text(text)
    words = signorom("run", "blocks.yaml", folder=tmp_path, n_ranks=2)
    assert "solver: condensed, gamg" in words
    assert re.search(r"displacements by \d+ modes", words)
    assert "trained condensed model of 49 contact rows" in words
    with (tmp_path / "results" / "blocks" / "validation.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 3
    for row in rows:
        assert float(row["e_lambda_all"]) < SAME_FORCES
        assert float(row["error_bound"]) < SAME_FORCES
        error, bound = float(row["e_u_energy"]), float(row["displacement_bound"])
        assert error < 1.01 * bound + SAME_FORCES
