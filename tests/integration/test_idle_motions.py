# SPDX-License-Identifier: BSD-3-Clause
"""Motions that nothing holds: left out where no load drives them, refused with the load's name where one does."""

import numpy as np
import pytest

from block_meshes import Mesh, stacked_blocks
from gmsh_mesh import make_mesh
from results import read_fields
from runs import CRASH, refuse

pytestmark = pytest.mark.slow

# Without Poisson's effect plates, 1/2 high, and the block between them, 1 high, all 1 wide, push with 50 times the
# stroke: 1 / K = 0.5 / 100 + 1 / 100 + 0.5 / 100. Nothing holds the block along x.
STIFFNESS = 50.0
STROKE = 0.02
DECK = """\
title: A block between two plates
mesh: {file: plates.msh, model: plane_strain}
parameters: {stroke: {min: 0.005, max: 0.03, unit: m}, P: {min: -0.1, max: 0.1, unit: Pa}, Q: {min: -0.1, max: 0.1}}
materials:
  plates: {regions: [lower, upper], young_modulus: 100.0, poisson_ratio: 0.0}
  block: {regions: [block], young_modulus: MODULUS, poisson_ratio: 0.0}
boundary_conditions:
  - {boundary: bottom, displacement: {x: 0, y: 0}}
  - {boundary: top, displacement: {x: 0, y: "-stroke"}}
loads: [{boundary: left, pressure: P}, {boundary: right, pressure: RIGHT}]
contact:
  - {first: block_low, second: lower_face}
  - {first: block_high, second: upper_face}
solver: SOLVER
training: TRAINING
test: {file: points.csv}
reduction: REDUCTION
"""
PLAIN = {
    "MODULUS": "100.0",
    "RIGHT": "P",
    "SOLVER": "{}",
    "TRAINING": "{sobol: 10}",
    "REDUCTION": "{fields: true}",
}
POINTS = "stroke,P,Q\n0.02,0.05,0.0\n0.01,-0.04,0.02\n"
NOTE = "nothing holds the body 'block' (translation in x), and no load drives it"
SOLVERS = ["{type: condensed}", "{type: active_set}", "{type: active_set, linear: gamg}"]
# [-] direct solvers; conjugate gradients stop at 1e-12 of the energy
DIRECT, ITERATIVE = 1e-10, 1e-7


def write_deck(folder, **changes):
    """Writes mesh, points and deck, and returns the path of the deck."""
    across = np.array([0.0, 0.4, 1.0])
    mesh = Mesh()
    mesh.add_block("lower", [across, [-0.5, 0.0]], "Q4", {(1, 0): "bottom", (1, 1): "lower_face"})
    sides = {(1, 0): "block_low", (1, 1): "block_high", (0, 0): "left", (0, 1): "right"}
    mesh.add_block("block", [across, [0.0, 0.3, 1.0]], "Q4", sides)
    mesh.add_block("upper", [across, [1.0, 1.5]], "Q4", {(1, 0): "upper_face", (1, 1): "top"})
    mesh.write(folder / "plates.msh")
    (folder / "points.csv").write_text(POINTS)
    text = DECK
    for old, new in (PLAIN | changes).items():
        text = text.replace(old, new)
    deck = folder / "plates.yaml"
    deck.write_text(text)
    return deck


def exact(stroke, side):
    """Displacement of the mesh's nodes at a point: u_y is linear in each body, the block is squeezed about its middle.

    The mesh has 6 nodes of the lower plate, 9 of the block and 6 of the upper plate, column by column. The block's
    middle is the mean of its nodes, (0 + 0.4 + 1) / 3.
    """
    across = np.array([0.0, 0.4, 1.0])
    rows = []
    for i, levels in enumerate(([-0.5, 0.0], [0.0, 0.3, 1.0], [1.0, 1.5])):
        for x in across:
            along = -side / 100 * (x - across.mean()) if i == 1 else 0.0
            rows += [[along, -stroke * (y + 0.5) / 2] for y in levels]
    return np.array(rows)


@pytest.mark.parametrize("n_ranks", [1, 3])
@pytest.mark.parametrize("solver", SOLVERS)
def test_a_block_between_plates(signorom, tmp_path, solver, n_ranks):
    """Force, displacement and note, by each solver."""
    deck = write_deck(tmp_path, SOLVER=solver)
    shown = signorom(
        "solve", deck.name, "--at", f"stroke={STROKE},P=0.05,Q=0", folder=tmp_path, n_ranks=n_ranks
    )
    assert NOTE in shown
    tolerance = ITERATIVE if "gamg" in solver else DIRECT
    fields = read_fields(tmp_path / "results" / "plates" / "fields.h5")
    forces = fields["multipliers_full_order"]
    assert forces.sum() == pytest.approx(2 * STIFFNESS * STROKE, rel=tolerance)
    np.testing.assert_allclose(fields["displacement"][:, :2], exact(STROKE, 0.05), atol=tolerance * STROKE)


MODELS = {
    "condensed": {},
    "interpolated": {"MODULUS": "100 + 200 * Q"},
    "hhr": {"REDUCTION": "{fields: true, method: hhr}"},
    "modes": {"REDUCTION": "{displacement: {boundaries: [top], elsewhere: modes}}"},
}


@pytest.mark.parametrize("kind", MODELS)
def test_models_leave_the_motion_out(signorom, post, tmp_path, kind):
    """Contact forces and displacements are those of the full order."""
    deck = write_deck(tmp_path, **MODELS[kind])
    for command in ("sample", "train", "validate"):
        signorom(command, deck.name, folder=tmp_path)
    with post.Model(tmp_path / "results" / "plates" / "model.h5") as model:
        answer = model.query(stroke=STROKE, P=0.05, Q=0.0)
        assert answer.multipliers.sum() == pytest.approx(2 * STIFFNESS * STROKE, rel=1e-6)
        if kind != "hhr":
            np.testing.assert_allclose(answer.displacement, exact(STROKE, 0.05), atol=1e-6 * STROKE)
            assert answer.gradient.multipliers[0].sum() == pytest.approx(2 * STIFFNESS, rel=1e-5)


def test_a_load_that_drives_the_block(signorom, tmp_path):
    """With 0.05 Pa on the left side, 1 high, and 0.02 on the right one: 0.03 N per metre along x."""
    deck = write_deck(tmp_path, RIGHT="Q")
    for command in ("check", "run"):
        words = refuse(signorom, command, deck.name, folder=tmp_path)
        assert (
            "the load on 'left' drives the body 'block', which nothing holds (translation in x), with a force of"
            in words
        )
    words = refuse(signorom, "solve", deck.name, "--at", "stroke=0.02,P=0.05,Q=0.02", folder=tmp_path)
    assert "plates.yaml:10:" in words
    assert "with a force of 0.05 N/m (all loads together: a force of 0.03 N/m) at" in words
    deck.write_text(deck.read_text().replace("solver: {}", "solver: {hold_unloaded_motions: false}"))
    assert "nothing can hold the body 'block' (translation in x)" in refuse(
        signorom, "check", deck.name, folder=tmp_path
    )


def test_a_model_says_where_loads_drive_the_block(signorom, post, tmp_path):
    """Trained where the pressures on both sides are equal, asked where they are not."""
    deck = write_deck(tmp_path, RIGHT="Q", TRAINING="{file: training.csv}")
    rows = [f"{0.005 * (i + 1)},{p},{p}" for i, p in enumerate((-0.1, 0.05, 0.1))]
    (tmp_path / "training.csv").write_text("\n".join(["stroke,P,Q", *rows, ""]))
    for command in ("sample", "train"):
        signorom(command, deck.name, folder=tmp_path)
    model = tmp_path / "results" / "plates" / "model.h5"
    done = signorom.run("predict", model, "--at", "stroke=0.02,P=0.05,Q=0.02", folder=tmp_path)
    assert done.returncode == 3
    assert "the loads drive a body in a motion that nothing holds" in done.stdout + done.stderr
    assert not [word for word in CRASH if word in done.stderr]
    with post.Model(model) as opened:
        answer = opened.query(stroke=STROKE, P=0.05, Q=0.05)
        assert answer.multipliers.sum() == pytest.approx(2 * STIFFNESS * STROKE, rel=1e-8)
        np.testing.assert_allclose(answer.displacement, exact(STROKE, 0.05), atol=1e-10 * STROKE)


PRESSED = """\
mesh: {file: part.msh, model: plane_strain}
parameters: {P: {min: 1.0, max: 2.0}}
materials: {all: {regions: [lower, upper], young_modulus: 100.0, poisson_ratio: 0.0}}
boundary_conditions: [{boundary: bottom, displacement: {x: 0, y: 0}}]
loads: [{boundary: top, pressure: P}]
contact: [{first: lower_face, second: upper_face, direction: [0, 1]}]
"""


def test_rounding_of_a_normal_drives_nothing(signorom, tmp_path):
    """A pressure on a top that is even but for rounding, as in converted meshes, has no force along x."""
    mesh = stacked_blocks("Q4", 2)
    mesh.coordinates[:, 1] += 1e-15 * np.cos(np.arange(len(mesh.coordinates)))
    mesh.write(tmp_path / "part.msh")
    (tmp_path / "part.yaml").write_text(PRESSED)
    shown = signorom("solve", "part.yaml", "--at", "P=1.5", folder=tmp_path)
    assert "nothing holds the body 'upper' (translation in x), and no load drives it" in shown
    forces = read_fields(tmp_path / "results" / "part" / "fields.h5")["multipliers_full_order"]
    width = np.ptp(mesh.coordinates[mesh.nodes_of("top"), 0])
    assert forces.sum() == pytest.approx(1.5 * width, rel=DIRECT)


# A disc, 50 high and wide, between plates; its arcs begin and end at 21 degrees beside the contacts, with edges of
# different lengths.
DISC = """R = 50; a = 0.37;
Point(1) = {0, 0, 0, 6};
Point(2) = {R*Cos(a), R*Sin(a), 0, 3}; Point(3) = {-R*Sin(a), R*Cos(a), 0, 0.4};
Point(4) = {-R*Cos(a), -R*Sin(a), 0, 4}; Point(5) = {R*Sin(a), -R*Cos(a), 0, 0.5};
Circle(1) = {2, 1, 3}; Circle(2) = {3, 1, 4}; Circle(3) = {4, 1, 5}; Circle(4) = {5, 1, 2};
Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1};
Point(11) = {-40, -60, 0, 4}; Point(12) = {40, -60, 0, 4}; Point(13) = {40, -50, 0, 4}; Point(14) = {-40, -50, 0, 4};
Point(15) = {0, -50, 0, 0.3};
Line(11) = {11, 12}; Line(12) = {12, 13}; Line(13) = {13, 15}; Line(14) = {15, 14}; Line(15) = {14, 11};
Curve Loop(2) = {11:15}; Plane Surface(2) = {2};
Point(21) = {-40, 60, 0, 4}; Point(22) = {40, 60, 0, 4}; Point(23) = {40, 50, 0, 4}; Point(24) = {-40, 50, 0, 4};
Point(25) = {0, 50, 0, 0.3};
Line(21) = {21, 22}; Line(22) = {22, 23}; Line(23) = {23, 25}; Line(24) = {25, 24}; Line(25) = {24, 21};
Curve Loop(3) = {21:25}; Plane Surface(3) = {3};
Physical Surface("disc") = {1}; Physical Surface("lower") = {2}; Physical Surface("upper") = {3};
Physical Curve("disc_top") = {1, 2}; Physical Curve("disc_bottom") = {3, 4};
Physical Curve("low_face") = {13, 14}; Physical Curve("up_face") = {23, 24};
Physical Curve("base") = {11}; Physical Curve("head") = {21};
"""
DISC_DECK = """title: A disc between plates
mesh: {file: disc.msh, model: plane_strain}
units: {length: mm, force: N}
parameters: {squeeze: {min: 0.01, max: 0.2, unit: mm}}
materials: {steel: {regions: [disc, lower, upper], young_modulus: 210000, poisson_ratio: 0.3}}
boundary_conditions:
  - {boundary: base, displacement: {x: 0, y: 0}}
  - {boundary: head, displacement: {x: 0, y: "-squeeze"}}
contact: [{first: disc_bottom, second: low_faceDOWN}, {first: disc_top, second: up_faceUP}]
"""


def test_facets_do_not_roll_a_disc(signorom, tmp_path):
    """Of an uneven mesh, without directions in the deck: the force is that with the directions.

    Its facets alone hold the disc: their moments rolled it away, and no contact force was left.
    """
    (tmp_path / "disc.geo").write_text(DISC)
    make_mesh(tmp_path / "disc.geo", tmp_path / "disc.msh")
    forces = {}
    for name, down, up in (("plain", "", ""), ("given", ", direction: [0, -1]", ", direction: [0, 1]")):
        (tmp_path / f"{name}.yaml").write_text(DISC_DECK.replace("DOWN", down).replace("UP", up))
        shown = signorom("solve", f"{name}.yaml", "--at", "squeeze=0.1", folder=tmp_path)
        motion = "rotation" if name == "plain" else "translation in x"
        assert f"nothing holds the body 'disc' ({motion}), and no load drives it" in shown
        fields = read_fields(tmp_path / "results" / name / "fields.h5")
        forces[name] = fields["multipliers_full_order"].sum() / 2
    # edges of 0.4 on a half width of contact of about 1.5
    assert forces["plain"] == pytest.approx(forces["given"], rel=0.02)


# A pin of radius 1 in a bush in an eye of radius 3, whose rim is held.
LUG = """\
SetFactory("OpenCASCADE");
Disk(11) = {0, 0, 0, 3};
Disk(12) = {0, 0, 0, 1.5};
BooleanDifference(1) = { Surface{11}; Delete; }{ Surface{12}; Delete; };
Disk(13) = {0, 0, 0, 1.5};
Disk(14) = {0, 0, 0, 1};
BooleanDifference(2) = { Surface{13}; Delete; }{ Surface{14}; Delete; };
Disk(3) = {0, 0, 0, 1};
Physical Surface("eye") = {1};
Physical Surface("bush") = {2};
Physical Surface("pin") = {3};
eye() = Abs(Boundary{ Surface{1}; });
bush() = Abs(Boundary{ Surface{2}; });
pin() = Abs(Boundary{ Surface{3}; });
Physical Curve("rim") = {eye(0)};
Physical Curve("eye_bore") = {eye(1)};
Physical Curve("bush_outside") = {bush(0)};
Physical Curve("bush_bore") = {bush(1)};
Physical Curve("pin_face") = {pin(0)};
Mesh.MeshSizeMin = 0.3;
Mesh.MeshSizeMax = 0.3;
"""
LUG_DECK = """\
mesh: {file: lug.msh, model: plane_stress}
parameters: {pull: {min: 1.0, max: 5.0}, angle: {min: -1.0, max: 1.0}}
materials: {steel: {regions: [pin, bush, eye], young_modulus: 2.0e5, poisson_ratio: 0.3}}
boundary_conditions: [{boundary: rim, displacement: {x: 0, y: 0}}]
loads: [{region: pin, body_force: {x: pull * sin(angle), y: pull * cos(angle)}}]
contact:
  - {first: bush_bore, second: pin_face, initial_gap: 1.0e-6}
  - {first: bush_outside, second: eye_bore, initial_gap: -1.0e-4}
"""


def test_a_load_on_one_body_does_not_turn_another(signorom, tmp_path):
    """Bush and pin may turn, each alone: what a pull at the pin works on the turn of the bush is rounding."""
    (tmp_path / "lug.geo").write_text(LUG)
    make_mesh(tmp_path / "lug.geo", tmp_path / "lug.msh")
    (tmp_path / "lug.yaml").write_text(LUG_DECK)
    shown = signorom("solve", "lug.yaml", "--at", "pull=2.0,angle=0.7", folder=tmp_path)
    for body in ("pin", "bush"):
        assert f"nothing holds the body '{body}' (rotation), and no load drives it" in shown
