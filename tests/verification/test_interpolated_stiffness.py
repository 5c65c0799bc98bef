# SPDX-License-Identifier: BSD-3-Clause
"""Models whose elastic constants depend on the parameters, against the full order that factors K anew at each point."""

import re

import h5py
import numpy as np
import pytest
import yaml

from runs import read_report, read_table
from varying_decks import (
    HANGING,
    MODULUS,
    RATIOS,
    write_core_and_rim,
    write_one_ratio,
    write_study,
    write_two_materials,
)

# moduli that scale a whole body: what is left is rounding; otherwise reduction.stiffness_tolerance
EXACT = 1e-10
TOLERANCE = 1e-6


def largest_errors(signorom, deck, n_ranks=1):
    """Of validation.csv; every point has an answer."""
    signorom("run", deck, folder=deck.parent, n_ranks=n_ranks)
    table = read_table(deck.parent / "results" / deck.stem / "validation.csv")
    assert {"condensed"} == set(table["solver"])
    return max(map(float, table["e_lambda_all"])), max(map(float, table["e_u"]))


@pytest.mark.parametrize(
    ("name", "changes", "allowed"),
    [
        ("pellet_cladding", MODULUS, EXACT),
        # test_training_points_that_say_little has these constants, too
        pytest.param("pellet_cladding", RATIOS, TOLERANCE, marks=pytest.mark.long),
        # test_bound_is_no_less_than_the_error has these, too
        pytest.param("bracket", HANGING, TOLERANCE, marks=pytest.mark.long),
    ],
    ids=["modulus", "ratios", "hanging"],
)
def test_model_is_the_full_order(signorom, tmp_path, figures, name, changes, allowed):
    """All defaults: forces at points with constants that no factorization of the model had."""
    deck = write_study(name, tmp_path, changes)
    forces, _ = largest_errors(signorom, deck)
    figures.at_most(
        f"{name}, elastic constants as parameters", "forces", forces, allowed, "K factored at each point"
    )


@pytest.fixture(scope="module")
def trained_at_a_node(signorom, tmp_path_factory):
    """Case b with two ratios as parameters, trained at one node of the interpolation: deck and largest errors."""
    folder = tmp_path_factory.mktemp("middle")
    deck = write_study("pellet_cladding", folder, RATIOS)
    rows = [f"{pressure},{height},0.3,0.325" for pressure in (5, 100, 200) for height in (0.6, 3, 6)]
    (folder / "middle.csv").write_text("\n".join(["P1,h1,nu_fuel,nu_cladding", *rows, ""]))
    deck.write_text(re.sub(r"(?m)^training: .*$", "training: {file: middle.csv}", deck.read_text()))
    return deck, largest_errors(signorom, deck)


def test_training_points_that_say_little(trained_at_a_node, figures):
    """All training points have the constants of a node, where interpolation is exact: probes see the other ones."""
    _, (forces, _) = trained_at_a_node
    figures.at_most(
        "pellet_cladding, trained at one node", "forces", forces, TOLERANCE, "K factored at each point"
    )


@pytest.mark.parametrize("n_ranks", [1, 3])
def test_two_materials_in_space(signorom, tmp_path, figures, n_ranks):
    """Ratio of moduli and Poisson's ratio of one body together; forces, and displacements by interpolation."""
    deck = write_two_materials(tmp_path)
    deck.write_text(deck.read_text() + "reduction: {displacement_tolerance: 0}\n")
    forces, displacement = largest_errors(signorom, deck, n_ranks)
    problem = f"core and rim in space, {n_ranks} ranks"
    figures.at_most(problem, "forces", forces, TOLERANCE, "K factored at each point")
    figures.at_most(problem, "displacements", displacement, TOLERANCE, "K factored at each point")


def test_ranks_agree(signorom, tmp_path):
    """One model on 1 and 4 ranks, a body that only contact holds."""
    answers = []
    for n_ranks in (1, 4):
        folder = tmp_path / str(n_ranks)
        folder.mkdir()
        deck = write_one_ratio(folder)
        signorom("sample", deck, folder=folder, n_ranks=n_ranks)
        signorom("train", deck, folder=folder, n_ranks=n_ranks)
        model = folder / "results" / deck.stem / "model.h5"
        signorom("predict", model, "--at", "ratio=0.7,E=1.3e5,P=210", "--output", "answer.csv", folder=folder)
        row = read_table(folder / "answer.csv")
        answers.append([float(values[0]) for column, values in row.items() if column.startswith("lambda_")])
    assert max(answers[0]) > 0
    for other in answers[1:]:
        np.testing.assert_allclose(other, answers[0], rtol=0, atol=1e-10 * max(answers[0]))


def test_tolerance_out_of_reach(signorom, tmp_path):
    """No interpolation is better than rounding: a sentence with the error that was reached, exit code 3, no model."""
    deck = write_one_ratio(tmp_path)
    deck.write_text(deck.read_text() + "reduction: {stiffness_tolerance: 1.0e-18}\n")
    signorom("sample", deck, folder=tmp_path)
    done = signorom.run("train", deck, folder=tmp_path)
    assert done.returncode == 3
    assert "reduction.stiffness_tolerance (1.0e-18)" in done.stderr
    assert not (tmp_path / "results" / deck.stem / "model.h5").exists()


def test_report_tells_the_interpolation(signorom, tmp_path):
    """Factorizations, nodes and the measured error stand in the report."""
    deck = write_two_materials(tmp_path)
    signorom("sample", deck, folder=tmp_path)
    signorom("train", deck, folder=tmp_path)
    report = read_report(tmp_path, "two_materials")["reduction"]
    assert report["kind"] == "interpolated"
    # all polynomials of two variables up to the degree 2
    assert report["n_factorizations"] >= 6
    assert 0 < report["largest_error"] <= TOLERANCE
    assert 1 <= report["worst_training_point"] <= 20


MODES = {
    "core_and_rim": (write_core_and_rim, 5),
    "one_ratio": (write_one_ratio, 0.02),
    # two interpolated constants in a body: the forces have no bound, displacements have one
    "two_materials": (write_two_materials, 0.02),
}


# of displacements in energy: the default of reduction.displacement_tolerance
FIELD_TOLERANCE = 1e-3


def validate_modes(signorom, folder, name, n_ranks=1):
    """Columns of validation.csv of a model that has room for no displacement but that by modes."""
    write, room = MODES[name]
    deck = write(folder)
    text = deck.read_text().replace("test: {sobol: 6, seed: 3}", "test: {latin_hypercube: 20}")
    deck.write_text(text + f"reduction: {{max_full_order_size: {room}}}\n")
    signorom("run", deck, folder=folder, n_ranks=n_ranks)
    return read_table(folder / "results" / deck.stem / "validation.csv")


@pytest.fixture(scope="module")
def one_ratio_by_modes(signorom, tmp_path_factory):
    """Of the deck with one constant, on one rank."""
    return validate_modes(signorom, tmp_path_factory.mktemp("one_ratio"), "one_ratio")


@pytest.mark.parametrize(
    "name", [pytest.param("core_and_rim", marks=pytest.mark.long), "one_ratio", "two_materials"]
)
def test_displacements_by_modes(signorom, tmp_path, figures, one_ratio_by_modes, name):
    """20 training points; bounds of the energy of what is missing; without prescribed displacements |u_r| is below |u|.

    Modes from these points alone miss the tolerance by a factor of 10 and more.
    """
    table = one_ratio_by_modes if name == "one_ratio" else validate_modes(signorom, tmp_path, name)
    effectivity = table["displacement_bound"] / table["e_u_energy_relative"]
    assert (table["e_u_energy_relative"] > 1e-10).all()
    assert effectivity.min() >= 1
    problem = f"{name}, displacements by modes"
    figures.at_most(problem, "median bound over error", np.median(effectivity), 4, "K factored")
    figures.at_most(problem, "largest bound over error", effectivity.max(), 10, "K factored")
    error = np.percentile(table["e_u_energy_relative"], 95)
    figures.at_most(
        problem, "energy, 95 % of unseen points", error, FIELD_TOLERANCE, "K factored at each point"
    )
    told = np.percentile(table["displacement_bound"], 95)
    figures.at_most(
        problem, "what answers tell of it, 95 %", told, FIELD_TOLERANCE, "K factored at each point"
    )


def test_ranks_agree_on_modes(signorom, tmp_path, one_ratio_by_modes):
    """Modes, Galerkin's equations and residuals are the same on 1 and 3 ranks, a body that only contact holds."""
    table = validate_modes(signorom, tmp_path, "one_ratio", 3)
    for column in ("e_u", "e_u_energy", "displacement_bound"):
        np.testing.assert_allclose(table[column], one_ratio_by_modes[column], rtol=1e-6)


# millimeters and degrees Celsius, meters and kelvin: texts of the deck of two materials
HEAT = {
    # no load at all would leave the upper block to rounding
    "P: {min: 0.0,": "P: {min: 10.0,",
    "materials:\n": "  T: {min: 20, max: 120, unit: °C}\nmaterials:\n",
    "poisson_ratio: 0.25}": "poisson_ratio: 0.25, thermal_expansion: 1.0e-5}",
    "loads:\n": "imposed_strains:\n  - {region: upper, temperature: T, reference: 20}\nloads:\n",
}
METERS = {
    "length: mm": "length: m",
    "model: solid": "model: solid, length_unit: mm",
    "{min: 100.0e3, max: 250.0e3, unit: MPa}": "{min: 100.0e9, max: 250.0e9, unit: Pa}",
    "{min: 10.0, max: 300.0, unit: MPa}": "{min: 10.0e6, max: 300.0e6, unit: Pa}",
    "P * (1.2 - x)": "P * (1.2 - 1e3 * x)",
    "4e-4 * (x^2 + y)": "4e-7 * (1e6 * x^2 + 1e3 * y)",
    "{min: 20, max: 120, unit: °C}": "{min: 293.15, max: 393.15, unit: K}",
    "reference: 20": "reference: 293.15",
}


def test_units_do_not_matter(signorom, tmp_path):
    """Forces and relative bounds of a model by modes in millimeters and degrees Celsius, and in meters and kelvin."""
    answers = []
    points = ("E=1.3e5,P=210,T=95", "E=1.3e11,P=210e6,T=368.15")
    for changes, point in zip(({}, METERS), points, strict=True):
        folder = tmp_path / str(len(changes))
        folder.mkdir()
        deck = write_two_materials(folder)
        text = deck.read_text() + "reduction: {max_full_order_size: 0.02}\n"
        for old, new in (HEAT | changes).items():
            assert old in text
            text = text.replace(old, new)
        deck.write_text(text)
        signorom("sample", deck, folder=folder)
        signorom("train", deck, folder=folder)
        model = folder / "results" / "two_materials" / "model.h5"
        signorom(
            "predict", model, "--at", f"{point},ratio=0.7,nu=0.36", "--output", "answer.csv", folder=folder
        )
        row = read_table(folder / "answer.csv")
        forces = [float(cells[0]) for column, cells in row.items() if column.startswith("lambda_")]
        answers.append([*np.array(forces) / max(forces), float(row["displacement_bound"][0])])
        assert max(forces) > 0
    np.testing.assert_allclose(answers[1], answers[0], rtol=1e-6, atol=1e-9)


def trained_for_bounds(name, signorom, folder, request):
    """Deck with results beside it."""
    if name == "pellet_cladding":
        return request.getfixturevalue("trained_at_a_node")[0]
    deck = write_one_ratio(folder) if name == "core_and_rim" else write_study(name, folder, HANGING)
    for command in ("sample", "train"):
        signorom(command, deck, folder=folder)
    return deck


def with_numbers(text, values):
    """The deck with numbers in the place of some parameters, whose ranges stay out."""
    for name, value in values.items():
        text = re.sub(rf"(?m)^  {name}: .*\n", "", text)
        text = re.sub(rf"(_modulus|_ratio): (2 \* )?{name}( \* ratio)?\b", rf"\1: \g<2>{value!r}\g<3>", text)
        text = text.replace(f" * {name},", f" * {value!r},")
    return text


@pytest.mark.parametrize("name", ["pellet_cladding", "bracket", "core_and_rim"])
def test_bound_is_no_less_than_the_error(request, signorom, tmp_path, figures, pytestconfig, name):
    """In the norm of W(mu), which a model of constant stiffness has; bodies of one interpolated constant.

    At 2 points, with --all-points at 24.
    """
    (tmp_path / "varying").mkdir()
    deck = trained_for_bounds(name, signorom, tmp_path / "varying", request)
    text = deck.read_text()
    ranges = yaml.safe_load(text)["parameters"]
    constants = [key for key in ranges if key in ("E", "nu", "nu_fuel", "nu_cladding", "ratio")]
    rng = np.random.default_rng(12)
    effectivities = []
    with h5py.File(deck.parent / "results" / deck.stem / "model.h5") as file:
        largest = file["clusters/1/largest_size"][()]
    for i in range(24 if pytestconfig.getoption("--all-points") else 2):
        point = {key: rng.uniform(float(ends["min"]), float(ends["max"])) for key, ends in ranges.items()}
        folder = tmp_path / str(i)
        folder.mkdir()
        fixed = folder / deck.name
        others = {key: value for key, value in point.items() if key not in constants}
        shape = re.sub(
            r"training: .*", f"training: {{grid: {{{', '.join(f'{key}: 2' for key in others)}}}}}", text
        )
        fixed.write_text(with_numbers(shape, {key: point[key] for key in constants}))
        for file in deck.parent.glob("*.msh"):
            (folder / file.name).write_text(file.read_text())
        signorom("sample", fixed, folder=folder)
        signorom("train", fixed, folder=folder)
        exact, _ = answer_at(signorom, folder, deck.stem, others)
        found, bound = answer_at(signorom, deck.parent, deck.stem, point)
        with h5py.File(folder / "results" / deck.stem / "model.h5") as file:
            part = file["clusters/1"]
            free = np.setdiff1d(np.arange(len(exact)), part["anchors"][()] - 1)
            compliance = part["compliance"][()][np.ix_(free, free)]
        wrong = (found - exact)[free]
        # bounds are relative to the size of the answer, at least a thousandth of the largest in training
        size = max(np.sqrt(exact[free] @ compliance @ exact[free]), 1e-3 * largest)
        error = np.sqrt(wrong @ compliance @ wrong) / size
        if error > 1e-10:
            effectivities.append(bound / error)
    assert effectivities
    assert min(effectivities) >= 1
    figures.at_most(
        f"{name}, interpolation", "median bound over error", np.median(effectivities), 4, "K factored"
    )


def answer_at(signorom, folder, name, point):
    """Contact forces and their bound from the model in a folder."""
    values = ",".join(f"{key}={value!r}" for key, value in point.items())
    model = folder / "results" / name / "model.h5"
    signorom("predict", model, "--at", values, "--output", "answer.csv", folder=folder)
    row = read_table(folder / "answer.csv")
    forces = [float(cells[0]) for column, cells in row.items() if column.startswith("lambda_")]
    return np.array(forces), float(row["error_bound"][0])
