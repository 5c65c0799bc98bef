# SPDX-License-Identifier: BSD-3-Clause
"""Sides that formulation auto swaps because the deck's first surface cannot carry the contact forces.

All stresses are uniform: p = E u / height of what is pressed. What the deck says of its first surface stays true.
"""

import re

import h5py
import numpy as np
import pytest
import yaml

from block_meshes import LINEAR, QUADRATIC, Mesh
from runs import refuse

# [-] uniform stress is in the span of the elements: rounding, and what the solvers leave
EXACT = 1e-9
# [Pa, m] of the decks
YOUNG_MODULUS, STROKE, GAP = 2.0e6, 0.1, 0.04
N_UPPER = 7


def held_floor(path, model, element):
    """A block that is pressed on another one, every node of whose face is held."""
    n_dim = 3 if model == "solid" else 2
    mesh = Mesh()
    for name, n, floor, side in (("lower", 4, -1.0, 1), ("upper", N_UPPER, 0.0, 0)):
        across = np.linspace(0, 1, n + 1)
        faces = {(n_dim - 1, side): f"{name}_face", (n_dim - 1, 1 - side): "bottom" if side else "top"}
        lines = [across] * (n_dim - 1) + [np.linspace(floor, floor + 1, 3)]
        mesh.add_block(name, lines, LINEAR.get(element, element), faces)
    if element in QUADRATIC:
        mesh.make_quadratic(element)
    mesh.write(path)


def write_held_deck(folder, model="plane_strain", element="T3", contact="direction: [0, 1]"):
    """The gap of the pairs and the stroke of the upper block are parameters."""
    held_floor(folder / "blocks.msh", model, element)
    axes = {"axisymmetric": "rz", "solid": "xyz"}.get(model, "xy")
    sides = ", ".join(f"{axis}: 0" for axis in axes[:-1])
    deck = folder / "held.yaml"
    deck.write_text(f"""mesh: {{file: blocks.msh, model: {model}}}
parameters: {{stroke: {{min: 0.05, max: {STROKE}}}, gap: {{min: 0, max: {GAP}}}}}
materials: {{block: {{regions: [lower, upper], young_modulus: {YOUNG_MODULUS}, poisson_ratio: 0}}}}
boundary_conditions:
  - {{boundary: bottom, displacement: {{{sides}, {axes[-1]}: 0}}}}
  - {{boundary: lower_face, displacement: {{{sides}, {axes[-1]}: 0}}}}
  - {{boundary: top, displacement: {{{sides}, {axes[-1]}: -stroke}}}}
contact: [{{first: lower_face, second: upper_face, {contact}}}]
training: {{grid: {{stroke: 2, gap: 2}}}}
output: {{points: [{{stroke: {STROKE}, gap: {GAP}}}]}}
""")
    return deck


def contacts_of(folder):
    """The answers of each contact in the report, at the point of output."""
    report = yaml.safe_load((folder / "report.yaml").read_text())
    return list(report["points"]["1"]["contacts"].values())


def assert_close(found, wanted):
    np.testing.assert_allclose(found, wanted, rtol=0, atol=EXACT * np.abs(wanted).max())


@pytest.mark.parametrize(
    ("model", "element", "n_ranks"),
    [("plane_strain", "T3", 1), ("plane_strain", "Q8", 3), ("axisymmetric", "T6", 1), ("solid", "T4", 2)],
)
def test_first_side_is_held(signorom, tmp_path, model, element, n_ranks):
    """The force on the deck's first surface is -p A, in axisymmetry A = pi; the pressure is shown on the second one."""
    direction = "[0, 0, 1]" if model == "solid" else "[0, 1]"
    deck = write_held_deck(tmp_path, model, element, f"direction: {direction}, initial_gap: gap")
    said = signorom("solve", deck, folder=tmp_path, n_ranks=n_ranks)
    note = r"sides swapped, because the displacement of node \d+ \(.*\) is prescribed along its normal, so that it "
    note += r"cannot carry a contact force \(formulation: mortar keeps the deck's order\); 100\.0 % of 'upper_face'"
    assert re.search(note, said), said
    pressure = YOUNG_MODULUS * (STROKE - GAP)
    area = np.pi if model == "axisymmetric" else 1.0
    (contact,) = contacts_of(tmp_path / "results/held")
    assert contact["surfaces"] == "lower_face - upper_face"
    assert_close(contact["area"], np.array(area))
    assert_close(contact["force"], np.array([0.0] * (2 if model == "solid" else 1) + [-pressure * area]))
    with h5py.File(tmp_path / "results/held/contact.h5") as file:
        assert len(file["mesh/topology"]) == {"solid": 2 * N_UPPER**2}.get(model, N_UPPER)
        (point,) = file["points"].values()
        assert_close(point["contact_pressure"][()], np.array(pressure))


def test_moment_of_the_first_side(signorom, tmp_path):
    """Across a gap of 0.04 both sides have moments of their own: that of the deck's first one is x F_y, at the face."""
    deck = write_held_deck(tmp_path, contact="initial_gap: gap")
    signorom("solve", deck, folder=tmp_path)
    (contact,) = contacts_of(tmp_path / "results/held")
    force = -YOUNG_MODULUS * (STROKE - GAP)
    assert_close(contact["moment"], np.array(force / 2))


def test_check_shows_the_other_side(signorom, tmp_path):
    """Side 1 of the surfaces are the edges of the upper block, where the rows are."""
    deck = write_held_deck(tmp_path)
    signorom("check", deck, "--fields", folder=tmp_path)
    with h5py.File(tmp_path / "results/held/check.h5") as file:
        (point,) = file["points"].values()
        is_first = (point["kind"][()] == 3) & (point["side"][()] == 1)
        assert is_first.sum() == N_UPPER
        assert (point["contact_side"][()] == 1).sum() == N_UPPER + 1


@pytest.mark.parametrize("contact", ["formulation: mortar", "formulation: auto, initial_gap: gap + 0 * x"])
def test_order_of_the_deck_is_kept(signorom, tmp_path, contact):
    """Where the deck insists, and where its gap belongs to the nodes of its first surface."""
    deck = write_held_deck(tmp_path, contact=contact)
    words = refuse(signorom, "check", deck, folder=tmp_path)
    assert re.search(
        r"contact\[1\]: the displacement of node \d+ .* is prescribed along its normal", words
    ), words
    assert "hint: leave the facets at such nodes out of the first surface, or swap first and" in words


@pytest.mark.parametrize("formulation", ["auto", "mortar"])
def test_floor_of_two_blocks(signorom, tmp_path, formulation):
    """The floor is the second surface of one contact and the first of the other, with nodes in both."""
    mesh = Mesh()
    heights = np.linspace(0, 1, 3)
    mesh.add_block(
        "floor", [np.linspace(0, 2, 6), heights - 1], "Q4", {(1, 1): "floor_face", (1, 0): "bottom"}
    )
    for name, n, start in (("left", 3, 0.0), ("right", 4, 1.0)):
        lines = [np.linspace(start, start + 1, n + 1), heights]
        mesh.add_block(name, lines, "T3", {(1, 0): f"{name}_face", (1, 1): "top"})
    mesh.write(tmp_path / "blocks.msh")
    deck = tmp_path / "floor.yaml"
    deck.write_text(f"""mesh: {{file: blocks.msh, model: plane_strain}}
parameters: {{stroke: {{min: 0.05, max: {STROKE}}}}}
materials: {{block: {{regions: [floor, left, right], young_modulus: {YOUNG_MODULUS}, poisson_ratio: 0}}}}
boundary_conditions:
  - {{boundary: bottom, displacement: {{x: 0, y: 0}}}}
  - {{boundary: top, displacement: {{x: 0, y: -stroke}}}}
contact:
  - {{first: left_face, second: floor_face}}
  - {{first: floor_face, second: right_face, formulation: {formulation}}}
training: {{grid: {{stroke: 2}}}}
output: {{points: [{{stroke: {STROKE}}}]}}
""")
    reason = r"node \d+ \(.*\) is in contact\[1\], too, of 'left_face' and 'floor_face'"
    if formulation == "mortar":
        assert re.search(rf"contact\[2\]: {reason}", refuse(signorom, "check", deck, folder=tmp_path))
        return
    said = signorom("solve", deck, folder=tmp_path)
    assert re.search(rf"contact\[2\]: mortar, .*: sides swapped, because {reason} \(formulation", said), said
    assert (
        "contact[1]: mortar, because node-to-node contact cannot pair the nodes of both surfaces: 100.0 % of 'left_face'"
        in said
    )
    force = YOUNG_MODULUS * STROKE / 2
    left, right = contacts_of(tmp_path / "results/floor")
    assert_close(left["force"], np.array([0, force]))
    assert_close(right["force"], np.array([0, -force]))
    assert_close([left["moment"], right["moment"]], np.array([[force / 2], [-force * 1.5]]))


def corner_of_three(path):
    """A square with one block on it and one beside it: its upper right corner is in both contacts."""
    mesh = Mesh()
    halves = np.linspace(0, 1, 3)
    sides = {(1, 1): "roof", (0, 1): "wall", (1, 0): "ground", (0, 0): "left"}
    mesh.add_block("middle", [np.linspace(0, 1, 4)] * 2, "Q4", sides)
    sides = {(1, 0): "above_face", (1, 1): "top", (0, 0): "left"}
    mesh.add_block("above", [np.linspace(0, 1, 6), 1 + halves], "T3", sides)
    sides = {(0, 0): "beside_face", (0, 1): "right", (1, 0): "ground"}
    mesh.add_block("beside", [1 + halves, np.linspace(0, 1, 5)], "Q4", sides)
    mesh.write(path)


CORNER = {
    "square first in both": (["roof, second: above_face", "wall, second: beside_face"], ["", ""], (1, 2)),
    "square first in one": (["roof, second: above_face", "beside_face, second: wall"], ["", ""], (1,)),
    "square second in both": (["above_face, second: roof", "beside_face, second: wall"], ["", ""], ()),
    "the second insists": (
        ["roof, second: above_face", "beside_face, second: wall"], ["", ", formulation: mortar"], (1,),
    ),
}  # fmt: skip


@pytest.mark.parametrize("n_ranks", [1, 3])
@pytest.mark.parametrize("case", CORNER)
def test_corner_of_two_contacts(signorom, tmp_path, case, n_ranks):
    """nu = 0: the blocks press independently, each with E stroke / 2, whatever side is the first one."""
    sides, ends, swapped = CORNER[case]
    corner_of_three(tmp_path / "blocks.msh")
    deck = tmp_path / "corner.yaml"
    contacts = "".join(f"  - {{first: {side}{end}}}\n" for side, end in zip(sides, ends, strict=True))
    deck.write_text(f"""mesh: {{file: blocks.msh, model: plane_strain}}
parameters: {{stroke: {{min: 0.05, max: {STROKE}}}}}
materials: {{block: {{regions: [middle, above, beside], young_modulus: {YOUNG_MODULUS}, poisson_ratio: 0}}}}
boundary_conditions:
  - {{boundary: ground, displacement: {{y: 0}}}}
  - {{boundary: left, displacement: {{x: 0}}}}
  - {{boundary: top, displacement: {{y: -stroke}}}}
  - {{boundary: right, displacement: {{x: -stroke / 2}}}}
contact:
{contacts}training: {{grid: {{stroke: 2}}}}
output: {{points: [{{stroke: {STROKE}}}]}}
""")
    said = signorom("solve", deck, folder=tmp_path, n_ranks=n_ranks)
    found = re.findall(
        r"note: contact\[(\d)\]: mortar, .*: sides swapped, because node \d+ \(1\.0, 1\.0\) is in", said
    )
    assert tuple(map(int, found)) == swapped
    force = YOUNG_MODULUS * STROKE / 2
    above, beside = contacts_of(tmp_path / "results/corner")
    assert_close(above["force"], np.array([0, force if "above" in sides[0][:5] else -force]))
    assert_close(beside["force"], np.array([force / 2 if "beside" in sides[1][:6] else -force / 2, 0]))
    assert_close([above["area"], beside["area"]], np.array([1.0, 1.0]))


def test_corner_of_two_contacts_that_insist(signorom, tmp_path):
    """The message is that of the deck's order, and names the other contact."""
    corner_of_three(tmp_path / "blocks.msh")
    deck = tmp_path / "corner.yaml"
    deck.write_text(f"""mesh: {{file: blocks.msh, model: plane_strain}}
materials: {{block: {{regions: [middle, above, beside], young_modulus: {YOUNG_MODULUS}, poisson_ratio: 0}}}}
boundary_conditions: [{{boundary: ground, displacement: {{y: 0}}}}]
parameters: {{stroke: {{min: 0.05, max: {STROKE}}}}}
contact:
  - {{first: roof, second: above_face, formulation: mortar}}
  - {{first: wall, second: beside_face}}
""")
    words = refuse(signorom, "check", deck, folder=tmp_path)
    shared = r"node \d+ \(1\.0, 1\.0\) is in contact\[1\], too, of 'roof' and 'above_face'"
    assert re.search(rf"yaml:7:13: error: contact\[2\]: {shared}", words), words
