# SPDX-License-Identifier: BSD-3-Clause
"""The errors of displacements and their derivatives that a model tells, against ones from an independent stiffness."""

import re

import h5py
import numpy as np
import pytest

from block_meshes import Mesh
from contact_reference import assemble, cell_stiffnesses, hooke_plane_strain
from test_gradients import full_order_differences
from two_materials import MATERIALS, core_and_rim, split_region

N_ACROSS = 80
# few modes span the displacements of a contact that stays, unless more error is allowed than the default of 1e-3
TOLERANCES = {"wanders": 1e-3, "stays": 4e-1, "floats": 1e-3, "slender": 1e-3}
NO_ROOM = "max_full_order_size: 0.5"  # [MB] W takes 0.1, responses of all nodes 1.2
# A body that wanders over the block, and one that is pressed in at the same place.
PLACES = {"wanders": "place", "stays": "1.5 + 0 * place", "floats": "place", "slender": "place"}
# The block is fixed, or it lies on the ground, and only contact holds it. As a strip it is so soft that its responses to
# single forces are far larger than displacements, and single precision alone would not do.
LOW = {"wanders": 0, "stays": 0, "floats": 0, "slender": 0.85}
SUPPORTS = {
    "wanders": ("{boundary: bottom, displacement: {x: 0, y: 0}}", ""),
    "stays": ("{boundary: bottom, displacement: {x: 0, y: 0}}", ""),
    "floats": (
        "{boundary: left, displacement: {x: 0}}",
        "\n  - {first: bottom, obstacle: {type: half_space, point: [0, 0], normal: [0, 1]}}",
    ),
}
SUPPORTS["slender"] = (
    SUPPORTS["floats"][0],
    SUPPORTS["floats"][1].replace("[0, 0]", f"[0, {LOW['slender']}]"),
)
DECK = """\
title: A cylinder on a block
mesh: {{file: block.msh, model: plane_strain}}
parameters: {{depth: {{min: 1.0e-3, max: 6.0e-3}}, place: {{min: 0.5, max: 2.5}}}}
materials: {{block: {{regions: [block], young_modulus: 3.0e6, poisson_ratio: 0.3}}}}
boundary_conditions:
  - {support}
loads: [{{boundary: right, pressure: "1.0e6 * depth"}}]
contact:
  - {{first: top, obstacle: {{type: sphere, center: [{place}, "1 + 4 - depth"], radius: 4}}, direction: [0, 1]}}{ground}
training: {{sobol: 30}}
reduction: {{{reduction}}}
"""


def train(signorom, folder, case, reduction, n_ranks=1):
    """The model of a block of T3."""
    folder.mkdir(exist_ok=True)
    mesh = Mesh()
    mesh.add_block(
        "block",
        [np.linspace(0, 3, N_ACROSS + 1), np.linspace(LOW[case], 1, 11)],
        "T3",
        {(1, 0): "bottom", (1, 1): "top", (0, 0): "left", (0, 1): "right"},
    )
    mesh.write(folder / "block.msh")
    deck = folder / "block.yaml"
    support, ground = SUPPORTS[case]
    deck.write_text(DECK.format(place=PLACES[case], support=support, ground=ground, reduction=reduction))
    said = signorom("run", deck.name, folder=folder, n_ranks=n_ranks)
    return said, folder / "results" / "block"


class Block:
    """Coordinates and cells of a results folder, for contact_reference."""

    def __init__(self, folder):
        with h5py.File(folder / "fields.h5") as file:
            self.coordinates = file["mesh/coordinates"][()][:, :2]
            self.cells = file["mesh/topology"][()][:, :3]
        self.stiffness = assemble(self, cell_stiffnesses(self, hooke_plane_strain(3e6, 0.3)))

    def norm(self, field):
        """In the norm of the stiffness."""
        field = field[:, :2].ravel()
        return np.sqrt(field @ self.stiffness @ field)


@pytest.mark.parametrize("case", list(PLACES))
def test_error_is_known(signorom, post, tmp_path, case):
    """At 60 other points the model tells the true error of displacements and their derivatives, and both are small."""
    reduction = f"{NO_ROOM}, displacement_tolerance: {TOLERANCES[case]}"
    said, folder = train(signorom, tmp_path / "some", case, reduction)
    exact = train(signorom, tmp_path / "exact", case, "")[1]
    assert ("by " in said) == (case == "stays")
    assert ("compressed responses" in said) == (case != "stays")
    block = Block(exact)
    points = np.random.default_rng(7).uniform([1e-3, 0.5], [6e-3, 2.5], (60, 2))
    fields, changes = [], []
    with post.Model(folder / "model.h5") as some, post.Model(exact / "model.h5") as whole:
        for depth, place in points:
            a, b = (model.query(depth=depth, place=place) for model in (some, whole))
            assert b.relative_displacement_bound <= 1e-6
            size = block.norm(b.displacement)
            fields.append((a.relative_displacement_bound, block.norm(a.displacement - b.displacement) / size))
            for i, length in enumerate([5e-3, 2.0]):
                found, expected = a.gradient.displacement[i], b.gradient.displacement[i]
                if block.norm(expected) * length > 0.01 * size:
                    true = block.norm(found - expected) / block.norm(expected)
                    changes.append((a.gradient.displacement_errors[i], true))
    check_errors(*np.transpose(fields), TOLERANCES[case])
    assert max(true for _, true in fields) > 1e-7, "the case tests something"
    assert len(changes) >= len(points)
    check_errors(*np.transpose(changes), TOLERANCES[case])


def check_errors(told, true, tolerance):
    """What a model tells, beside the truth."""
    assert np.all(true <= told * (1 + 1e-5))
    assert np.percentile(told, 95) <= tolerance
    np.testing.assert_allclose(told[true > 1e-6], true[true > 1e-6], rtol=1e-3)


def test_ranks_and_validation_agree(signorom, tmp_path, post):
    """Two ranks compress like one; single precision rounds alike but for the last bit of a few numbers."""
    reduction = NO_ROOM + ", fields: true"
    folders = [train(signorom, tmp_path / str(n), "wanders", reduction, n_ranks=n)[1] for n in (1, 2)]
    answers = []
    for folder in folders:
        with post.Model(folder / "model.h5") as model:
            answers.append(model.query(depth=4e-3, place=1.1))
    assert answers[0].relative_displacement_bound == pytest.approx(
        answers[1].relative_displacement_bound, rel=0.05
    )
    largest = abs(answers[0].displacement).max()
    np.testing.assert_allclose(answers[1].displacement, answers[0].displacement, atol=1e-5 * largest)


def test_tolerance_zero_keeps_all(signorom, post, tmp_path):
    """A tighter tolerance gives smaller errors; zero keeps the responses as they are where they fit."""
    bounds = {}
    for tolerance in ("1.0e-2", "1.0e-4"):
        _, folder = train(
            signorom,
            tmp_path / tolerance,
            "wanders",
            f"{NO_ROOM}, displacement_tolerance: {tolerance}",
        )
        with post.Model(folder / "model.h5") as model:
            bounds[tolerance] = model.query(depth=4e-3, place=1.1).relative_displacement_bound
    assert bounds["1.0e-4"] <= 1e-4 < bounds["1.0e-2"] <= 1e-2


# A block of a core and a rim under one that only contact holds in height; few nodes of interpolation, few modes.
VARYING = """\
title: A block of two materials under another one
mesh: {file: blocks.msh, model: plane_strain}
parameters:
  ratio: {min: 0.3, max: 1.5}
  E: {min: 100.0e3, max: 250.0e3}
  nu: {min: 0.2, max: 0.4}
  P: {min: 50.0, max: 300.0}
  drop: {min: 1.0e-4, max: 1.0e-3}
{materials}boundary_conditions:
  - {boundary: bottom, displacement: {x: 0, y: "-drop * x"}}
  - {boundary: left, displacement: {x: 0}}
loads:
  - {boundary: top, pressure: "P * (1.2 - x)"}
contact:
  - {first: lower_face, second: upper_face, initial_gap: "4e-4 * x^2"}
training: {sobol: 40}
reduction: {stiffness_tolerance: 1.0e-2, fields: true{room}}
"""
# What each case leaves of the constants: lines without a match, and other texts.
CONSTANTS = {
    "ratio": ("  nu: ", {"poisson_ratio: nu": "poisson_ratio: 0.3"}),
    "poisson": ("  (ratio|rim): ", {"E * ratio": "E", "[core]": "[core, rim]"}),
    "both": ("without", {}),
}
ROOMS = {"exact": "", "modes": ", max_full_order_size: 0.02"}  # [MB] of responses of all nodes
# differences over 2e-4 of a range, of solutions that are exact to 1e-12
OF_DIFFERENCES = 1e-7


def write_varying(folder, case, displacement):
    """Mesh and deck of two blocks of T3 whose nodes match."""
    folder.mkdir()
    x, mesh = np.linspace(0, 1, 9), Mesh()
    lower = {(1, 0): "bottom", (1, 1): "lower_face", (0, 0): "left"}
    mesh.add_block("lower", [x, x - 1], "T3", lower, 0.2, seed=1)
    mesh.add_block("upper", [x, x], "T3", {(1, 1): "top", (1, 0): "upper_face", (0, 0): "left"}, 0.2, seed=2)
    split_region(mesh, "lower", core_and_rim)
    mesh.write(folder / "blocks.msh")
    removed, others = CONSTANTS[case]
    text = VARYING.replace("{materials}", MATERIALS).replace("{room}", ROOMS[displacement])
    text = re.sub(rf"(?m)^{removed}.*\n", "", text)
    for old, new in others.items():
        assert old in text
        text = text.replace(old, new)
    deck = folder / "blocks.yaml"
    deck.write_text(text)
    return mesh, deck


class Varying:
    """The stiffness of the two blocks at a point."""

    def __init__(self, mesh, values):
        """Adds the regions, whose constants are those of MATERIALS."""
        self.coordinates = mesh.coordinates[:, :2]
        modulus, ratio = values["E"], values.get("ratio", 1.0)
        core = values.get("nu", 0.3)
        rim = 0.3 if "ratio" in values else core
        constants = {"core": (modulus * ratio, core), "rim": (modulus, rim), "upper": (2 * modulus, 0.25)}
        self.stiffness = 0
        for region, (young_modulus, poisson_ratio) in constants.items():
            cells = np.array(mesh.facets_of(region))
            sides = self.coordinates[cells[:, 1:]] - self.coordinates[cells[:, :1]]
            # anticlockwise
            cells[np.linalg.det(sides) < 0] = cells[np.linalg.det(sides) < 0][:, [0, 2, 1]]
            self.cells = cells
            hooke = hooke_plane_strain(young_modulus, poisson_ratio)
            self.stiffness = self.stiffness + assemble(self, cell_stiffnesses(self, hooke))

    norm = Block.norm


@pytest.mark.parametrize("displacement", list(ROOMS))
@pytest.mark.parametrize("case", list(CONSTANTS))
def test_error_of_derivatives_over_constants(signorom, post, tmp_path, case, displacement):
    """Of interpolated models: no less than the error against differences of the full order, and not far above it."""
    mesh, deck = write_varying(tmp_path / "model", case, displacement)
    signorom("sample", deck, folder=deck.parent)
    said = signorom("train", deck, folder=deck.parent)
    # otherwise it is a warning
    assert ("modes: the error in energy" in said) == (displacement == "modes" or case == "both")
    told, true = [], []
    with post.Model(deck.parent / "results" / "blocks" / "model.h5") as model:
        assert "interpolated" in model.describe()
        # with several constants in a body only the error of modes is known
        assert ("modes" in model.describe()) == (displacement == "modes" or case == "both")
        names = [parameter.name for parameter in model.parameters]
        low, high = np.transpose([[p.minimum, p.maximum] for p in model.parameters])
        places = np.random.default_rng(3).uniform(0.05, 0.95, (3, len(names)))
        for i, point in enumerate(low + places * (high - low)):
            values = dict(zip(names, point, strict=True))
            beside = tmp_path / str(i)
            beside.mkdir()
            _, slopes = full_order_differences(signorom, deck, beside, names, point, high - low)
            gradient, blocks = model.query(**values).gradient, Varying(mesh, values)
            told.append(gradient.displacement_errors)
            exact = slopes.reshape(len(names), -1, 2)
            true.append(
                [
                    blocks.norm(a[:, :2] - b) / blocks.norm(b)
                    for a, b in zip(gradient.displacement, exact, strict=True)
                ]
            )
    told, true = np.array(told), np.array(true)
    assert true.max() > 10 * OF_DIFFERENCES
    assert np.all(true <= told + OF_DIFFERENCES)
    # Modes are far better than this interpolation: if the forces have a bound, two bounds of its error add up. The size
    # of a derivative over an interpolated constant is a lower bound, too.
    is_constant = np.isin(names, ["ratio", "nu"])
    assert np.median((told / true)[:, ~is_constant]) <= (4 if displacement == "modes" else 3)
    assert np.max((told / true)[:, is_constant]) <= (50 if displacement == "exact" else 10)
