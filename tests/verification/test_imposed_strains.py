# SPDX-License-Identifier: BSD-3-Clause
"""Imposed strains: free expansion, hollow cylinders, a heated shrink fit, a bimetal strip, gaps that heat closes."""

import numpy as np
import pytest

import shrink_fit
from block_meshes import LINEAR, QUADRATIC, Mesh, stacked_blocks
from runs import read_fields, read_snapshots, read_table, write_input
from spread import spread
from thermal_cylinder import ThermalCylinder, bimetal_curvature, logarithmic, parabolic

ROUNDING = 1e-10
YOUNG_MODULUS, POISSON_RATIO, EXPANSION = 2.0e11, 0.3, 1.2e-5
AXES = {"axisymmetric": "rz", "solid": "xyz"}
MATERIAL = f"young_modulus: {YOUNG_MODULUS}, poisson_ratio: {POISSON_RATIO}, thermal_expansion: {EXPANSION}"
CASES = [
    (model, element)
    for model in ("plane_strain", "plane_stress", "axisymmetric")
    for element in ("T3", "Q4", "mixed", "T6", "Q8", "Q9")
] + [("solid", element) for element in ("T4", "H8", "T10", "H20", "H27")]


def write_deck(folder, model, sections, contact, material=MATERIAL, regions="[lower, upper]"):
    """A deck on body.msh with the parameter `heat` up to 400."""
    (folder / "body.yaml").write_text(
        f"mesh: {{file: body.msh, model: {model}}}\n"
        "parameters: {heat: {min: 0, max: 400}}\n"
        f"materials: {{all: {{regions: {regions}, {material}}}}}\n"
        f"{sections}"
        f"contact:\n  - {contact}\n"
        "output: {points: [{heat: 300}]}\n"
    )
    return folder / "body.yaml"


def solve(signorom, deck, n_ranks=1):
    """Fields at the first output point."""
    signorom("solve", deck, folder=deck.parent, n_ranks=n_ranks)
    return read_fields(deck.parent / "results" / deck.stem / "fields.h5")


def lines(key, entries):
    """A section that is a list."""
    return f"{key}:\n" + "".join(f"  - {entry}\n" for entry in entries)


@pytest.mark.parametrize(("model", "element"), CASES)
def test_free_expansion(signorom, tmp_path, figures, model, element):
    """Two blocks, the upper one held by contact alone, 300 degrees warmer: no stress in any cell or node.

    In plane strain the stress across the plane is -E alpha dT, and nothing else.
    """
    mesh = stacked_blocks(element, 3 if model == "solid" else 2)
    axes = AXES.get(model, "xy")
    held = [f"{{boundary: bottom, displacement: {{{axes[-1]}: 0}}}}"]
    if model == "axisymmetric":
        mesh.coordinates[:, 0] += 1.0
    else:
        sides = zip(("left", "front"), axes[:-1], strict=False)
        held += [f"{{boundary: {name}, displacement: {{{axis}: 0}}}}" for name, axis in sides]
    mesh.write(tmp_path / "body.msh")
    warm = [
        f'{{region: {name}, temperature: "293.15 + heat", reference: 293.15}}' for name in ("lower", "upper")
    ]
    direction = "[0, 0, 1]" if model == "solid" else "[0, 1]"
    deck = write_deck(
        tmp_path,
        model,
        lines("boundary_conditions", held) + lines("imposed_strains", warm),
        f"{{first: lower_face, second: upper_face, direction: {direction}}}",
    )
    fields = solve(signorom, deck)
    scale = YOUNG_MODULUS * EXPANSION * 300
    across = np.array([0, 0, -scale if model == "plane_strain" else 0, 0, 0, 0])
    worst = max(np.abs(fields[name] - across).max() / scale for name in ("stress", "stress_smoothed"))
    figures.at_most(
        f"free expansion, {model}", f"{element}: stress / (E alpha dT)", worst, ROUNDING, "no stress"
    )
    strain = np.array([1, 1, 1, 0, 0, 0]) * EXPANSION * 300
    np.testing.assert_allclose(
        fields["imposed_strain"], np.tile(strain, (len(fields["stress"]), 1)), rtol=1e-12
    )


STOP = {"plane_stress": "Q4", "axisymmetric": "Q4", "solid": "H8"}


def add_stop(mesh, model):
    """A body far away that has the contact: where it is held, and its obstacle."""
    n_dim = 3 if model == "solid" else 2
    mesh.add_block(
        "stop",
        [np.array([50.0, 51.0])] * n_dim,
        STOP[model],
        {(n_dim - 1, 0): "foot", (n_dim - 1, 1): "roof"},
    )
    zeros = ", ".join(["0"] * (n_dim - 1))
    held = ", ".join(f"{axis}: 0" for axis in AXES.get(model, "xy"))
    obstacle = f"{{first: roof, obstacle: {{type: half_space, point: [{zeros}, 60], normal: [{zeros}, -1]}}}}"
    return f"{{boundary: foot, displacement: {{{held}}}}}", obstacle


@pytest.mark.parametrize(
    ("model", "element"),
    [("plane_stress", element) for element in ("T6", "Q8", "Q9")]
    + [("solid", element) for element in ("T10", "H20", "H27")],
)
def test_linear_temperature(signorom, tmp_path, figures, model, element):
    """A body on statically determinate supports, a temperature linear in place: quadratic elements have no stress.

    Distorted cells of 8 and 20 nodes do not hold all quadratic displacements: theirs are rectangles.
    """
    n_dim = 3 if model == "solid" else 2
    names = ["a", "b", "c"][:n_dim]
    moved = 0.0 if element in ("Q8", "H20") else 0.2
    mesh = Mesh()
    mesh.add_block("body", [np.linspace(0, 1, 4)] * n_dim, LINEAR[element], {}, moved, seed=4)
    corners = [np.zeros(3), np.array([1.0, 0, 0]), np.array([0, 1.0, 0])][:n_dim]
    for name, corner in zip(names, corners, strict=True):
        node = int(np.argmin(np.linalg.norm(mesh.coordinates - corner, axis=1)))
        mesh.elements.append(("P1", name, [node]))
    mesh.make_quadratic(element)
    foot, obstacle = add_stop(mesh, model)
    mesh.write(tmp_path / "body.msh")
    held = [["x: 0, y: 0", "y: 0"], ["x: 0, y: 0, z: 0", "y: 0, z: 0", "z: 0"]][n_dim - 2]
    supports = [
        f"{{boundary: {name}, displacement: {{{axes}}}}}" for name, axes in zip(names, held, strict=True)
    ]
    rise = "heat * (x - 0.3 * y)" if n_dim == 2 else "heat * (x - 0.3 * y + 0.7 * z)"
    deck = write_deck(
        tmp_path,
        model,
        lines("boundary_conditions", [*supports, foot])
        + lines("imposed_strains", [f'{{region: body, temperature: "20 + {rise}", reference: 20}}']),
        obstacle,
        regions="[body, stop]",
    )
    fields = solve(signorom, deck)
    worst = np.abs(fields["stress"]).max() / (YOUNG_MODULUS * EXPANSION * 300)
    name = f"{element}: stress / (E alpha dT)"
    figures.at_most(f"temperature linear in place, {model}", name, worst, ROUNDING, "no stress")


RADII = (1.0, 2.5)
PROFILES = {"parabolic": parabolic, "logarithmic": logarithmic}


def hot_cylinder(signorom, folder, element, n, profile):
    """The formula; radii, displacements and stresses at the nodes; middles and stresses of the cells."""
    folder.mkdir()
    text, temperature, moment = PROFILES[profile](300.0, *RADII)
    mesh = Mesh()
    grid = [np.linspace(*RADII, n + 1), np.linspace(0, 0.5, max(2, n // 4) + 1)]
    mesh.add_block("body", grid, LINEAR.get(element, element), {(1, 0): "ends", (1, 1): "ends"})
    if element in QUADRATIC:
        mesh.make_quadratic(element)
    n_nodes, cells = len(mesh.coordinates), [nodes for _, name, nodes in mesh.elements if name == "body"]
    foot, obstacle = add_stop(mesh, "axisymmetric")
    mesh.write(folder / "body.msh")
    sections = lines("boundary_conditions", ["{boundary: ends, displacement: {z: 0}}", foot])
    # of the parameter, as a user would write it
    warm = text.replace("300.0", "heat")
    sections += lines("imposed_strains", [f'{{region: body, temperature: "500 + {warm}", reference: 500}}'])
    deck = write_deck(folder, "axisymmetric", sections, obstacle, regions="[body, stop]")
    fields = solve(signorom, deck)
    material = (YOUNG_MODULUS, POISSON_RATIO, EXPANSION)
    cylinder = ThermalCylinder(*material, *RADII, temperature, moment)
    middles = np.array([mesh.coordinates[nodes, 0].mean() for nodes in cells])
    r = mesh.coordinates[:n_nodes, 0]
    return (
        cylinder,
        (r, fields["displacement"][:n_nodes, 0], fields["stress_smoothed"][:n_nodes]),
        (
            middles,
            fields["stress"][: len(cells)],
        ),
    )


def tensor(cylinder, r):
    """rr, zz, hoop as columns xx, yy, zz."""
    radial, hoop, axial = cylinder.stress(r)
    return np.column_stack([radial, axial, hoop])


@pytest.mark.parametrize(("element", "profile"), spread(["T3", "Q4", "T6", "Q8", "Q9"], list(PROFILES)))
def test_hollow_cylinder(signorom, tmp_path, figures, element, profile):
    """Errors of displacements and stresses fall as h^2 or faster; 0.1 % of the largest at the finest mesh."""
    errors = []
    counts = (16, 32, 64) if element in ("T3", "Q4") else (8, 16, 32)
    for n in counts:
        cylinder, (r, u, nodes), (middles, cells) = hot_cylinder(
            signorom, tmp_path / str(n), element, n, profile
        )
        exact, stress = cylinder.displacement(r), tensor(cylinder, middles)
        errors.append(
            [
                np.sqrt(np.mean((u - exact) ** 2)) / np.abs(exact).max(),
                np.sqrt(np.mean((cells[:, :3] - stress) ** 2)) / np.abs(stress).max(),
                np.sqrt(np.mean((nodes[:, :3] - tensor(cylinder, r)) ** 2)) / np.abs(stress).max(),
            ]
        )
    errors = np.array(errors)
    orders = np.log2(errors[:-1] / errors[1:]).min(axis=0)
    problem = f"hollow cylinder, {profile} temperature, {element}"
    source = "Timoshenko, Goodier"
    figures.at_least(problem, "order of the displacement", orders[0], 1.9, source, reference=2.0)
    figures.at_most(problem, f"displacement, {counts[-1]} cells", errors[-1, 0], 1e-3, source)
    # the middle of a triangle is no place where stresses are better than elsewhere
    if element != "T3":
        figures.at_least(problem, "order of the stress", orders[1], 1.9, source, reference=2.0)
        figures.at_most(problem, f"stress in the cells, {counts[-1]} cells", errors[-1, 1], 1e-3, source)
    if element in QUADRATIC:
        figures.at_least(problem, "order of the stress at nodes", orders[2], 1.9, source, reference=2.0)
        figures.at_most(problem, f"stress at nodes, {counts[-1]} cells", errors[-1, 2], 1e-3, source)


@pytest.mark.parametrize("model", ["plane_strain", "plane_stress"])
def test_quarter_of_the_cylinder(signorom, tmp_path, figures, model):
    """The same in the plane, by curved Q8 of a quarter circle: with and without strain across the plane."""
    text, temperature, moment = parabolic(300.0, *RADII)
    mesh = Mesh()
    grid = [np.linspace(*RADII, 17), np.linspace(0, np.pi / 2, 17)]
    mesh.add_block("body", grid, "Q4", {(1, 0): "along_x", (1, 1): "along_y"})
    mesh.make_quadratic("Q8")
    r, angle = mesh.coordinates[:, 0].copy(), mesh.coordinates[:, 1].copy()
    mesh.coordinates[:, :2] = np.column_stack([r * np.cos(angle), r * np.sin(angle)])
    foot, obstacle = add_stop(mesh, "plane_stress")
    mesh.write(tmp_path / "body.msh")
    sides = ["{boundary: along_x, displacement: {y: 0}}", "{boundary: along_y, displacement: {x: 0}}", foot]
    warm = text.replace("300.0", "heat").replace("(r / 2.5)^2", "(x^2 + y^2) / 2.5^2")
    sections = lines("boundary_conditions", sides)
    sections += lines("imposed_strains", [f'{{region: body, temperature: "{warm}", reference: 0}}'])
    fields = solve(signorom, write_deck(tmp_path, model, sections, obstacle, regions="[body, stop]"))
    ends = "held" if model == "plane_strain" else "thin"
    material = (YOUNG_MODULUS, POISSON_RATIO, EXPANSION)
    cylinder = ThermalCylinder(*material, *RADII, temperature, moment, ends)
    found = np.linalg.norm(fields["displacement"][: len(r), :2], axis=1)
    worst = np.abs(found - cylinder.displacement(r)).max() / found.max()
    name, source = "hollow cylinder, parabolic temperature, a quarter", "Timoshenko, Goodier"
    figures.at_most(name, f"{model}, Q8: displacement", worst, 1e-5, source)
    radial, hoop, axial = cylinder.stress(r)
    stress = fields["stress_smoothed"][: len(r)]
    np.testing.assert_allclose(stress[:, :2].sum(axis=1), radial + hoop, atol=0.01 * np.abs(hoop).max())
    worst = np.abs(stress[:, 2] - axial).max() / np.abs(hoop).max()
    figures.at_most(name, f"{model}, Q8: stress across the plane at nodes", worst, 1e-2, source)


@pytest.mark.parametrize("ends", ["held", "thin"])
@pytest.mark.parametrize("profile", PROFILES)
def test_formula_meets_the_equations(ends, profile):
    """The reference itself: free surfaces, equilibrium, e_r = du/dr, and e_z = 0 of held ends."""
    _, temperature, moment = PROFILES[profile](300.0, *RADII)
    cylinder = ThermalCylinder(2.0, 0.3, 0.01, *RADII, temperature, moment, ends)
    r, step = np.linspace(*RADII, 31), 1e-6
    radial, hoop, axial = cylinder.stress(r)
    np.testing.assert_allclose(radial[[0, -1]], 0, atol=1e-12)
    slope = (cylinder.stress(r + step)[0] - cylinder.stress(r - step)[0]) / (2 * step)
    np.testing.assert_allclose(slope, (hoop - radial) / r, atol=1e-6)
    slope = (cylinder.displacement(r + step) - cylinder.displacement(r - step)) / (2 * step)
    rise = 0.01 * temperature(r)
    np.testing.assert_allclose(slope, (radial - 0.3 * (hoop + axial)) / 2.0 + rise, atol=1e-6)
    if ends == "held":
        np.testing.assert_allclose((axial - 0.3 * (radial + hoop)) / 2.0 + rise, 0, atol=1e-12)


ENDS_AND_RANKS = [("free", 1), ("held", 1), ("held", 2), ("held", 4)]


@pytest.mark.parametrize(
    ("solver", "ends_and_ranks"), spread(["condensed", "active_set", "snesvi"], ENDS_AND_RANKS)
)
def test_heated_shrink_fit(signorom, tmp_path, figures, ends_and_ranks, solver):
    """The inner ring dT warmer: the overlap grows by alpha dT d, and by (1 + nu) times that with held ends."""
    ends, n_ranks = ends_and_ranks
    changes = {"poisson_ratio: 0.3": "poisson_ratio: 0.3, thermal_expansion: 1.1e-5"}
    changes |= {"bore_pressure: {min: 0.0, max: 60.0, unit: MPa}": "heat: {min: 0.0, max: 60.0}"}
    changes |= {"loads:\n": "imposed_strains:\n", "grid: {bore_pressure: 4}": "grid: {heat: 4}"}
    warm = '{region: inner_ring, temperature: "20 + heat", reference: 20}'
    changes |= {"{boundary: bore, pressure: bore_pressure}": warm}
    changes |= {"points: [{bore_pressure: 0}, {bore_pressure: 60}]": "points: [{heat: 60}]"}
    if ends == "free":
        changes["  - {boundary: top, displacement: {z: 0}}\n"] = ""
    deck = write_input("shrink_fit", tmp_path, changes)
    deck.write_text(f"{deck.read_text()}solver: {{type: {solver}}}\n")
    signorom("sample", deck, folder=tmp_path, n_ranks=n_ranks)
    snapshots = read_snapshots(tmp_path / "results" / "shrink_fit" / "snapshots.h5")
    growth = 1.1e-5 * 60 * shrink_fit.MIDDLE * (1 if ends == "free" else 1.3)
    cold = shrink_fit.pressure(ends)
    expected = cold * (1 + growth / shrink_fit.INTERFERENCE)
    found = snapshots["multipliers"][-1].sum() / (np.pi * shrink_fit.MIDDLE * 2.0)
    name = f"contact pressure at 60 degrees, ends {ends}, {solver}, {n_ranks} ranks"
    figures.compare("heated shrink fit", name, found, expected, 1e-3, "Lamé", "MPa")


def test_bimetal_strip(signorom, tmp_path, figures):
    """Curvature of two strips of different metals in the middle of their length, in plane stress, Q8."""
    length, thicknesses, moduli, expansions = 20.0, (0.4, 0.6), (2.0e11, 0.7e11), (1.1e-5, 2.4e-5)
    mesh = Mesh()
    grid = [np.linspace(0, length, 81), np.array([0, 0.2, 0.4, 0.7, 1.0])]
    mesh.add_block("first", grid, "Q4", {(0, 0): "middle"})
    centers = [mesh.coordinates[nodes, 1].mean() for _, _, nodes in mesh.elements]
    mesh.elements = [
        (kind, "second" if name == "first" and y > thicknesses[0] else name, nodes)
        for (kind, name, nodes), y in zip(mesh.elements, centers, strict=True)
    ]
    corner = int(np.argmin(np.linalg.norm(mesh.coordinates, axis=1)))
    mesh.elements.append(("P1", "corner", [corner]))
    mesh.make_quadratic("Q8")
    line = np.flatnonzero((np.abs(mesh.coordinates[:, 1]) < 1e-9) & (mesh.coordinates[:, 0] < length / 2))
    foot, obstacle = add_stop(mesh, "plane_stress")
    mesh.write(tmp_path / "body.msh")
    held = ["{boundary: middle, displacement: {x: 0}}", "{boundary: corner, displacement: {y: 0}}", foot]
    warm = [f"{{region: {name}, temperature: heat, reference: 0}}" for name in ("first", "second")]
    deck = write_deck(
        tmp_path,
        "plane_stress",
        lines("boundary_conditions", held) + lines("imposed_strains", warm),
        obstacle,
    )
    text = deck.read_text().splitlines()
    materials = [
        f"  {name}: {{regions: {regions}, young_modulus: {e}, poisson_ratio: 0.3, thermal_expansion: {alpha}}}"
        for name, regions, e, alpha in zip(
            ("first", "second"), ("[first, stop]", "[second]"), moduli, expansions, strict=True
        )
    ]
    text[2:3] = ["materials:", *materials]
    deck.write_text("\n".join([*text, ""]))
    fields = solve(signorom, deck)
    x, v = mesh.coordinates[line, 0], fields["displacement"][line, 1]
    found = 2 * np.polyfit(x, v, 2)[0]
    # the second strip lies above and expands more: the strip bends downwards
    expected = -bimetal_curvature(thicknesses, moduli, expansions, 300)
    figures.compare("bimetal strip", "curvature", found, expected, 1e-6, "Timoshenko 1925", "1/m")


# length unit, factor of lengths and of stresses, temperature offset
UNITS = {"m, °C": ("m", 1.0, 1.0, 0.0), "mm, K": ("mm", 1e3, 1e-6, 273.15)}


@pytest.mark.parametrize(("solver", "units"), spread(["condensed", "active_set", "snesvi"], list(UNITS)))
def test_heat_closes_a_gap(signorom, tmp_path, figures, solver, units):
    """A bar of length 1 m expands across a gap of 1 mm and presses on one of the same length; cold, it lets go again.

    p = (alpha dT L - gap) E / 2 L in plane stress without Poisson's effect; the gap closes at dT = 83.33.
    """
    unit, lengths, stresses, offset = UNITS[units]
    mesh = stacked_blocks("Q4", 2)
    mesh.coordinates[mesh.nodes_of("upper"), 1] += 0.001
    mesh.coordinates *= lengths
    mesh.write(tmp_path / "body.msh")
    held = [
        "{boundary: bottom, displacement: {y: 0}}",
        "{boundary: top, displacement: {y: 0}}",
        "{boundary: left, displacement: {x: 0}}",
    ]
    warm = [f'{{region: lower, temperature: "{20 + offset} + heat", reference: {20 + offset}}}']
    deck = write_deck(
        tmp_path,
        "plane_stress",
        lines("boundary_conditions", held) + lines("imposed_strains", warm),
        "{first: lower_face, second: upper_face, direction: [0, 1]}",
        f"young_modulus: {YOUNG_MODULUS * stresses}, poisson_ratio: 0, thermal_expansion: {EXPANSION}",
    )
    deck.write_text(
        f"{deck.read_text()}units: {{length: {unit}}}\nsolver: {{type: {solver}}}\n"
        "training: {grid: {heat: 25}}\nreduction: {method: hhr}\n"
    )
    signorom("sample", deck, folder=tmp_path)
    snapshots = read_snapshots(tmp_path / "results" / "body" / "snapshots.h5")
    heat = snapshots["parameters"][:, 0]
    pressure = np.maximum(0, (EXPANSION * heat - 0.001) * YOUNG_MODULUS / 2) * stresses
    assert (pressure == 0).sum() == 6
    worst = np.abs(snapshots["multipliers"].sum(axis=1) / lengths - pressure).max() / pressure.max()
    figures.at_most(
        "gap closed by heat",
        f"forces at 25 temperatures, {solver}, {units}",
        worst,
        ROUNDING,
        "springs in series",
    )
    faces = mesh.nodes_of("lower_face")
    free = np.minimum(EXPANSION * heat, EXPANSION * heat - pressure / (YOUNG_MODULUS * stresses)) * lengths
    found = snapshots["displacement"].reshape(len(heat), -1, 2)[:, faces, 1]
    np.testing.assert_allclose(found, np.tile(free[:, None], len(faces)), atol=ROUNDING * free.max())


# the tolerance of reduction.stiffness_tolerance where responses are interpolated
MODULI = {"E": ("modulus", "0.3", 1e-10), "E and nu": ("modulus", "ratio", 1e-6)}


@pytest.mark.parametrize("constants", MODULI)
@pytest.mark.parametrize("model", ["plane_strain", "plane_stress"])
def test_models_of_warm_bodies(signorom, tmp_path, figures, model, constants):
    """Heat, swelling, expansion and moduli vary together: condensed models against K factored at each point.

    The upper block is held by contact alone. Its forces, and the energies, which heat alone does not make zero.
    """
    young_modulus, poisson_ratio, tolerance = MODULI[constants]
    mesh = stacked_blocks("mixed", 2)
    mesh.coordinates[mesh.nodes_of("upper"), 1] += 0.01
    mesh.write(tmp_path / "body.msh")
    held = ["{boundary: bottom, displacement: {y: 0}}", "{boundary: left, displacement: {x: 0}}"]
    warm = [
        '{region: lower, temperature: "heat * (1 + x - 0.3 * y)", reference: 0}',
        '{region: lower, strain: {xx: "1e-4 * heat * y", yy: 2e-3, xy: "1e-6 * heat"}}',
        "{region: upper, temperature: 2 * heat, reference: 100 * alpha}",
    ]
    sections = lines("boundary_conditions", held) + lines("loads", ["{boundary: top, pressure: press}"])
    deck = write_deck(
        tmp_path,
        model,
        sections + lines("imposed_strains", warm),
        "{first: lower_face, second: upper_face, direction: [0, 1]}",
        f"young_modulus: {young_modulus}, poisson_ratio: {poisson_ratio}, thermal_expansion: 1e-4 * alpha",
    )
    more = ", press: {min: 1e3, max: 2e4}, alpha: {min: 0.5, max: 1.5}"
    more += ", modulus: {min: 1.0e6, max: 3.0e6}, ratio: {min: 0.2, max: 0.4}}"
    text = deck.read_text().replace("max: 400}}", f"max: 400}}{more}")
    text = text.replace(
        "output: {points: [{heat: 300}]}\n", "training: {sobol: 24}\ntest: {sobol: 10, seed: 3}\n"
    )
    deck.write_text(text)
    signorom("run", deck, folder=tmp_path, n_ranks=2)
    table = read_table(tmp_path / "results" / "body" / "validation.csv")
    problem, source = f"warm blocks, {model}, with {constants}", "K factored at each point"
    figures.at_most(problem, "largest error of the forces", max(table["e_lambda_all"]), tolerance, source)
    figures.at_most(
        problem, "largest error of the energy", max(table["e_energy_relative"]), tolerance, source
    )
    assert min(table["n_active_full_order"]) < max(table["n_active_full_order"])
