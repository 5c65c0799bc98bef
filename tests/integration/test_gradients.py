# SPDX-License-Identifier: BSD-3-Clause
"""Derivatives of answers with respect to the parameters, against differences of full-order solutions."""

import re

import numpy as np
import pytest
import yaml

from block_meshes import Mesh, stacked_blocks
from decks import copy_deck
from results import read_snapshots
from runs import HERE
from test_tied import TIED, write_strip
from two_materials import HANGING, write_two_materials_below

pytestmark = pytest.mark.slow

INPUT = HERE.parents[1] / "input"
# Central differences with steps of this share of the box: small beside an element that the end of a window crosses.
# Interpolated models are as good as reduction.stiffness_tolerance; the slope of a polynomial of degree n in n^2 of that.
STEP = 1e-4
ALLOWED = 1e-5
# differences of the full order or of the answers show a wrong derivative of any model, however few points it has
FEW_POINTS = "training: {sobol: 12}\ntest: {sobol: 2, seed: 1}\n"
# without Poisson's effect two blocks, 1 wide and 1 high each, push with 100 / 2 times what the stroke exceeds the gap by
STIFFNESS = 50.0
BLOCKS = """\
title: Two blocks that a stroke presses together
mesh: {file: blocks.msh, model: plane_strain}
parameters: {stroke: {min: 0.0, max: 0.02, unit: m}, gap: {min: 0.0, max: 0.02, unit: m}}
materials: {all: {regions: [lower, upper], young_modulus: 100.0, poisson_ratio: 0.0}}
boundary_conditions:
  - {boundary: bottom, displacement: {x: 0, y: 0}}
  - {boundary: top, displacement: {x: 0, y: "-stroke"}}
contact: [{first: lower_face, second: upper_face, initial_gap: gap}]
training: {grid: {stroke: 3, gap: 3}}
"""

# nodes of the face are 1/16 apart
ROLLER = """\
title: A block under a roller that travels
mesh: {file: block.msh, model: plane_strain}
parameters:
  x0: {min: 0.2, max: 0.8, unit: m}
  radius: {min: 0.4, max: 0.6, unit: m}
  depth: {min: 0.01, max: 0.03, unit: m}
materials: {all: {regions: [block], young_modulus: 100.0, poisson_ratio: 0.3}}
boundary_conditions: [{boundary: bottom, displacement: {x: 0, y: 0}}]
contact:
  - {first: face, obstacle: {type: sphere, center: [x0, radius - depth], radius: radius}, direction: [0, 1]}
training: {grid: {x0: 3, radius: 2, depth: 2}}
"""

CORE_AND_RIM = """\
title: A block of two materials under another one
mesh: {file: core_and_rim.msh, model: plane_stress}
parameters:
  ratio: {min: 0.3, max: 1.5, unit: "1"}
  E: {min: 100.0, max: 250.0, unit: Pa}
  nu: {min: 0.2, max: 0.4, unit: "1"}
  P: {min: 0.5, max: 3.0, unit: Pa}
{materials}boundary_conditions:
  - {boundary: bottom, displacement: {x: 0, y: 0}}
  - {boundary: left, displacement: {x: 0}}
loads: [{boundary: top, pressure: "P * (1.2 - x)"}]
contact: [{first: lower_face, second: upper_face, initial_gap: "4e-4 * x^2"}]
"""


def write_core_and_rim(folder):
    """A ratio of moduli and Poisson's ratio of one body together; contact alone holds the other one in height.

    Displacements are interpolated: by modes their derivatives have the error of modes."""
    text = CORE_AND_RIM + FEW_POINTS + "reduction: {displacement_tolerance: 0}\n"
    return write_two_materials_below(folder, "core_and_rim", "Q4", 2, text)


def write_few(name, folder, changes):
    """A deck of input/ with few points."""
    deck = copy_deck(INPUT / f"{name}.yaml", folder, **changes)
    text = re.sub(r"(?ms)^(training|test|output):.*?(?=^\S|\Z)", "", deck.read_text())
    deck.write_text(text + FEW_POINTS)
    return deck


def write_tied(folder):
    """A contact whose matrix has no room."""
    deck = write_strip(folder, TIED + ", displacement: {boundaries: [upper_face]}")
    deck.write_text(re.sub(r"(?m)^test: .*\n", "", deck.read_text()))
    return deck


CASES = {
    "fuel_rod": (lambda folder: write_few("fuel_rod", folder, {}), "interpolated"),
    "hanging_bracket": (lambda folder: write_few("bracket", folder, HANGING), "interpolated"),
    "core_and_rim": (write_core_and_rim, "interpolated"),
    "saddle": (lambda folder: write_few("saddle", folder, {}), "condensed"),
    "pellet_cladding": (
        lambda folder: write_few("pellet_cladding", folder, {"method: hhr": "method: condensed"}),
        "condensed",
    ),
    "tied_strip": (write_tied, "tied"),
    # of the full-order operator that these models keep
    "half_disks": (lambda folder: write_few("half_disks", folder, {}), "hhr"),
    "hyper_reduced_bracket": (
        lambda folder: write_few(
            "bracket", folder, HANGING | {"contact:\n": "reduction: {method: hhr}\ncontact:\n"}
        ),
        "hhr",
    ),
}


def write_roller(folder, changes):
    """A roller on a block, 1 wide and 1 high."""
    across = np.linspace(0, 1, 17)
    mesh = Mesh()
    mesh.add_block("block", [across, across - 1], "Q4", {(1, 0): "bottom", (1, 1): "face"})
    mesh.write(folder / "block.msh")
    text = ROLLER
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    deck = folder / "roller.yaml"
    deck.write_text(text)
    return deck


def trained(signorom, post, deck):
    """The model of a deck, opened in Python."""
    for command in ("sample", "train"):
        signorom(command, deck, folder=deck.parent)
    return post.Model(deck.parent / "results" / deck.stem / "model.h5")


def full_order_differences(signorom, deck, folder, names, point, lengths):
    """Of forces [n_parameters, n_contacts] and displacements [n_parameters, n_dofs]."""
    rows = [
        point + sign * STEP * length * np.eye(len(point))[i]
        for i, length in enumerate(lengths)
        for sign in (1, -1)
    ]
    lines = [",".join(names), *(",".join(repr(float(value)) for value in row) for row in rows)]
    (folder / "points.csv").write_text("\n".join(lines) + "\n")
    text = re.sub(r"(?m)^(training|test|output|solver): .*\n", "", deck.read_text())
    text += "training: {file: points.csv}\nsolver: {type: active_set}\n"
    if "nu" not in "".join(names):
        # snapshots of such a model hold displacements
        text = re.sub(r"(?ms)^reduction:.*?(?=^\S|\Z)", "", text) + "reduction: {method: hhr}\n"
    for mesh in deck.parent.glob("*.msh"):
        (folder / mesh.name).write_bytes(mesh.read_bytes())
    beside = folder / deck.name
    beside.write_text(text)
    signorom("sample", beside, folder=folder)
    found = read_snapshots(folder / "results" / deck.stem / "snapshots.h5")
    steps = 2 * STEP * np.asarray(lengths)[:, None]
    return [(found[name][::2] - found[name][1::2]) / steps for name in ("multipliers", "displacement")]


@pytest.mark.parametrize("name", [pytest.param("fuel_rod", marks=pytest.mark.long), *list(CASES)[1:]])
def test_gradients_are_those_of_the_full_order(signorom, post, tmp_path, name):
    """All parameters, all contacts, all nodes; every kind of model that has derivatives, 2D and 3D."""
    write, kind = CASES[name]
    (tmp_path / "model").mkdir()
    (tmp_path / "beside").mkdir()
    deck = write(tmp_path / "model")
    with trained(signorom, post, deck) as model:
        assert kind in model.describe()
        ranges = np.array([[parameter.minimum, parameter.maximum] for parameter in model.parameters])
        lengths = ranges[:, 1] - ranges[:, 0]
        names = [parameter.name for parameter in model.parameters]
        point = ranges[:, 0] + np.random.default_rng(7).uniform(0.3, 0.7, len(names)) * lengths
        values = dict(zip(names, point, strict=True))
        answer = model.query(**values)
        gradient = answer.gradient
        assert answer.multipliers.max() > 0
        assert gradient.parameters == names
        assert gradient.n_grazing == 0
        assert not gradient.is_one_sided.any()
        forces, displacements = full_order_differences(
            signorom, deck, tmp_path / "beside", names, point, lengths
        )
        assert_close(gradient.multipliers, forces, lengths, answer.multipliers)
        has_one = ~np.isnan(answer.displacement)
        assert_close(
            gradient.displacement[:, has_one],
            displacements.reshape(-1, *has_one.shape)[:, has_one],
            lengths,
            answer.displacement[has_one],
        )
        # sums of forces: linear in them
        summed = model.resultants(gradient.multipliers)
        np.testing.assert_array_equal(gradient.forces, summed.forces)
        np.testing.assert_array_equal(gradient.moments, summed.moments)
        few = model.nodes[0][has_one.all(axis=1)][:3]
        np.testing.assert_allclose(
            model.query(nodes=few, **values).gradient.displacement,
            gradient.displacement[:, has_one.all(axis=1)][:, :3],
            rtol=1e-12,
        )


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        (
            "fuel_rod",
            {
                "max_full_order_size: 256": "max_full_order_size: 8",
                # four constants, each with few nodes
                "min: 0.25, max: 0.35": "min: 0.29, max: 0.31",
                "min: 0.30, max: 0.40": "min: 0.33, max: 0.35",
            },
        ),
        (
            "bracket",
            HANGING
            | {
                "contact:\n": "reduction: {max_full_order_size: 3}\ncontact:\n",
                "materials:\n": HANGING["materials:\n"].replace("min: 0.2, max: 0.4", "min: 0.28, max: 0.32"),
            },
        ),
    ],
)
def test_displacements_by_modes(signorom, post, tmp_path, name, changes):
    """Their derivatives are those of the answer itself, which errs by what the modes leave: differences of answers."""
    deck = write_few(name, tmp_path, changes)
    with trained(signorom, post, deck) as model:
        assert (model.displacement_sources == 1).all()
        ranges = {parameter.name: (parameter.minimum, parameter.maximum) for parameter in model.parameters}
        values = {name: low + 0.55 * (high - low) for name, (low, high) in ranges.items()}
        answer = model.query(**values)
        for row, (name, (low, high)) in enumerate(ranges.items()):
            step = STEP * (high - low)
            above, below = (model.query(**values | {name: values[name] + sign * step}) for sign in (1, -1))
            difference = (above.displacement - below.displacement) / (2 * step)
            worst = abs(answer.gradient.displacement[row] - difference).max() * (high - low)
            assert worst <= ALLOWED * abs(answer.displacement).max()
        # known, and above rounding; test_displacement_error compares with the truth
        errors = answer.gradient.displacement_errors
        assert errors.min() > 1e-9
        assert np.median(errors) < 1


def assert_close(found, expected, lengths, values):
    """What a parameter changes from one end of its range to the other, relative to the answer."""
    worst = (abs(found - expected).max(axis=1) * lengths).max() / abs(values).max()
    assert worst <= ALLOWED


def test_one_sided_where_contacts_graze(signorom, post, tmp_path):
    """The stroke has just closed the gap: pushing on builds up force, pulling back does nothing."""
    stacked_blocks("Q4", 2).write(tmp_path / "blocks.msh")
    deck = tmp_path / "blocks.yaml"
    deck.write_text(BLOCKS)
    with trained(signorom, post, deck) as model:
        pressed = model.query(stroke=0.015, gap=0.01)
        assert pressed.gradient.n_grazing == 0
        np.testing.assert_allclose(pressed.gradient.forces[:, 0, 1], [-STIFFNESS, STIFFNESS], rtol=1e-10)
        np.testing.assert_array_equal(pressed.gradient.forces, pressed.backward_gradient.forces)
        grazing = model.query(stroke=0.01, gap=0.01)
        assert grazing.gradient.n_grazing == len(grazing.multipliers)
        assert grazing.gradient.is_one_sided.all()
        np.testing.assert_allclose(
            grazing.gradient.forces[:, 0, 1], [-STIFFNESS, 0.0], rtol=1e-10, atol=1e-10
        )
        np.testing.assert_allclose(
            grazing.backward_gradient.forces[:, 0, 1], [0.0, STIFFNESS], rtol=1e-10, atol=1e-10
        )
        apart = model.query(stroke=0.005, gap=0.01)
        assert not apart.gradient.multipliers.any()


TWO_MODULI = {
    "parameters: {": "parameters: {E: {min: 50, max: 200, unit: Pa}, ",
    "{all: {regions: [lower, upper], young_modulus: 100.0, poisson_ratio: 0.0}}": "{low: {regions: [lower], "
    "young_modulus: 100.0, poisson_ratio: 0.0}, up: {regions: [upper], young_modulus: E, poisson_ratio: 0.0}}",
    "training: {grid: {": "training: {grid: {E: 3, ",
}


@pytest.mark.parametrize(
    ("changes", "more", "kind"), [({}, {}, "condensed"), (TWO_MODULI, {"E": 100.0}, "interpolated")]
)
def test_one_sided_where_a_load_is_rounding(signorom, post, tmp_path, changes, more, kind):
    """0.1 + 0.2 - 0.3 is 5.6e-17: such a stroke neither closes nor opens the contacts."""
    stacked_blocks("Q4", 2).write(tmp_path / "blocks.msh")
    deck = tmp_path / "blocks.yaml"
    text = BLOCKS.replace('"-stroke"', '"0.1 + 0.2 - stroke"').replace(
        "stroke: {min: 0.0", "stroke: {min: 0.29"
    )
    text = text.replace("max: 0.02, unit: m}, gap", "max: 0.31, unit: m}, gap")
    for old, new in changes.items():
        text = text.replace(old, new)
    deck.write_text(text)
    with trained(signorom, post, deck) as model:
        assert kind in model.describe()
        grazing = model.query(stroke=0.3, gap=0.0, **more)
        stroke = grazing.gradient.parameters.index("stroke")
        assert grazing.gradient.n_grazing == len(grazing.multipliers)
        assert grazing.gradient.is_one_sided[stroke]
        assert grazing.gradient.forces[stroke, 0, 1] == pytest.approx(-STIFFNESS, rel=1e-9)
        assert grazing.backward_gradient.forces[stroke, 0, 1] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("direction", ["[0, 1]", "[0.28, 0.96]"])
def test_nodes_at_the_radius_of_a_sphere(signorom, post, tmp_path, direction):
    """Along the direction some nodes are as far aside as the radius: there the sphere has an infinite slope.

    No force is near them. Each x0 has a node whose distance from the line through the center along the direction is the
    radius.
    """
    deck = write_roller(tmp_path, {"direction: [0, 1]": f"direction: {direction}"})
    names, lengths = ["x0", "radius", "depth"], [0.6, 0.2, 0.02]
    along = np.array(yaml.safe_load(direction))
    radius, depth = 0.5, 0.022
    with trained(signorom, post, deck) as model:
        for i, node in enumerate((0.75, 1.0, 0.125)):
            # (x - c) across = +-R, where c = (x0, R - depth) and x = (node, 0)
            across = np.array([along[1], -along[0]])
            side = np.sign(node - 0.5)
            x0 = node - (side * radius + (radius - depth) * across[1]) / across[0]
            x0 = float(np.round(x0, 12))
            assert 0.2 < x0 < 0.8
            point = np.array([x0, radius, depth])
            distance = abs((np.array([node, 0]) - [x0, radius - depth]) @ across)
            assert distance == pytest.approx(radius, rel=1e-11)
            answer = model.query(**dict(zip(names, point, strict=True)))
            assert (answer.multipliers > 0).sum() >= 2
            (tmp_path / f"beside_{i}").mkdir()
            (tmp_path / f"beside_{i}" / "block.msh").write_bytes((tmp_path / "block.msh").read_bytes())
            forces, _ = full_order_differences(
                signorom, deck, tmp_path / f"beside_{i}", names, point, lengths
            )
            for gradient in (answer.gradient, answer.backward_gradient):
                assert not gradient.is_one_sided.any()
                assert gradient.n_grazing == 0
                assert_close(gradient.multipliers, forces, lengths, answer.multipliers)


def test_refusal_names_the_contact(signorom, post, tmp_path):
    """The roller jumps."""
    deck = write_roller(tmp_path, {"[x0, radius": '["x0 > 0.5 ? 0.6 : x0", radius'})
    sentence = r"as 'x0' passes this point, 'gap of contact\[1\], sphere, at node \d+' jumps"
    with trained(signorom, post, deck) as model, pytest.raises(post.NoAnswerError, match=sentence):
        _ = model.query(x0=0.5, radius=0.5, depth=0.022).gradient


def test_answers_without_derivatives(signorom, post, tmp_path):
    """A hyper-reduced answer alone, and a load that jumps at the point: a sentence says why."""
    deck = copy_deck(INPUT / "half_disks.yaml", tmp_path)
    deck.write_text(deck.read_text().replace("{method: hhr", "{method: hhr, max_full_order_size: 0"))
    with trained(signorom, post, deck) as model:
        answer = model.query(**{parameter.name: parameter.maximum for parameter in model.parameters})
        with pytest.raises(post.NoAnswerError, match="an answer of the kind hhr has no derivatives"):
            _ = answer.gradient
    stacked_blocks("Q4", 2).write(tmp_path / "blocks.msh")
    deck = tmp_path / "blocks.yaml"
    deck.write_text(BLOCKS.replace('"-stroke"', '"stroke > 0.01 ? -stroke : 0"'))
    sentence = r"as 'stroke' passes this point, 'stroke > 0.01 \? -stroke : 0' jumps"
    with trained(signorom, post, deck) as model:
        with pytest.raises(post.NoAnswerError, match=sentence):
            _ = model.query(stroke=0.01, gap=0.005).gradient
        np.testing.assert_allclose(
            model.query(stroke=0.0101, gap=0.005).gradient.forces[:, 0, 1],
            [-STIFFNESS, STIFFNESS],
            rtol=1e-10,
        )
