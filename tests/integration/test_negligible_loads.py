# SPDX-License-Identifier: BSD-3-Clause
"""Points where nearly nothing is loaded: forces of rounding do not count, and a window beside its surface is named."""

import numpy as np
import pytest
import yaml

from gmsh_mesh import make_mesh
from results import read_table
from runs import write_deck

BLOCKS = """SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 3.7, 2.3, 1.1};
Box(2) = {0.4, 0.3, 1.1, 2.1, 1.3, 0.9};
Physical Volume("lower") = {1};
Physical Volume("upper") = {2};
Physical Surface("bottom") = {5};
Physical Surface("lower_top") = {6};
Physical Surface("left") = {7};
Physical Surface("front") = {9};
Physical Surface("upper_bottom") = {11};
Physical Surface("press") = {12};
Mesh.MeshSizeMax = 0.6;
"""
# The upper block cannot turn, so contact carries the resultant of the load. That of the tilt alone is 0: the center of
# the face is at x = 1.45 mm.
DECK = """title: Blocks
units: {length: mm, force: N}
mesh: {file: blocks.msh, model: solid}
materials:
  steel: {regions: [lower], young_modulus: 210000, poisson_ratio: 0.3}
  aluminum: {regions: [upper], young_modulus: 70000, poisson_ratio: 0.33}
parameters: {P: {min: 0, max: 20, unit: MPa}, tilt: {min: 0, max: 10, unit: MPa}}
boundary_conditions:
  - {boundary: bottom, displacement: {x: 0, y: 0, z: 0}}
  - {boundary: left, displacement: {x: 0}}
  - {boundary: front, displacement: {y: 0}}
loads: [{boundary: press, LOAD}]
contact: [{first: upper_bottom, second: lower_top, formulation: mortar}]
training: {sobol: 12}
test: {grid: {P: 3, tilt: 3}}
"""


@pytest.fixture(scope="module")
def blocks(tmp_path_factory):
    folder = tmp_path_factory.mktemp("blocks")
    (folder / "blocks.geo").write_text(BLOCKS)
    make_mesh(folder / "blocks.geo", folder / "blocks.msh", 3)
    return folder


def write(folder, load, more=""):
    (folder / "blocks.yaml").write_text(DECK.replace("LOAD", load) + more)


@pytest.mark.parametrize("method", ["condensed", "hhr"])
def test_forces_of_rounding_are_not_judged(signorom, blocks, method):
    """Without P the contact forces are 0 but for rounding, in the full-order model and in the answers."""
    write(blocks, 'pressure: "P + tilt * (x - 1.45)"', f"reduction: {{method: {method}}}\n")
    signorom("run", "blocks.yaml", folder=blocks)
    report = yaml.safe_load((blocks / "results" / "blocks" / "report.yaml").read_text())
    assert report["validation"]["accepted"] is True
    table = read_table(blocks / "results" / "blocks" / "validation.csv")
    errors = np.array(table["e_lambda_all"])
    assert not np.isinf(errors).any()
    assert errors[np.array(table["P"]) > 0].max() < 1e-2


def test_a_window_beside_its_surface_is_named(signorom, blocks):
    """The press face reaches from x = 0.4 to 2.5 mm, the window from 0.2 tilt to 0.2 tilt + 0.3 mm."""
    write(blocks, 'pressure: P, window: {axis: x, min: "0.2 * tilt", max: "0.2 * tilt + 0.3"}')
    done = signorom.run("solve", "blocks.yaml", "--at", "P=5,tilt=0", folder=blocks)
    assert (
        "warning: the window of loads[1] loads nothing of 'press' at 1 of 1 points, for instance at P = 5.0 MPa"
        in done.stderr
    )
    assert (
        "the window has min 0.0 mm and max 0.3 mm, and 'press' lies between x = 0.4 and 2.5 mm" in done.stderr
    )
    done = signorom.run("solve", "blocks.yaml", "--at", "P=5,tilt=5", folder=blocks)
    assert done.returncode == 0
    assert "loads nothing" not in done.stderr


def test_a_model_of_points_without_contact(signorom, tmp_path):
    """The blocks are 0.01 m apart and never touch: u = G theta is exact, and no displacement by contact is known."""
    changes = {
        "{min: 0.02, max: 0.1, unit: m}": "{min: 0, max: 0.0078125, unit: m}",
        "push: 0.05": "push: 0.005",
        "{method: hhr}": "{method: condensed, max_full_order_size: 0.0005}",
    }
    deck = write_deck("patch", tmp_path, **changes)
    signorom("run", deck.name, folder=tmp_path)
    table = read_table(tmp_path / "results" / "patch" / "validation.csv")
    assert max(table["n_active_full_order"]) == 0
    assert np.nanmax(table["e_u"]) < 1e-12
