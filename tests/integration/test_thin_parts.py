# SPDX-License-Identifier: BSD-3-Clause
"""A thin strip between two bodies: as a free body it is a million times softer than its contacts."""

import pytest
import yaml

from gmsh_mesh import make_mesh
from results import read_table


def strip_geometry():
    """Text of the .geo file: a base, a strip of 36 x 0.35 mm and a block on it, of quadratic quadrilaterals."""
    lines = ["Mesh.ElementOrder = 2;", "Mesh.SecondOrderIncomplete = 1;", "Mesh.RecombineAll = 1;"]
    parts = (("base", 27, -9, 0, 28, 5), ("strip", 18, 0, 0.35, 25, 2), ("block", 22, 0.35, 9, 24, 5))
    for i, (name, half, low, high, across, up) in enumerate(parts):
        n = 10 * (i + 1)
        corners = ((-half, low), (half, low), (half, high), (-half, high))
        lines += [f"Point({n + k}) = {{{x}, {y}, 0}};" for k, (x, y) in enumerate(corners)]
        lines += [f"Line({n + k}) = {{{n + k}, {n + (k + 1) % 4}}};" for k in range(4)]
        lines += [
            f"Curve Loop({n}) = {{{n}, {n + 1}, {n + 2}, {n + 3}}}; Plane Surface({n}) = {{{n}}};",
            f"Transfinite Curve {{{n}, {n + 2}}} = {across}; Transfinite Curve {{{n + 1}, {n + 3}}} = {up};",
            f'Transfinite Surface {{{n}}}; Physical Surface("{name}") = {{{n}}};',
            f'Physical Curve("{name}_low") = {{{n}}}; Physical Curve("{name}_up") = {{{n + 2}}};',
            f'Physical Curve("{name}_end") = {{{n + 3}}};',
        ]
    return "\n".join(lines) + "\n"


DECK = """units: {length: mm, force: N}
mesh: {file: strip.msh, model: plane_strain}
parameters:
  p: {min: 1, max: 20, unit: MPa}
  s: {min: -10, max: 10, unit: mm}
  MORE
materials:
  steel: {regions: [base, block], young_modulus: 210e3, poisson_ratio: 0.3}
  copper: {regions: [strip], young_modulus: MODULUS, poisson_ratio: 0.34}
boundary_conditions:
  - {boundary: base_low, displacement: {x: 0, y: 0}}
  - {boundary: strip_end, displacement: {x: 0}}
  - {boundary: block_end, displacement: {x: 0}}
loads: [{boundary: block_up, pressure: p, window: {axis: x, min: s - 4, max: s + 4}}]
contact:
  - {first: strip_low, second: base_up}
  - {first: strip_up, second: block_low}
training: {sobol: 24}
test: {sobol: 12, seed: 5}
"""


@pytest.mark.parametrize(
    ("modulus", "more", "tolerance"),
    [("110e3", "", 1e-7), ("E", "E: {min: 60e3, max: 180e3, unit: MPa}", 1e-6)],
    ids=["fixed", "variable"],
)
def test_forces_of_the_model_are_those_of_another_solver(signorom, tmp_path, modulus, more, tolerance):
    """The active set method on the whole mesh, which makes no matrix of the contacts, solves the test points."""
    (tmp_path / "strip.geo").write_text(strip_geometry())
    make_mesh(tmp_path / "strip.geo", tmp_path / "strip.msh", 2)
    deck = DECK.replace("MODULUS", modulus).replace("MORE", more) + "solver: {type: active_set}\n"
    (tmp_path / "strip.yaml").write_text(deck)
    signorom("run", "strip.yaml", folder=tmp_path)
    results = tmp_path / "results" / "strip"
    table = read_table(results / "validation.csv")
    assert min(table["n_active_full_order"]) > 10
    assert max(table["e_lambda_all"]) < tolerance
    assert yaml.safe_load((results / "report.yaml").read_text())["validation"]["accepted"] is True
