# SPDX-License-Identifier: BSD-3-Clause
"""Every solver that a deck can name gives the same answer, on the verification cases that are small."""

import itertools

import numpy as np
import pytest
import yaml

from block_meshes import stacked_blocks
from runs import solve_deck, write_deck, write_input

# Displacements and forces relative to the largest; conjugate gradients end at 1e-12 of the energy norm.
AGREEMENT = 1e-8
SOLVERS = [
    ("condensed", "cholesky"),
    ("active_set", "cholesky"),
    ("active_set", "gamg"),
    ("snesvi", "cholesky"),
]
# Bodies that only contact holds are none of snesvi's; it says so.
HELD = [
    "bar_with_gap",
    "patch",
    "loaded_bars",
    "half_disks",
    "pellet_cladding",
    "punch",
    "solid",
    "shrink_fit",
]
FLOATING = ["blocks", "hertz_cylinder", "sphere"]


def deck_of(case, folder, solver, linear):
    """The case's deck with a solver of its own and no more than two points."""
    if case in ("bar_with_gap", "patch", "loaded_bars"):
        deck = write_deck(case, folder)
    elif case == "solid":
        stacked_blocks("H8", 3).write(folder / "blocks.msh")
        deck = write_deck("patch_models", folder)
    else:
        deck = write_input(case, folder)
    content = yaml.safe_load(deck.read_text())
    if case == "solid":
        content["mesh"]["model"] = "solid"
        content["contact"][0]["direction"] = [0, 0, 1]
        # pushed on one side only, so that pairs open
        content["boundary_conditions"] = [
            {"boundary": "bottom", "displacement": {"x": 0, "y": 0, "z": 0}},
            {"boundary": "top", "displacement": {"x": 0, "y": 0, "z": "-stroke * (x - 0.4)"}},
        ]
    content["solver"] = {"type": solver, "linear": linear}
    content.pop("training", None)
    content.pop("test", None)
    deck.write_text(yaml.safe_dump(content, sort_keys=False))
    return deck


def answers(signorom, case, folder, solver, linear):
    """Displacement and multipliers of each output point."""
    folder.mkdir()
    fields, _ = solve_deck(signorom, deck_of(case, folder, solver, linear))
    return fields


@pytest.mark.parametrize("case", HELD + FLOATING)
def test_solvers_agree(signorom, tmp_path, case):
    """Each against the first one."""
    solvers = [pair for pair in SOLVERS if case not in FLOATING or pair[0] != "snesvi"]
    found = [answers(signorom, case, tmp_path / "_".join(pair), *pair) for pair in solvers]
    for (name, linear), points in itertools.islice(zip(solvers, found, strict=True), 1, None):
        for i, (point, first) in enumerate(zip(points, found[0], strict=True)):
            for field in ("displacement", "multipliers_full_order"):
                scale = np.abs(first[field]).max() or 1.0
                np.testing.assert_allclose(
                    point[field] / scale,
                    first[field] / scale,
                    rtol=0,
                    atol=AGREEMENT,
                    err_msg=f"{name}, {linear}, {field}, point {i}",
                )


@pytest.mark.parametrize("case", ["half_disks", *FLOATING])
@pytest.mark.parametrize("n_ranks", [1, 3])
def test_multigrid_gains_a_digit_in_three_iterations(signorom, tmp_path, case, n_ranks):
    """As good multigrid does for one elastic body: contact that opens and slides must not slow it down.

    Each step wants three digits at most, the last one twelve; steps that want six make up for those that start close to
    their end.
    """
    deck = deck_of(case, tmp_path, "active_set", "gamg")
    signorom("solve", deck, folder=tmp_path, n_ranks=n_ranks)
    report = yaml.safe_load((tmp_path / "results" / deck.stem / "report.yaml").read_text())
    for point in report["points"].values():
        assert 0 < point["linear_iterations"] <= 3 * (3 * point["iterations"] + 12)


@pytest.mark.parametrize("case", ["half_disks", "pellet_cladding"])
def test_snesvi_needs_few_steps(signorom, tmp_path, case):
    """Full steps are those of an active set, which needs 4 or 5 on these; a search that creeps needs 28 and more."""
    deck = deck_of(case, tmp_path, "snesvi", "cholesky")
    signorom("solve", deck, folder=tmp_path)
    report = yaml.safe_load((tmp_path / "results" / deck.stem / "report.yaml").read_text())
    for point in report["points"].values():
        assert 0 < point["iterations"] <= 10


@pytest.mark.parametrize("case", FLOATING)
def test_snesvi_refuses_bodies_held_by_contact(signorom, tmp_path, case):
    """A sentence and exit code 2."""
    deck = deck_of(case, tmp_path, "snesvi", "cholesky")
    done = signorom.run("solve", deck, folder=tmp_path)
    assert done.returncode == 2
    assert "contact alone holds a body" in done.stderr
