# SPDX-License-Identifier: BSD-3-Clause
"""What makes results doubtful is said: a domain without contact, other settings, one snapshot, poor materials."""

import re

import numpy as np
import pytest
import yaml

from block_meshes import stacked_blocks
from gmsh_mesh import make_mesh
from program import ROOT
from results import read_table
from runs import refuse, write_deck

ONE_POINT = {"grid: {squeeze: 7, shift: 3}": "file: points.csv"}


def deck_with_one_point(folder, changes=None):
    """A deck with one training point."""
    (folder / "points.csv").write_text("squeeze,shift\n0.2,0.0\n")
    return write_deck("shifted_disks", folder, **ONE_POINT, **(changes or {}))


def report_of(folder):
    return yaml.safe_load((folder / "results" / "shifted_disks" / "report.yaml").read_text())


def test_domain_grows_by_contacts_that_snapshots_close(signorom, tmp_path):
    """Few interpolation points: on a part that only contact holds nothing touched in the domain at 8 % of the points."""
    deck = tmp_path / "bracket.yaml"
    text = (ROOT / "input" / "bracket.yaml").read_text().replace("../meshes", str(ROOT / "meshes"))
    deck.write_text(
        f"{text}certificate: {{max_error: none}}\nreduction: {{method: hhr, pod_tolerance: 1.0e-5}}\n"
    )
    signorom("run", deck.name, folder=tmp_path)
    table = read_table(tmp_path / "results" / "bracket" / "validation.csv")
    assert (table["n_active"] > 0).all()
    assert max(table["e_lambda_all"]) < 0.5


def test_model_without_unknowns_is_refused(signorom, tmp_path):
    """The rows of prescribed values take the only mode; the contact surface is in the domain."""
    changes = {
        "pod_tolerance: 1.0e-5}": "pod_tolerance: 0.9, dirichlet: multiplier, zones_of_interest: [lower_arc], "
        "enrichment: none}"
    }
    deck = deck_with_one_point(tmp_path, changes)
    signorom("sample", deck.name, folder=tmp_path)
    done = signorom.run("train", deck.name, folder=tmp_path)
    assert done.returncode == 2
    assert "the reduced model has no unknowns" in done.stderr


def test_large_errors_are_warned_of_with_their_size(signorom, tmp_path):
    """One snapshot: the warnings name what the table says; another setting is refused afterwards."""
    deck = deck_with_one_point(tmp_path)
    done = signorom.run("run", deck.name, folder=tmp_path)
    assert done.returncode == 0
    assert "trained on one snapshot" in done.stdout + done.stderr
    errors = read_table(tmp_path / "results" / "shifted_disks" / "validation.csv")["e_lambda_all"]
    statistics = report_of(tmp_path)["errors"]
    assert statistics["e_lambda_all"]["median"] > 0.1
    warning = next(text for text in statistics["warnings"] if "e_lambda_all" in text)
    named = float(warning.split("median of e_lambda_all is ")[1].split()[0])
    # four digits
    assert named == pytest.approx(np.median(errors), rel=1e-3)
    assert warning in done.stdout + done.stderr
    deck.write_text(deck.read_text().replace("pod_tolerance: 1.0e-5", "pod_tolerance: 1.0e-6"))
    done = signorom.run("validate", deck.name, folder=tmp_path)
    assert done.returncode == 2
    assert "trained with other settings; the deck now has 'pod_tolerance: 1.0e-6'" in done.stderr


def test_a_model_of_other_ranges_is_not_validated(signorom, tmp_path):
    deck = deck_with_one_point(tmp_path)
    assert signorom.run("run", deck.name, folder=tmp_path).returncode == 0
    deck.write_text(deck.read_text().replace("min: 0.15, max: 0.45", "min: 0.15, max: 0.5"))
    done = signorom.run("validate", deck.name, folder=tmp_path)
    assert done.returncode == 2
    assert "the deck now has 'squeeze: {min: 0.15, max: 0.5, unit: m}'" in done.stderr


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("poisson_ratio: 0.35", "poisson_ratio: 0.4999999999", "volumetric locking"),
        ("young_modulus: 15.0", "young_modulus: 15.0e12", "is 6.0e11 times the smallest"),
    ],
)
def test_poor_materials_are_warned_of(signorom, tmp_path, old, new, words):
    """Before the work, and in the report."""
    deck = write_deck("shifted_disks", tmp_path, **{old: new})
    done = signorom.run("solve", deck.name, folder=tmp_path)
    assert done.returncode == 0
    assert words in done.stdout + done.stderr
    assert any(words in text for text in report_of(tmp_path)["solver"]["warnings"])


def test_quadratic_elements_do_not_lock(signorom, tmp_path):
    deck = tmp_path / "dovetail.yaml"
    text = (ROOT / "input" / "dovetail.yaml").read_text().replace("../meshes", str(ROOT / "meshes"))
    deck.write_text(re.sub(r"poisson_ratio: [\d.]+", "poisson_ratio: 0.495", text))
    done = signorom.run("check", deck.name, folder=tmp_path)
    assert done.returncode == 0
    assert "locking" not in done.stdout + done.stderr


LEVER = """SetFactory("OpenCASCADE");
Disk(1) = {0, 0, 0, 9.7};
Rectangle(2) = {-20, -20, 0, 80, 40};
Disk(3) = {0, 0, 0, 10};
BooleanDifference(4) = {Surface{2}; Delete;}{Surface{3}; Delete;};
Physical Surface("pin") = {1};
Physical Surface("lever") = {4};
bore() = Curve In BoundingBox{-10.1, -10.1, -1, 10.1, 10.1, 1};
rim() = Boundary{Surface{1};};
bore() -= {rim(0), -rim(0)};
Physical Curve("rim") = {rim()};
Physical Curve("bore") = {bore()};
end() = Curve In BoundingBox{59.9, -30, -1, 60.1, 30, 1};
Physical Curve("end") = {end()};
Mesh.MeshSizeMax = 4;
// edges of different lengths: their normals are not exactly radial
Transfinite Curve {bore()} = 40 Using Progression 1.05;
"""
LEVER_DECK = """mesh: {file: lever.msh, model: plane_strain}
units: {length: mm, force: N}
parameters: {pull: {min: 1, max: 20, unit: MPa}}
materials: {steel: {regions: [pin, lever], young_modulus: 2.1e5, poisson_ratio: 0.3}}
boundary_conditions: [{boundary: rim, displacement: {x: 0, y: 0}}SUPPORT]
loads: [{boundary: end, traction: {x: pull, y: 0.1 * pull}}]
contact: [{first: bore, second: rim, formulation: mortar}]
training: {sobol: 8}
test: {sobol: 4, seed: 3}
"""


@pytest.mark.parametrize(
    ("support", "is_turning"), [(", {boundary: end, displacement: {y: 0}}", False), ("", True)]
)
def test_a_lever_that_turns_on_its_pin(signorom, tmp_path, support, is_turning):
    """Nothing but the corners of the mesh holds it against a moment: linear equations turn it by more than a radian.

    Where corners do not count, the moment is refused: 2 N/mm^2 over the end, 40 high and 60 from the pin, in mm.
    """
    (tmp_path / "lever.geo").write_text(LEVER)
    make_mesh(tmp_path / "lever.geo", tmp_path / "lever.msh")
    deck = LEVER_DECK.replace("SUPPORT", support)
    (tmp_path / "lever.yaml").write_text(deck)
    if is_turning:
        words = refuse(signorom, "solve", "lever.yaml", "--at", "pull=20", folder=tmp_path)
        assert "drives the body 'lever', which nothing holds (rotation), with a moment of 4800" in words
        (tmp_path / "lever.yaml").write_text(deck + "solver: {hold_unloaded_motions: false}\n")
    done = signorom.run("run", "lever.yaml", folder=tmp_path, n_ranks=2)
    said = done.stdout + done.stderr
    assert done.returncode == 0, said
    # when sampling, when validating, in the verdict, and at the output point
    sentence = "a body that only contact holds rotates by up to"
    assert said.count(sentence) == (4 if is_turning else 0)
    report = yaml.safe_load((tmp_path / "results" / "lever" / "report.yaml").read_text())
    assert (sentence in str(report.get("deformations"))) == is_turning
    assert (sentence in str(report["errors"]["warnings"])) == is_turning
    assert report["validation"]["accepted"] is not is_turning
    answered = signorom.run("predict", "results/lever/model.h5", "--at", "pull=10", folder=tmp_path)
    assert (sentence in answered.stderr) == is_turning


def test_good_decks_get_no_warning(signorom, tmp_path):
    deck = write_deck("shifted_disks", tmp_path, **{"method: hhr": "method: condensed"})
    done = signorom.run("run", deck.name, folder=tmp_path)
    assert done.returncode == 0
    assert "warning" not in done.stdout + done.stderr
    assert report_of(tmp_path)["errors"]["warnings"] == []


NEVER = """\
title: A contact that closes or not, and a parameter that nothing uses
mesh: {file: blocks.msh, model: plane_strain}
parameters: {stroke: {min: 0.001, max: 0.02, unit: m}, q: {min: 0, max: 1, unit: "1"}}
materials: {all: {regions: [lower, upper], young_modulus: 100.0, poisson_ratio: 0.0}}
boundary_conditions:
  - {boundary: bottom, displacement: {x: 0, y: 0}}
  - {boundary: top, displacement: {x: 0, y: "-stroke"}}
loads: [{boundary: top, pressure: stroke, window: {axis: x, min: "9 + stroke"}}]
contact: [{first: upper_face, second: lower_face, initial_gap: GAP}]
training: {sobol: 4}
test: {sobol: 3, seed: 1}
"""


@pytest.mark.parametrize(("gap", "is_accepted"), [("0", True), ("0.1", False)])
def test_what_does_nothing_is_named(signorom, tmp_path, gap, is_accepted):
    """A parameter, a window and a contact; a model without any force at the test points is not accepted."""
    stacked_blocks("Q4", 2).write(tmp_path / "blocks.msh")
    (tmp_path / "never.yaml").write_text(NEVER.replace("GAP", gap))
    checked = signorom.run("check", "never.yaml", folder=tmp_path)
    assert checked.returncode == 0
    assert "warning: no expression of the deck uses the parameter 'q'" in checked.stderr
    assert "loads[1]" in checked.stderr
    done = signorom.run("run", "never.yaml", folder=tmp_path)
    assert done.returncode == 0
    opened = "warning: contact[1] (upper_face - lower_face) is open at all 4 training points"
    assert (opened in done.stderr) != is_accepted
    report = yaml.safe_load((tmp_path / "results" / "never" / "report.yaml").read_text())
    assert report["validation"]["accepted"] is is_accepted
    assert ("NOT accepted: no test point has a contact force" in done.stderr) != is_accepted


@pytest.mark.parametrize(("stroke", "is_large"), [("0.7", False), ("1.0", True)])
def test_large_deformations_are_warned_of(signorom, tmp_path, stroke, is_large):
    """Two blocks of 1 x 1 share the stroke s: at its ends each moves by s/4 from its mean, at most 0.70 of it away."""
    stacked_blocks("Q4", 2).write(tmp_path / "blocks.msh")
    deck = NEVER.replace("GAP", "0").replace("max: 0.02", f"max: {stroke}")
    deck = deck.replace("{sobol: 3, seed: 1}", "{grid: {stroke: 3, q: 2}}")
    (tmp_path / "large.yaml").write_text(deck + f"output: {{points: [{{stroke: {stroke}, q: 0}}]}}\n")
    done = signorom.run("run", "large.yaml", folder=tmp_path)
    assert done.returncode == 0
    sentence = "displacements within a body differ by up to"
    assert (sentence in done.stderr) == is_large
    report = yaml.safe_load((tmp_path / "results" / "large" / "report.yaml").read_text())
    assert (sentence in str(report.get("deformations"))) == is_large
    assert report["validation"]["accepted"] is not is_large
    assert (f"NOT accepted: {sentence}" in done.stderr) == is_large
