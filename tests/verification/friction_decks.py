# SPDX-License-Identifier: BSD-3-Clause
"""Decks of two blocks with friction and random histories: reversals, turns of the direction, tilts, lifting."""

from dataclasses import dataclass

import numpy as np

from block_meshes import Mesh

# [s] nodes of the tables
N_TIMES = 7
# [mm] inner radius in axisymmetry
INNER = 0.5


@dataclass
class Kind:
    """What a random deck looks like."""

    n_dim: int
    model: str
    #: how far the middle of the contact face bulges; 0: flat
    bulge: float = 0.0
    #: direction of the deck; averaged normals without
    direction: tuple = ()
    #: the upper block is held by contact alone, and pressed
    is_loose: bool = False
    #: first side of the contact
    first: str = "lower_face"
    #: x is prescribed on the left side of both blocks, so that a tangent has no row there
    has_symmetry: bool = False


PLANE = {
    "plane_strain": Kind(2, "plane_strain"),
    "plane_stress, curved": Kind(2, "plane_stress", bulge=0.04),
    "leaning direction": Kind(2, "plane_strain", direction=(0.15, 1.0)),
    "other side first": Kind(2, "plane_strain", bulge=0.03, first="upper_face"),
    "axisymmetric": Kind(2, "axisymmetric", bulge=0.03),
}
SOLID = {
    "solid": Kind(3, "solid"),
    "solid, curved": Kind(3, "solid", bulge=0.04),
    "solid, symmetric": Kind(3, "solid", has_symmetry=True),
}
LOOSE = Kind(2, "plane_strain", is_loose=True)


def blocks(kind, n_across, seed=1):
    """Two blocks, 1 wide and 0.6 high each, that touch at height 0; their inner nodes are moved."""
    random = np.random.default_rng(seed)
    across = []
    for n in n_across:
        line = np.linspace(0, 1, n)
        line[1:-1] += random.uniform(-0.2, 0.2, n - 2) / (n - 1)
        across.append(line)
    up, mesh = kind.n_dim - 1, Mesh()
    for name, heights in (
        ("lower", np.array([-0.6, -0.35, -0.15, 0.0])),
        ("upper", np.array([0.0, 0.12, 0.3, 0.6])),
    ):
        faces = {(up, 0): "bottom", (up, 1): "lower_face"}
        if name == "upper":
            faces = {(up, 0): "upper_face", (up, 1): "top"}
        faces |= {(0, 0): "left"}
        element = "Q4" if kind.n_dim == 2 else "H8"
        mesh.add_block(name, [*across, heights], element, faces, moved=0.15, seed=len(name) + seed)
    places = mesh.coordinates
    bulge = kind.bulge * np.prod([4 * places[:, i] * (1 - places[:, i]) for i in range(up)], axis=0)
    places[:, up] += bulge * (1 - np.abs(places[:, up]) / 0.6)
    if kind.model == "axisymmetric":
        places[:, 0] += INNER
    return mesh


def random_tables(kind, random):
    """Values of the tables at the times 0, 1, ...: 0 at the time 0."""

    def values(size, low=-1.0):
        return np.append(0.0, size * random.uniform(low, 1.0, N_TIMES - 1))

    stroke = 0.02
    tables = {"push": values(stroke, 0.2), "slide_x": values(3 * stroke), "tilt": values(2 * stroke)}
    if kind.n_dim == 3:
        tables |= {"slide_y": values(3 * stroke), "spin": values(2 * stroke)}
    if kind.is_loose:
        # forces; what slides is 0.9 f times this times what presses
        tables = {"push": values(1.0, 0.5), "tilt": values(0.5)}
        tables["slide_x"] = np.append(0.0, random.choice([-1.0, 1.0], N_TIMES - 1))
    else:
        # the blocks part once
        tables["push"][random.integers(2, N_TIMES - 1)] = -0.3 * stroke
    return tables


def write_random_deck(folder, kind, friction, seed, n_increments=12, n_across=None):
    """Mesh and deck; returns the path of the deck. 11 or 20 contacts, 7 of a loose block, whose sweeps are long."""
    n_across = n_across or ((7,) if kind.is_loose else {2: (11,), 3: (5, 4)}[kind.n_dim])
    random = np.random.default_rng(seed)
    blocks(kind, n_across, seed).write(folder / "blocks.msh")
    up, axes = kind.n_dim - 1, "xyz"[: kind.n_dim]
    if kind.model == "axisymmetric":
        axes = "rz"
    x = axes[0]
    tables = [
        f"    {name}: {{time: {list(range(N_TIMES))}, value: {values.tolist()}}}"
        for name, values in random_tables(kind, random).items()
    ]
    held = ", ".join(f"{axis}: 0" for axis in axes)
    conditions = [f"{{boundary: bottom, displacement: {{{held}}}}}"]
    loads = "[]"
    middle = f"({x} - {INNER + 0.5 if kind.model == 'axisymmetric' else 0.5})"
    if kind.is_loose:
        loads = (
            f"[{{boundary: top, traction: {{{x}: 0.9 * mu * push * slide_x, "
            f"{axes[up]}: -push * (1 + tilt * {middle})}}}}]"
        )
    else:
        moves = {x: "slide_x", axes[up]: f"-push + tilt * {middle}"}
        if kind.n_dim == 3:
            moves |= {"x": "slide_x - spin * (y - 0.5)", "y": f"slide_y + spin * {middle}"}
        if kind.has_symmetry:
            moves = {"y": "slide_y", "z": moves["z"]}
            conditions.append("{boundary: left, displacement: {x: 0}}")
        moved = ", ".join(f'{axis}: "{text}"' for axis, text in moves.items())
        conditions.append(f"{{boundary: top, displacement: {{{moved}}}}}")
    second = "upper_face" if kind.first == "lower_face" else "lower_face"
    sides = f"first: {kind.first}, second: {second}"
    if kind.direction:
        sides += f", direction: {list(kind.direction)}"
    deck = folder / "blocks.yaml"
    newline = "\n"
    deck.write_text(f"""units: {{length: mm, force: N, time: s}}
mesh: {{file: blocks.msh, model: {kind.model}}}
parameters: {{mu: {{min: 0, max: 1.5}}}}
history:
  tables:
{newline.join(tables)}
  steps: [{{until: {N_TIMES - 1}, increments: {n_increments}}}]
materials:
  hard: {{regions: [lower], young_modulus: 70, poisson_ratio: 0.3}}
  soft: {{regions: [upper], young_modulus: 40, poisson_ratio: 0.2}}
boundary_conditions:
{newline.join(f"  - {text}" for text in conditions)}
loads: {loads}
contact: [{{{sides}, friction: mu}}]
output: {{points: [{{mu: {friction}}}]}}
""")
    return deck
