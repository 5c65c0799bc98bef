# SPDX-License-Identifier: BSD-3-Clause
"""The twin of a fuel rod: heat, loads, gap and elastic constants as eight parameters, against K factored at each point.

`--all-points` trains and asks at the deck's own points and at 2000 random ones; without it at a few.
"""

import re

import numpy as np
import pytest

from runs import read_report, read_table, write_input

SEED = 14
FORCES = 1e-6
DISPLACEMENTS = 1e-3


@pytest.fixture(scope="module")
def rod(request, signorom, tmp_path_factory):
    """Columns of validation.csv, and the folder of the run."""
    folder = tmp_path_factory.mktemp("rod")
    deck = write_input("fuel_rod", folder)
    n_points = 2000 if request.config.getoption("--all-points") else 20
    text = re.sub(r"(?m)^test: .*$", f"test: {{latin_hypercube: {n_points}, seed: {SEED}}}", deck.read_text())
    if n_points == 20:
        text = re.sub(r"(?m)^training: .*$", "training: {sobol: 40}", text)
    deck.write_text(text)
    signorom("run", deck, folder=folder)
    return read_table(folder / "results" / "fuel_rod" / "validation.csv"), folder


def test_forces_and_displacements(rod, figures):
    """Every point is answered; there is no error of forces where nothing touches in either model."""
    table, _ = rod
    assert set(table["solver"]) == {"condensed"}
    touches = (table["n_active"] > 0) | (table["n_active_full_order"] > 0)
    figures.at_most(
        "fuel rod", "forces on all contacts", table["e_lambda_all"][touches].max(), FORCES, "K factored"
    )
    figures.at_most("fuel rod", "displacements", table["e_u"].max(), DISPLACEMENTS, "K factored")


def test_answers_have_a_bound(rod):
    """Each body has one interpolated constant: the bound is finite, and as small as the errors."""
    table, _ = rod
    bounds = np.array(table["error_bound"], dtype=float)
    assert (bounds > 0).all()
    assert bounds.max() <= 10 * FORCES


def test_heat_closes_the_gap(rod):
    """Free expansion of both bodies, and the thin tube under the coolant, say when nothing or everything touches."""
    table, _ = rod
    growth = 1e-5 * (307 + 25.25 * table["q"]) * 4.1 - 6e-6 * (307 + 2 * table["q"]) * 4.1
    pressed = table["P"] * 4.4**2 / (0.57 * table["E_cladding"])
    is_open = growth + 2 * pressed < table["gap"]
    is_closed = growth > 2 * table["gap"]
    assert is_open.any()
    assert is_closed.any()
    assert (table["n_active"][is_open] == 0).all()
    assert (table["n_active"][is_closed] > 80).all()


def test_report_counts_the_factorizations(rod):
    """A node of both bodies each, and once more for the bound."""
    _, folder = rod
    report = read_report(folder, "fuel_rod")["reduction"]
    assert report["kind"] == "interpolated"
    assert 9 <= report["n_factorizations"] <= 41
