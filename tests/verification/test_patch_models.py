# SPDX-License-Identifier: BSD-3-Clause
"""Contact patch test for every element and mechanical model, on distorted meshes.

Uniaxial stress p = E' U / H with E' = E / (1 - nu^2) in plane strain and E elsewhere; the sides move by eps_side times
the distance from the support. Linear displacements, constant stress: in the span of every element.
"""

import numpy as np
import pytest
import yaml

from block_meshes import QUADRATIC, SOLIDS, consistent_areas, stacked_blocks
from runs import read_fields, write_deck_with
from spread import spread

TOLERANCE = 1e-10
YOUNG_MODULUS = 2.0e6
HEIGHT = 2.0
STROKE = 0.1
CASES = [
    (model, element)
    for model in ("plane_strain", "plane_stress", "axisymmetric")
    for element in ("T3", "Q4", "mixed", "T6", "Q8", "Q9", "T6 and Q8")
] + [("solid", element) for element in ("T4", "H8", "H27", "W6", "P5", "P14", SOLIDS)]
# Order of the components in fields.h5, VTK's; zz is the hoop stress in axisymmetry.
STRESS = ["xx", "yy", "zz", "xy", "yz", "xz"]
AXES = {"axisymmetric": "rz", "solid": "xyz"}


def supports(model, poisson_ratio):
    """Bottom held, top moved down; with nu = 0 fully clamped, else on planes of symmetry."""
    axes = AXES.get(model, "xy")
    up, across = axes[-1], axes[:-1]
    if poisson_ratio == 0:
        clamped = "".join(f"{axis}: 0, " for axis in across)
        return [("bottom", f"{clamped}{up}: 0"), ("top", f"{clamped}{up}: -stroke")]
    sides = [(name, f"{axis}: 0") for name, axis in zip(("left", "front"), across, strict=False)]
    return [("bottom", f"{up}: 0"), ("top", f"{up}: -stroke"), *sides]


def patch_deck(folder, model, poisson_ratio):
    """The deck of a model."""
    entries = "".join(
        f"\n  - {{boundary: {name}, displacement: {{{values}}}}}"
        for name, values in supports(model, poisson_ratio)
    )
    direction = "[0, 0, 1]" if model == "solid" else "[0, 1]"
    return write_deck_with(
        "patch_models",
        folder,
        {
            "model: plane_strain": f"model: {model}",
            "poisson_ratio: 0.0": f"poisson_ratio: {poisson_ratio}",
            "boundary_conditions: []": f"boundary_conditions:{entries}",
            "direction: [0, 1]": f"direction: {direction}",
        },
    )


def uniaxial(model, poisson_ratio):
    """Pressure, strain of the sides, stress across the plane of plane strain."""
    strain = STROKE / HEIGHT
    if model == "plane_strain":
        pressure = YOUNG_MODULUS / (1 - poisson_ratio**2) * strain
        return pressure, poisson_ratio / (1 - poisson_ratio) * strain, -poisson_ratio * pressure
    return YOUNG_MODULUS * strain, poisson_ratio * strain, 0.0


@pytest.mark.parametrize("poisson_ratio", [0.0, 0.3])
@pytest.mark.parametrize(("model", "element"), CASES)
def test_uniaxial_stress(signorom, tmp_path, figures, model, element, poisson_ratio):
    """Displacement, multipliers, contact pressure and stress everywhere."""
    n_dim = 3 if model == "solid" else 2
    mesh = stacked_blocks(element, n_dim)
    deck = patch_deck(tmp_path, model, poisson_ratio)
    if model == "axisymmetric" and element in QUADRATIC:
        # off the axis, where a corner of a quadratic edge bears no force
        mesh.coordinates[:, 0] += 1.0
        held = f'{{boundary: left, displacement: {{r: "{poisson_ratio / HEIGHT} * stroke"}}}}'
        deck.write_text(deck.read_text().replace("{boundary: left, displacement: {r: 0}}", held))
    mesh.write(tmp_path / "blocks.msh")
    signorom("solve", deck, folder=tmp_path)
    fields = read_fields(tmp_path / "results" / "patch_models" / "fields.h5")
    pressure, side_strain, across = uniaxial(model, poisson_ratio)

    expected = side_strain * mesh.coordinates
    expected[:, n_dim - 1] = -STROKE * (mesh.coordinates[:, n_dim - 1] + HEIGHT / 2) / HEIGHT
    expected[:, n_dim:] = 0
    worst = [np.abs(fields["displacement"] - expected).max() / STROKE]

    areas = consistent_areas(mesh, "lower_face", model == "axisymmetric")
    faces = mesh.nodes_of("lower_face")
    forces = pressure * areas[faces]
    worst.append(np.abs(fields["multipliers_full_order"] - forces).max() / forces.max())
    touching = np.union1d(faces, mesh.nodes_of("upper_face"))
    worst.append(np.abs(fields["contact_pressure"][touching] / pressure - 1).max())

    stress = np.zeros(len(STRESS))
    stress[STRESS.index("zz")] = across
    stress[STRESS.index("zz" if n_dim == 3 else "yy")] = -pressure
    worst.append(np.abs(fields["stress"] - stress).max() / pressure)
    name = f"{model}, {element}, nu = {poisson_ratio}: displacement, forces, pressure, stress"
    figures.at_most("patch test, distorted meshes", name, max(worst), TOLERANCE, "uniaxial stress")
    np.testing.assert_allclose(fields["stress_smoothed"] - stress, 0, atol=TOLERANCE * pressure)
    equivalent = np.sqrt((pressure**2 + across**2 + (pressure + across) ** 2) / 2)
    np.testing.assert_allclose(fields["von_mises"], equivalent, rtol=TOLERANCE)
    np.testing.assert_allclose(fields["von_mises_smoothed"], equivalent, rtol=TOLERANCE)

    report = yaml.safe_load((tmp_path / "results" / "patch_models" / "report.yaml").read_text())
    assert report["units"]["force"] == ("N/m" if model.startswith("plane") else "N")
    reactions = {entry["boundary"]: entry for entry in report["points"]["1"]["reactions"].values()}
    up = AXES.get(model, "xy")[-1]
    assert reactions["bottom"][up] == pytest.approx(forces.sum(), rel=TOLERANCE)
    assert reactions["top"][up] == pytest.approx(-forces.sum(), rel=TOLERANCE)
    for name in ("left", "front"):
        if name in reactions:
            (value,) = (reactions[name][axis] for axis in AXES.get(model, "xy") if axis in reactions[name])
            assert abs(value) <= TOLERANCE * forces.sum()


OTHER_CASES = [
    ("axisymmetric", "mixed"),
    ("solid", "T4"),
    ("solid", "H8"),
    ("plane_strain", "T6 and Q8"),
    ("solid", "H27"),
    ("solid", SOLIDS),
]


@pytest.mark.parametrize(
    ("case", "solver_and_ranks"),
    spread(OTHER_CASES, [("active_set", 1), ("snesvi", 1), ("active_set", 3), ("snesvi", 3)]),
)
def test_other_solvers_and_ranks(signorom, tmp_path, case, solver_and_ranks):
    """The multipliers by the solvers that need no dense matrix, on one and three ranks."""
    (model, element), (solver, n_ranks) = case, solver_and_ranks
    mesh = stacked_blocks(element, 3 if model == "solid" else 2)
    mesh.write(tmp_path / "blocks.msh")
    deck = patch_deck(tmp_path, model, 0.3)
    deck.write_text(deck.read_text().replace("type: condensed", f"type: {solver}"))
    signorom("solve", deck, folder=tmp_path, n_ranks=n_ranks)
    fields = read_fields(tmp_path / "results" / "patch_models" / "fields.h5")
    faces = mesh.nodes_of("lower_face")
    forces = uniaxial(model, 0.3)[0] * consistent_areas(mesh, "lower_face", model == "axisymmetric")[faces]
    np.testing.assert_allclose(
        fields["multipliers_full_order"], forces, rtol=0, atol=TOLERANCE * forces.max()
    )


# Node orders that turn an element inside out.
INSIDE_OUT = {"T3": [0, 2, 1], "Q4": [0, 3, 2, 1], "T4": [0, 2, 1, 3], "H8": [0, 3, 2, 1, 4, 7, 6, 5]}
INSIDE_OUT |= {"W6": [0, 2, 1, 3, 5, 4], "P5": [0, 3, 2, 1, 4]}
SOLID = ("T4", "H8", "W6", "P5")


@pytest.mark.parametrize("element", INSIDE_OUT)
def test_inverted_cells_are_turned(signorom, tmp_path, figures, element):
    """Every other cell written inside out: the same uniaxial stress."""
    model = "solid" if element in SOLID else "plane_strain"
    mesh = stacked_blocks(element, 3 if model == "solid" else 2)
    regions = ("lower", "upper")
    mesh.elements = [
        (kind, name, [nodes[i] for i in INSIDE_OUT[kind]] if name in regions and i_element % 2 else nodes)
        for i_element, (kind, name, nodes) in enumerate(mesh.elements)
    ]
    mesh.write(tmp_path / "blocks.msh")
    signorom("solve", patch_deck(tmp_path, model, 0.3), folder=tmp_path)
    fields = read_fields(tmp_path / "results" / "patch_models" / "fields.h5")
    pressure = uniaxial(model, 0.3)[0]
    axis = STRESS.index("zz" if model == "solid" else "yy")
    worst = np.abs(fields["stress"][:, axis] / -pressure - 1).max()
    name = f"half of the {element} inside out: stress"
    figures.at_most("patch test, distorted meshes", name, worst, TOLERANCE, "uniaxial stress")


@pytest.mark.parametrize("element", INSIDE_OUT)
def test_flat_cell_is_named(signorom, tmp_path, element):
    """A cell whose nodes lie in one line or plane: its region, its number in gmsh and its quality."""
    n_dim = 3 if element in SOLID else 2
    mesh = stacked_blocks(element, n_dim, moved=0.0)
    i_cell = next(i for i, (_, name, _) in enumerate(mesh.elements) if name == "upper")
    nodes = mesh.elements[i_cell][2]
    mesh.coordinates[nodes, n_dim - 1] = mesh.coordinates[nodes[0], n_dim - 1]
    mesh.write(tmp_path / "blocks.msh")
    deck = patch_deck(tmp_path, "solid" if n_dim == 3 else "plane_strain", 0.3)
    done = signorom.run("check", deck, folder=tmp_path)
    assert done.returncode == 2
    said = f"cell {i_cell + 1} (number in gmsh) of region 'upper' is flat: its quality is 0.00E+00"
    assert f"blocks.msh: error: {said}" in done.stderr
