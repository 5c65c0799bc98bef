# SPDX-License-Identifier: BSD-3-Clause
"""A block that lies loosely between two plates.

The program says where no contact force holds it, and the forces have derivatives there.
"""

import re

import numpy as np
import pytest

from block_meshes import Mesh

pytestmark = pytest.mark.slow

# Without Poisson's effect plates, 1/2 high, and the block, 1 high, all 1 wide, push with K times what the stroke
# exceeds the gap by: 1 / K = 0.5 / 100 + 1 / E + 0.5 / 100. The supports of the block along its lower face leave its
# shift in y and its rotation.
GAP = 0.01
DECK = """\
title: A block between two plates
mesh: {file: plates.msh, model: plane_strain}
parameters: {PARAMETERS}
materials:
  plates: {regions: [lower, upper], young_modulus: 100.0, poisson_ratio: 0.0}
  block: {regions: [block], young_modulus: MODULUS, poisson_ratio: 0.0}
boundary_conditions:
  - {boundary: bottom, displacement: {x: 0, y: 0}}
  - {boundary: top, displacement: {x: 0, y: "-stroke"}}
  - {boundary: block_low, displacement: {x: 0}}
loads: LOADS
contact:
  - {first: block_low, second: lower_face}
  - {first: block_high, second: upper_face, initial_gap: 0.01}
training: {sobol: 12}
reduction: {fields: true}
"""
STROKE = "stroke: {min: 0.0, max: 0.03, unit: m}"
# of both sides of the block, which are 1 high: 2 P in all
LOADED = {
    "PARAMETERS": STROKE + ", P: {min: -0.1, max: 0.1, unit: Pa}",
    "MODULUS": "100.0",
    "LOADS": "[{boundary: left, traction: {y: P}}, {boundary: right, traction: {y: P}}]",
}
PLAIN = {"PARAMETERS": STROKE, "MODULUS": "100.0", "LOADS": "[]"}
WITH_MODULUS = {"PARAMETERS": STROKE + ", E: {min: 50, max: 200, unit: Pa}", "MODULUS": "E", "LOADS": "[]"}
HYPER_REDUCED = PLAIN | {"{fields: true}": "{fields: true, method: hhr}"}
SENTENCE = "its displacement and its gaps are one of many possible"


def write_deck(folder, changes):
    """Writes mesh and deck, and returns the path of the deck."""
    across = np.array([0.0, 0.4, 1.0])
    mesh = Mesh()
    mesh.add_block("lower", [across, [-0.5, 0.0]], "Q4", {(1, 0): "bottom", (1, 1): "lower_face"})
    sides = {(1, 0): "block_low", (1, 1): "block_high", (0, 0): "left", (0, 1): "right"}
    mesh.add_block("block", [across, [0.0, 0.5, 1.0]], "Q4", sides)
    mesh.add_block("upper", [across, [1.0, 1.5]], "Q4", {(1, 0): "upper_face", (1, 1): "top"})
    mesh.write(folder / "plates.msh")
    text = DECK
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    deck = folder / "plates.yaml"
    deck.write_text(text)
    return deck


def trained(signorom, post, folder, changes):
    """The model of a deck, opened in Python."""
    deck = write_deck(folder, changes)
    for command in ("sample", "train"):
        signorom(command, deck, folder=folder)
    return post.Model(folder / "results" / "plates" / "model.h5")


def force_between(answer):
    """The force of the ceiling on the block, downwards."""
    return -answer.forces[..., 1, 1]


@pytest.mark.parametrize(
    ("changes", "kind", "more"),
    [(PLAIN, "condensed", {}), (WITH_MODULUS, "interpolated", {"E": 100.0}), (HYPER_REDUCED, "hhr", {})],
)
def test_answers_say_that_nothing_holds_the_block(signorom, post, tmp_path, changes, kind, more):
    """Two motions are free until both plates press on the block."""
    with trained(signorom, post, tmp_path, changes) as model:
        assert model.kind == kind
        loose, pressed = (model.query(stroke=stroke, **more) for stroke in (0.005, 0.02))
        assert (loose.n_free_motions, pressed.n_free_motions) == (2, 0)
        assert force_between(pressed.resultants) == pytest.approx(50 * (0.02 - GAP), rel=1e-6)
        points = [[0.005, *more.values()], [0.02, *more.values()]]
        assert model.query_many(points).n_free_motions.tolist() == [2, 0]
        with pytest.warns(post.FreeMotionWarning, match="one of many possible"):
            assert abs(model.fields(stroke=0.005, **more).stress).max() < 1e-9


def test_the_program_warns_of_loose_bodies(signorom, tmp_path):
    """`solve` and `predict --fields` name the number of points and the first one; no warning where plates press."""
    deck = write_deck(tmp_path, PLAIN)
    (tmp_path / "points.csv").write_text("stroke\n0.02\n0.005\n0.006\n")
    found = said(signorom, tmp_path, "solve", deck, "--at", "stroke=0.005")
    assert (
        "warning: at stroke = 0.005 m no contact force holds the body 'block' (translation in y, rotation): "
        + SENTENCE
        in found
    )
    assert SENTENCE in (tmp_path / "results" / "plates" / "report.yaml").read_text()
    assert SENTENCE not in said(signorom, tmp_path, "solve", deck, "--at", "stroke=0.02")
    for command in ("sample", "train"):
        signorom(command, deck, folder=tmp_path)
    model = tmp_path / "results" / "plates" / "model.h5"
    arguments = ("predict", model, "--points", "points.csv", "--output", "table.csv")
    found = said(signorom, tmp_path, *arguments, "--fields")
    assert re.search(
        r"at 2 points, the first \(stroke = 0.005\), no contact force holds a body .*" + SENTENCE, found
    )
    assert SENTENCE not in said(signorom, tmp_path, *arguments)


def said(signorom, folder, *arguments):
    """The warnings of a command."""
    done = signorom.run(*arguments, folder=folder)
    assert done.returncode == 0
    return done.stderr


@pytest.mark.parametrize(("changes", "more"), [(PLAIN, {}), (WITH_MODULUS, {"E": 80.0})])
def test_forces_on_a_loose_block_have_derivatives(signorom, post, tmp_path, changes, more):
    """They are zero until the plates squeeze the block; its displacement has none, and that of the plates has."""
    with trained(signorom, post, tmp_path, changes) as model:
        places = model.nodes[1]
        in_block = slice(6, 15)  # the mesh has 6 nodes of the lower plate, then 9 of the block
        assert places[in_block, 1].min() == 0.0
        assert places[in_block, 1].max() == 1.0
        loose = model.query(stroke=0.005, **more)
        for gradient in (loose.gradient, loose.backward_gradient):
            assert not gradient.multipliers.any()
            assert not gradient.is_one_sided.any()
            assert np.isnan(gradient.displacement[:, in_block, 1]).all()
            # the upper plate moves down as a whole
            np.testing.assert_allclose(gradient.displacement[0, 15:, 1], -1.0, atol=1e-9)
            assert not np.isnan(np.delete(gradient.displacement, range(6, 15), axis=1)).any()
        modulus = more.get("E", 100.0)
        stiffness = 1 / (0.01 + 1 / modulus)
        touching, pressed = (model.query(stroke=stroke, **more) for stroke in (GAP, 0.02))
        assert force_between(touching.gradient)[0] == pytest.approx(stiffness, rel=1e-6)
        assert force_between(touching.backward_gradient)[0] == pytest.approx(0.0, abs=1e-9)
        assert touching.gradient.is_one_sided[0]
        assert touching.gradient.n_grazing == len(touching.multipliers)
        assert force_between(pressed.gradient)[0] == pytest.approx(stiffness, rel=1e-6)
        assert not np.isnan(pressed.gradient.displacement).any()
        if more:  # dK/dE = K^2 / E^2
            expected = (stiffness / modulus) ** 2 * (0.02 - GAP)
            assert force_between(pressed.gradient)[1] == pytest.approx(expected, rel=1e-4)


def test_loads_that_begin_to_act(signorom, post, tmp_path):
    """At P = 0 a load moves a block that lies loosely; one that lies on a plate presses it there at once."""
    with trained(signorom, post, tmp_path, LOADED) as model:
        held = model.query(stroke=0.005, P=0.05)
        assert force_between(held.resultants) == pytest.approx(0.1, rel=1e-9)
        assert force_between(held.gradient).tolist() == pytest.approx([0.0, 2.0], abs=1e-9)
        assert held.n_free_motions == 0
        loose = model.query(stroke=0.005, P=0.0)
        assert loose.n_free_motions == 2
        refusals = []
        # a load upwards is carried by the ceiling, one downwards by the floor, and the block can lie on one of them only
        for name, of_ceiling, of_floor in (("gradient", 2.0, 0.0), ("backward_gradient", 0.0, -2.0)):
            try:
                gradient = getattr(loose, name)
            except post.NoAnswerError as refused:
                refusals.append(str(refused))
                continue
            assert force_between(gradient)[1] == pytest.approx(of_ceiling, abs=1e-9)
            assert gradient.forces[1, 0, 1] == pytest.approx(of_floor, abs=1e-9)
        assert len(refusals) >= 1
        assert all("the loads move a body that no contact force holds here" in text for text in refusals)
