# SPDX-License-Identifier: BSD-3-Clause
"""The error of displacements that a condensed model tells, against one from an independent stiffness."""

import h5py
import numpy as np
import pytest

from block_meshes import Mesh
from contact_reference import assemble, cell_stiffnesses, hooke_plane_strain

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
