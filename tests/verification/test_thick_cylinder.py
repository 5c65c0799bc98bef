# SPDX-License-Identifier: BSD-3-Clause
"""Axisymmetric thick cylinder of two tubes in contact against Lame: values and observed order under refinement."""

import numpy as np
import pytest
import yaml

import thick_cylinder
from block_meshes import LINEAR, QUADRATIC, Mesh
from runs import read_fields, write_deck

LEVELS = (8, 16, 32)
HEIGHT = 0.5
# Linear elements: 2 in the displacement and in the resultant of the contact forces; single T3 corners are less regular.
SMALLEST_ORDER = 1.8


def tubes(element, n):
    """Inner and outer tube, n cells across each."""
    inner, middle, outer = thick_cylinder.RADII
    heights = np.linspace(0, HEIGHT, n // 2 + 1)
    ends = {(1, 0): "ends", (1, 1): "ends"}
    mesh = Mesh()
    mesh.add_block(
        "inner",
        [np.linspace(inner, middle, n + 1), heights],
        LINEAR.get(element, element),
        {(0, 0): "bore", (0, 1): "inner_face"} | ends,
    )
    mesh.add_block(
        "outer",
        [np.linspace(middle, outer, n + 1), heights],
        LINEAR.get(element, element),
        {(0, 0): "outer_face", (0, 1): "rim"} | ends,
    )
    if element in QUADRATIC:
        mesh.make_quadratic(element)
    return mesh


def solve(signorom, folder, element, n):
    """Mesh and fields of one level."""
    folder.mkdir()
    mesh = tubes(element, n)
    mesh.write(folder / "tubes.msh")
    signorom("solve", write_deck("thick_cylinder", folder), folder=folder)
    return mesh, read_fields(folder / "results" / "thick_cylinder" / "fields.h5")


@pytest.mark.parametrize("element", ["T3", "Q4", "mixed"])
def test_second_order(signorom, tmp_path, figures, element):
    """Largest nodal error of u_r and error of the mean contact pressure fall as h^2."""
    errors = []
    for n in LEVELS:
        mesh, fields = solve(signorom, tmp_path / str(n), element, n)
        first_outer = mesh.nodes_of("outer").min()
        is_inner = np.arange(len(mesh.coordinates)) < first_outer
        exact = thick_cylinder.radial_displacement(mesh.coordinates[:, 0], is_inner)
        faces = mesh.nodes_of("inner_face")
        pressure = thick_cylinder.contact_pressure()
        force = fields["multipliers_full_order"].sum() / (2 * np.pi * thick_cylinder.RADII[1] * HEIGHT)
        errors.append(
            [
                np.abs(fields["displacement"][:, 0] - exact).max() / thick_cylinder.PUSH,
                abs(force / pressure - 1),
                np.abs(fields["contact_pressure"][faces] / pressure - 1).max(),
            ]
        )
    errors = np.array(errors)
    orders = np.log2(errors[:-1] / errors[1:])
    problem = f"thick cylinder of two tubes, {element}"
    for name, values in (("displacement", orders[:, 0]), ("contact force", orders[:, 1])):
        source = "linear elements"
        figures.at_least(problem, f"order of the {name}", values.min(), SMALLEST_ORDER, source, reference=2.0)
    name = "radial displacement, largest error"
    figures.at_most(problem, f"{name}, {LEVELS[-1]} cells", errors[-1, 0], 1e-3, "Lamé")
    figures.at_most(problem, "contact pressure, worst node", errors[-1, 2], 1e-2, "Lamé")


@pytest.mark.parametrize("element", ["T6", "Q8", "Q9"])
def test_quadratic_elements(signorom, tmp_path, figures, element):
    """The mean error of u_r falls as h^3 at least, the largest ones of contact pressure and nodal stress as h^2."""
    errors = []
    for n in (4, 8, 16):
        mesh, fields = solve(signorom, tmp_path / str(n), element, n)
        is_inner = np.zeros(len(mesh.coordinates), dtype=bool)
        is_inner[mesh.nodes_of("inner")] = True
        exact = thick_cylinder.radial_displacement(mesh.coordinates[:, 0], is_inner)
        pressure = thick_cylinder.contact_pressure()
        stress = thick_cylinder.stresses(mesh.coordinates[:, 0], is_inner)
        difference = (fields["displacement"][:, 0] - exact) / thick_cylinder.PUSH
        errors.append(
            [
                np.sqrt(np.mean(difference**2)),
                np.abs(fields["contact_pressure"][mesh.nodes_of("inner_face")] / pressure - 1).max(),
                np.abs(fields["stress_smoothed"] - stress).max() / pressure,
            ]
        )
    errors = np.array(errors)
    orders = np.log2(errors[:-1] / errors[1:]).min(axis=0)
    problem = f"thick cylinder of two tubes, {element}"
    for name, order, least in zip(
        ("mean error of the displacement", "contact pressure", "stress"), orders, (3.0, 1.8, 1.6), strict=True
    ):
        figures.at_least(
            problem, f"order of the {name}", order, least, "quadratic elements", reference=round(least)
        )
    for i, (name, limit) in enumerate(
        [("radial displacement", 1e-5), ("contact pressure", 1e-3), ("stress", 1e-2)]
    ):
        figures.at_most(problem, f"{name}, 16 cells", errors[-1, i], limit, "Lamé")


def test_stress_of_the_cylinder(signorom, tmp_path):
    """sigma_rr, hoop and axial stress at the cells' middles, to 1 % of the contact pressure at 16 cells."""
    mesh, fields = solve(signorom, tmp_path / "run", "Q4", 16)
    cells = [
        (name == "inner", np.mean(mesh.coordinates[nodes, 0]))
        for kind, name, nodes in mesh.elements
        if kind == "Q4"
    ]
    is_inner, r = (np.array(values) for values in zip(*cells, strict=True))
    limit = 0.01 * thick_cylinder.contact_pressure()
    np.testing.assert_allclose(fields["stress"], thick_cylinder.stresses(r, is_inner), rtol=0, atol=limit)


def test_balance_is_along_the_axis(signorom, tmp_path):
    """Radial forces do not add up to zero around an axis; what the report calls balance must not count them."""
    solve(signorom, tmp_path / "run", "mixed", 8)
    report = yaml.safe_load((tmp_path / "run" / "results" / "thick_cylinder" / "report.yaml").read_text())
    point = report["points"]["1"]
    assert point["residuals"]["force_balance"] < 1e-12
    reactions = {entry["boundary"]: entry for entry in point["reactions"].values()}
    # both are pushed together: outwards by the bore, inwards by the rim
    assert reactions["bore"]["r"] > 0 > reactions["rim"]["r"]
    assert abs(reactions["ends"]["z"]) < 1e-9 * reactions["bore"]["r"]


def test_formula_meets_the_equations():
    """The reference itself: u at both ends, continuity, and a positive pressure."""
    inner, middle, outer = thick_cylinder.RADII
    u = thick_cylinder.radial_displacement(
        np.array([inner, middle, middle, outer]), np.array([True, True, False, False])
    )
    assert u[0] == pytest.approx(thick_cylinder.PUSH, rel=1e-12)
    assert u[1] == pytest.approx(u[2], rel=1e-12)
    assert abs(u[3]) < 1e-15
    assert thick_cylinder.contact_pressure() > 0
