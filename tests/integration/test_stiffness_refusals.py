# SPDX-License-Identifier: BSD-3-Clause
"""Decks whose stiffness depends on the parameters: what cannot be done with them is said before any work."""

import pytest

from runs import refuse, write_deck

# the modulus is negative inside the range only, at a training point and at no corner
HOLE = '"push > 0.03 && push < 0.05 ? -5 : 2e6"'


@pytest.mark.parametrize(("command", "n_ranks"), [("check", 1), ("sample", 1), ("sample", 3)])
def test_point_out_of_range_is_named(signorom, tmp_path, command, n_ranks):
    deck = write_deck("patch", tmp_path, **{"young_modulus: 2.0e6": f"young_modulus: {HOLE}"})
    words = refuse(signorom, command, deck.name, folder=tmp_path, n_ranks=n_ranks)
    assert "patch.yaml:6:51: error: materials.block.young_modulus is 'push > 0.03" in words
    assert "which is -5.0 N/m^2 at push = 0.04 m; it must be greater than 0" in words


def test_other_modulus_is_another_study(signorom, tmp_path):
    """The provenance of snapshots holds the expressions."""
    deck = write_deck("patch", tmp_path, **{"young_modulus: 2.0e6": "young_modulus: 2e7 * push"})
    signorom("sample", deck.name, folder=tmp_path)
    deck.write_text(deck.read_text().replace("2e7 * push", "3e7 * push"))
    words = refuse(signorom, "sample", deck.name, folder=tmp_path)
    assert "these snapshots belong to another deck, mesh or field file" in words


@pytest.mark.parametrize("method", ["condensed", "hhr", "hhr, max_full_order_size: 0"])
@pytest.mark.parametrize("n_ranks", [1, 3])
def test_hole_between_the_points_is_found(signorom, tmp_path, method, n_ranks):
    """No training point lies in the range where the modulus is negative; a model of the box would have answers there."""
    changes = {"young_modulus: 2.0e6": f"young_modulus: {HOLE}", "grid: {push: 5}": "grid: {push: 3}"}
    deck = write_deck("patch", tmp_path, **changes)
    deck.write_text(deck.read_text().replace("method: hhr", f"method: {method}"))
    signorom("sample", deck.name, folder=tmp_path)
    for command in ("check", "train"):
        words = refuse(signorom, command, deck.name, folder=tmp_path, n_ranks=n_ranks)
        assert "patch.yaml:6:51: error: materials.block.young_modulus is 'push > 0.03" in words
        assert "which is -5.0 N/m^2 at push = " in words


MODULUS = {"young_modulus: 2.0e6": "young_modulus: 2e7 * push"}
RATIO = {"poisson_ratio: 0": "poisson_ratio: 4 * push"}


@pytest.mark.parametrize(
    ("method", "constant", "push"),
    [
        ("condensed", MODULUS, "-0.01"),
        ("condensed", RATIO, "0.126"),
        ("condensed", RATIO, "-0.26"),
        ("hhr", RATIO, "0.126"),
        ("hhr, max_full_order_size: 0", MODULUS, "-0.01"),
        ("hhr, max_full_order_size: 0", RATIO, "-0.26"),
    ],
)
def test_no_answer_for_a_material_that_cannot_be(signorom, tmp_path, method, constant, push):
    """Outside of the box, where extrapolation would have an answer."""
    deck = write_deck("patch", tmp_path, **constant, **{"method: hhr": f"method: {method}"})
    for command in ("sample", "train"):
        signorom(command, deck.name, folder=tmp_path)
    model = tmp_path / "results" / "patch" / "model.h5"
    done = signorom.run("predict", model, "--at", f"push={push}", folder=tmp_path)
    assert done.returncode == 3
    reason = "Young's modulus is not positive at this point, or Poisson's ratio is not between -1 and 0.5"
    assert reason in done.stdout
    inside = signorom("predict", model, "--at", "push=0.09", folder=tmp_path)
    assert ",answered," in inside
