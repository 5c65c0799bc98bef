# SPDX-License-Identifier: BSD-3-Clause
"""Hyper-reduced models of bodies whose elastic constants depend on the parameters, against K factored at each point."""

import re

import h5py
import numpy as np
import pytest

from runs import read_report, read_table, write_deck_with, write_input
from test_interpolated_stiffness import answer_at, with_numbers

N_PAIRS = 7
# rounding of the snapshots over the smallest singular value kept, as in test_full_basis.py
ROUNDING = 1e-9
# [-] what 30 snapshots leave of a problem of five parameters
COARSE = 0.3
# [-] what a dozen leave of a problem of two
SMALL = 5e-3

RANGES = """  right: {min: 0.01, max: 0.1, unit: m}
  E: {min: 50.0, max: 200.0, unit: Pa}
  nu: {min: 0.1, max: 0.4, unit: "1"}
"""
MATERIALS = """materials:
  lower: {regions: [lower], young_modulus: E, poisson_ratio: nu, thermal_expansion: 1}
  upper: {regions: [upper], young_modulus: 100.0, poisson_ratio: 0.3, thermal_expansion: 1}
"""
FIXED = "materials: {block: {regions: [lower, upper], young_modulus: 100.0, poisson_ratio: 0.3}}\n"
VARYING = {"  right: {min: 0.01, max: 0.1, unit: m}\n": RANGES, FIXED: MATERIALS}
HEAT = """imposed_strains:
  - {region: lower, temperature: "0.01 * heat * (1 + x)", reference: 0}
  - {region: upper, strain: 0.002}
contact:
"""
SAME_POINTS = {
    "training: {grid: {left: 6, right: 6}}": "training: {sobol: 30}",
    "test: {grid: {left: 9, right: 9}}": "test: {sobol: 30}",
}


def write_stamps(folder, *changes):
    """The deck of test_full_basis.py, all modes on the whole mesh, with changes."""
    merged = {}
    for change in changes:
        merged.update(change)
    return write_deck_with("full_basis", folder, merged)


def heated(parameters):
    """Changes that heat both bodies; `parameters` as they stand in the deck after other changes."""
    return {
        "  right: {min: 0.01, max: 0.1, unit: m}\n": parameters + "  heat: {min: 0, max: 1}\n",
        "contact:\n": HEAT,
    }


def largest_errors(signorom, deck, n_ranks=1, share=1.0):
    """Of displacement and forces in validation.csv, or a quantile; every point has an answer of the reduced model."""
    signorom("run", deck, folder=deck.parent, n_ranks=n_ranks)
    table = read_table(deck.parent / "results" / deck.stem / "validation.csv")
    assert "condensed" not in set(table["solver"])
    return np.quantile(table["e_u"], share), np.nanquantile(table["e_lambda_all"], share)


@pytest.mark.parametrize(
    ("model", "n_ranks"), [("plane_strain", 1), ("plane_strain", 3), ("plane_stress", 1)]
)
def test_answers_at_training_points_are_the_full_order_ones(signorom, tmp_path, figures, model, n_ranks):
    """All modes on the whole mesh: the solutions at the training points are in the span, so they are the answers."""
    deck = write_stamps(tmp_path, VARYING, SAME_POINTS, {"model: plane_strain": f"model: {model}"})
    problem = f"all modes, whole mesh, {model}, E and nu as parameters, {n_ranks} ranks"
    for name, value in zip(("e_u", "e_lambda"), largest_errors(signorom, deck, n_ranks), strict=True):
        figures.at_most(problem, f"{name}, largest of 30 training points", value, ROUNDING, "K factored")


def test_heat_with_constants_as_parameters(signorom, tmp_path, figures):
    """The same with imposed strains whose forces carry the moduli."""
    deck = write_stamps(tmp_path, VARYING, SAME_POINTS, heated(RANGES))
    for name, value in zip(("e_u", "e_lambda"), largest_errors(signorom, deck), strict=True):
        figures.at_most(
            "all modes, whole mesh, heat, E and nu as parameters", name, value, ROUNDING, "K factored"
        )


def test_heat_is_lifted(signorom, tmp_path, figures):
    """With numbers as elastic constants what heat does without contact needs no mode: a mode per pair does."""
    deck = write_stamps(
        tmp_path,
        {FIXED: FIXED.replace("poisson_ratio: 0.3", "poisson_ratio: 0.3, thermal_expansion: 1")},
        heated("  right: {min: 0.01, max: 0.1, unit: m}\n"),
        {
            "training: {grid: {left: 6, right: 6}}": "training: {grid: {left: 6, right: 6, heat: 2}}",
            "test: {grid: {left: 9, right: 9}}": "test: {latin_hypercube: 40, seed: 2}",
        },
    )
    for name, value in zip(("e_u", "e_lambda"), largest_errors(signorom, deck), strict=True):
        figures.at_most("all modes, whole mesh, heat", name, value, ROUNDING, "full-order model")
    with h5py.File(tmp_path / "results" / "full_basis" / "model.h5") as file:
        assert file["clusters/1/basis"].shape[0] == N_PAIRS


MODULUS = {
    "  h1: {min: 0.6, max: 6.0, unit: mm}\n": "  h1: {min: 0.6, max: 6.0, unit: mm}\n"
    "  E: {min: 60.0e3, max: 100.0e3, unit: MPa}\n"
    '  nu: {min: 0.25, max: 0.35, unit: "1"}\n',
    "young_modulus: 78.0e3, poisson_ratio: 0.34": "young_modulus: E, poisson_ratio: 0.34",
    "young_modulus: 190.0e3, poisson_ratio: 0.3": "young_modulus: 190.0e3, poisson_ratio: nu",
}


def write_pellet(folder, reduction, more="training: {sobol: 30}\ntest: {sobol: 6, seed: 3}\n"):
    """Case b with the modulus of the cladding and the ratio of the pellet as parameters."""
    deck = write_input("pellet_cladding", folder, MODULUS)
    text = re.sub(
        r"(?ms)^(training|test|reduction|certificate|validation|output):.*?(?=^\S|\Z)", "", deck.read_text()
    )
    deck.write_text(f"{text}\nreduction: {{method: hhr{reduction}}}\n{more}")
    return deck


def test_pellet_and_cladding(signorom, tmp_path):
    """Every point has an answer and a bound; what is not good enough the interpolated model answers."""
    deck = write_pellet(tmp_path, "")
    signorom("run", deck, folder=tmp_path)
    table = read_table(tmp_path / "results" / "pellet_cladding" / "validation.csv")
    own = np.array(table["solver"]) != "condensed"
    assert own.any()
    assert (np.array(table["error_bound"], dtype=float) <= 0.05).all()
    assert np.nanmax(np.array(table["e_lambda_all"])[own]) < COARSE
    assert np.nanmax(np.array(table["e_lambda_all"])[~own], initial=0) < 1e-6
    report = read_report(tmp_path, "pellet_cladding")
    assert report["stiffness"]["depends_on_parameters"]


def test_bound_of_reduced_forces(signorom, tmp_path, figures):
    """In the norm of W, which a model with the constants of the point has, as test_interpolated_stiffness.py does."""
    (tmp_path / "varying").mkdir()
    limit = "certificate: {max_error: 1.0e6}\ntraining: {sobol: 25}\n"
    deck = write_pellet(tmp_path / "varying", "", limit)
    signorom("sample", deck, folder=deck.parent)
    signorom("train", deck, folder=deck.parent)
    with h5py.File(deck.parent / "results" / deck.stem / "model.h5") as file:
        largest = file["fallback/largest_size"][()]
    rng = np.random.default_rng(7)
    effectivities = []
    for i in range(2):
        point = {"P1": rng.uniform(50, 200), "h1": rng.uniform(2, 6), "E": rng.uniform(6e4, 1e5)}
        point["nu"] = rng.uniform(0.25, 0.35)
        folder = tmp_path / str(i)
        folder.mkdir()
        fixed = folder / deck.name
        text = deck.read_text().replace("method: hhr", "method: condensed")
        text = re.sub(r"training: .*", "training: {grid: {P1: 2, h1: 2}}", text)
        text = re.sub(r"certificate: .*\n", "", text)
        fixed.write_text(with_numbers(text, {"E": point["E"], "nu": point["nu"]}))
        for file in deck.parent.glob("*.msh"):
            (folder / file.name).write_text(file.read_text())
        signorom("sample", fixed, folder=folder)
        signorom("train", fixed, folder=folder)
        exact, _ = answer_at(signorom, folder, deck.stem, {key: point[key] for key in ("P1", "h1")})
        found, bound = answer_at(signorom, deck.parent, deck.stem, point)
        with h5py.File(folder / "results" / deck.stem / "model.h5") as file:
            compliance = file["clusters/1/compliance"][()]
        size = max(np.sqrt(found @ compliance @ found), 1e-3 * largest)
        error = np.sqrt((found - exact) @ compliance @ (found - exact)) / size
        assert error > 1e-6
        effectivities.append(bound / error)
    assert min(effectivities) >= 1 - 1e-6
    median = np.median(effectivities)
    figures.at_most("case b, E and nu as parameters, hhr", "median bound over error", median, 4, "K factored")


def test_ranks_agree(signorom, tmp_path):
    """One model on 1 and 3 ranks, on a part of the mesh; test_ranks.py has 2 and 4."""
    answers = []
    for n_ranks in (1, 3):
        folder = tmp_path / str(n_ranks)
        folder.mkdir()
        deck = write_pellet(folder, ", max_full_order_size: 0", "training: {sobol: 10}\n")
        signorom("sample", deck, folder=folder, n_ranks=n_ranks)
        signorom("train", deck, folder=folder, n_ranks=n_ranks)
        model = folder / "results" / "pellet_cladding" / "model.h5"
        signorom(
            "predict", model, "--at", "P1=120,h1=4,E=7.7e4,nu=0.31", "--output", "answer.csv", folder=folder
        )
        row = read_table(folder / "answer.csv")
        answers.append([float(cells[0]) for column, cells in row.items() if column.startswith("lambda_")])
    for other in answers[1:]:
        np.testing.assert_allclose(other, answers[0], rtol=0, atol=1e-10 * max(answers[0]))


TWO = {
    "  right: {min: 0.01, max: 0.1, unit: m}\n": "  E: {min: 50.0, max: 200.0, unit: Pa}\n",
    "y: -right": "y: -left / 2",
    FIXED: MATERIALS.replace("poisson_ratio: nu", "poisson_ratio: 0.2"),
    "certificate: {max_error: none}\n": "",
}


@pytest.mark.parametrize(
    ("change", "n_clusters"),
    [
        ({"reduction:\n": "clusters: {number: 2}\nreduction:\n", "left: 6, right: 6": "left: 7, E: 6"}, 2),
        (
            {
                "{grid: {left: 6, right: 6}}": "{greedy: {candidates: {sobol: 40}, initial: 3, max_points: 12}}"
            },
            1,
        ),
        (
            {
                "{grid: {left: 6, right: 6}}": "{greedy: {candidates: {sobol: 40}, indicator: defect, initial: 3, "
                "max_points: 12}}"
            },
            1,
        ),
    ],
    ids=["clusters", "projection", "defect"],
)
def test_choices_over_constants(request, signorom, tmp_path, figures, change, n_clusters):
    """Clusters of a grid over load and modulus, and points that a greedy selection finds."""
    deck = write_stamps(tmp_path, TWO, change, {"{grid: {left: 9, right: 9}}": "{sobol: 20, seed: 4}"})
    deck.write_text(deck.read_text().replace("method: hhr", "method: hhr\n  max_full_order_size: 0"))
    # relative errors are large where little touches
    displacement, forces = largest_errors(signorom, deck, share=0.9)
    problem = f"two stamps, E as parameter, {request.node.callspec.id}"
    figures.at_most(problem, "e_u, 90 %", displacement, SMALL, "K factored")
    figures.at_most(problem, "e_lambda, 90 %", forces, 10 * SMALL, "K factored")
    with h5py.File(tmp_path / "results" / "full_basis" / "model.h5") as file:
        assert file.attrs["n_clusters"] == n_clusters
