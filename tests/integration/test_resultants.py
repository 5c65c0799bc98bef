# SPDX-License-Identifier: BSD-3-Clause
"""Area, resultant force and moment of each contact: those of a uniform pressure, alike in report, CSV, C and Python.

The surfaces in contact.xdmf show that pressure.
"""

from dataclasses import dataclass

import h5py
import numpy as np
import pytest
import yaml

from block_meshes import Mesh
from c_programs import compile_c, run_c
from results import read_table
from vtk_fields import read_with_vtk

# [-] uniform stress is in the span of the elements: rounding, and what the solvers leave
EXACT = 1e-9
# [-] the same multipliers, other orders of sums
SAME = 1e-12
# [Pa, m] of the deck
YOUNG_MODULUS, STROKE = 2.0e6, 0.1


@dataclass
class Case:
    """Blocks of 1 m by 1 m (by 1 m) on top of each other, turned and moved."""

    model: str
    n_blocks: int = 2
    #: [m] where the corner of the lowest block is
    place: tuple = (2.0, 5.0, 3.0)
    #: in the plane of the last two coordinates
    angle: float = 0.0
    unit: str = "m"
    #: edges of the lowest block, and of those above
    edges: tuple = (3, 3)
    method: str = "condensed"
    n_ranks: int = 1


CASES = {
    "turned, nodes that do not match": Case("plane_strain", angle=np.pi / 6, edges=(4, 7)),
    "axisymmetric in mm": Case("axisymmetric", unit="mm", place=(0.5, 2.0, 0.0), n_ranks=2),
    "turned in space": Case("solid", angle=np.pi / 6, method="hhr", n_ranks=3),
    "two contacts in mm": Case("plane_stress", n_blocks=3, unit="mm", method="hhr", n_ranks=4),
}


def turn(case):
    """Rotation matrix of the case, and its dimension."""
    n_dim = 3 if case.model == "solid" else 2
    c, s = np.cos(case.angle), np.sin(case.angle)
    turned = np.eye(3)
    turned[n_dim - 2 : n_dim, n_dim - 2 : n_dim] = [[c, -s], [s, c]]
    return turned, n_dim


def write_mesh(case, path):
    """Blocks with the faces below_<i>, above_<i> and left_<i>, in meters."""
    turned, n_dim = turn(case)
    mesh = Mesh()
    for i in range(case.n_blocks):
        across = np.linspace(0, 1, case.edges[min(i, 1)] + 1) ** 1.2
        height = np.linspace(i, i + 1, 3)
        faces = {(n_dim - 1, 0): f"below_{i}", (n_dim - 1, 1): f"above_{i}", (0, 0): f"left_{i}"}
        mesh.add_block(f"block_{i}", [across] * (n_dim - 1) + [height], {2: "T3", 3: "H8"}[n_dim], faces)
    place = np.array(case.place)
    place[n_dim:] = 0
    mesh.coordinates = mesh.coordinates @ turned.T + place
    mesh.write(path)


def write_deck(case, folder):
    """Pressed by `stroke`, which must be positive; the second contact has the upper block first."""
    turned, n_dim = turn(case)
    write_mesh(case, folder / "blocks.msh")
    size = {"m": 1.0, "mm": 1e3}[case.unit]
    axes = {"axisymmetric": "rz", "solid": "xyz"}.get(case.model, "xy")
    down = "stroke * sqrt(stroke) / sqrt(stroke)"
    held = ", ".join(f"{axis}: 0" for axis in axes)
    pressed = ", ".join(
        f"{axis}: {-x:.17g} * {down}" for axis, x in zip(axes, turned[:, n_dim - 1], strict=False)
    )
    middle = "".join(
        f"\n  - {{boundary: left_{i}, displacement: {{x: 0}}}}" for i in range(1, case.n_blocks - 1)
    )
    second = "\n  - {first: below_2, second: above_1}" if case.n_blocks > 2 else ""
    regions = ", ".join(f"block_{i}" for i in range(case.n_blocks))
    deck = folder / "blocks.yaml"
    deck.write_text(f"""title: Blocks
units: {{length: {case.unit}, force: N}}
mesh: {{file: blocks.msh, model: {case.model}, length_unit: m}}
parameters: {{stroke: {{min: {0.5 * STROKE * size}, max: {STROKE * size}, unit: {case.unit}}}}}
materials: {{block: {{regions: [{regions}], young_modulus: {YOUNG_MODULUS / size**2}, poisson_ratio: 0.0}}}}
boundary_conditions:
  - {{boundary: below_0, displacement: {{{held}}}}}
  - {{boundary: above_{case.n_blocks - 1}, displacement: {{{pressed}}}}}{middle}
contact:
  - {{first: above_0, second: below_1}}{second}
training: {{grid: {{stroke: 3}}}}
test: {{grid: {{stroke: 2}}}}
reduction: {{method: {case.method}}}
output: {{points: [{{stroke: {STROKE * size}}}]}}
""")
    return deck


def expected(case):
    """Areas, forces, moments of all contacts at the largest stroke, in the units of the deck.

    nu = 0: p = E stroke / height. F = -p A n on the first surface and M = c x F, c the centroid; in axisymmetry
    A = pi (r1^2 - r0^2), F = (0, -p A) and r F_z sums up to -p 2 pi (r1^3 - r0^3) / 3.
    """
    turned, n_dim = turn(case)
    size = {"m": 1.0, "mm": 1e3}[case.unit]
    pressure = YOUNG_MODULUS / size**2 * STROKE / case.n_blocks
    areas, forces, moments = [], [], []
    for i in range(case.n_blocks - 1):
        centroid = [0.5] * (n_dim - 1) + [i + 1] + [0] * (3 - n_dim)
        centroid = (np.array(case.place[:n_dim]) + (turned @ centroid)[:n_dim]) * size
        if case.model == "axisymmetric":
            r = size * np.array([case.place[0], case.place[0] + 1])
            area = np.pi * (r[1] ** 2 - r[0] ** 2)
            force = np.array([0, -pressure * area])
            moment = [-pressure * 2 * np.pi * (r[1] ** 3 - r[0] ** 3) / 3]
        else:
            area = size ** (n_dim - 1)
            force = -pressure * area * turned[:n_dim, n_dim - 1] * (1 if i == 0 else -1)
            moment = (
                np.cross(centroid, force) if n_dim == 3 else [centroid[0] * force[1] - centroid[1] * force[0]]
            )
        areas.append(area)
        forces.append(force)
        moments.append(moment)
    return np.array(areas), np.array(forces), np.array(moments)


def columns(case):
    """Names of the columns of predict, contact by contact."""
    axes = {"axisymmetric": "rz", "solid": "xyz"}.get(case.model, "xy")
    moments = [f"_moment_{axis}" for axis in axes] if case.model == "solid" else ["_moment"]
    names = ["_area", *(f"_force_{axis}" for axis in axes), *moments]
    return [[f"contact_{i + 1}{name}" for name in names] for i in range(case.n_blocks - 1)]


def assert_close(found, wanted, tolerance):
    """Of each kind of quantity relative to its largest component."""
    for values, known in zip(found, wanted, strict=True):
        np.testing.assert_allclose(values, known, rtol=0, atol=tolerance * np.abs(known).max())


def together(areas, forces, moments):
    """A row per contact as in the tables."""
    return np.column_stack([areas, forces, moments])


def check_surfaces(results, case, known):
    """Facets of the first surfaces with uniform pressure; their forces add up to those of the contacts."""
    size = {"m": 1.0, "mm": 1e3}[case.unit]
    pressure = YOUNG_MODULUS / size**2 * STROKE / case.n_blocks
    (shown,) = read_with_vtk(results / "contact.xdmf").values()
    with h5py.File(results / "contact.h5") as file:
        topology = file["mesh/topology"][()]
    edges = [case.edges[min(i, 1)] for i in (0, 2)[: case.n_blocks - 1]]
    n_cells = [n**2 if case.model == "solid" else n for n in edges]
    contact = shown.cells["contact"]
    assert [(contact == i + 1).sum() for i in range(case.n_blocks - 1)] == n_cells
    assert len(contact) == shown.n_cells == sum(n_cells)
    for name in ("contact_pressure", "contact_pressure_reduced"):
        np.testing.assert_allclose(shown.nodes[name], pressure, rtol=EXACT)
    np.testing.assert_array_equal(shown.nodes["status"], 2)
    np.testing.assert_allclose(shown.nodes["gap"], 0, atol=EXACT * STROKE * size)
    n_dim = known[1].shape[1]
    for name in ("contact_force", "contact_force_reduced"):
        forces = [
            shown.nodes[name][np.unique(topology[contact == i + 1])].sum(axis=0)
            for i in range(case.n_blocks - 1)
        ]
        assert_close([np.array(forces)[:, :n_dim]], [known[1]], EXACT)


@pytest.mark.parametrize("name", CASES)
def test_pressed_blocks(signorom, library, post, tmp_path, name):
    case = CASES[name]
    deck = write_deck(case, tmp_path)
    signorom("run", deck, folder=tmp_path, n_ranks=case.n_ranks)
    known = expected(case)
    report = yaml.safe_load((tmp_path / "results/blocks/report.yaml").read_text())
    contacts = report["points"]["1"]["contacts"].values()
    told = [np.array([contact[key] for contact in contacts]) for key in ("area", "force", "moment")]
    assert_close(told, known, EXACT)
    # the surfaces touch
    for contact, force in zip(contacts, known[1], strict=True):
        arm = np.linalg.norm(case.place) * (1 if case.unit == "m" else 1e3)
        assert np.abs(contact["moment_imbalance"]).max() <= EXACT * arm * np.abs(force).max()
    names = ["above_0 - below_1", "below_2 - above_1"][: case.n_blocks - 1]
    assert [contact["surfaces"] for contact in contacts] == names
    length = {"m": "m", "mm": "mm"}[case.unit]
    is_plane = case.model in ("plane_strain", "plane_stress")
    assert report["units"]["contact_area"] == (length if is_plane else f"{length}2")
    assert report["units"]["moment"] == f"N*{length}" + (f"/{length}" if is_plane else "")

    check_surfaces(tmp_path / "results/blocks", case, known)

    stroke = STROKE * (1 if case.unit == "m" else 1e3)
    (tmp_path / "points.csv").write_text(f"stroke\n{stroke}\n{-stroke}\n")
    model = tmp_path / "results/blocks/model.h5"
    arguments = ("predict", model, "--points", tmp_path / "points.csv", "--output", tmp_path / "answers.csv")
    done = signorom.run(*arguments, folder=tmp_path)
    assert done.returncode == 3, done.stderr
    table = read_table(tmp_path / "answers.csv")
    rows = np.array([[table[column] for column in group] for group in columns(case)])
    assert_close([rows[:, :1, 0], rows[:, 1:, 0]], [together(*known)[:, :1], together(*known)[:, 1:]], EXACT)
    assert np.isnan(rows[:, :, 1]).all()

    with post.Model(model) as asked:
        answer = asked.query(stroke=stroke)
        assert asked.contact_names == names
        assert asked.contact_entries.tolist() == sorted(asked.contact_entries)
        assert set(asked.contact_entries) == set(range(case.n_blocks - 1))
        with pytest.warns(post.ExtrapolationWarning, match="at 1 of 2 points: stroke"):
            answers = asked.query_many(np.array([[stroke], [-stroke]]))
        many = answers.resultants
        assert answers.has_answer.tolist() == [True, False]
        for name in ("areas", "forces", "moments"):
            summed = getattr(asked.resultants(answers.multipliers), name)
            np.testing.assert_array_equal(getattr(many, name), summed)
    found = answer.resultants
    np.testing.assert_allclose(together(found.areas, found.forces, found.moments), rows[:, :, 0], rtol=SAME)
    np.testing.assert_array_equal(many.forces[0], found.forces)
    for values in (many.areas, many.forces, many.moments):
        assert np.isnan(values[1]).all()

    done = run_c(compile_c("tell_resultants", library, tmp_path), model, stroke)
    assert done.returncode == 0, done.stderr
    lines = [line.split(": ") for line in done.stdout.splitlines()]
    assert [line[0] for line in lines] == names
    np.testing.assert_array_equal(
        [[float(value) for value in line[1].split()] for line in lines],
        together(found.areas, found.forces, found.moments),
    )


@pytest.mark.parametrize("n_dim", [2, 3])
def test_pairs_aside_leave_a_moment(signorom, tmp_path, n_dim):
    """Pairs of nodes 0.02 aside, nu = 0: p = E stroke / 2 on both faces, and both forces make the couple 0.02 p A.

    The force on the upper block, p A upwards, stands to the right: about z in the plane, about -y in space.
    """
    aside, mesh = 0.02, Mesh()
    for name, start, floor, side in (("lower", 0.0, -1.0, 1), ("upper", aside, 0.0, 0)):
        faces = {(n_dim - 1, side): f"{name}_face", (n_dim - 1, 1 - side): "bottom" if side else "top"}
        lines = [np.linspace(0, 1, 4)] * (n_dim - 1) + [np.linspace(floor, floor + 1, 3)]
        lines[0] = lines[0] + start
        mesh.add_block(name, lines, {2: "Q4", 3: "H8"}[n_dim], faces)
    mesh.write(tmp_path / "blocks.msh")
    held = {2: "x: 0, y: 0", 3: "x: 0, y: 0, z: 0"}[n_dim]
    deck = tmp_path / "aside.yaml"
    deck.write_text(f"""mesh: {{file: blocks.msh, model: {"plane_strain" if n_dim == 2 else "solid"}}}
parameters: {{stroke: {{min: 0.05, max: {STROKE}}}}}
materials: {{block: {{regions: [lower, upper], young_modulus: {YOUNG_MODULUS}, poisson_ratio: 0}}}}
boundary_conditions:
  - {{boundary: bottom, displacement: {{{held}}}}}
  - {{boundary: top, displacement: {{{held[:-1]}-stroke}}}}
contact:
  - {{first: lower_face, second: upper_face, direction: {[0] * (n_dim - 1) + [1]}, pairing_tolerance: 0.1}}
training: {{grid: {{stroke: 2}}}}
output: {{points: [{{stroke: {STROKE}}}]}}
""")
    signorom("run", deck, folder=tmp_path)
    couple = aside * YOUNG_MODULUS * STROKE / 2
    known = np.array([couple] if n_dim == 2 else [0, -couple, 0])
    report = yaml.safe_load((tmp_path / "results/aside/report.yaml").read_text())
    assert_close([np.array(report["points"]["1"]["contacts"]["1"]["moment_imbalance"])], [known], EXACT)
    model = tmp_path / "results/aside/model.h5"
    (tmp_path / "points.csv").write_text(f"stroke\n{STROKE}\n")
    signorom("predict", model, "--points", "points.csv", "--output", "answers.csv", folder=tmp_path)
    table = read_table(tmp_path / "answers.csv")
    names = [""] if n_dim == 2 else ["_x", "_y", "_z"]
    told = np.array([table[f"contact_1_moment_imbalance{name}"][0] for name in names])
    assert_close([told], [known], EXACT)
