# SPDX-License-Identifier: BSD-3-Clause
"""Elastic constants that depend on the parameters: changes of decks, and bodies of two materials."""

from block_meshes import stacked_blocks

# of input/bracket.yaml: one modulus and one ratio of a body that only contact holds
HANGING = {
    "young_modulus: 207.0e3, poisson_ratio: 0.29": "young_modulus: E, poisson_ratio: nu",
    "materials:\n": "  E: {min: 100.0e3, max: 250.0e3, unit: MPa}\n"
    "  nu: {min: 0.2, max: 0.4, unit: '1'}\nmaterials:\n",
}
# a body of a core and a rim, with a ratio of moduli and a Poisson's ratio; another body above it
MATERIALS = """\
materials:
  core: {regions: [core], young_modulus: E * ratio, poisson_ratio: nu}
  rim: {regions: [rim], young_modulus: E, poisson_ratio: 0.3}
  cover: {regions: [upper], young_modulus: 2 * E, poisson_ratio: 0.25}
"""


def core_and_rim(place):
    """Returns the region of a cell of the lower block, core or rim; `place` is the middle of the cell."""
    return "core" if place[0] < 0.5 else "rim"


def split_region(mesh, name, name_at):
    """Gives the elements with the physical name `name` other names: name_at(middle of the element)."""
    for i, (kind, region, nodes) in enumerate(mesh.elements):
        if region == name:
            mesh.elements[i] = (kind, name_at(mesh.coordinates[nodes].mean(axis=0)), nodes)


def write_two_materials_below(folder, name, element, n_dim, deck):
    """Writes `<name>.msh`, two blocks whose lower one has a core and a rim, and `<name>.yaml`; returns the latter.

    `deck` is its text, in which MATERIALS replaces {materials}; `element` and `n_dim` are those of stacked_blocks.
    """
    mesh = stacked_blocks(element, n_dim)
    split_region(mesh, "lower", core_and_rim)
    mesh.write(folder / f"{name}.msh")
    path = folder / f"{name}.yaml"
    path.write_text(deck.replace("{materials}", MATERIALS))
    return path
