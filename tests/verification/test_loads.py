# SPDX-License-Identifier: BSD-3-Clause
"""Bars under pressure, traction and weight: displacements by formula, reactions that balance the loads.

Prescribed values that depend on the place, and at points.
"""

import numpy as np
import pytest
import yaml

import bar_with_gap as bar
import patch_test
from block_meshes import stacked_blocks
from gmsh_ascii import read_mesh
from runs import HERE, read_fields, write_deck_with

# Uniaxial fields are in the span of linear elements: what is left is rounding.
TOLERANCE = 1e-10
PUSH = 1.5
BARS = "two bars under loads"
LOADS = """  - {boundary: lower_face, pressure: push}
  - {boundary: upper_face, traction: {y: "push + 0 * x"}}
"""


def solve_points(signorom, folder, replacements):
    """Fields and entry of the report of each point."""
    deck = write_deck_with("loaded_bars", folder, replacements)
    signorom("solve", deck, folder=folder)
    results = folder / "results" / "loaded_bars"
    points = list(yaml.safe_load((results / "report.yaml").read_text())["points"].values())
    return [read_fields(results / "fields.h5", i_point) for i_point in range(1, len(points) + 1)], points


def solve(signorom, folder, **replacements):
    """Displacement (n_nodes, 2) and the report's first point."""
    fields, points = solve_points(signorom, folder, replacements)
    return fields[0]["displacement"][:, :2], points[0]


@pytest.fixture(scope="module")
def mesh():
    """The mesh by the reference's reader."""
    return read_mesh(HERE / "meshes" / "bar_with_gap.msh")


@pytest.mark.parametrize("solver", ["condensed", "active_set", "snesvi"])
def test_pressure_and_traction_compress_the_bars(signorom, tmp_path, mesh, figures, solver):
    """u = p (distance from the held end) / E, away from the other bar."""
    u, point = solve(signorom, tmp_path, **{"type: condensed": f"type: {solver}"})
    y = mesh.coordinates[:, 1]
    expected = np.where(
        y < bar.GAP / 2,
        -PUSH * (y + bar.LOWER_HEIGHT) / bar.LOWER_MODULUS,
        PUSH * (bar.GAP + bar.UPPER_HEIGHT - y) / bar.UPPER_MODULUS,
    )
    scale = np.abs(expected).max()
    worst = max(np.abs(u[:, 1] - expected).max(), np.abs(u[:, 0]).max()) / scale
    figures.at_most(BARS, f"pressure and traction: displacements, {solver}", worst, TOLERANCE, "p h / E")
    assert point["n_active"] == 0
    x = mesh.coordinates[:, 0]
    resultant = PUSH * (x.max() - x.min())
    assert [reaction["boundary"] for reaction in point["reactions"].values()] == ["lower_base", "upper_base"]
    assert point["reactions"]["1"]["y"] == pytest.approx(resultant, rel=1e-9)
    assert point["reactions"]["2"]["y"] == pytest.approx(-resultant, rel=1e-9)
    assert point["residuals"]["force_balance"] <= 1e-9
    assert point["residuals"]["equilibrium"] <= 1e-9


@pytest.mark.parametrize("solver", ["condensed", "active_set", "snesvi"])
def test_traction_closes_the_gap(signorom, tmp_path, mesh, figures, solver):
    """A traction t stretches the lower bar until it touches; then p = (t h1 / E1 - gap) / (h1 / E1 + h2 / E2)."""
    tractions = (1.5, 2.0, 5.0, 8.0)
    points = ", ".join(f"{{push: {traction}}}" for traction in tractions)
    changes = {
        LOADS: "  - {boundary: lower_face, traction: {y: push}}\n",
        "{min: 0.5, max: 2.0, unit: Pa}": "{min: 0.5, max: 8.0, unit: Pa}",
        "points: [{push: 1.5}]": f"points: [{points}]",
        "type: condensed": f"type: {solver}",
    }
    fields, _ = solve_points(signorom, tmp_path, changes)
    y = mesh.coordinates[:, 1]
    lengths = patch_test.tributary_lengths(mesh.coordinates[mesh.nodes_of["lower_face"], 0])
    compliance = bar.LOWER_HEIGHT / bar.LOWER_MODULUS
    both = compliance + bar.UPPER_HEIGHT / bar.UPPER_MODULUS
    worst = 0.0
    for traction, answer in zip(tractions, fields, strict=True):
        pressure = max(0.0, traction * compliance - bar.GAP) / both
        worst = max(
            worst, np.abs(answer["multipliers_full_order"] - pressure * lengths).max() / lengths.max()
        )
        expected = np.where(
            y < bar.GAP / 2,
            (traction - pressure) * (y + bar.LOWER_HEIGHT) / bar.LOWER_MODULUS,
            pressure * (bar.GAP + bar.UPPER_HEIGHT - y) / bar.UPPER_MODULUS,
        )
        worst = max(worst, np.abs(answer["displacement"][:, 1] - expected).max() / bar.GAP)
    assert pressure > 0
    name = f"traction closes the gap: forces and displacements, {solver}"
    figures.at_most(BARS, name, worst, TOLERANCE, "springs in series")


def test_loads_add_up(signorom, tmp_path, mesh, figures):
    """Several entries on one surface, two windows that meet inside an edge, another surface: their sum."""
    loads = """  - {boundary: lower_face, pressure: push}
  - {boundary: lower_face, pressure: push / 2, window: {axis: x, max: 0.15}}
  - {boundary: upper_face, pressure: 2 * push}
  - {boundary: lower_face, traction: {y: push / 4}}
  - {boundary: lower_face, pressure: push / 2, window: {axis: x, min: 0.15}}
"""
    u, point = solve(signorom, tmp_path, **{LOADS: loads})
    y = mesh.coordinates[:, 1]
    expected = np.where(
        y < bar.GAP / 2,
        -1.25 * PUSH * (y + bar.LOWER_HEIGHT) / bar.LOWER_MODULUS,
        2 * PUSH * (bar.GAP + bar.UPPER_HEIGHT - y) / bar.UPPER_MODULUS,
    )
    worst = max(np.abs(u[:, 1] - expected).max(), np.abs(u[:, 0]).max()) / np.abs(expected).max()
    figures.at_most(BARS, "five loads on two surfaces: displacements", worst, TOLERANCE, "their sum")
    width = np.ptp(mesh.coordinates[:, 0])
    found = [reaction["y"] / (PUSH * width) for reaction in point["reactions"].values()]
    worst = np.abs(np.array(found) - [1.25, -2]).max()
    figures.at_most(BARS, "five loads on two surfaces: reactions", worst, 1e-9, "equilibrium")


@pytest.mark.parametrize("axis", ["x", "y"])
def test_window_cuts_irregular_faces(signorom, tmp_path, figures, axis):
    """Pressure 1e5 (1 + x) on a strip of a unit square of faces without parallel sides: the integral, by hand."""
    low, high = 0.15, 0.47
    mesh = stacked_blocks("H8", 3)
    top = mesh.nodes_of("top")
    x, y = mesh.coordinates[top, :2].T
    inner = top[(x > 0) & (x < 1) & (y > 0) & (y < 1)]
    mesh.coordinates[inner, :2] += [[0.11, -0.08], [-0.06, 0.13]]
    mesh.write(tmp_path / "blocks.msh")
    changes = {
        "model: plane_strain": "model: solid",
        "boundary_conditions: []": "boundary_conditions:\n  - {boundary: bottom, displacement: {z: 0}}\n"
        "  - {boundary: left, displacement: {x: 0}}\n  - {boundary: front, displacement: {y: 0}}\n"
        "loads:\n  - boundary: top\n    pressure: 1e6 * stroke * (1 + x)\n"
        f"    window: {{axis: {axis}, min: {low}, max: {high} + stroke - 0.1}}",
        "direction: [0, 1]": "direction: [0, 0, 1]",
    }
    signorom("solve", write_deck_with("patch_models", tmp_path, changes), folder=tmp_path)
    report = yaml.safe_load((tmp_path / "results" / "patch_models" / "report.yaml").read_text())
    (point,) = report["points"].values()
    (reaction,) = [r["z"] for r in point["reactions"].values() if r["boundary"] == "bottom"]
    width = high - low
    expected = 1e5 * (width + (high**2 - low**2) / 2 if axis == "x" else 1.5 * width)
    name = f"pressure on a strip along {axis} of irregular faces: reaction"
    figures.compare("windows that cut faces", name, reaction, expected, 1e-9, "integral of the pressure", "N")


def test_weight_of_a_bar(signorom, tmp_path, mesh, figures):
    """The mean displacement of the free end is f h^2 / (2 E) exactly: a field linear in y is a test function."""
    loads = (
        "  - {region: lower, body_force: {y: -push}}\n  - {region: lower, body_force: {y: 0.5 * (1 + y)}}\n"
    )
    loads += "  - {region: lower, body_force: {y: push^2 * (1 + y) / 3 - push}}"
    old = "  - {boundary: lower_face, pressure: push}"
    u, point = solve(signorom, tmp_path, **{old: loads})
    nodes = mesh.nodes_of["lower_face"]
    lengths = patch_test.tributary_lengths(mesh.coordinates[nodes, 0])
    mean = lengths @ u[nodes, 1] / lengths.sum()
    # the second force grows from the held end, s (1 + y): s h^3 / (3 E); the third one has both parts
    constant, growing = -2 * PUSH, 0.5 + PUSH**2 / 3
    expected = (constant * bar.LOWER_HEIGHT**2 / 2 + growing * bar.LOWER_HEIGHT**3 / 3) / bar.LOWER_MODULUS
    figures.compare(BARS, "end of a bar under three body forces", mean, expected, 1e-9, "f h^2 / (2 E)", "m")
    width = np.ptp(mesh.coordinates[:, 0])
    weight = (constant * bar.LOWER_HEIGHT + growing * bar.LOWER_HEIGHT**2 / 2) * width
    reaction = point["reactions"]["1"]["y"]
    figures.compare(BARS, "reaction to three body forces", reaction, -weight, 1e-9, "equilibrium", "N/m")
    assert point["residuals"]["force_balance"] <= 1e-9


def test_displacements_may_depend_on_the_place(signorom, tmp_path, mesh):
    """A patch test by prescribed values: u = push (x, y) on the lower bar's ends, expression by expression."""
    u, _ = solve(
        signorom,
        tmp_path,
        **{
            "lower_base, displacement: {x: 0.0, y: 0.0}": "lower_base, "
            'displacement: {x: "1e-3*push*x", y: "1e-3*push*y"}',
            "  - {boundary: upper_base": '  - {boundary: lower_face, displacement: {x: "1e-3*push*x", y: "1.5e-3*y"}}\n'
            "  - {boundary: upper_base",
        },
    )
    for name in ("lower_base", "lower_face"):
        nodes = mesh.nodes_of[name]
        np.testing.assert_allclose(u[nodes], 1.5e-3 * mesh.coordinates[nodes, :2], rtol=0, atol=1e-15)


# A rigid motion by as many values as it has freedoms: at corners of the upper block, each component an expression.
MOTIONS = {
    2: ("-0.1 * stroke * y", "stroke + 0.1 * stroke * x"),
    3: (
        "0.2 * stroke * z - 0.1 * stroke * y",
        "0.1 * stroke * x - 0.3 * stroke * z",
        "stroke + 0.3 * stroke * y - 0.2 * stroke * x",
    ),
}
# corner -> components
SUPPORTS = {
    2: {(0, 1): "xy", (1, 1): "y"},
    3: {(0, 0, 1): "xyz", (1, 0, 1): "yz", (0, 1, 1): "z"},
}


@pytest.mark.parametrize(
    ("model", "element"), [("plane_strain", "Q4"), ("plane_stress", "T3"), ("solid", "H8")]
)
def test_points_may_be_prescribed(signorom, tmp_path, figures, model, element):
    """The upper block follows its corners without strain and leaves the lower one alone."""
    n_dim = 3 if model == "solid" else 2
    mesh = stacked_blocks(element, n_dim)
    entries = ["  - {boundary: bottom, displacement: {x: 0, y: 0" + (", z: 0" if n_dim == 3 else "") + "}}"]
    first_upper = mesh.nodes_of("upper").min()
    for i_corner, (corner, components) in enumerate(SUPPORTS[n_dim].items()):
        distances = np.linalg.norm(mesh.coordinates[first_upper:, :n_dim] - corner, axis=1)
        assert distances.min() == 0
        mesh.elements.append(("P1", f"corner_{i_corner}", [first_upper + distances.argmin()]))
        values = ", ".join(f'{axis}: "{MOTIONS[n_dim]["xyz".index(axis)]}"' for axis in components)
        entries.append(f"  - {{boundary: corner_{i_corner}, displacement: {{{values}}}}}")
    mesh.write(tmp_path / "blocks.msh")
    changes = {
        "model: plane_strain": f"model: {model}",
        "boundary_conditions: []": "\n".join(["boundary_conditions:", *entries]),
        "direction: [0, 1]": "direction: [0, 0, 1]" if n_dim == 3 else "direction: [0, 1]",
    }
    signorom("solve", write_deck_with("patch_models", tmp_path, changes), folder=tmp_path)
    fields = read_fields(tmp_path / "results" / "patch_models" / "fields.h5")
    stroke, (x, y, z) = 0.1, mesh.coordinates[first_upper:].T
    if n_dim == 2:
        expected = np.stack([-0.1 * stroke * y, stroke + 0.1 * stroke * x, 0 * x], axis=1)
    else:
        expected = stroke * np.stack([0.2 * z - 0.1 * y, 0.1 * x - 0.3 * z, 1 + 0.3 * y - 0.2 * x], axis=1)
    worst = np.abs(fields["displacement"][first_upper:] - expected).max() / stroke
    assert np.abs(fields["displacement"][:first_upper]).max() <= TOLERANCE * stroke
    name = f"prescribed corners, {model}, {element}"
    figures.at_most("rigid motion of a block", name, worst, TOLERANCE, "translation and rotation")
