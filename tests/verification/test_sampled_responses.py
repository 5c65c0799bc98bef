# SPDX-License-Identifier: BSD-3-Clause
"""Training points from the responses of the bodies against points that each factor their own stiffness."""

import re

import numpy as np
import pytest

from runs import read_snapshots
from varying_decks import HANGING, MODULUS, RATIOS, write_study, write_two_materials

# moduli that scale a whole body: what is left is rounding; otherwise reduction.stiffness_tolerance
EXACT = 1e-10
TOLERANCE = 1e-6
N_POINTS = 80


def sample(signorom, deck, stiffness, n_ranks=1):
    """The snapshots in the order of their points, and what the terminal says."""
    folder = deck.parent / f"{stiffness}{n_ranks}"
    folder.mkdir()
    wish = f"training: {{sobol: {N_POINTS}, stiffness: {stiffness}}}"
    text = re.sub(r"(?m)^training: .*$", wish, deck.read_text())
    (folder / deck.name).write_text(re.sub(r"file: (?!/)", "file: ../", text, count=1))
    done = signorom.run("sample", deck.name, folder=folder, n_ranks=n_ranks)
    assert done.returncode == 0, done.stderr
    return read_snapshots(folder / "results" / deck.stem / "snapshots.h5"), done.stdout + done.stderr


def compare(snapshots, reference):
    """Largest differences of forces and of displacements, relative as in training."""
    np.testing.assert_array_equal(snapshots["parameters"], reference["parameters"])
    forces, fields = (reference[name] for name in ("multipliers", "displacement"))
    return (
        largest_difference(snapshots["multipliers"], forces),
        largest_difference(snapshots["displacement"], fields),
    )


def largest_difference(values, reference):
    """Of rows, over their size, at least a thousandth of the largest."""
    sizes = np.linalg.norm(reference, axis=1)
    missed = np.linalg.norm(values - reference, axis=1)
    return np.max(missed / np.maximum(sizes, 1e-3 * sizes.max()))


def study_of(name, folder):
    """A deck and how its points are to be solved."""
    if name == "two_materials":
        return write_two_materials(folder)
    if name == "modulus in space":
        deck = write_two_materials(folder)
        text = deck.read_text().replace("E * ratio, poisson_ratio: nu", "0.7 * E, poisson_ratio: 0.35")
        deck.write_text(re.sub(r"(?m)^  (ratio|nu): .*\n", "", text))
        return deck
    changes = {"modulus": MODULUS, "ratios": RATIOS, "hanging": HANGING}[name]
    return write_study("bracket" if name == "hanging" else "pellet_cladding", folder, changes)


@pytest.mark.parametrize(
    ("name", "stiffness", "allowed"),
    [
        ("modulus in space", "auto", EXACT),
        ("two_materials", "interpolated", TOLERANCE),
        pytest.param("modulus", "auto", EXACT, marks=pytest.mark.long),
        pytest.param("ratios", "interpolated", TOLERANCE, marks=pytest.mark.long),
        pytest.param("hanging", "interpolated", TOLERANCE, marks=pytest.mark.long),
    ],
)
def test_points_are_those_of_their_own_stiffness(signorom, tmp_path, figures, name, stiffness, allowed):
    """Few factorizations give all points, at 2 ranks that share them out."""
    deck = study_of(name, tmp_path)
    snapshots, told = sample(signorom, deck, stiffness, n_ranks=2)
    reference, told_reference = sample(signorom, deck, "factored")
    assert f"{N_POINTS} stiffnesses" in told_reference
    assert "solver: condensed: the" in told
    assert int(re.search(r"(\d+) stiffnesses", told)[1]) < N_POINTS
    assert (snapshots["reasons"] > 0).all()
    assert snapshots["residuals"][:, 0].max() <= max(allowed, 1e-8)
    forces, fields = compare(snapshots, reference)
    problem = f"{name}, training points without a stiffness of their own"
    figures.at_most(problem, "forces", forces, allowed, "K factored at each point")
    figures.at_most(problem, "displacements", fields, allowed, "K factored at each point")


def test_ratios_are_factored_unless_the_deck_allows_more(signorom, tmp_path):
    """What is not exact needs a word in the deck."""
    deck = study_of("two_materials", tmp_path)
    _, told = sample(signorom, deck, "auto")
    assert f"{N_POINTS} stiffnesses" in told


def test_what_goes_wrong_is_factored(signorom, tmp_path):
    """No interpolation reaches this tolerance: each point has its own stiffness, and the terminal says why."""
    deck = study_of("two_materials", tmp_path)
    deck.write_text(deck.read_text() + "reduction: {stiffness_tolerance: 1.0e-15}\n")
    snapshots, told = sample(signorom, deck, "interpolated")
    assert "each point is solved with its own stiffness: interpolation over the elastic constants" in told
    reference, _ = sample(signorom, deck, "factored")
    assert max(compare(snapshots, reference)) <= EXACT
