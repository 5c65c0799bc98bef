# SPDX-License-Identifier: BSD-3-Clause
"""Gaps by expressions: the distances of the nodes as a formula, and a gap that moves in place of the bodies."""

import numpy as np
import pytest

from results import read_fields, read_snapshots
from runs import check_reduced_model, results_of, write_deck

# Two arcs of radius 1 m, 0.1 m apart at x = 0; the mesh has them to rounding.
DISTANCE = "2*(1.05 - sqrt(max(1 - x^2, 0)))"
SAME = 1e-9
DIRECTION = "direction: [0, 1]}"
# u_y = squeeze below and -squeeze above, or the gaps of bodies at rest are smaller by as much
MOVING_GAP = {
    "y: squeeze}": "y: 0}",
    "y: -squeeze}": "y: 0}",
    DIRECTION: f'direction: [0, 1], initial_gap: "{DISTANCE} - 2*squeeze"}}',
}


@pytest.fixture(scope="module")
def pressed(signorom, tmp_path_factory):
    """Results of the deck as it is."""
    return results_of(signorom, tmp_path_factory.mktemp("pressed"), "run", {})


@pytest.fixture(scope="module")
def moving(signorom, tmp_path_factory):
    """Results with a moving gap."""
    return results_of(signorom, tmp_path_factory.mktemp("moving"), "run", MOVING_GAP)


def test_formula_of_the_distance_changes_nothing(signorom, tmp_path, pressed):
    """Coordinates without parameters: the gaps of the mesh."""
    found = read_snapshots(
        results_of(
            signorom,
            tmp_path,
            "sample",
            {DIRECTION: f'direction: [0, 1], initial_gap: "{DISTANCE}"}}'},
        )
        / "snapshots.h5"
    )
    expected = read_snapshots(pressed / "snapshots.h5")
    for name in ("multipliers", "displacement"):
        limit = SAME * np.abs(expected[name]).max()
        np.testing.assert_allclose(found[name], expected[name], rtol=0, atol=limit)


@pytest.mark.parametrize("solver", ["active_set", "snesvi"])
def test_moving_gap_by_every_solver(signorom, tmp_path, moving, solver):
    """As by the condensed solver."""
    changes = {**MOVING_GAP, "type: condensed": f"type: {solver}"}
    found = read_snapshots(results_of(signorom, tmp_path, "sample", changes) / "snapshots.h5")
    expected = read_snapshots(moving / "snapshots.h5")
    limit = 1e-8 * expected["multipliers"].max()
    np.testing.assert_allclose(found["multipliers"], expected["multipliers"], rtol=0, atol=limit)


def test_moving_gap_presses_as_moving_bodies(pressed, moving):
    """Each body moved as a whole by its base: the same forces."""
    found, expected = (read_snapshots(folder / "snapshots.h5") for folder in (moving, pressed))
    assert (expected["multipliers"] > 0).any()
    limit = SAME * expected["multipliers"].max()
    np.testing.assert_allclose(found["multipliers"], expected["multipliers"], rtol=0, atol=limit)


def test_gap_field_is_the_open_distance(pressed, moving):
    """Zero where the nodes touch, the same in both ways of moving: the gap at the point, not that at rest."""
    for point in (1, 2):
        found, expected = (read_fields(folder / "fields.h5", point) for folder in (moving, pressed))
        np.testing.assert_allclose(found["gap"], expected["gap"], rtol=0, atol=1e-9)
        touches = np.linalg.norm(found["contact_force"], axis=1) > 0
        assert touches.any()
        assert np.abs(found["gap"][touches]).max() < 1e-12
        assert np.nanmin(found["gap"]) > -1e-12


def test_reduced_model_answers_with_the_moving_gap(signorom, moving, tmp_path):
    """The model holds the terms of the gap: small errors at the test points, by predict too."""
    check_reduced_model(signorom, moving, tmp_path)


def test_moving_gap_on_three_ranks(signorom, tmp_path, moving):
    """The same snapshots."""
    found = read_snapshots(results_of(signorom, tmp_path, "sample", MOVING_GAP, n_ranks=3) / "snapshots.h5")
    expected = read_snapshots(moving / "snapshots.h5")
    for name in ("multipliers", "displacement"):
        limit = 1e-10 * np.abs(expected[name]).max()
        np.testing.assert_allclose(found[name], expected[name], rtol=0, atol=limit)


def test_inert_pairs_are_checked_at_every_point(signorom, tmp_path):
    """The corners of the disks are prescribed on both sides: a gap below zero there cannot be."""
    changes = {
        "y: squeeze}": "y: 0}",
        "y: -squeeze}": "y: 0}",
        DIRECTION: "direction: [0, 1], initial_gap: 0.3 - squeeze}",
    }
    done = signorom.run("sample", write_deck("small_disks", tmp_path, **changes), folder=tmp_path)
    assert done.returncode == 2
    assert "the prescribed displacements and the gap press nodes" in done.stderr
    assert "narrow the parameter range" in done.stderr


@pytest.mark.parametrize(
    ("changes", "gaps"), [({}, "0.1 to 2.1 m"), (MOVING_GAP, "-0.8 to 1.8 m")], ids=["distances", "moving"]
)
def test_pairs_and_gaps_are_told_before_solving(signorom, tmp_path, changes, gaps):
    """2 (1.05 - sqrt(1 - x^2)) from x = 0 to 1, less 2 squeeze from 0.15 to 0.45; the corners are inert."""
    line = f"contact[1]: lower_arc - upper_arc, 15 pairs (2 inert), gaps {gaps}"
    deck = write_deck("small_disks", tmp_path, **changes)
    checked = signorom("check", deck, folder=tmp_path).splitlines()
    assert f"# {line}" in checked
    assert any(text.startswith("# inert pairs") and text.endswith("1 - 16, 15 - 30") for text in checked)
    assert line in signorom("sample", deck, folder=tmp_path).splitlines()
