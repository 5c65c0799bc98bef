# SPDX-License-Identifier: BSD-3-Clause
"""Bodies that only touch have no contact force, and a gap that is linear along the surface closes exactly."""

from itertools import product

import numpy as np
import pytest

from block_meshes import LINEAR, QUADRATIC, Mesh
from runs import read_snapshots, solve_deck
from spread import spread

FACES = ("lower_face", "upper_face")
YOUNG_MODULUS = 2.0e6
HEIGHT = 0.5
# radii of the upper body and, where it is round, of the lower one
RADII = (4.0, 5.0)
SQUEEZE = RADII[0] / 400
# [-] of the force at that squeeze
NOTHING = 1e-9


def round_profile(radius):
    """Height above the point that touches."""
    return lambda squared: radius - np.sqrt(radius**2 - squared)


def bodies(element, lines, profiles):
    """Two blocks that touch at height 0; their faces stand back by a profile of the squared distance from the middle."""
    mesh = Mesh()
    up = len(lines[0])
    for name, across, sign in (("lower", lines[0], -1), ("upper", lines[1], 1)):
        heights = np.sort(sign * np.linspace(0, HEIGHT, 3))
        sides = {(up, int(sign < 0)): f"{name}_face", (up, int(sign > 0)): "bottom" if sign < 0 else "top"}
        mesh.add_block(name, [*across, heights], LINEAR.get(element, element), sides)
    if element in QUADRATIC:
        mesh.make_quadratic(element)
    for name, profile, sign in zip(("lower", "upper"), profiles, (-1, 1), strict=True):
        nodes = mesh.nodes_of(name)
        x = mesh.coordinates[nodes]
        back = sign * profile(x[:, :up]) * (1 - np.abs(x[:, up]) / HEIGHT)
        mesh.coordinates[nodes, up] += back
    return mesh


def deck_of(folder, n_dim, first, bottom, top, points, contact=""):
    """Two blocks, the lower one held; `contact` goes into the entry."""
    second = FACES[1 - FACES.index(first)]
    path = folder / "touch.yaml"
    path.write_text(
        f"mesh: {{file: touch.msh, model: {'plane_strain' if n_dim == 2 else 'solid'}}}\n"
        f"parameters: {{stroke: {{min: 0, max: {SQUEEZE}}}}}\n"
        f"materials: {{block: {{regions: [lower, upper], young_modulus: {YOUNG_MODULUS}, poisson_ratio: 0}}}}\n"
        "boundary_conditions:\n"
        f"  - {{boundary: bottom, displacement: {{{bottom}}}}}\n"
        f"  - {{boundary: top, displacement: {{{top}}}}}\n"
        f"contact:\n  - {{first: {first}, second: {second}{contact}}}\n"
        f"solver: {{type: condensed}}\ntraining: {{grid: {{stroke: 2}}}}\noutput: {{points: [{points}]}}\n"
    )
    return path


def forces_of_touch(signorom, folder, mesh, n_dim, first, contact=""):
    """Sums of the contact forces where the bodies only touch, and at the squeeze."""
    mesh.write(folder / "touch.msh")
    up, across = "xyz"[n_dim - 1], "".join(f"{axis}: 0, " for axis in "xyz"[: n_dim - 1])
    deck = deck_of(folder, n_dim, first, f"{across}{up}: 0", f"{across}{up}: -stroke", "{stroke: 0}", contact)
    signorom("sample", deck, folder=folder)
    return read_snapshots(folder / "results" / deck.stem / "snapshots.h5")["multipliers"].sum(axis=1)


def flat(x):
    """No profile."""
    return np.zeros(len(x))


def around_middle(radius):
    """A circle or a sphere that touches at the middle."""
    return lambda x: round_profile(radius)(np.sum(x**2, axis=1))


# edges of the lower and the upper face; of an odd number one touches in its middle
SIZES = [(7, 6), (8, 6), (6, 7)]
SHAPES = {"flat": flat, "round": around_middle(RADII[1])}
ELEMENTS = {"T3": 2, "Q4": 2, "T6": 2, "Q8": 2, "T4": 3, "H8": 3, "T10": 3, "H20": 3}


@pytest.mark.parametrize(
    ("element", "sizes", "case"), spread(list(ELEMENTS), SIZES, list(product(SHAPES, FACES)))
)
def test_touching_bodies(signorom, tmp_path, figures, element, sizes, case):
    """A cylinder or a sphere on a flat or a round body, gap 0 at one point, nothing moves."""
    n_dim, (shape, first) = ELEMENTS[element], case
    if element not in QUADRATIC and (sizes[1] % 2 or shape == "round"):
        sizes = SIZES[1]  # of linear elements only nodes lie on the surface
    lines = [[np.linspace(-1, 1, n + 1)] * (n_dim - 1) for n in sizes]
    mesh = bodies(element, lines, [SHAPES[shape], around_middle(RADII[0])])
    touching, squeezed = forces_of_touch(signorom, tmp_path, mesh, n_dim, first)
    name = f"force over that at R / 400, {element} {sizes}, on a {shape} body, {first} first"
    assert squeezed > 0
    figures.at_most("bodies that only touch", name, touching / squeezed, NOTHING, "none")


@pytest.mark.parametrize(("element", "first"), spread(["T3", "Q8", "T10"], FACES))
def test_tilted_block_touches_with_its_edge(signorom, tmp_path, figures, element, first):
    """The lower body reaches beyond the edge that touches: nodes beside it face nothing."""
    n_dim = ELEMENTS[element]
    lines = [
        [np.linspace(-1, 1, 9)] * (n_dim - 1),
        [np.linspace(-0.6, 0.5, 6), np.linspace(-1, 1, 6)][: n_dim - 1],
    ]
    mesh = bodies(element, lines, [flat, lambda x: 0.03 * (x[:, 0] + 0.6)])
    touching, squeezed = forces_of_touch(signorom, tmp_path, mesh, n_dim, first)
    assert squeezed > 0
    name = f"force over that at R / 400, {element}, {first} first"
    figures.at_most("tilted block that only touches", name, touching / squeezed, NOTHING, "none")


@pytest.mark.parametrize("first", FACES)
@pytest.mark.parametrize("element", ["T6", "H8"])
def test_overlap_of_meshes_whose_gap_is_given(signorom, tmp_path, figures, element, first):
    """The meshes overlap by three elements; the deck says that they touch: no force; uniform when squeezed."""
    n_dim = ELEMENTS[element]
    lines = [[np.linspace(-1, 1, n + 1)] * (n_dim - 1) for n in (14, 9)]
    mesh = bodies(element, lines, [flat, flat])
    mesh.coordinates[mesh.nodes_of("upper"), n_dim - 1] -= 0.45
    touching, squeezed = forces_of_touch(signorom, tmp_path, mesh, n_dim, first, ", initial_gap: 0")
    expected = YOUNG_MODULUS * SQUEEZE / (2 * HEIGHT) * 2 ** (n_dim - 1)
    name = f"force, {element}, {first} first"
    figures.at_most(
        "meshes that overlap, gap 0 given", f"{name}, at rest", touching, NOTHING * expected, "none"
    )
    figures.compare(
        "meshes that overlap, gap 0 given", name, squeezed, expected, 1e-9, "uniform pressure", "N"
    )


@pytest.mark.parametrize(
    ("element", "first"), spread(["T3", "Q4", "T6", "Q8", "T4", "H8", "T10", "H20"], FACES)
)
def test_wedge_closes_exactly(signorom, tmp_path, figures, element, first):
    """A gap slope * (1 + x) closes by a small rotation, nu = 0: uniform pressure to rounding, nodes do not match."""
    n_dim, slope, strain = ELEMENTS[element], 0.03, 0.01
    lines = [[np.linspace(-1, 1, n + 1)] * (n_dim - 1) for n in (7, 5)]
    # equal places up to rounding, unequal edges
    lines = [[np.sign(line) * np.abs(line) ** 1.3 for line in across] for across in lines]
    mesh = bodies(element, lines, [flat, lambda x: slope * (1 + x[:, 0])])
    mesh.write(tmp_path / "touch.msh")
    up = "xyz"[n_dim - 1]
    # u_up = - strain (up + HEIGHT) below; above the same strain, and the rotation that closes the gap
    turn, middle = slope * (1 - strain), "".join("y: 0, " for _ in range(n_dim - 2))
    closed = f"-({strain * HEIGHT} + {turn} * (1 + x) + {strain} * {HEIGHT})"
    share = f"stroke / {SQUEEZE}"
    top = f'x: "{share} * {turn * HEIGHT}", {middle}{up}: "{share} * {closed}"'
    bottom = f"x: 0, {middle}{up}: 0"
    direction = [0] * (n_dim - 1) + [1 if first == "lower_face" else -1]
    deck = deck_of(tmp_path, n_dim, first, bottom, top, f"{{stroke: {SQUEEZE}}}", f", direction: {direction}")
    (fields,), _ = solve_deck(signorom, deck)
    nodes = mesh.nodes_of(first)
    # the upper face leans
    area = 1.0 if first == "lower_face" else np.sqrt(1 + slope**2)
    found = fields["contact_pressure"][nodes]
    worst = np.abs(found / (YOUNG_MODULUS * strain / area) - 1).max()
    figures.at_most(
        "wedge that closes", f"pressure, {element}, {first} first", worst, 1e-9, "uniform pressure"
    )
