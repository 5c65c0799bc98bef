# SPDX-License-Identifier: BSD-3-Clause
"""What decks and options may ask of the solvers: bodies that contact holds or cannot hold, multigrid, wrong options."""

import re

import h5py
import numpy as np
import pytest
import yaml

from results import read_fields
from runs import CRASH, SOON, refuse, write_deck

TOP = "  - {boundary: top, displacement: {y: -push}}\n"
# Multipliers of a point: conjugate gradients stop at 1e-12 of the energy.
TOLERANCE = 1e-8
# [N/m] of a traction of 1e5 Pa per m of `push` on the top, 1 m wide, at push = 0.05 m
FORCE = 0.05 * 1e5
SOLVERS = ["{type: condensed}", "{type: active_set}", "{type: active_set, linear: gamg}"]
SOLVERS.append("{type: condensed, linear: gamg}")


def loaded_deck(folder, solver, sign):
    """The upper square carries a traction along y and rests on the contact: only that holds it in height."""
    deck = write_deck("patch", folder, **{TOP: ""})
    load = f"loads:\n  - {{boundary: top, traction: {{y: {sign}1.0e5 * push}}}}\n"
    deck.write_text(f"{deck.read_text()}{load}solver: {solver}\n")
    return deck


@pytest.mark.parametrize("n_ranks", [1, 3])
@pytest.mark.parametrize("solver", SOLVERS)
def test_body_held_by_contact(signorom, tmp_path, solver, n_ranks):
    """nu = 0: the pressure is the traction, a quarter of it at the inner nodes 0.25 m apart, an eighth at the ends."""
    deck = loaded_deck(tmp_path, solver, "-")
    shown = signorom("solve", deck.name, folder=tmp_path, n_ranks=n_ranks)
    assert "note: only contact holds the body 'upper' (translation in y)" in shown
    forces = read_fields(tmp_path / "results" / "patch" / "fields.h5")["multipliers_full_order"]
    np.testing.assert_allclose(np.sort(forces), np.array([1, 1, 2, 2, 2]) * FORCE / 8, rtol=TOLERANCE)


@pytest.mark.parametrize("n_ranks", [1, 3])
@pytest.mark.parametrize("solver", SOLVERS)
def test_load_that_pulls_a_body_off(signorom, tmp_path, solver, n_ranks):
    """Exit code 3, the point is named and marked."""
    deck = loaded_deck(tmp_path, solver, "")
    done = signorom.run("solve", deck.name, folder=tmp_path, n_ranks=n_ranks, time_limit=SOON)
    assert done.returncode == 3
    assert "not converged at push = 0.05 m: there is no equilibrium: the loads pull a body off" in done.stderr
    report = yaml.safe_load((tmp_path / "results" / "patch" / "report.yaml").read_text())
    point = report["points"]["1"]
    assert point["status"].startswith("there is no equilibrium")
    assert not {"n_active", "contact_force", "reactions"} & set(point)
    assert "the files have no fields for 1 point that did not converge" in done.stderr
    with h5py.File(tmp_path / "results" / "patch" / "fields.h5") as file:
        assert "points" not in file


def test_preconditioner_that_is_no_factorization(signorom, tmp_path):
    deck = write_deck("patch", tmp_path)
    words = refuse(signorom, "solve", deck.name, "-fom_pc_type", "gamg", folder=tmp_path)
    assert re.match(r"error: the command line has -fom_pc_type gamg; it must be cholesky or lu", words)


def test_log_of_petsc(signorom, tmp_path):
    """Of the whole run, in a file: its events, and no complaint."""
    deck = write_deck("patch", tmp_path)
    signorom("solve", deck.name, "-log_view", ":log.txt", folder=tmp_path)
    assert re.search(r"^MatMult +[1-9]", (tmp_path / "log.txt").read_text(), re.MULTILINE)


@pytest.mark.parametrize(
    ("solver", "option"),
    [
        (SOLVERS[2], "-active_set_pc_type nonsense"),
        (SOLVERS[2], "-active_set_ksp_max_it 1"),
        (SOLVERS[3], "-fom_ksp_max_it 1"),
    ],
)
@pytest.mark.parametrize("n_ranks", [1, 3])
def test_multigrid_that_fails_is_a_reason(signorom, tmp_path, solver, option, n_ranks):
    """Not converged, and no trace of PETSc's."""
    deck = loaded_deck(tmp_path, solver, "-")
    done = signorom.run(
        "solve", deck.name, *option.split(), folder=tmp_path, n_ranks=n_ranks, time_limit=SOON
    )
    assert done.returncode == 3
    assert "the linear solver failed" in done.stderr
    assert not [word for word in CRASH if word in done.stderr + done.stdout], done.stderr
