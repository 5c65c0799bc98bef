# SPDX-License-Identifier: BSD-3-Clause
"""Round surfaces that are pressed far without a `direction`: a warning tells the error and the key to give."""

import re

import h5py
import numpy as np
import pytest
import yaml

from gmsh_mesh import make_mesh

# A quarter of a disc of radius R about (0, R), which touches what is below it at (0, 0). Above its center it is a
# rectangle, so that its rim ends at free nodes.
R = 10.0
DISC = """\
R = 10; H = 12;
Point(1) = {0, R, 0}; Point(2) = {0, 0, 0}; Point(3) = {R, R, 0}; Point(4) = {R, R + 1, 0}; Point(5) = {0, R + 1, 0};
Line(1) = {5, 1}; Line(6) = {1, 2}; Circle(2) = {2, 1, 3}; Line(3) = {3, 4}; Line(4) = {4, 5};
Curve Loop(1) = {1, 6, 2, 3, 4}; Plane Surface(1) = {1};
MeshSize{:} = 1.5; MeshSize{2} = 0.1; MeshSize{3} = 0.8;
Physical Surface("disc") = {1}; Physical Curve("rim") = {2}; Physical Curve("top") = {4};
"""
BLOCK = """\
Point(11) = {0, 0, 0}; Point(12) = {0, -H, 0}; Point(13) = {2 * R, -H, 0}; Point(14) = {2 * R, 0, 0};
Line(11) = {11, 12}; Line(12) = {12, 13}; Line(13) = {13, 14}; Line(14) = {14, 11};
Curve Loop(2) = {11, 12, 13, 14}; Plane Surface(2) = {2};
MeshSize{11} = 0.12;
Physical Curve("face") = {14};
"""
OTHER_DISC = """\
Point(11) = {0, -R, 0}; Point(12) = {0, 0, 0}; Point(13) = {R, -R, 0};
Line(11) = {12, 11}; Circle(14) = {13, 11, 12}; Line(12) = {11, 13};
Curve Loop(2) = {11, 12, 14}; Plane Surface(2) = {2};
MeshSize{12} = 0.12; MeshSize{13} = 0.8;
Physical Curve("face") = {14};
"""
SIDES = (
    'Physical Surface("below") = {2}; Physical Curve("bottom") = {12}; Physical Curve("axis") = {1, 6, 11};\n'
)
DECK = """\
mesh: {file: part.msh, model: plane_strain}
parameters: {d: {min: 0.001, max: SQUEEZE}}
materials:
  soft: {regions: [disc], young_modulus: 1000, poisson_ratio: 0.3}
  below: {regions: [below], young_modulus: MODULUS, poisson_ratio: 0.3}
boundary_conditions:
  - {boundary: top, displacement: {x: 0, y: -d}}
  - {boundary: bottom, displacement: {x: 0, y: 0}}
  - {boundary: axis, displacement: {x: 0}}
contact:
  - {first: rim, second: faceDIRECTION}
output: {points: [{d: SQUEEZE}]}
"""
DIRECTION = ", direction: [0.0, -1.0]"
SENTENCE = re.compile(
    r"warning: contact\[1\] \(rim - face\) reaches far beyond where its surfaces touch: contact forces lean by about "
    r"(\d+) degrees and may be too small by about (\d+) %, because the normals of the mesh are not right there; "
    r"give direction: \[0\.0, -1\.0\] in this entry"
)


def write_part(folder, below=BLOCK):
    """Writes the mesh."""
    (folder / "part.geo").write_text(DISC + below + SIDES)
    make_mesh(folder / "part.geo", folder / "part.msh")


def write_deck(folder, squeeze, direction="", modulus=1.0e5, name="part"):
    """Writes a deck, and returns its path."""
    text = (
        DECK.replace("SQUEEZE", str(squeeze)).replace("DIRECTION", direction).replace("MODULUS", str(modulus))
    )
    path = folder / f"{name}.yaml"
    path.write_text(text)
    return path


def said_by(signorom, command, deck):
    """What a command writes into its log."""
    done = signorom.run(command, deck.name, folder=deck.parent)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stderr


def pushes_on_disc(folder, name):
    """Places of the rim's nodes with contact force, and the sizes of their forces."""
    with h5py.File(folder / "results" / name / "fields.h5") as file:
        places = file["mesh/coordinates"][()]
        forces = file["points/0001/contact_force"][()]
    pushed = forces[:, 1] > 0
    return places[pushed], forces[pushed]


def test_disc_pressed_far_on_a_flat_face(signorom, tmp_path):
    """Squeezed by R / 10: the percentage is twice the mean of (x / (R - y))^2, and nearly what `direction` adds."""
    write_part(tmp_path)
    deck = write_deck(tmp_path, 1.0)
    checked = SENTENCE.findall(said_by(signorom, "check", deck))
    solved = SENTENCE.findall(said_by(signorom, "solve", deck))
    assert len(checked) == len(solved) == 1
    places, forces = pushes_on_disc(tmp_path, "part")
    leans = (places[:, 0] / (R - places[:, 1])) ** 2
    mean = np.average(leans, weights=np.linalg.norm(forces, axis=1))
    # nodes have the mean normal of two arcs, and at a plane of symmetry that of the plane
    assert 200 * mean == pytest.approx(int(solved[0][1]), abs=0.6)
    assert np.degrees(np.arctan(np.sqrt(mean))) == pytest.approx(int(solved[0][0]), abs=0.6)
    # a bed of springs: X^2 / R^2 = 2 d / R = 1 / 5 at the rim of contact, and the mean is a fifth of it; but tan^2 there
    # is 1 / (1 - d / R)^2 - 1 = 0.235, and the gaps along the normals end the contact a little earlier
    assert 7 <= int(checked[0][1]) <= 9

    straight = write_deck(tmp_path, 1.0, DIRECTION, name="straight")
    assert "reaches far" not in said_by(signorom, "check", straight) + said_by(signorom, "solve", straight)
    loss = 1 - forces[:, 1].sum() / pushes_on_disc(tmp_path, "straight")[1][:, 1].sum()
    assert 0.7 < 100 * loss / int(solved[0][1]) < 1.4


def test_disc_pressed_little(signorom, tmp_path):
    """Squeezed by R / 400: no warning."""
    write_part(tmp_path)
    deck = write_deck(tmp_path, R / 400)
    assert "reaches far" not in said_by(signorom, "check", deck) + said_by(signorom, "solve", deck)


def test_equal_discs(signorom, tmp_path):
    """Each normal errs by half of the angle between them; each command with solutions warns once of its points."""
    write_part(tmp_path, OTHER_DISC)
    deck = write_deck(tmp_path, 1.0, modulus=1000.0)
    deck.write_text(deck.read_text() + "training: {grid: {d: 2}}\n")
    (found,) = SENTENCE.findall(said_by(signorom, "run", deck))
    for command in ("sample", "train", "solve"):  # the snapshots are there already
        assert SENTENCE.findall(said_by(signorom, command, deck)) == [found]
    places, forces = pushes_on_disc(tmp_path, "part")
    leans = (places[:, 0] / (R - places[:, 1])) ** 2
    mean = np.average(leans, weights=np.linalg.norm(forces, axis=1))
    assert 200 * mean == pytest.approx(int(found[1]), abs=0.6)
    (told,) = yaml.safe_load((tmp_path / "results" / "part" / "report.yaml").read_text())["contact"][
        "warnings"
    ]
    assert SENTENCE.fullmatch(f"warning: {told}").groups() == found
