# SPDX-License-Identifier: BSD-3-Clause
"""Punch with a rounded edge on a foundation, in the round and without friction (geometry of NAFEMS, Konter 2006).

The answers on meshes that do not match are compared with our own on a fine mesh whose nodes match, by pairs and not by
mortar. The published displacement and pressure (-0.13073 mm and -91.10 MPa, code_aster SSNA122) are not: they agree with
one code to six digits, where their point lies and how the foundation is held could not be found, and a converged
solution of our own has -0.136 mm and 87.1 MPa in the middle of the contact, with a foundation that slides on its base.
"""

import numpy as np
import pytest

from block_meshes import LINEAR, QUADRATIC, Mesh
from runs import read_fields
from sphere_mesh import graded

# [mm] punch: radius, height, of its edge; foundation: radius, height
RADIUS, HIGH, EDGE, WIDE, DEEP = 50.0, 100.0, 10.0, 100.0, 200.0
# the contact ends before: up to here the surfaces can touch; what lies beyond ROUND of the edge is cut off straight
REACH, ROUND = 44.0, 48.0
ALLOWED = 0.01
SIDES = "first: foundation_face, second: punch_face"


def profile(r):
    """Height of the lower face: flat, a quarter of a circle, a straight line to the side."""
    inside = np.clip(r - (RADIUS - EDGE), 0, ROUND - (RADIUS - EDGE))
    height = EDGE - np.sqrt(EDGE**2 - inside**2)
    return height + np.clip(r - ROUND, 0, None) / (RADIUS - ROUND) * (EDGE - height)


def columns(n_flat, n_round):
    """Radii of the nodes: finer towards the rounded edge, even up to the end of the contact, then a few more."""
    step = (REACH - (RADIUS - EDGE)) / n_round
    flat = RADIUS - EDGE - graded(step, 2, RADIUS - EDGE, 1 + 4 / n_flat)[::-1]
    return np.concatenate(
        [flat, np.linspace(RADIUS - EDGE, REACH, n_round + 1)[1:], np.linspace(REACH, RADIUS, 5)[1:]]
    )


def punch_on_foundation(element, n_punch, n_foundation):
    """Edges of the flat part of each body by their growth, and on the rounded one up to the end of the contact."""
    mesh = Mesh()
    for name, (n_flat, n_round) in (("foundation", n_foundation), ("punch", n_punch)):
        across = columns(n_flat, n_round)
        step, growth = (REACH - (RADIUS - EDGE)) / n_round, 1 + 4 / n_flat
        if name == "foundation":
            outside = graded(across[-1] - across[-2], 1, WIDE - RADIUS, growth)[1:]
            lines = [np.append(across, RADIUS + outside), -graded(step, 3, DEEP, growth)[::-1]]
            faces = {(1, 0): "base", (1, 1): "foundation_face", (0, 0): "axis"}
        else:
            lines = [across, graded(step, 3, HIGH, growth)]
            faces = {(1, 0): "punch_face", (1, 1): "top", (0, 0): "axis"}
        mesh.add_block(name, lines, LINEAR.get(element, element), faces)
    if element in QUADRATIC:
        mesh.make_quadratic(element)
    nodes = mesh.nodes_of("punch")
    r, z = mesh.coordinates[nodes, :2].T
    mesh.coordinates[nodes, 1] = z + profile(r) * (1 - z / HIGH)

    def is_kept(item):
        return not item[1].endswith("_face") or mesh.coordinates[item[2], 0].max() < REACH + 1e-6

    mesh.elements = [item for item in mesh.elements if is_kept(item)]
    return mesh


def solve_middle(signorom, folder, mesh, sides, direction="[0, 1]"):
    """Displacement of the foundation [mm] and pressure [MPa] in the middle of the contact."""
    mesh.write(folder / "punch.msh")
    deck = folder / "rounded_punch.yaml"
    deck.write_text(f"""units: {{length: mm, force: N}}
mesh: {{file: punch.msh, model: axisymmetric}}
parameters: {{load: {{min: 50, max: 100, unit: MPa}}}}
materials:
  steel: {{regions: [punch], young_modulus: 210.0e3, poisson_ratio: 0.3}}
  aluminum: {{regions: [foundation], young_modulus: 70.0e3, poisson_ratio: 0.3}}
boundary_conditions:
  - {{boundary: axis, displacement: {{r: 0}}}}
  - {{boundary: base, displacement: {{z: 0}}}}
loads: [{{boundary: top, pressure: load}}]
contact: [{{{sides}, direction: {direction}}}]
output: {{points: [{{load: 100}}]}}
""")
    said = signorom("solve", deck, folder=folder)
    assert ("mortar" in said) == ("mortar" in sides)
    fields = read_fields(folder / "results" / deck.stem / "fields.h5", 1)
    first = mesh.nodes_of(sides.split()[1].strip(","))
    below = mesh.nodes_of("foundation_face")
    at_first, at_below = (nodes[np.argmin(mesh.coordinates[nodes, 0])] for nodes in (first, below))
    closed = mesh.coordinates[first, 0][fields["contact_pressure"][first] > 0]
    # the contact ends on the rounded edge, before the surfaces do
    assert RADIUS - EDGE < closed.max() < REACH - 1
    return fields["displacement"][at_below, 1], fields["contact_pressure"][at_first]


@pytest.fixture(scope="module")
def converged(signorom, tmp_path_factory):
    """With half as many edges the displacement differs by 3e-4 and the pressure by 2e-3."""
    mesh = punch_on_foundation("Q4", (40, 32), (40, 32))
    return solve_middle(
        signorom, tmp_path_factory.mktemp("matching"), mesh, f"{SIDES}, formulation: node_to_node"
    )


@pytest.mark.parametrize("first", ["foundation_face", "punch_face"])
@pytest.mark.parametrize(
    ("element", "n_punch", "n_foundation"),
    [
        ("Q4", (20, 16), (15, 11)),
        ("Q4", (15, 11), (20, 16)),
        ("T3", (15, 11), (20, 16)),
        ("Q8", (10, 8), (8, 5)),
        ("Q8", (8, 5), (10, 8)),
        ("T6", (8, 5), (10, 8)),
    ],
)
def test_middle_of_the_contact(signorom, tmp_path, figures, converged, element, n_punch, n_foundation, first):
    mesh = punch_on_foundation(element, n_punch, n_foundation)
    sides = SIDES if first == "foundation_face" else "first: punch_face, second: foundation_face"
    direction = "[0, 1]" if sides == SIDES else "[0, -1]"
    found = solve_middle(signorom, tmp_path, mesh, f"{sides}, formulation: mortar", direction)
    problem = f"rounded punch, {element}, {n_punch[1]} facing {n_foundation[1]} edges, {first} first"
    source = "fine mesh, matching nodes"
    for name, value, reference, unit in zip(
        ("displacement in the middle", "pressure in the middle"), found, converged, ("mm", "MPa"), strict=True
    ):
        figures.compare(problem, name, value, reference, ALLOWED, source, unit)
