# SPDX-License-Identifier: BSD-3-Clause
"""Mortar contact whose first surface has faces of six or eight nodes, which take a changed basis: known answers."""

import subprocess

import numpy as np
import pytest

from block_meshes import LINEAR, QUADRATIC, SOLIDS_WITH, SOLIDS_WITHOUT, Mesh
from program import find_program
from runs import read_fields, read_snapshots, read_table
from spread import spread
from test_mortar_solid import DISTORTED, EXACT, FACES, SOLVERS, blocks, shrink, solve_patch

PATCH = "patch test in space, faces of six and eight nodes first"
STAMP = "stamp on a block, faces of six and eight nodes first"
SHRINK_FIT = "shrink fit in space, faces of six and eight nodes first"
CHECK = find_program().executable.parent / "tests" / "check_certificate"


def add_block(mesh, region, lines, element, faces, seed=0, moved=0.2):
    """A block of elements of any order; the nodes of several blocks are not shared."""
    before, mesh.elements = mesh.elements, []
    mesh.add_block(region, lines, LINEAR.get(element, element), faces, moved, seed)
    if element in QUADRATIC:
        mesh.make_quadratic(element)
    mesh.elements = before + mesh.elements


PAIRS = [
    (("T10", "H20"), ((7, 8), (2, 2))),
    (("T10", "H20"), ((2, 2), (7, 8))),
    (("T10", "T10"), ((3, 3), (5, 4))),
    (("H20", "H20"), ((3, 2), (5, 7))),
    (("T10", "H8"), ((2, 3), (7, 8))),
    (("T4", "H20"), ((5, 4), (2, 2))),
    (("T10", "H27"), ((3, 2), (4, 4))),
    (("W15", "P13"), ((4, 3), (2, 2))),
    (("W18", "P14"), ((2, 2), (3, 4))),
    ((SOLIDS_WITHOUT, "T10"), ((3, 2), (2, 3))),
    ((SOLIDS_WITH, SOLIDS_WITHOUT), ((2, 3), (3, 2))),
]


@pytest.mark.parametrize(("pair", "first"), spread(PAIRS, FACES))
def test_uniform_pressure(signorom, tmp_path, figures, pair, first):
    """Turned by 30 degrees, nu = 0, either side first: E U / H everywhere."""
    elements, sizes = pair
    said, errors = solve_patch(signorom, tmp_path, blocks(elements, sizes), first)
    assert f"100.0 % of '{first}' faces" in said
    figures.at_most(
        PATCH, f"{'/'.join(elements)} {sizes}, {first} first", max(errors.values()), EXACT, "uniform pressure"
    )


def test_matching_faces_need_no_word_of_the_deck(signorom, tmp_path, figures):
    """The same mesh above and below: pairs of nodes cannot take the faces, mortar does."""
    said, errors = solve_patch(signorom, tmp_path, blocks(("T10", "T10"), ((3, 2), (3, 2))), FACES[0])
    assert "mortar, because node-to-node contact cannot use faces of six or eight nodes" in said
    figures.at_most(PATCH, "matching T10", max(errors.values()), EXACT, "uniform pressure")


@pytest.mark.parametrize(("kinds", "first"), spread([("T10", "H20"), ("T10", "H27"), ("T10", "H8")], FACES))
def test_two_kinds_of_faces_on_one_surface(signorom, tmp_path, figures, kinds, first):
    """Tetrahedra beside hexahedra, which share the nodes of an edge; linear ones share none."""
    mesh = Mesh()
    heights = np.linspace(-1, 0, 3)
    across = np.linspace(0, 1, 5)
    for element, ends, n in zip(kinds, ((0, 0.45), (0.45, 1)), (2, 3), strict=True):
        lines = [np.linspace(*ends, n + 1), across, heights]
        add_block(mesh, "lower", lines, element, {(2, 1): "lower_face", (2, 0): "bottom"}, seed=n)
    if "H8" not in kinds:
        merge_nodes(mesh)
    lines = [np.linspace(0, 1, 6), np.linspace(0, 1, 4), heights + 1]
    mesh.add_block("upper", lines, "T4", {(2, 0): "upper_face", (2, 1): "top"}, 0.2, seed=9)
    _, errors = solve_patch(signorom, tmp_path, mesh, first)
    name = f"{kinds[0]} and {kinds[1]} beside each other, {first} first"
    figures.at_most(PATCH, name, max(errors.values()), EXACT, "uniform pressure")


def merge_nodes(mesh):
    """Nodes at one place become one."""
    _, kept, place = np.unique(np.round(mesh.coordinates, 9), axis=0, return_index=True, return_inverse=True)
    mesh.coordinates = mesh.coordinates[kept]
    place = place.ravel()
    mesh.elements = [
        (kind, name, [int(place[node]) for node in nodes]) for kind, name, nodes in mesh.elements
    ]


@pytest.mark.parametrize("first", FACES)
def test_distorted_faces(signorom, tmp_path, figures, first):
    """Faces of eight nodes that are no parallelograms: integration is not exact."""
    _, errors = solve_patch(signorom, tmp_path, blocks(("H20", "H20"), ((4, 3), (5, 6)), moved=0.25), first)
    for quantity in ("stress", "displacement", "pressure"):
        name = f"distorted H20, {first} first: {quantity}"
        figures.at_most(PATCH, name, errors[quantity], DISTORTED, "uniform pressure")


@pytest.mark.parametrize(("solver", "n_ranks"), spread([*SOLVERS, "active_set, linear: gamg"], [1, 2, 4]))
def test_solvers_and_ranks(signorom, tmp_path, figures, solver, n_ranks):
    """Tetrahedra first, hexahedra second, 1 to 4 ranks."""
    _, errors = solve_patch(
        signorom, tmp_path, blocks(("T10", "H20"), ((4, 3), (2, 3))), FACES[0], solver, n_ranks
    )
    allowed = DISTORTED if "gamg" in solver else EXACT
    figures.at_most(PATCH, f"{solver}, ranks: {n_ranks}", max(errors.values()), allowed, "uniform pressure")


def stamp(path, elements, unit="m"):
    """A smaller, turned stamp on a block."""
    mesh = Mesh()
    line = np.linspace(0, 1, 6)
    faces = {(2, 0): "bottom", (2, 1): FACES[0]}
    add_block(mesh, "lower", [line, line, np.linspace(-0.6, 0, 4)], elements[0], faces)
    n_lower = len(mesh.coordinates)
    lines = [np.linspace(-0.31, 0.27, 5), np.linspace(-0.2, 0.25, 4), np.linspace(0, 0.5, 3)]
    add_block(mesh, "upper", lines, elements[1], {(2, 0): FACES[1], (2, 1): "top"})
    cosine, sine = np.cos(0.4), np.sin(0.4)
    x = mesh.coordinates[n_lower:]
    x[:, :2] = x[:, :2] @ np.array([[cosine, sine], [-sine, cosine]]) + [0.52, 0.47]
    mesh.coordinates *= 1000 if unit == "mm" else 1
    mesh.write(path)
    return mesh


def stamp_deck(folder, first, rest, unit="m", is_driven=False):
    """A round, tilted gap; the stamp hangs on contact alone, or its top is moved."""
    size, force = (1000.0, 1e-6) if unit == "mm" else (1.0, 1.0)
    wave = f"press * (1 + tilt * (x / {size} - 0.5))"
    top = "{boundary: top, displacement: {x: 0, y: 0}}"
    loads = f'loads:\n  - {{boundary: top, traction: {{z: "-{wave}"}}}}\n'
    if is_driven:
        top = f'{{boundary: top, displacement: {{x: 0, y: 0, z: "-{size / force} * {wave} / 2e6"}}}}'
        loads = ""
    deck = folder / "stamp.yaml"
    deck.write_text(f"""title: Stamp
mesh: {{file: stamp.msh, model: solid}}
units: {{length: {unit}, force: N}}
parameters:
  press: {{min: {2000 * force}, max: {20000 * force}}}
  tilt: {{min: -2.0, max: 2.0}}
  shim: {{min: {-0.001 * size}, max: {0.001 * size}}}
materials:
  soft: {{regions: [upper], young_modulus: {1e6 * force}, poisson_ratio: 0.25}}
  stiff: {{regions: [lower], young_modulus: {2e6 * force}, poisson_ratio: 0.3}}
boundary_conditions:
  - {{boundary: bottom, displacement: {{x: 0, y: 0, z: 0}}}}
  - {top}
{loads}contact:
  - first: {first}
    second: {FACES[1 - FACES.index(first)]}
    initial_gap: "shim + 0.3 / {size} * ((x - {0.5 * size})^2 + (y - {0.5 * size})^2)"
output: {{points: [{{press: {10000 * force}, tilt: 0.5, shim: 0}}]}}
{rest}
""")
    return deck


def draw_points(folder, n, unit="m"):
    """A file of random points, the same in either unit."""
    size, force = (1000.0, 1e-6) if unit == "mm" else (1.0, 1.0)
    points = np.random.default_rng(5).uniform([2000, -2, -0.001], [20000, 2, 0.001], (n, 3)) * [
        force,
        1,
        size,
    ]
    lines = [",".join(map(repr, row)) for row in points.tolist()]
    (folder / "points.csv").write_text("\n".join(["press,tilt,shim", *lines, ""]))


def sampled(signorom, deck, n_ranks=1):
    """Forces of all snapshots."""
    signorom("sample", deck, folder=deck.parent, n_ranks=n_ranks)
    return read_snapshots(deck.parent / "results" / deck.stem / "snapshots.h5")["multipliers"]


def largest_difference(found, expected):
    """Over all points, relative."""
    return (np.linalg.norm(found - expected, axis=1) / np.linalg.norm(expected, axis=1)).max()


@pytest.mark.parametrize(("first", "is_driven"), spread(FACES, [False, True]))
def test_solvers_agree_where_parts_touch(signorom, tmp_path, figures, first, is_driven):
    """Nodes open and close one by one; of the block a quarter is covered. In m and mm, 1 to 4 ranks."""
    runs = {
        "condensed": ("type: condensed", 1, "m"),
        "active_set": ("type: active_set, linear: cholesky", 1, "m"),
    }
    runs |= {"multigrid": ("type: active_set, linear: gamg", 2, "m"), "mm": ("type: active_set", 4, "mm")}
    if is_driven:
        runs["snesvi"] = ("type: snesvi", 1, "m")
    found = {}
    for name, (solver, n_ranks, unit) in runs.items():
        folder = tmp_path / name
        folder.mkdir()
        stamp(folder / "stamp.msh", ("H20", "T10"), unit)
        draw_points(folder, 3, unit)
        rest = f"solver: {{{solver}}}\ntraining: {{file: points.csv}}"
        found[name] = sampled(signorom, stamp_deck(folder, first, rest, unit, is_driven), n_ranks)
    n_closed = (found["active_set"] > 0).sum(axis=1)
    assert n_closed.min() > 2
    assert n_closed.max() < found["active_set"].shape[1]
    for name in runs.keys() - {"active_set"}:
        worst = largest_difference(found[name], found["active_set"])
        figures.at_most(
            STAMP, f"{name}, {first} first, driven: {is_driven}", worst, 1e-9, "solver active_set"
        )


@pytest.mark.parametrize("first", FACES)
def test_forces_balance(signorom, tmp_path, figures, first):
    """One resultant, no moment, and the force on the stamp is the load: the surfaces touch in a plane."""
    mesh = stamp(tmp_path / "stamp.msh", ("T10", "H20"))
    signorom("solve", stamp_deck(tmp_path, first, ""), folder=tmp_path)
    forces = read_fields(tmp_path / "results" / "stamp" / "fields.h5")["contact_force"]
    size = np.abs(forces[mesh.nodes_of(FACES[0]), 2]).sum()
    figures.at_most(
        STAMP, f"resultant, {first} first", np.abs(forces.sum(axis=0)).max() / size, 1e-12, "balance"
    )
    moment = max(abs(mesh.coordinates[:, i] @ forces[:, 2]) for i in (0, 1)) / size
    figures.at_most(STAMP, f"moment, {first} first", moment, 1e-12, "balance")
    x = 0.52 + np.cos(0.4) * -0.02 - np.sin(0.4) * 0.025  # middle of the stamp
    load = 10000 * 0.58 * 0.45 * (1 + 0.5 * (x - 0.5))
    found = forces[mesh.nodes_of(FACES[1]), 2].sum()
    figures.compare(STAMP, f"force, {first} first", found, load, 1e-10, "the load", "N")


@pytest.mark.parametrize("first", [FACES[0], pytest.param(FACES[1], marks=pytest.mark.long)])
def test_reduced_models(signorom, tmp_path, figures, first):
    """The default model is exact; hyper-reduction has a hat per row, and its bound without W holds."""
    stamp(tmp_path / "stamp.msh", ("H20", "T10"))
    draw_points(tmp_path, 12)
    expected = sampled(
        signorom, stamp_deck(tmp_path, first, "solver: {type: active_set}\ntraining: {file: points.csv}")
    )
    (tmp_path / "results" / "stamp" / "snapshots.h5").unlink()
    deck = stamp_deck(tmp_path, first, "training: {sobol: 60}")
    signorom("sample", deck, folder=tmp_path)
    signorom("train", deck, folder=tmp_path)
    model = tmp_path / "results" / "stamp" / "model.h5"
    signorom("predict", model, "--points", "points.csv", "--output", "answers.csv", folder=tmp_path)
    answers = read_table(tmp_path / "answers.csv")
    assert set(answers["status"]) == {"answered"}
    found = np.column_stack([answers[name] for name in answers if name.startswith("lambda_")])
    figures.at_most(
        STAMP, f"default model, {first} first", largest_difference(found, expected), 1e-8, "solver active_set"
    )


@pytest.mark.parametrize("first", [pytest.param(FACES[0], marks=pytest.mark.long), FACES[1]])
def test_hyper_reduction_and_its_bound(signorom, tmp_path, first):
    """A hat per row; the lift moves corners with their mid-side nodes. Errors from the condensed model's W."""
    stamp(tmp_path / "stamp.msh", ("H20", "T10"))
    rest = "training: {sobol: 60}\nreduction: {method: hhr}\ncertificate: {max_error: 0.05}\n"
    deck = stamp_deck(tmp_path, first, rest, is_driven=True)
    signorom("sample", deck, folder=tmp_path)
    deck = stamp_deck(tmp_path, first, rest + "solver: {linear: gamg}", is_driven=True)
    said = signorom("train", deck, folder=tmp_path)
    assert "certificate without the matrix of all contacts" in said
    model = tmp_path / "results" / "stamp" / "model.h5"
    reduced = model.rename(tmp_path / "reduced.h5")
    deck = stamp_deck(
        tmp_path, first, "training: {sobol: 60}\nreduction: {method: condensed}", is_driven=True
    )
    signorom("train", deck, folder=tmp_path)
    done = subprocess.run([CHECK, reduced, "200", "3", model], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "one wrong status" in done.stdout


def rings(path, elements, n_around):
    """A quarter of two rings that meet at radius 1, nodes on the circles."""
    mesh = Mesh()
    for i, (name, radii) in enumerate((("inner", (0.5, 1.0)), ("outer", (1.0, 1.5)))):
        sides = {(0, 1 - i): f"{name}_face", (1, 0): "on_x", (1, 1): "on_y", (2, 0): "ends", (2, 1): "ends"}
        lines = [
            np.linspace(*radii, 6),
            np.linspace(0, np.pi / 2, n_around[i] + 1),
            np.linspace(0, 0.4, 3 + i),
        ]
        add_block(mesh, name, lines, elements[i], sides, moved=0.0)
    r, angle = mesh.coordinates[:, 0].copy(), mesh.coordinates[:, 1].copy()
    mesh.coordinates[:, 0], mesh.coordinates[:, 1] = r * np.cos(angle), r * np.sin(angle)
    mesh.write(path)
    return mesh


@pytest.mark.parametrize(
    ("elements", "first"),
    spread([("T10", "H20"), ("H20", "H20"), ("T10", "T10")], ["inner_face", "outer_face"]),
)
def test_shrink_fit(signorom, tmp_path, figures, elements, first):
    """Lame's pressure, whichever side comes first."""
    mesh = rings(tmp_path / "rings.msh", elements, (12, 17))
    found, pressure = shrink(signorom, tmp_path, mesh, first)
    name = f"{'/'.join(elements)}, {first} first"
    figures.compare(SHRINK_FIT, f"mean pressure, {name}", found.mean(), pressure, 1e-3, "Lamé", "Pa")
    figures.at_most(
        SHRINK_FIT, f"spread of pressure, {name}", np.ptp(found) / pressure, 0.01, "axial symmetry"
    )
