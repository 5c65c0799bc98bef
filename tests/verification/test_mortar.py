# SPDX-License-Identifier: BSD-3-Clause
"""Contact of surfaces whose nodes do not match, in the plane and in axisymmetry: dual mortar against known answers."""

import re
from itertools import product

import numpy as np
import pytest

import shrink_fit
from block_meshes import LINEAR, QUADRATIC, Mesh, consistent_areas
from gmsh_mesh import make_mesh
from runs import MESHES, read_fields, read_snapshots, write_deck, write_deck_with, write_input
from spread import spread

TOLERANCE = 1e-10
YOUNG_MODULUS = 2.0e6
HEIGHT = 2.0
STROKE = 0.1
PATCH = "patch test, nodes that do not match"
SOLVERS = ("condensed", "active_set", "snesvi")
FACES = ("lower_face", "upper_face")
CONTACT = "first: lower_face, second: upper_face"


def blocks(path, n_lower, n_upper, element="T3", angle=0.0):
    """Two blocks, 1 wide and 1 high each, that meet at height 0 with different edges, turned by an angle."""
    mesh = Mesh()
    for name, n, floor, face in (("lower", n_lower, -1.0, 1), ("upper", n_upper, 0.0, 0)):
        # unequal edges
        across = np.linspace(0, 1, n + 1) ** 1.2
        linear = LINEAR.get(element, element)
        sides = {(1, face): f"{name}_face", (1, 1 - face): "bottom" if face else "top", (0, 0): "left"}
        mesh.add_block(name, [across, np.linspace(floor, floor + 1, 4)], linear, sides, 0.2, seed=n)
    if element in QUADRATIC:
        mesh.make_quadratic(element)
    turned = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    mesh.coordinates[:, :2] = mesh.coordinates[:, :2] @ turned.T
    mesh.write(path)
    return mesh


def patch_deck(folder, model, supports, contact=CONTACT, solver="condensed"):
    """The deck of the patch tests with nodes that need not match."""
    entries = "".join(f"\n  - {{boundary: {name}, displacement: {{{values}}}}}" for name, values in supports)
    return write_deck_with(
        "patch_models",
        folder,
        {
            "model: plane_strain": f"model: {model}",
            "boundary_conditions: []": f"boundary_conditions:{entries}",
            f"{CONTACT}, direction: [0, 1]": contact,
            "solver: {type: condensed}": f"solver: {{type: {solver}}}\ntraining: {{grid: {{stroke: 2}}}}",
        },
    )


def change_basis_on_axis(mesh, name, areas):
    """An edge of three nodes that ends on the axis: each end takes a fifth of the middle, N + N_mid / 5."""
    for nodes in mesh.facets_of(name):
        if len(nodes) == 3 and np.abs(mesh.coordinates[nodes, 0]).min() < TOLERANCE:
            areas[nodes[:2]] += areas[nodes[2]] / 5
            areas[nodes[2]] *= 3 / 5


def largest_error(mesh, snapshots, name, pressure, is_round=False):
    """Of the forces on the nodes of the first surface against a uniform pressure; a node without force has no row."""
    nodes = mesh.nodes_of(name)
    areas = consistent_areas(mesh, name, is_round)
    if is_round:
        change_basis_on_axis(mesh, name, areas)
    expected = pressure * areas[nodes]
    expected = expected[expected > TOLERANCE * expected.max()]
    return np.abs(snapshots["multipliers"][-1] - expected).max() / expected.max()


MODELS = ["plane_strain", "axisymmetric"]
ELEMENTS = ["T3", "Q4", "T6", "Q8", "Q9"]


@pytest.mark.parametrize(
    ("case", "sizes"), spread(list(product(MODELS, ELEMENTS)), [(4, 7), (7, 4), (3, 11)])
)
def test_uniform_pressure(signorom, tmp_path, figures, case, sizes):
    """nu = 0: E U / H everywhere; forces by the areas of the first surface's nodes, displacements linear."""
    model, element = case
    up, across = ("z", "r") if model == "axisymmetric" else ("y", "x")
    mesh = blocks(tmp_path / "blocks.msh", *sizes, element)
    supports = [("bottom", f"{across}: 0, {up}: 0"), ("top", f"{across}: 0, {up}: -stroke")]
    deck = patch_deck(tmp_path, model, supports)
    said = signorom("sample", deck, folder=tmp_path)
    assert "mortar, because node-to-node contact cannot pair the nodes of both surfaces: 100.0 % of" in said
    snapshots = read_snapshots(tmp_path / "results" / deck.stem / "snapshots.h5")
    pressure = YOUNG_MODULUS * STROKE / HEIGHT
    worst = largest_error(mesh, snapshots, "lower_face", pressure, model == "axisymmetric")
    figures.at_most(PATCH, f"forces, {model}, {element}, {sizes}", worst, TOLERANCE, "uniform pressure")


@pytest.mark.parametrize(("first", "solver", "n_ranks"), spread(FACES, SOLVERS, [1, 3]))
def test_turned_blocks(signorom, tmp_path, figures, first, solver, n_ranks):
    """Turned by 30 degrees, either side as the first one, every solver."""
    mesh = blocks(tmp_path / "blocks.msh", 4, 9, angle=np.pi / 6)
    down = f"x: {np.sin(np.pi / 6):.17g} * stroke, y: -{np.cos(np.pi / 6):.17g} * stroke"
    second = FACES[1 - FACES.index(first)]
    supports = [("bottom", "x: 0, y: 0"), ("top", down)]
    deck = patch_deck(tmp_path, "plane_strain", supports, f"first: {first}, second: {second}", solver)
    signorom("sample", deck, folder=tmp_path, n_ranks=n_ranks)
    snapshots = read_snapshots(tmp_path / "results" / deck.stem / "snapshots.h5")
    worst = largest_error(mesh, snapshots, first, YOUNG_MODULUS * STROKE / HEIGHT)
    quantity = f"forces, turned, {first} first, {solver}, ranks: {n_ranks}"
    figures.at_most(PATCH, quantity, worst, TOLERANCE, "uniform pressure")


@pytest.mark.parametrize("first", FACES)
@pytest.mark.parametrize("gap", ["", ", initial_gap: 0"])
@pytest.mark.parametrize(("case", "sizes"), spread(list(product(MODELS, ELEMENTS)), [(4, 7), (3, 11)]))
def test_uniform_stress(signorom, tmp_path, figures, case, sizes, gap, first):
    """Stress of every cell, pressure and displacement of every node; in the plane turned by 30 degrees."""
    model, element = case
    angle = np.pi / 6 if model == "plane_strain" else 0.0
    up = np.array([-np.sin(angle), np.cos(angle)])
    mesh = blocks(tmp_path / "blocks.msh", *sizes, element, angle)
    across, along = ("r", "z") if model == "axisymmetric" else ("x", "y")
    down = f"{across}: {-up[0]:.17g} * stroke, {along}: {-up[1]:.17g} * stroke"
    supports = [("bottom", f"{across}: 0, {along}: 0"), ("top", down)]
    second = FACES[1 - FACES.index(first)]
    deck = patch_deck(tmp_path, model, supports, f"first: {first}, second: {second}{gap}")
    signorom("solve", deck, folder=tmp_path)
    fields = read_fields(tmp_path / "results" / deck.stem / "fields.h5")
    pressure = YOUNG_MODULUS * STROKE / HEIGHT
    # xx, yy, zz and xy come first
    stress = (
        -pressure * np.array([up[0] ** 2, up[1] ** 2, 0, up[0] * up[1], 0, 0])[: fields["stress"].shape[1]]
    )
    moved = -STROKE / HEIGHT * (mesh.coordinates[:, :2] @ up + 1)[:, None] * up
    found = fields["contact_pressure"][mesh.nodes_of(first)]
    worst = max(
        np.abs(fields["stress"] - stress).max() / pressure,
        np.nanmax(np.abs(found / pressure - 1)),
        np.abs(fields["displacement"][:, :2] - moved).max() / STROKE,
    )
    name = f"stress, {model}, {element}, {sizes}, {first} first{gap}"
    figures.at_most(PATCH, name, worst, TOLERANCE, "uniform stress")


@pytest.mark.parametrize("first", FACES)
@pytest.mark.parametrize("elements", [("T6", "Q4"), ("Q8", "T6")])
def test_quadratic_edges_turned(signorom, tmp_path, figures, elements, first):
    """Quadratic elements on linear ones and on each other, turned by 30 degrees, either side as the first one."""
    mesh = Mesh()
    for name, element, n, floor in zip(("lower", "upper"), elements, (4, 7), (-1.0, 0.0), strict=True):
        sides = {(1, int(floor < 0)): f"{name}_face", (1, int(floor == 0)): "top" if floor == 0 else "bottom"}
        line = np.linspace(0, 1, n + 1) ** 1.2
        linear = LINEAR.get(element, element)
        mesh.add_block(name, [line, np.linspace(floor, floor + 1, 4)], linear, sides, 0.2, seed=n)
        if element in QUADRATIC:
            mesh.make_quadratic(element, [name, *sides.values()])
    cosine, sine = np.cos(np.pi / 6), np.sin(np.pi / 6)
    mesh.coordinates[:, :2] = mesh.coordinates[:, :2] @ np.array([[cosine, sine], [-sine, cosine]])
    mesh.write(tmp_path / "blocks.msh")
    second = FACES[1 - FACES.index(first)]
    supports = [("bottom", "x: 0, y: 0"), ("top", f"x: {sine:.17g} * stroke, y: -{cosine:.17g} * stroke")]
    deck = patch_deck(tmp_path, "plane_strain", supports, f"first: {first}, second: {second}")
    signorom("sample", deck, folder=tmp_path)
    snapshots = read_snapshots(tmp_path / "results" / deck.stem / "snapshots.h5")
    worst = largest_error(mesh, snapshots, first, YOUNG_MODULUS * STROKE / HEIGHT)
    figures.at_most(
        PATCH, f"forces, turned, {'/'.join(elements)}, {first} first", worst, TOLERANCE, "uniform pressure"
    )


@pytest.mark.parametrize("first", ["inner_face", "outer_face"])
def test_shrink_fit_on_curved_edges(signorom, tmp_path, figures, first):
    """A quarter of two rings of Q8, 8 edges facing 13, nodes on the circles: Lame's pressure in plane strain."""
    mesh = Mesh()
    for name, radii, n, side in (("inner", (0.5, 1.0), 8, 1), ("outer", (1.0, 1.5), 13, 0)):
        lines = [np.linspace(*radii, 7), np.linspace(0, np.pi / 2, n + 1)]
        mesh.add_block(name, lines, "Q4", {(0, side): f"{name}_face", (1, 0): "on_x", (1, 1): "on_y"})
    mesh.make_quadratic("Q8")
    r, angle = mesh.coordinates[:, 0].copy(), mesh.coordinates[:, 1].copy()
    mesh.coordinates[:, 0], mesh.coordinates[:, 1] = r * np.cos(angle), r * np.sin(angle)
    mesh.write(tmp_path / "blocks.msh")
    second = {"inner_face": "outer_face", "outer_face": "inner_face"}[first]
    supports = [("on_x", "y: 0"), ("on_y", "x: 0")]
    deck = patch_deck(
        tmp_path, "plane_strain", supports, f'first: {first}, second: {second}, initial_gap: "-stroke / 100"'
    )
    text = deck.read_text().replace("[lower, upper]", "[inner, outer]").replace("ratio: 0.0", "ratio: 0.3")
    deck.write_text(text)
    signorom("solve", deck, folder=tmp_path)
    fields = read_fields(tmp_path / "results" / deck.stem / "fields.h5")
    # Lame: delta / r = p / E' (compliance of both rings), E' = E / (1 - nu^2)
    compliance = (1.5**2 + 1) / (1.5**2 - 1) + (1 + 0.5**2) / (1 - 0.5**2)
    pressure = STROKE / 100 * YOUNG_MODULUS / (1 - 0.3**2) / compliance
    nodes = mesh.nodes_of(first)
    # along x, on the radius 1
    force = abs(fields["contact_force"][nodes, 0].sum())
    worst = np.abs(fields["contact_pressure"][nodes] / pressure - 1).max()
    problem = "shrink fit, curved edges of Q8"
    figures.compare(problem, f"force, {first} first", force, pressure, 2e-5, "Lamé", "N/m")
    figures.at_most(problem, f"pressure at nodes, {first} first", worst, 5e-3, "Lamé")


def test_quadratic_stamp_that_covers_a_part(signorom, tmp_path, figures):
    """T6 on Q8, the wider block first: edges covered by any part, none of its shares is huge, forces balance."""
    problem = "stamp on a block, quadratic edges"
    for step in range(5):
        folder = tmp_path / str(step)
        folder.mkdir()
        mesh = Mesh()
        wide, narrow = np.linspace(0, 2, 9), np.linspace(0.37, 1.3 + 0.05 * step, 9)
        mesh.add_block("lower", [wide, np.linspace(-1, 0, 4)], "Q4", {(1, 0): "bottom", (1, 1): "lower_face"})
        mesh.make_quadratic("Q8")
        mesh.add_block(
            "upper", [narrow, np.linspace(0, 1, 4)], "T3", {(1, 0): "upper_face", (1, 1): "top"}, 0.2, 2
        )
        mesh.make_quadratic("T6", ["upper", "upper_face", "top"])
        mesh.write(folder / "blocks.msh")
        deck = patch_deck(folder, "plane_strain", [("bottom", "x: 0, y: 0"), ("top", "x: 0, y: -stroke")])
        said = signorom("solve", deck, folder=folder)
        told = re.search(r"shares of up to (\S+?)[;\s]", said)
        assert told
        fields = read_fields(folder / "results" / deck.stem / "fields.h5")
        forces = fields["contact_force"][:, :2]
        size = np.abs(forces[mesh.nodes_of("lower_face"), 1]).sum()
        left_over = np.abs(forces.sum(axis=0)).max() / size
        moment = abs(mesh.coordinates[:, 0] @ forces[:, 1]) / size
        figures.at_most(problem, f"largest share, {step}", float(told[1]), 100.0, "its limit")
        figures.at_most(problem, f"resultant, {step}", left_over, 1e-12, "equilibrium")
        figures.at_most(problem, f"moment, {step}", moment, 1e-11, "equilibrium")


def test_matching_nodes_give_pairs(signorom, tmp_path, figures):
    """On flat faces with matching nodes mortar is node-to-node contact."""
    found = {}
    for formulation in ("node_to_node", "mortar"):
        folder = tmp_path / formulation
        folder.mkdir()
        entry = f"direction: [0, 1], formulation: {formulation}"
        deck = write_deck("patch", folder, **{"direction: [0, 1]": entry})
        signorom("sample", deck, folder=folder)
        found[formulation] = read_snapshots(folder / "results" / "patch" / "snapshots.h5")["multipliers"]
    pairs = found["node_to_node"]
    worst = np.abs(found["mortar"] - pairs).max() / np.abs(pairs).max()
    figures.at_most("matching nodes", "forces of mortar", worst, 1e-12, "node_to_node")


def test_forces_balance_where_a_part_is_covered(signorom, tmp_path, figures):
    """A narrow stamp on a wide block: the forces on both sides have one resultant, and no moment is left."""
    mesh = Mesh()
    wide, narrow = np.linspace(0, 2, 15), np.linspace(0.37, 1.41, 9)
    mesh.add_block(
        "lower", [wide, np.linspace(-1, 0, 6)], "Q4", {(1, 0): "bottom", (1, 1): "lower_face"}, 0.2, 1
    )
    mesh.add_block(
        "upper", [narrow, np.linspace(0, 1, 6)], "Q4", {(1, 0): "upper_face", (1, 1): "top"}, 0.2, 2
    )
    mesh.write(tmp_path / "blocks.msh")
    supports = [("bottom", "x: 0, y: 0"), ("top", "x: 0, y: -stroke")]
    deck = patch_deck(tmp_path, "plane_strain", supports)
    deck.write_text(f"{deck.read_text()}reduction: {{method: hhr}}\n")
    said = signorom("sample", deck, folder=tmp_path)
    share = 100 * (narrow[-1] - narrow[0]) / 2
    told = re.search(r"both surfaces: (\S+) % of 'lower_face' faces 'upper_face'", said)
    assert told
    assert float(told[1]) == pytest.approx(share, rel=1e-5)
    signorom("solve", deck, folder=tmp_path)
    fields = read_fields(tmp_path / "results" / deck.stem / "fields.h5")
    forces = fields["contact_force"][:, :2]
    lower, upper = mesh.nodes_of("lower_face"), mesh.nodes_of("upper_face")
    size = np.abs(forces[lower, 1]).sum()
    assert size > 0
    x = mesh.coordinates[:, 0]
    left_over = np.abs(forces[lower].sum(axis=0) + forces[upper].sum(axis=0)).max() / size
    moment = abs((x * forces[:, 1])[lower].sum() + (x * forces[:, 1])[upper].sum()) / size
    figures.at_most("stamp on a block", "resultant of both sides", left_over, 1e-12, "equilibrium")
    figures.at_most("stamp on a block", "moment of both sides", moment, 1e-12, "equilibrium")


@pytest.mark.parametrize("first", ["inner_face", "outer_face"])
def test_shrink_fit(signorom, tmp_path, figures, first):
    """Edges of 1 to 2.3: Lame's pressure whichever side comes first."""
    source = (MESHES / "shrink_fit.geo").read_text()
    old = "Transfinite Curve {first + 1, first + 3} = n_axial + 1;"
    assert source.count(old) == 1
    (tmp_path / "rings.geo").write_text(source.replace(old, old.replace("n_axial", "n_axial + 4 * ring")))
    make_mesh(tmp_path / "rings.geo", tmp_path / "rings.msh")
    second = {"inner_face": "outer_face", "outer_face": "inner_face"}[first]
    old = "first: inner_face, second: outer_face, direction: [1, 0]"
    deck = write_input("shrink_fit", tmp_path, {old: f"first: {first}, second: {second}"})
    deck.write_text(deck.read_text().replace(str(MESHES / "shrink_fit.msh"), str(tmp_path / "rings.msh")))
    signorom("sample", deck, folder=tmp_path)
    forces = read_snapshots(tmp_path / "results" / "shrink_fit" / "snapshots.h5")["multipliers"][0]
    expected = shrink_fit.pressure("held") * 2 * np.pi * (shrink_fit.MIDDLE / 2) * 2
    figures.compare(
        "shrink fit, edges 1 to 2.3", f"force, {first} first", forces.sum(), expected, 1e-3, "Lamé", "N"
    )
