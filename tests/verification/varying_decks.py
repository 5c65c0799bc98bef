# SPDX-License-Identifier: BSD-3-Clause
"""Decks whose elastic constants depend on the parameters."""

import re

import numpy as np

from block_meshes import Mesh
from runs import write_input
from two_materials import HANGING, split_region, write_two_materials_below

__all__ = ["HANGING", "MODULUS", "RATIOS", "STUDY", "write_core_and_rim", "write_one_ratio", "write_study"]
__all__ += ["write_two_materials"]

STUDY = "training: {sobol: 20}\ntest: {sobol: 6, seed: 3}\n"
MODULUS = {
    "young_modulus: 78.0e3": "young_modulus: E",
    "materials:\n": "  E: {min: 40.0e3, max: 160.0e3, unit: MPa}\nmaterials:\n",
}
RATIOS = {
    "poisson_ratio: 0.34": "poisson_ratio: nu_cladding",
    "poisson_ratio: 0.3}": "poisson_ratio: nu_fuel}",
    "materials:\n": "  nu_fuel: {min: 0.2, max: 0.4, unit: '1'}\n"
    "  nu_cladding: {min: 0.25, max: 0.4, unit: '1'}\nmaterials:\n",
}
# nearly the volume of water: 1 - 2 nu changes by a factor of 2500
NEARLY_INCOMPRESSIBLE = RATIOS | {
    "materials:\n": RATIOS["materials:\n"].replace("min: 0.25, max: 0.4,", "min: 0.25, max: 0.4999,")
}
# A core and a rim of one body, a block that only contact holds in height; tilted by a load that wanders.
TWO_MATERIALS = """\
title: A block of two materials under another one
units: {length: mm, force: N}
mesh: {file: two_materials.msh, model: solid}
parameters:
  ratio: {min: 0.3, max: 1.5, unit: "1"}
  E: {min: 100.0e3, max: 250.0e3, unit: MPa}
  nu: {min: 0.2, max: 0.4, unit: "1"}
  P: {min: 0.0, max: 300.0, unit: MPa}
{materials}boundary_conditions:
  - {boundary: bottom, displacement: {x: 0, y: 0, z: 0}}
  - {boundary: left, displacement: {x: 0}}
  - {boundary: front, displacement: {y: 0}}
loads:
  - {boundary: top, pressure: "P * (1.2 - x)"}
contact:
  - {first: lower_face, second: upper_face, initial_gap: "4e-4 * (x^2 + y)"}
"""


def write_two_materials(folder):
    """The deck and its mesh: cells of the lower block beside the middle are the core."""
    return write_two_materials_below(folder, "two_materials", "H8", 3, TWO_MATERIALS + STUDY)


def write_study(name, folder, changes):
    """A deck of input/ with other constants, all defaults of reduction, and few points."""
    deck = write_input(name, folder, changes)
    text = re.sub(r"(?ms)^training:.*", "", deck.read_text())
    deck.write_text(text + STUDY)
    return deck


def write_one_ratio(folder):
    """Two materials in one body with a ratio of moduli as its one constant."""
    deck = write_two_materials(folder)
    text = deck.read_text().replace(
        "young_modulus: E * ratio, poisson_ratio: nu", "young_modulus: E * ratio, poisson_ratio: 0.3"
    )
    deck.write_text(re.sub(r"(?m)^  nu: .*\n", "", text))
    return deck


CORE_AND_RIM = """\
title: Case b with a pellet of core and rim
units: {length: mm, force: N}
mesh: {file: core_and_rim.msh, model: axisymmetric}
parameters:
  P1: {min: 5.0, max: 200.0, unit: MPa}
  h1: {min: 0.6, max: 6.0, unit: mm}
  ratio: {min: 0.3, max: 1.5, unit: "1"}
materials:
  core: {regions: [core], young_modulus: 190.0e3 * ratio, poisson_ratio: 0.3}
  rim: {regions: [rim], young_modulus: 190.0e3, poisson_ratio: 0.3}
  cladding: {regions: [cladding], young_modulus: 78.0e3, poisson_ratio: 0.34}
boundary_conditions:
  - {boundary: axis, displacement: {r: 0}}
  - {boundary: bottom, displacement: {z: 0}}
  - {boundary: top, displacement: {z: 0}}
loads:
  - {boundary: cladding_outside, pressure: P1, window: {axis: z, min: 0, max: h1}, load: cut}
contact:
  - {first: fuel_surface, second: cladding_inside, direction: [1, 0]}
"""


def write_core_and_rim(folder):
    """Case b on its own grid; the pellet's outer third is the rim, and their ratio of moduli a parameter."""
    mesh = Mesh()
    heights = np.linspace(0, 7, 101)
    faces = {(1, 0): "bottom", (1, 1): "top"}
    pellet = [np.linspace(0, 4.1, 61), heights]
    mesh.add_block("fuel", pellet, "Q4", faces | {(0, 0): "axis", (0, 1): "fuel_surface"})
    tube = [np.linspace(4.102, 4.672, 9), heights]
    mesh.add_block("cladding", tube, "Q4", faces | {(0, 0): "cladding_inside", (0, 1): "cladding_outside"})
    split_region(mesh, "fuel", lambda place: "core" if place[0] < 4.1 * 2 / 3 else "rim")
    mesh.write(folder / "core_and_rim.msh")
    deck = folder / "core_and_rim.yaml"
    deck.write_text(CORE_AND_RIM + STUDY)
    return deck
