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


# A wedge between two flanks at 15 degrees to the y axis, 0.01 mm from both; contact alone holds it.
WEDGE = """t = Tan(Pi/12); d = 0.01/Cos(Pi/12); h = 2.5;
Point(1) = {-5-3*t+d, 3, 0, h}; Point(2) = {5+3*t-d, 3, 0, h}; Point(3) = {5+17*t-d, 17, 0, h};
Point(4) = {-5-17*t+d, 17, 0, h};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1};
Point(11) = {-25, -15, 0, 2*h}; Point(12) = {25, -15, 0, 2*h}; Point(13) = {25, 20, 0, 2*h};
Point(14) = {5+20*t, 20, 0, h}; Point(15) = {5, 0, 0, h}; Point(16) = {-5, 0, 0, h}; Point(17) = {-5-20*t, 20, 0, h};
Point(18) = {-25, 20, 0, 2*h};
For i In {11:17}
  Line(i) = {i, i+1};
EndFor
Line(18) = {18, 11};
Curve Loop(2) = {11:18}; Plane Surface(2) = {2};
Physical Surface("wedge") = {1}; Physical Surface("slot") = {2};
Physical Curve("right") = {2}; Physical Curve("left") = {4}; Physical Curve("top") = {3};
Physical Curve("slot_right") = {14}; Physical Curve("slot_left") = {16}; Physical Curve("base") = {11};
Mesh.ElementOrder = 2;
"""
WEDGE_DECK = """title: Wedge
units: {length: mm, force: N}
mesh: {file: wedge.msh, model: plane_strain}
parameters: {P: {min: 0, max: 60, unit: MPa}, T: {min: 20, max: 220, unit: C}}
materials:
  wedge: {regions: [wedge], young_modulus: 70.0e+3, poisson_ratio: 0.3, thermal_expansion: 1.8e-5}
  slot: {regions: [slot], young_modulus: 210.0e+3, poisson_ratio: 0.28}
boundary_conditions: [{boundary: base, displacement: {x: 0, y: 0}}]
loads: [{boundary: top, pressure: P}]
imposed_strains: [{region: wedge, temperature: T, reference: 20}]
contact: [{first: right, second: slot_right}, {first: left, second: slot_left}]
training: {sobol: 12}
test: {sobol: 4, seed: 1}
"""


def test_rounding_of_heat_is_no_contact(signorom, tmp_path):
    """Nothing presses the free wedge into its slot: no force and no area that touches, whatever the heat."""
    (tmp_path / "wedge.geo").write_text(WEDGE)
    make_mesh(tmp_path / "wedge.geo", tmp_path / "wedge.msh")
    (tmp_path / "wedge.yaml").write_text(WEDGE_DECK)
    signorom("run", "wedge.yaml", folder=tmp_path)
    temperatures = range(20, 221, 25)
    points = ", ".join(f"{{P: 0, T: {temperature}}}" for temperature in temperatures)
    (tmp_path / "wedge.yaml").write_text(
        WEDGE_DECK.replace(
            "title: Wedge", f"title: Wedge\noutput: {{points: [{points}]}}\nsolver: {{type: active_set}}"
        )
    )
    (tmp_path / "points.csv").write_text("P,T\n" + "".join(f"0,{value}\n" for value in temperatures))
    signorom(
        "predict", "results/wedge/model.h5", "--points", "points.csv", "--output", "told.csv", folder=tmp_path
    )
    signorom("solve", "wedge.yaml", folder=tmp_path)
    told = read_table(tmp_path / "told.csv")
    report = yaml.safe_load((tmp_path / "results" / "wedge" / "report.yaml").read_text())
    assert [point["n_active"] for point in report["points"].values()] == [0] * len(temperatures)
    for name in ("n_active", "contact_1_area", "contact_2_area"):
        assert set(told[name]) == {0}


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
