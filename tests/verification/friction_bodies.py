# SPDX-License-Identifier: BSD-3-Clause
"""Cylinders and spheres in partial slip: meshes whose two bodies mirror each other, decks, and how results are read."""

from dataclasses import dataclass

import numpy as np

import hertz
from block_meshes import LINEAR, QUADRATIC, Mesh, consistent_areas
from friction_formulas import PointSlip
from friction_results import Forces, read_forces
from sphere_mesh import graded

# D21, D22: two equal cylinders, mirror images of each other, so that shear changes no pressure. Their half-spaces are
# blocks of 12 half-widths.
YOUNG, POISSON, RADIUS, CYLINDER_FRICTION = 70e3, 0.3, 100.0, 0.4
HALF_WIDTH, SIZE = 2.0, 24.0
# spheres: [mm] half-width that the mesh is made for, size of the half-spaces, radius of each; [mm] strokes
BALL_HALF_WIDTH, BALL_SIZE, BALL, BALL_FRICTION = 2.0, 20.0, 50.0, 0.4
BALL_PUSH, BALL_SLIDE = 0.155, 0.05
# small, so that slip across the load hardly counts
BALL_POISSON = 0.0
N_SHEARS = 6
SPHERE_DECK = f"""units: {{length: mm, force: N, time: s}}
mesh: {{file: spheres.msh, model: solid}}
parameters: {{push: {{min: 0, max: 1, unit: mm}}, slide: {{min: 0, max: 1, unit: mm}}}}
history:
  tables:
    down: {{time: [0, 1, 2], value: [0, push, push]}}
    along: {{time: [0, 1, 2], value: [0, 0, slide]}}
  steps: [{{until: 1, increments: 1}}, {{until: 2, increments: {N_SHEARS}}}]
materials: {{all: {{regions: [lower, upper], young_modulus: {YOUNG}, poisson_ratio: {BALL_POISSON}}}}}
boundary_conditions:
  - {{boundary: bottom, displacement: {{x: 0, y: 0, z: 0}}}}
  - {{boundary: top, displacement: {{x: along, y: 0, z: -down}}}}
  - {{boundary: front, displacement: {{y: 0}}}}
contact: [{{first: lower_face, second: upper_face, direction: [0, 0, 1], friction: {BALL_FRICTION}}}]
output: {{points: [{{push: {BALL_PUSH}, slide: {BALL_SLIDE}}}]}}
"""


def fit_half_width(x, rest):
    """What is left of the limit in the stick zone is a half ellipse as wide; where all slips, it is rounding."""
    return hertz.fit(x, np.where(rest > 1e-6 * rest.max(), rest, 0.0))[0]


def two_cylinders(element, n_fine, n_second=None):
    """Edges per half-width near the contact; n_second: those of the upper body, where nodes do not match."""
    mesh = Mesh()
    for name, n in (("lower", n_fine), ("upper", n_second or n_fine)):
        half = graded(HALF_WIDTH / n, int(np.ceil(1.3 * n)), SIZE, 1.35)
        up = graded(HALF_WIDTH / n, n // 2, SIZE, 1.35)
        faces = {(1, 0): f"{name}_face", (1, 1): "top" if name == "upper" else "bottom"}
        n_before, n_nodes = len(mesh.elements), len(mesh.coordinates)
        mesh.add_block(name, [np.append(-half[:0:-1], half), up], LINEAR.get(element, element), faces)
        if name == "lower":
            mesh.coordinates[n_nodes:, 1] *= -1
            mesh.elements[n_before:] = [
                (kind, group, nodes[::-1]) for kind, group, nodes in mesh.elements[n_before:]
            ]
    if element in QUADRATIC:
        mesh.make_quadratic(element)
    x, y = mesh.coordinates[:, :2].T
    upper = np.isin(np.arange(len(x)), mesh.nodes_of("upper"))
    profile = np.minimum(x**2 / (2 * RADIUS), SIZE / 4) * (1 - np.abs(y) / SIZE)
    mesh.coordinates[:, 1] += np.where(upper, profile, -profile)

    def is_kept(item):
        return not item[1].endswith("_face") or np.abs(mesh.coordinates[item[2], 0]).max() < 1.4 * HALF_WIDTH

    mesh.elements = [item for item in mesh.elements if is_kept(item)]
    return mesh


CYLINDER_DECK = f"""units: {{length: mm, force: N, time: s}}
mesh: {{file: cylinders.msh, model: plane_strain}}
parameters: {{push: {{min: 0, max: 1, unit: mm}}, slide: {{min: 0, max: 1, unit: mm}}}}
history:
  tables:
    down: {{time: [0, 1], value: [0, push]}}
    along: {{time: [0, 1, 2, 3, 4, 5], value: [0, 0, slide, 0.3 * slide, -slide, slide]}}
  steps: [{{until: 1, increments: 1}}, {{until: 5, increments: 16}}]
materials: {{all: {{regions: [lower, upper], young_modulus: {YOUNG}, poisson_ratio: {POISSON}}}}}
boundary_conditions:
  - {{boundary: bottom, displacement: {{x: 0, y: 0}}}}
  - {{boundary: top, displacement: {{x: along, y: -down}}}}
contact: [{{first: lower_face, second: upper_face, direction: [0, 1], friction: {CYLINDER_FRICTION}}}]
output: {{points: [{{push: PUSH, slide: SLIDE}}]}}
"""
# strokes [mm] that give about this half-width, and 0.6 of the largest shear
PUSH, SLIDE = 0.125, 0.05
# states by their times: pressed, at Q*, on the way back, at -Q*, at Q* again
PRESSED, LOADED, BACK, REVERSED, AGAIN = 0, 4, 8, 12, 16


def edge_lengths(mesh, name):
    """Integral of each node's shape function over a surface whose edges are nearly along x; Simpson's rule for three."""
    lengths = np.zeros(len(mesh.coordinates))
    for nodes in mesh.facets_of(name):
        length = abs(mesh.coordinates[nodes[1], 0] - mesh.coordinates[nodes[0], 0])
        lengths[nodes] += length * np.array([1, 1, 4] if len(nodes) == 3 else [3, 3]) / 6
    return lengths


def solve_cylinders(signorom, folder, element, n_fine, n_second=None):
    """Forces, slips, places and areas of the contacts."""
    mesh = two_cylinders(element, n_fine, n_second)
    mesh.write(folder / "cylinders.msh")
    deck = folder / "cylinders.yaml"
    deck.write_text(CYLINDER_DECK.replace("PUSH", str(PUSH)).replace("SLIDE", str(SLIDE)))
    signorom("solve", deck, folder=folder)
    forces = read_forces(deck)
    places = mesh.coordinates[forces.numbers - 1, 0]
    areas = edge_lengths(mesh, "lower_face")[forces.numbers - 1]
    return deck, forces, places, areas


def two_spheres(n_fine):
    """Halves of two equal spheres, cut by the plane y = 0, whose faces mirror each other."""
    mesh, step = Mesh(), BALL_HALF_WIDTH / n_fine
    half = graded(step, int(np.ceil(1.3 * n_fine)), BALL_SIZE, 1.5)
    line = graded(step, n_fine // 2, BALL_SIZE, 1.5)
    for name, up in (("lower", -line[::-1]), ("upper", line)):
        faces = {(2, 0): "upper_face", (2, 1): "top", (1, 0): "front"}
        if name == "lower":
            faces |= {(2, 0): "bottom", (2, 1): "lower_face"}
        mesh.add_block(name, [np.append(-half[:0:-1], half), half, up], "H8", faces)
    places = mesh.coordinates
    upper = np.isin(np.arange(len(places)), mesh.nodes_of("upper"))
    profile = np.minimum(np.sum(places[:, :2] ** 2, axis=1) / (2 * BALL), BALL_SIZE / 4) * (
        1 - np.abs(places[:, 2]) / BALL_SIZE
    )
    places[:, 2] += np.where(upper, profile, -profile)

    def is_kept(item):
        return not item[1].endswith("_face") or np.abs(places[item[2], :2]).max() < 1.4 * BALL_HALF_WIDTH

    mesh.elements = [item for item in mesh.elements if is_kept(item)]
    return mesh


@dataclass
class Slipping:
    """Two spheres under growing shear, as wholes: the forces of their halves twice."""

    forces: Forces
    exact: PointSlip
    n_nodes: int
    #: half-width by a fit; from the third time on: Q, c by a fit, relative displacement
    half_width: float
    shear: np.ndarray
    stick_radius: np.ndarray
    displacement: np.ndarray


def solve_spheres(signorom, folder, n_fine):
    """All times. Blocks of finite size add to the displacement what grows with Q alone, as at the second time."""
    mesh = two_spheres(n_fine)
    mesh.write(folder / "spheres.msh")
    deck = folder / "spheres.yaml"
    deck.write_text(SPHERE_DECK)
    signorom("solve", deck, folder=folder, time_limit=7200)
    forces = read_forces(deck)
    distance = np.linalg.norm(mesh.coordinates[forces.numbers - 1, :2], axis=1)
    areas = consistent_areas(mesh, "lower_face")[forces.numbers - 1]
    body = (YOUNG, BALL_POISSON)
    exact = PointSlip.of_materials(body, body, BALL / 2, 2 * forces.resultant[0][-1], BALL_FRICTION)
    # the tangents are x and y; the force on the upper sphere resists
    shear, moved = -2 * forces.resultant[1][:, 0], BALL_SLIDE * (forces.times - 1)
    linear = (moved[1] - exact.approach(shear[1])) / shear[1]
    limit = BALL_FRICTION * forces.normal
    left = (limit - np.linalg.norm(forces.tangential, axis=2)) / areas
    return Slipping(
        forces,
        exact,
        len(mesh.coordinates),
        hertz.fit(distance, forces.normal[0] / areas)[0],
        shear[2:],
        np.array([fit_half_width(distance, rest) for rest in left[2:]]),
        (moved - linear * shear)[2:],
    )
