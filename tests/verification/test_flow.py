# SPDX-License-Identifier: BSD-3-Clause
"""Plasticity and creep: D29 to D34, patch tests, contact of bodies that flow, Newton's method, limit loads."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from block_meshes import LINEAR, QUADRATIC, Mesh
from flow_decks import AXES, PLANE, SOLID, block, held, read_run, solve, write_deck
from flow_formulas import (
    CreepingBeam,
    CreepingCylinder,
    Point,
    YieldingCylinder,
    cyclic_bar,
    relaxation,
    relaxation_steps,
)
from runs import read_report

# Numbers of size 1 after some ten iterations.
ROUNDING = 5e-12
# Results on several ranks, relative.
RANKS = 1e-10
STEEL = "young_modulus: 2.0e5, poisson_ratio: 0.3"


def bar(n_dim=3, displacement="load"):
    """Supports of a bar along x that is pulled at its right end, free to contract."""
    supports = {"left": {"x": 0}, "bottom": {"y": 0}, "right": {"x": displacement}}
    if n_dim == 3:
        supports["front"] = {"z": 0}
    return held(**supports)


def relaxing_bar(n, strain=0.002, coefficient=1e-12, scale=1.0):
    """Sections of a bar of length 1 held at a strain over the time 1, in n steps; `scale` of stress and modulus."""
    return (
        f"materials: {{steel: {{regions: [body], young_modulus: {2e5 * scale!r}, poisson_ratio: 0.3, "
        f"creep: {{norton: {{coefficient: {coefficient!r}, exponent: 4}}}}}}}}\n"
        f"{bar(displacement=f'load*{strain!r}')}"
        f"history: {{steps: [{{until: 1, increments: {n}}}]}}\n"
    )


@pytest.mark.parametrize("element", SOLID)
def test_relaxation(signorom, tmp_path, figures, element):
    """D29: each stress of a held bar is that of backward Euler's own recursion."""
    fields, _ = solve(signorom, tmp_path / "run", block(element, 3), "solid", relaxing_bar(8))
    expected = relaxation_steps(400.0, 2e5, 1e-12, 4.0, np.full(8, 1 / 8))
    stress = np.array([field["stress"] for field in fields])
    assert np.ptp(stress[..., 0], axis=1).max() <= ROUNDING * 400
    assert np.abs(stress[..., 1:]).max() <= ROUNDING * 400
    worst = np.abs(stress[:, 0, 0] / expected - 1).max()
    figures.at_most(
        "relaxation of a bar (D29)", f"{element}: stress, 8 steps", worst, ROUNDING, "backward Euler"
    )
    creep = np.array([field["creep_strain"][0] for field in fields])
    np.testing.assert_allclose(creep, 0.002 - expected / 2e5, rtol=1e-11)


def test_order_in_time(signorom, tmp_path, figures):
    """D29 against its integral: halving the steps halves the error."""
    exact = relaxation(400.0, 2e5, 1e-12, 4.0, 1.0)
    errors = []
    for n in (20, 40, 80):
        fields, _ = solve(signorom, tmp_path / str(n), block("H8", 3), "solid", relaxing_bar(n))
        errors.append(fields[-1]["stress"][0, 0] / exact - 1)
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    problem = "relaxation of a bar (D29)"
    figures.at_least(problem, "order in time", orders.min(), 0.9, "backward Euler", reference=1.0)
    figures.at_most(problem, "stress, 80 steps", errors[-1], 0.02, "integral")
    assert orders.max() <= 1.1


def test_halved_steps(signorom, tmp_path, figures):
    """The estimated time error of a bar that is pulled and held, against its differential equation."""
    sections = (
        relaxing_bar(24)
        .replace("load*0.002", "0.002*pull")
        .replace(
            "increments: 24}]", "increments: 24}], tables: {pull: {time: [0, 0.25, 1], value: [0, 1, 1]}}"
        )
    )
    deck = write_deck(tmp_path, block("H8", 3), "solid", sections)
    said = signorom("solve", deck, "--halve-steps", folder=tmp_path)
    fields, _ = read_run(tmp_path)
    times = np.arange(1, 25) / 24
    # while pulled: stress rate = E (strain rate - creep rate); then D29
    pulled = solve_ivp(
        lambda _, s: 2e5 * (0.008 - 1e-12 * s**4),
        (0, 0.25),
        [0.0],
        "Radau",
        t_eval=times[:6],
        rtol=1e-9,
        atol=1e-8,
    ).y[0]
    exact = np.append(pulled, [relaxation(pulled[-1], 2e5, 1e-12, 4.0, t - 0.25) for t in times[6:]])
    errors = np.abs(np.array([field["stress"][0, 0] for field in fields]) - exact).max() / exact.max()
    estimates = read_report(tmp_path, "deck")["time_error"]
    problem = "relaxation of a bar (D29)"
    for name in ("von_mises", "support_forces"):
        figures.compare(
            problem, f"estimated error of {name} by halved steps", estimates[name], errors, 0.5, "formula"
        )
        assert errors / 1.5 <= estimates[name] <= 1.5 * errors
    assert "largest stress" in said
    assert "creep strain" in said


def test_units(signorom, tmp_path):
    """The same bar in m, N and s: sigma in Pa, A in 1/s/Pa^4."""
    mesh = block("H20", 3)
    small, _ = solve(signorom, tmp_path / "mm", mesh, "solid", relaxing_bar(5))
    mesh.coordinates *= 1e-3
    sections = relaxing_bar(5, 2e-6, 1e-12 / 3600 / 1e24, 1e6).replace("until: 1,", "until: 3600,")
    big, _ = solve(signorom, tmp_path / "m", mesh, "solid", sections, units="{length: m, force: N, time: s}")
    for one, other in zip(small, big, strict=True):
        np.testing.assert_allclose(other["stress"] / 1e6, one["stress"], rtol=0, atol=ROUNDING * 400)
        np.testing.assert_allclose(
            other["displacement"] * 1e3, one["displacement"], rtol=0, atol=ROUNDING * 0.002
        )


def test_temperature(signorom, tmp_path):
    """Creep by A0 exp(-Q / T) under a temperature that rises in time, whose expansion moves the held end along."""
    rates = [1e-9 * np.exp(-8000 / t) for t in (850, 900, 950, 1000)]
    sections = (
        "materials: {steel: {regions: [body], young_modulus: 2.0e5, poisson_ratio: 0.3, thermal_expansion: 1.0e-5, "
        'creep: {norton: {coefficient: "1e-9*exp(-8000/T)", exponent: 4}}}}\n'
        f"{bar(displacement=chr(34) + '0.002*load + 1.0e-5*(heat - 800)' + chr(34))}"
        "imposed_strains: [{region: body, temperature: heat, reference: 800}]\n"
        "history: {steps: [{until: 4, increments: 4}], tables: {heat: {time: [0, 4], value: [800, 1000]}}}\n"
    )
    fields, _ = solve(signorom, tmp_path / "run", block("H8", 3), "solid", sections)
    start = 400.0
    for field, rate in zip(fields, rates, strict=True):
        start = relaxation_steps(start, 2e5, rate, 4.0, [1.0])[0]
        np.testing.assert_allclose(field["stress"][:, 0], start, rtol=1e-11)


def ring(element, n, inner=1.0, outer=2.0, region="body"):
    """Mesh of a thick cylinder, n cells across it and one along the axis, not distorted."""
    return block(element, 2, [np.linspace(inner, outer, n + 1), np.array([0.0, 0.2])], 0.0, region=region)


RING = held(bottom={"z": 0}, top={"z": 0})


def ring_of_cells(mesh, element):
    """Inner and outer radius of each cell of a ring."""
    cells = [mesh.coordinates[nodes, 0] for kind, _, nodes in mesh.elements if kind == element]
    return np.array([[min(radii), max(radii)] for radii in cells])


@pytest.mark.parametrize(("element", "allowed"), [("Q8", 1e-5), ("T6", 2e-4), ("Q4", 1e-2)])
def test_creeping_cylinder(signorom, tmp_path, figures, element, allowed):
    """D30: steady state of Norton's cylinder, 10 cells: mean stresses of the cells, and the velocity of the rim."""
    exact = CreepingCylinder(1.0, 2.0, 50.0, 1e-12, 4.0)
    sections = (
        f"materials: {{steel: {{regions: [body], {STEEL}, creep: {{norton: {{coefficient: 1e-12, exponent: 4}}}}}}}}\n"
        f"{RING}"
        'loads: [{boundary: left, pressure: "50*load"}]\n'
        "history: {steps: [{until: 3000, increments: 60, growth: 100}, {until: 3200, increments: 2}]}\n"
    )
    mesh = ring(element, 10)
    fields, _ = solve(signorom, tmp_path / "run", mesh, "axisymmetric", sections)
    rim = mesh.nodes_of("right")
    velocity = (fields[-1]["displacement"][rim, 0] - fields[-2]["displacement"][rim, 0]).mean() / 100
    problem = "creeping thick cylinder (D30)"
    figures.compare(
        problem,
        f"{element}: velocity of the rim",
        velocity,
        exact.velocity(np.array([2.0]))[0],
        allowed,
        "formula",
    )
    if element == "T6":
        return
    expected = np.array([exact.mean_stresses(*radii) for radii in ring_of_cells(mesh, element)])
    # rr, axial, hoop: components xx, yy, zz of the fields
    worst = np.abs(fields[-1]["stress"][:, :3] - expected).max() / 50
    figures.at_most(problem, f"{element}: mean stresses of cells / pressure", worst, 20 * allowed, "formula")


@pytest.mark.parametrize(("element", "allowed"), [("Q8", 2e-3), ("T6", 2e-3), ("Q4", 2e-2)])
def test_yielding_cylinder(signorom, tmp_path, figures, element, allowed):
    """D31: the rim moves as Hill says, also near the limit load; unloading leaves his residual stresses."""
    exact = YieldingCylinder(1.0, 2.0, 100.0, 2e5, 0.4999)
    sections = (
        "materials: {steel: {regions: [body], young_modulus: 2.0e5, poisson_ratio: 0.4999, "
        "plasticity: {yield_stress: 100}}}\n"
        f"{RING}"
        f'loads: [{{boundary: left, pressure: "load*p*{exact.limit_pressure!r}"}}]\n'
        "history: {steps: [{until: 2, increments: 20}], tables: {p: {time: [0, 1, 2], value: [0, 0.98, 0]}}}\n"
    )
    mesh = ring(element, 20)
    fields, points = solve(signorom, tmp_path / "run", mesh, "axisymmetric", sections)
    problem = "yielding thick cylinder (D31)"
    for i in (3, 6, 8, 9):
        pressure = 0.098 * (i + 1) * exact.limit_pressure
        found = fields[i]["displacement"][mesh.nodes_of("right"), 0].mean()
        name = f"{element}: displacement of the rim at {0.098 * (i + 1):.3f} of the limit"
        figures.compare(problem, name, found, exact.displacement_of_rim(pressure), allowed, "Hill")
    if element != "T6":
        # the front lies inside of a cell: cells beside it are right to the size of a cell
        middles = ring_of_cells(mesh, element).mean(axis=1)
        for name, i, expected in (
            ("stress", 9, exact.stresses(middles, 0.98 * exact.limit_pressure)),
            ("residual stress", 19, exact.residual_stresses(middles, 0.98 * exact.limit_pressure)),
        ):
            worst = np.abs(fields[i]["stress"][:, :3] - expected).max() / 100
            figures.at_most(problem, f"{element}: {name} / yield stress", worst, 0.02, "Hill, Lamé")
    # elastic unloading: one solution of a linear problem, behind a first one with the tangent of loading
    assert all(point["iterations"] == 1 for point in points[11:])
    assert points[10]["iterations"] <= 3


def test_limit_load(signorom, tmp_path):
    """Above the limit load: exit code 3, fields of the times before, and a message."""
    exact = YieldingCylinder(1.0, 2.0, 100.0, 2e5)
    sections = (
        f"materials: {{steel: {{regions: [body], {STEEL}, plasticity: {{yield_stress: 100}}}}}}\n"
        f"{RING}"
        f'loads: [{{boundary: left, pressure: "load*p*{exact.limit_pressure!r}"}}]\n'
        "history: {steps: [{until: 1, increments: 5}], tables: {p: {time: [0, 1], value: [0, 1.3]}}}\n"
    )
    deck = write_deck(tmp_path, ring("Q8", 6), "axisymmetric", sections)
    done = signorom.run("solve", deck, folder=tmp_path)
    assert done.returncode == 3, done.stderr
    fields, points = read_run(tmp_path)
    # 1.04 and 1.3 of the limit are above it
    assert len(fields) == 3
    assert points[3]["flow"]["n_cuts"] >= 1
    reached = points[3]["flow"]["reached"]
    assert 0.6 <= reached < 1 / 1.3 + 0.01
    assert "the load may be above what they carry" in done.stderr
    assert f"there is an answer up to the time {reached:.4g}" in done.stderr
    assert "100 % of the integration points of 'body' yield" in done.stderr
    assert "nor has this history a solution at its 1 later time" in done.stderr


def test_cyclic_bar(signorom, tmp_path, figures):
    """D32: strain cycles of 0.4 % with kinematic hardening: the loop of straight lines."""
    sections = (
        f"materials: {{steel: {{regions: [body], {STEEL}, "
        "plasticity: {yield_stress: 250, kinematic_hardening: 2.0e4}}}\n"
        f"{bar(displacement='push*load')}"
        "history: {steps: [{until: 9, increments: 36}], "
        "tables: {push: {time: [0, 1, 3, 5, 7, 9], value: [0, 0.004, -0.004, 0.004, -0.004, 0.004]}}}\n"
    )
    fields, points = solve(signorom, tmp_path / "run", block("H20", 3), "solid", sections)
    times = np.arange(1, 37) / 4
    strains = np.interp(times, [0, 1, 3, 5, 7, 9], [0, 0.004, -0.004, 0.004, -0.004, 0.004])
    expected = cyclic_bar(2e5, 250.0, 2e4, strains)
    worst = (
        max(np.abs(field["stress"][:, 0] - s).max() for field, s in zip(fields, expected, strict=True)) / 250
    )
    figures.at_most(
        "cyclic bar (D32)", "stress / yield stress, 4 reversals", worst, 1e-11, "kinematic hardening"
    )
    # plastic work: stress at the end of each step times the change of the plastic strain
    plastic = np.diff(np.concatenate([[0.0], strains - expected / 2e5]))
    for point, work in zip(points, expected * plastic, strict=True):
        assert point["work"]["plastic"] == pytest.approx(work, rel=1e-9, abs=1e-12)


# Gradients of the displacement at the end of a path; in axisymmetry a uniform shear would not be in equilibrium.
GRADIENTS = {
    "plane_strain": np.array([[0.004, 0.002], [-0.001, -0.003]]),
    "axisymmetric": np.array([[0.003, 0.0], [0.0, -0.005]]),
    "solid": np.array([[0.004, 0.002, 0.001], [-0.001, -0.003, 0.0005], [0.0015, 0.002, 0.0007]]),
}
LAWS = {
    "plasticity": "plasticity: {yield_stress: 250, isotropic_hardening: 3000}",
    "creep": "creep: {norton: {coefficient: 1e-13, exponent: 5}}",
}
LAWS["both"] = ", ".join(LAWS.values())


def strain_tensor(model, gradient):
    """Strain of a displacement gradient as a 3 x 3 tensor xx, yy, zz: in axisymmetry the third axis is the hoop."""
    tensor = np.zeros((3, 3))
    n = len(gradient)
    tensor[:n, :n] = (gradient + gradient.T) / 2
    if model == "axisymmetric":
        tensor[2, 2] = gradient[0, 0]
    return tensor


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize(
    ("model", "element"),
    [(model, element) for model in ("plane_strain", "axisymmetric") for element in PLANE]
    + [("solid", element) for element in SOLID],
)
def test_patch(signorom, tmp_path, figures, model, element, law):
    """D33: a linear displacement of all sides of a distorted mesh gives all cells the stress of one material point."""
    axes, gradient = AXES[model], GRADIENTS[model]
    places = ("r", "z") if model == "axisymmetric" else axes
    moved = {
        axis: '"load*path*('
        + " + ".join(f"{g!r}*{place}" for g, place in zip(row, places, strict=True))
        + ')"'
        for axis, row in zip(axes, gradient.tolist(), strict=True)
    }
    sides = ("left", "right", "bottom", "top", "front", "back")[: 2 * len(axes)]
    sections = (
        f"materials: {{steel: {{regions: [body], {STEEL}, {LAWS[law]}}}}}\n"
        f"{held(**dict.fromkeys(sides, moved))}"
        "history: {steps: [{until: 4, increments: 4}], tables: {path: {time: [0, 2, 4], value: [0, 1, 0.3]}}}\n"
    )
    n_dim = len(axes)
    mesh = block(
        element, n_dim, [np.linspace(0, 1, 4)] * n_dim, shift=2.0 if model == "axisymmetric" else 0.0
    )
    fields, points = solve(signorom, tmp_path / "run", mesh, model, sections)
    point = Point(2e5, 0.3)
    if law != "creep":
        point.yield_stress, point.hardening = 250.0, 3000.0
    if law != "plasticity":
        point.coefficient, point.exponent = 1e-13, 5.0
    spread, difference = 0.0, 0.0
    for field, share in zip(fields, (0.5, 1.0, 0.65, 0.3), strict=True):
        s = point.advance(strain_tensor(model, gradient) * share, 1.0)
        expected = np.array([s[0, 0], s[1, 1], s[2, 2], s[0, 1], s[1, 2], s[0, 2]])
        spread = max(spread, np.ptp(field["stress"], axis=0).max() / 250)
        # extrapolated to nodes
        assert np.ptp(field["stress_smoothed"], axis=0).max() <= 10 * ROUNDING * 250
        difference = max(difference, np.abs(field["stress"][0] - expected).max() / 250)
        if law != "creep":
            np.testing.assert_allclose(field["plastic_strain"], point.plastic_strain, rtol=1e-8, atol=1e-12)
        if law != "plasticity":
            np.testing.assert_allclose(field["creep_strain"], point.creep_strain, rtol=1e-8, atol=1e-14)
    problem = f"patch test with {law}, {model} (D33)"
    figures.at_most(problem, f"{element}: spread of the stress", spread, ROUNDING, "uniform")
    figures.at_most(problem, f"{element}: stress", difference, 1e-9, "one material point")
    assert all(p["work"]["residual"] <= ROUNDING for p in points)


@pytest.mark.parametrize(("element", "allowed"), [("Q8", 1e-2), ("T6", 2e-2), ("Q4", 0.1)])
def test_creeping_beam(signorom, tmp_path, figures, element, allowed):
    """D34: a beam bent by a linear traction: its stress becomes that of the steady state, in plane strain, too."""
    beam = CreepingBeam(2.0, 40.0, 4.0)
    sections = (
        f"materials: {{steel: {{regions: [body], {STEEL}, creep: {{norton: {{coefficient: 1e-11, exponent: 4}}}}}}}}\n"
        f"{held(left={'x': 0}, pin={'y': 0})}"
        f'loads: [{{boundary: right, traction: {{x: "load*{40.0 * 12 / 8!r}*y"}}}}]\n'
        "history: {steps: [{until: 3000, increments: 50, growth: 200}]}\n"
    )
    mesh = Mesh()
    lines = [np.linspace(0, 8, 17), np.linspace(-1, 1, 11)]
    mesh.add_block("body", lines, LINEAR.get(element, element), {(0, 0): "left", (0, 1): "right"})
    if element in QUADRATIC:
        mesh.make_quadratic(element)
    pin = int(np.argmin(np.linalg.norm(mesh.coordinates - [0, 1, 0], axis=1)))
    mesh.elements.append(("P1", "pin", [pin]))
    fields, _ = solve(signorom, tmp_path / "run", mesh, "plane_strain", sections)
    cells = [nodes for kind, _, nodes in mesh.elements if kind == element]
    found = {}
    # the ends are Saint-Venant's
    for nodes, stress in zip(cells, fields[-1]["stress"][:, 0], strict=True):
        x, y = mesh.coordinates[nodes, 0], mesh.coordinates[nodes, 1]
        if x.min() >= 1.9 and x.max() <= 4.1:
            found.setdefault((round(y.min(), 6), round(y.max(), 6)), []).append(stress)
    assert len(found) == 10
    worst = max(abs(np.mean(values) - beam.mean_stress(*span)) for span, values in found.items())
    figures.at_most(
        "creeping beam (D34)",
        f"{element}: mean stresses / largest",
        worst / beam.stress(1.0),
        allowed,
        "formula",
    )


def punch_loads(signorom, folder, element, n):
    """Load per half width over k of a flat punch that sinks into a plastic block, n cells under its half width.

    Half of the block, in plane strain, in space one cell thick.
    """
    n_dim = 2 if element in PLANE else 3
    up = "xyz"[n_dim - 1]
    lines = [np.linspace(0, 6, 6 * n + 1), np.linspace(0, 3, 3 * n + 1)]
    if n_dim == 3:
        lines.insert(1, np.array([0.0, 1 / n]))
    mesh = Mesh()
    faces = {(0, 0): "left", (0, 1): "right", (n_dim - 1, 0): "bottom", (n_dim - 1, 1): "top"}
    if n_dim == 3:
        faces |= {(1, 0): "front", (1, 1): "back"}
    mesh.add_block("body", lines, LINEAR.get(element, element), faces)
    if element in QUADRATIC:
        mesh.make_quadratic(element)
    mesh.elements = [
        (
            kind,
            "punch" if name == "top" and mesh.coordinates[list(nodes), 0].max() <= 1 + 1e-9 else name,
            nodes,
        )
        for kind, name, nodes in mesh.elements
    ]
    supports = {"left": {"x": 0}, "right": {"x": 0}, "bottom": dict.fromkeys("xyz"[:n_dim], 0)}
    supports["punch"] = {"x": 0, up: "-0.24*load*time"}
    if n_dim == 3:
        supports |= {"front": {"y": 0}, "back": {"y": 0}}
        supports["punch"]["y"] = 0
    sections = (
        "materials: {soft: {regions: [body], young_modulus: 2.0e4, poisson_ratio: 0.3, "
        "plasticity: {yield_stress: 100}}}\n"
        f"{held(**supports)}"
        "history: {steps: [{until: 1, increments: 16, growth: 10}]}\n"
    )
    model = "plane_strain" if n_dim == 2 else "solid"
    _, points = solve(signorom, folder, mesh, model, sections)
    thickness = 1.0 if n_dim == 2 else 1 / n
    forces = [
        -reaction[up]
        for point in points
        for reaction in point["reactions"].values()
        if reaction["boundary"] == "punch"
    ]
    return np.array(forces) / thickness / (100 / np.sqrt(3))


@pytest.mark.parametrize(("element", "allowed"), [("Q8", 0.02), ("T6", 0.02), ("Q4", 0.03)])
def test_punch(signorom, tmp_path, figures, element, allowed):
    """Prandtl's punch: no locking, so that the load stays at last; its limit, extrapolated to small cells, is 2 + pi."""
    limits = []
    for n in (2, 4):
        loads = punch_loads(signorom, tmp_path / str(n), element, n)
        # fully plastic: the last fourth of the way adds nearly nothing
        assert 0 <= loads[-1] / loads[-3] - 1 <= 5e-3
        limits.append(loads[-1])
    # the edge of the punch is as sharp as a cell: an error of first order
    limit = 2 * limits[1] - limits[0]
    figures.compare(
        "punch on a plastic block", f"{element}: limit load / k", limit, 2 + np.pi, allowed, "Prandtl"
    )


@pytest.mark.parametrize("element", SOLID)
def test_punch_in_space(signorom, tmp_path, figures, element):
    """The same with one cell across: no solid element locks."""
    loads = punch_loads(signorom, tmp_path / "run", element, 2)
    assert 0 <= loads[-1] / loads[-3] - 1 <= 1e-2
    problem = "punch on a plastic block"
    figures.at_most(
        problem, f"{element}: limit load / k, 2 cells", loads[-1], 1.25 * (2 + np.pi), "Prandtl and an edge"
    )


def clamped(steps, table, friction=""):
    """Sections of two blocks on each other, pressed by a stroke; the lower one creeps."""
    return (
        f"materials:\n  soft: {{regions: [lower], {STEEL}, creep: {{norton: {{coefficient: 1e-11, exponent: 4}}}}}}\n"
        f"  hard: {{regions: [upper], young_modulus: 4.0e5, poisson_ratio: 0.0}}\n"
        f"{held(bottom={'y': 0}, left={'x': 0}, top={'y': '-push*load'})}"
        f"contact:\n  - {{first: lower_face, second: upper_face{friction}}}\n"
        f"history: {{steps: [{steps}], tables: {{push: {table}}}}}\n"
    )


def stacked(element):
    """Two unit squares, the upper one 0.001 above the lower one."""
    mesh = Mesh()
    line = np.linspace(0, 1, 4)
    name = LINEAR.get(element, element)
    mesh.add_block("lower", [line, line], name, {(1, 0): "bottom", (1, 1): "lower_face", (0, 0): "left"})
    faces = {(1, 0): "upper_face", (1, 1): "top", (0, 0): "left"}
    mesh.add_block("upper", [line, 1.001 + line], name, faces)
    if element in QUADRATIC:
        mesh.make_quadratic(element)
    return mesh


@pytest.mark.parametrize("element", ["Q8", "T6", "Q4"])
def test_contact_opens(signorom, tmp_path, figures, element):
    """A block that creeps under a stroke, which is then taken back by less than it was: the contact opens.

    In plane strain, sigma_zz follows from eps_zz = 0: both blocks are material points in series.
    """
    strokes = np.interp(np.arange(1, 9), [0, 1, 6, 8], [0.0, 0.004, 0.004, 0.0035])
    sections = clamped("{until: 8, increments: 8}", "{time: [0, 1, 6, 8], value: [0, 0.004, 0.004, 0.0035]}")
    fields, points = solve(signorom, tmp_path / "run", stacked(element), "plane_strain", sections)
    expected = series(strokes)
    pressures = np.array([field["contact_pressure"].max() for field in fields])
    forces = np.array([field["multipliers_full_order"].sum() for field in fields])
    figures.at_most(
        "creeping block under a stroke", f"{element}: contact force / largest",
        np.abs(forces - expected).max() / expected.max(), 1e-9, "material points in series",
    )  # fmt: skip
    assert expected[-1] == 0.0
    assert expected[-2] > 0.0
    assert points[-1]["n_active"] == 0
    assert pressures[-1] == 0.0
    # nothing presses at the last time: its terms are rounding
    assert all(p["work"]["residual"] <= ROUNDING for p in points[:-1])


def series(strokes):
    """Contact force per width of the blocks of `clamped` under strokes, backward Euler over times of 1."""
    e, nu, a, n, gap, upper = 2e5, 0.3, 1e-11, 4, 0.001, 4e5
    creep = np.zeros(3)
    forces = []

    def step(force):
        """Creep strains after a step with this force: sigma_yy = -force, sigma_xx = 0, eps_zz = 0."""

        def missing(out):
            deviator = np.array([0.0, -force, out]) - (out - force) / 3
            q = np.sqrt(1.5 * deviator @ deviator)
            new = creep + a * q ** (n - 1) * 1.5 * deviator
            return (out + nu * force) / e + new[2], new

        out = brentq(lambda s: missing(s)[0], -force - 2e3, force + 2e3, xtol=1e-13, rtol=1e-15)
        return out, missing(out)[1]

    for stroke in strokes:

        def overlap(force, stroke=stroke):
            out, new = step(force)
            lower = (force + nu * out) / e - new[1]
            return stroke - gap - lower - force / upper

        force = brentq(overlap, 0.0, 1e4, xtol=1e-13, rtol=1e-15) if overlap(0.0) > 0 else 0.0
        creep = step(force)[1]
        forces.append(force)
    return np.array(forces)


SOLVERS = ["condensed", "active_set, linear: cholesky", "active_set, linear: gamg"]


def two_tubes(friction, solver="auto", element="Q8"):
    """Mesh and sections of a hot tube in a cooler one that yields and creeps: they touch, slip and part again."""
    mesh = Mesh()
    name, heights = LINEAR.get(element, element), np.linspace(0, 4, 6)
    faces = {(0, 1): "inner_face", (0, 0): "bore", (1, 0): "foot"}
    mesh.add_block("inner", [np.linspace(1, 4, 5), heights], name, faces, 0.1, seed=1)
    faces = {(0, 0): "outer_face", (0, 1): "rim", (1, 0): "foot"}
    mesh.add_block("outer", [np.linspace(4.02, 4.6, 4), heights], name, faces, 0.1, seed=2)
    if element in QUADRATIC:
        mesh.make_quadratic(element)
    sections = (
        "materials:\n"
        "  tube: {regions: [outer], young_modulus: 78000, poisson_ratio: 0.34, thermal_expansion: 6.0e-6,\n"
        "    plasticity: {yield_stress: 100, isotropic_hardening: 2000},\n"
        '    creep: {norton: {coefficient: "1e-11*exp(-3000/(T + 273))", exponent: 4}}}\n'
        "  pellet: {regions: [inner], young_modulus: 180000, poisson_ratio: 0.31, thermal_expansion: 1.1e-5}\n"
        f"{held(foot={'z': 0})}"
        "imposed_strains:\n"
        '  - {region: inner, temperature: "20 + load*heat*(1 - (r/5)^2)*(1 + 0.1*z)", reference: 20}\n'
        '  - {region: outer, temperature: "20 + 0.3*load*heat", reference: 20}\n'
        'loads: [{boundary: rim, pressure: "10*load"}]\n'
        f"contact:\n  - {{first: outer_face, second: inner_face, formulation: mortar{friction}}}\n"
        "history: {steps: [{until: 10, increments: 15}], "
        "tables: {heat: {time: [0, 4, 7, 10], value: [0, 1200, 1200, 0]}}}\n"
        f"solver: {{type: {solver}}}\n"
    )
    return mesh, sections


def numbers_of(fields):
    """Displacements, contact forces and stresses of all times, each by its largest."""
    parts = []
    for name in ("displacement", "multipliers_full_order", "stress", "stress_smoothed"):
        values = np.array([field[name] for field in fields])
        parts.append((values / np.abs(values).max()).ravel())
    return np.concatenate(parts)


def test_solvers_agree(signorom, tmp_path):
    """All contact solvers and elements find the same history, in which contact closes and opens."""
    found = []
    for i, solver in enumerate(SOLVERS):
        fields, points = solve(signorom, tmp_path / str(i), *with_model(two_tubes("", solver)))
        found.append(numbers_of(fields))
        active = [point["n_active"] for point in points]
        assert max(active) > 0
        assert active[-1] == 0
        assert max(field["plastic_strain"].max() for field in fields) > 1e-3
        assert max(field["creep_strain"].max() for field in fields) > 1e-6
    for other in found[1:]:
        assert np.abs(other - found[0]).max() <= 1e-8


def with_model(mesh_and_sections):
    """Mesh, model and sections for solve."""
    mesh, sections = mesh_and_sections
    return mesh, "axisymmetric", sections


@pytest.mark.parametrize(
    ("friction", "solver"), [("", SOLVERS[0]), ("", SOLVERS[1]), (", friction: 0.3", "auto")]
)
def test_ranks(signorom, tmp_path, friction, solver):
    """1 and 3 ranks find the same history."""
    found = []
    for n_ranks in (1, 3):
        run = solve(
            signorom, tmp_path / str(n_ranks), *with_model(two_tubes(friction, solver)), n_ranks=n_ranks
        )
        found.append(numbers_of(run[0]))
    for other in found[1:]:
        assert np.abs(other - found[0]).max() <= RANKS


@pytest.mark.parametrize("friction", ["", ", friction: 0.3"])
def test_work(signorom, tmp_path, figures, friction):
    """D28: loads and supports do the work that energy, materials, friction and the error of the steps take.

    The balance with mean forces is exact, and half the steps have half of the error.
    """
    errors = []
    for n in (15, 30, 60):
        mesh, sections = two_tubes(friction)
        sections = sections.replace("increments: 15", f"increments: {n}")
        _, points = solve(signorom, tmp_path / str(n), mesh, "axisymmetric", sections)
        works = [point["work"] for point in points]
        assert max(work["residual"] for work in works) <= ROUNDING
        assert min(work["plastic"] for work in works) >= -1e-12 * max(work["plastic"] for work in works)
        total = {key: sum(work[key] for work in works) for key in works[0]}
        given = total["loads"] + total["supports"]
        taken = sum(
            total[key]
            for key in ("energy", "imposed_strains", "plastic", "creep", "gaps", "friction", "time_error")
        )
        assert given == pytest.approx(taken, rel=1e-9, abs=1e-9 * abs(total["energy"] + total["loads"]))
        errors.append(sum(abs(work["time_error"]) for work in works) / total["plastic"])
    order = np.log2(errors[0] / errors[2]) / 2
    problem = f"two tubes that flow{friction}"
    figures.at_least(problem, "order of the error of work", order, 0.7, "first order", reference=1.0)


def test_newton_is_quadratic(signorom, tmp_path):
    """The residuals of a step in which contact, yielding and creep change end as those of Newton's method."""
    _, points = solve(signorom, tmp_path / "run", *with_model(two_tubes("")))
    ends = []
    for point in points:
        residuals = point["flow"]["newton_residuals"]
        assert point["flow"]["n_cuts"] == 0
        assert len(residuals) <= 8
        # rounding is about 1e-15
        ends += [(a, b) for a, b in pairwise(residuals) if a < 1e-3 and b > 1e-13]
    assert len(ends) >= 5
    # r_(k + 1) <= c r_k^2
    assert all(b <= 300 * a**2 for a, b in ends), ends


def test_cut_steps(signorom, tmp_path):
    """Steps that may take only four iterations are cut in two until they converge; the end is that of shorter steps.

    The report says how often steps were cut, and the balance of work holds through the parts.
    """
    mesh, sections = two_tubes("", "condensed")
    sections = sections.replace("increments: 15", "increments: 5").replace(
        "condensed}", "condensed, max_iterations: 4}"
    )
    fields, points = solve(signorom, tmp_path / "cut", mesh, "axisymmetric", sections)
    assert sum(point["flow"]["n_cuts"] for point in points) >= 3
    assert all(len(point["flow"]["newton_residuals"]) <= 4 for point in points)
    assert max(point["work"]["residual"] for point in points) <= ROUNDING
    short, _ = solve(
        signorom,
        tmp_path / "short",
        mesh,
        "axisymmetric",
        sections.replace("increments: 5", "increments: 80"),
    )
    for i, field in enumerate(fields):
        expected = short[16 * (i + 1) - 1]
        scale = np.abs(expected["von_mises"]).max()
        np.testing.assert_allclose(field["von_mises"], expected["von_mises"], atol=0.02 * scale)
