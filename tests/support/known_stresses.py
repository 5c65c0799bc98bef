# SPDX-License-Identifier: BSD-3-Clause
"""Decks whose stresses are known in every cell, for the programs that show them.

`block`: one strain everywhere, all six stresses different. Linear elements hold it exactly (Hooke's law).
`tubes`: the thick cylinder of tests/reference, whose hoop stress stands under zz (Lame).
"""

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from block_meshes import Mesh
from decks import copy_deck

TESTS = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(TESTS / "reference"))
import thick_cylinder  # noqa: E402

#: order of the components in fields.h5, and their names in ParaView
COMPONENTS = ("XX", "YY", "ZZ", "XY", "YZ", "XZ")
NAMES = ("block", "tubes")
YOUNG_MODULUS, POISSON_RATIO = 2.0e6, 0.3
#: xx, yy, zz and xy, yz, xz (not the angles) of the block
STRAINS = np.array([3.0, -2.0, -7.0, 1.5, -4.0, 5.5]) * 1e-4
N_CELLS_ACROSS = 16


@dataclass
class KnownStresses:
    """What a reader of the fields must find."""

    #: file of the deck; the results are in results/<stem> beside it
    deck: Path
    #: [force/length^2] shape (n_cells, 6)
    cells: np.ndarray
    #: the same at the nodes, shape (n_nodes, 6)
    nodes: np.ndarray
    #: [force/length^2] largest difference: of cells, of nodes
    limits: tuple[float, float]


def write_case(name, folder):
    """Writes mesh and deck of a case, one of NAMES, into a folder, and returns the KnownStresses of its fields."""
    return {"block": _block, "tubes": _tubes}[name](Path(folder))


def block_stress():
    """Returns the stress of the block, shape (6), by Hooke's law: lambda tr(eps) I + 2 mu eps."""
    mu = YOUNG_MODULUS / (2 * (1 + POISSON_RATIO))
    lame = YOUNG_MODULUS * POISSON_RATIO / ((1 + POISSON_RATIO) * (1 - 2 * POISSON_RATIO))
    return 2 * mu * STRAINS + lame * STRAINS[:3].sum() * np.array([1, 1, 1, 0, 0, 0])


def _block(folder):
    """Writes the block: five sides move as the strain says, the sixth carries its traction.

    The rigid plane above the sixth side stays away.
    """
    xx, yy, zz, xy, yz, xz = STRAINS.tolist()
    stress = block_stress()
    rows = {"x": (xx, xy, xz), "y": (xy, yy, yz), "z": (xz, yz, zz)}
    motion = ", ".join(f'{axis}: "{a!r} * x + {b!r} * y + {c!r} * z"' for axis, (a, b, c) in rows.items())
    sides = ("bottom", "left", "right", "front", "back")
    entries = "".join(f"\n  - {{boundary: {side}, displacement: {{{motion}}}}}" for side in sides)
    traction = ", ".join(f"{axis}: {float(stress[i])!r}" for axis, i in (("x", 5), ("y", 4), ("z", 2)))
    mesh = Mesh()
    lines = [
        np.array([0.0, 0.3, 0.55, 1.0]),
        np.array([0.0, 0.4, 0.7, 1.0]),
        np.array([-1.0, -0.6, -0.2, 0.0]),
    ]
    faces = {
        (2, 0): "bottom",
        (2, 1): "top",
        (0, 0): "left",
        (0, 1): "right",
        (1, 0): "front",
        (1, 1): "back",
    }
    mesh.add_block("block", lines, "H8", faces, 0.25, seed=1)
    mesh.write(folder / "block.msh")
    deck = folder / "block.yaml"
    deck.write_text(f"""title: One stress everywhere
mesh: {{file: block.msh, model: solid, length_unit: m}}
parameters: {{height: {{min: 1.0, max: 2.0, unit: m}}}}
materials: {{block: {{regions: [block], young_modulus: {YOUNG_MODULUS}, poisson_ratio: {POISSON_RATIO}}}}}
boundary_conditions:{entries}
loads: [{{boundary: top, traction: {{{traction}}}}}]
contact:
  - {{first: top, obstacle: {{type: half_space, point: [0, 0, height], normal: [0, 0, -1]}}}}
output: {{fields: [displacement, contact, stress], points: [{{height: 1.0}}]}}
""")
    n_cells = sum(kind == "H8" for kind, _, _ in mesh.elements)
    limit = 1e-10 * np.abs(stress).max()
    return KnownStresses(
        deck, np.tile(stress, (n_cells, 1)), np.tile(stress, (len(mesh.coordinates), 1)), (limit, limit)
    )


def _tubes(folder):
    """Writes the tubes: radial, axial and hoop stress stand under xx, yy and zz.

    The stress of a cell is that of its middle, but for an error of the order h^2.
    """
    radii = thick_cylinder.RADII
    heights = np.linspace(0, 0.5, N_CELLS_ACROSS // 2 + 1)
    ends = {(1, 0): "ends", (1, 1): "ends"}
    mesh = Mesh()
    for i, (name, faces) in enumerate([("inner", ("bore", "inner_face")), ("outer", ("outer_face", "rim"))]):
        lines = [np.linspace(radii[i], radii[i + 1], N_CELLS_ACROSS + 1), heights]
        mesh.add_block(name, lines, "Q4", {(0, 0): faces[0], (0, 1): faces[1]} | ends)
    mesh.write(folder / "tubes.msh")
    deck = copy_deck(TESTS / "verification" / "decks" / "thick_cylinder.yaml", folder)
    cells = [(name == "inner", nodes) for kind, name, nodes in mesh.elements if kind == "Q4"]
    is_inner = np.ones(len(mesh.coordinates), dtype=bool)
    is_inner[np.unique([nodes for first, nodes in cells if not first])] = False
    middles = np.array([mesh.coordinates[nodes, 0].mean() for _, nodes in cells])
    p = thick_cylinder.contact_pressure()
    # a node at the edge of a tube has the mean of cells that lie half a cell inside: an error of first order
    return KnownStresses(
        deck,
        thick_cylinder.stresses(middles, np.array([first for first, _ in cells])),
        thick_cylinder.stresses(mesh.coordinates[:, 0], is_inner),
        (0.01 * p, 0.1 * p),
    )
