# SPDX-License-Identifier: BSD-3-Clause
"""Decks without a contact: linear elasticity, as to try supports and loads first."""

import numpy as np
import pytest
import yaml

from block_meshes import stacked_blocks
from runs import read_fields, refuse

# nu = 0: the upper block, 1 high, is stretched by P / E, and the stress is P
MODULUS, LOAD = 2.0e6, 5.0
DECK = f"""title: A block
mesh: {{file: part.msh, model: plane_strain}}
parameters: {{P: {{min: 1, max: 9, unit: Pa}}}}
materials: {{all: {{regions: [lower, upper], young_modulus: {MODULUS}, poisson_ratio: 0}}}}
boundary_conditions:
  - {{boundary: bottom, displacement: {{x: 0, y: 0}}}}
  - {{boundary: upper_face, displacement: {{x: 0, y: 0}}}}
loads: [{{boundary: top, pressure: -P}}]
training: {{sobol: 4}}
test: {{sobol: 3, seed: 1}}
reduction: {{fields: true}}
output: {{points: [{{P: {LOAD}}}]}}
solver: {{}}
"""
NOTE = "note: the deck has no contact, so that nothing touches"


def write_deck(folder, **changes):
    """Mesh and deck, with texts replaced."""
    stacked_blocks("Q4", 2).write(folder / "part.msh")
    text = DECK
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    (folder / "part.yaml").write_text(text)
    return folder / "part.yaml"


@pytest.mark.parametrize("solver", ["{}", "{type: active_set}", "{type: snesvi}"])
@pytest.mark.parametrize("n_ranks", [1, 2])
def test_solve(signorom, tmp_path, solver, n_ranks):
    """The block is stretched; the other one, which would touch it, stays as it is."""
    deck = write_deck(tmp_path, **{"solver: {}": f"solver: {solver}"})
    assert NOTE in signorom("solve", deck, folder=tmp_path, n_ranks=n_ranks)
    fields = read_fields(tmp_path / "results" / "part" / "fields.h5")
    up = fields["displacement"][:, 1]
    assert up.max() == pytest.approx(LOAD / MODULUS, rel=1e-10)
    assert up.min() == pytest.approx(0, abs=1e-16)
    assert fields["stress"][:, 1].max() == pytest.approx(LOAD, rel=1e-10)


def test_check_and_run(signorom, tmp_path):
    """What `check` prints is a deck again; a model of the loads alone is accepted for its fields."""
    deck = write_deck(tmp_path)
    said = signorom("check", deck, folder=tmp_path)
    assert NOTE in said
    assert "contact" not in yaml.safe_load(said)
    said = signorom("run", deck, folder=tmp_path)
    assert "forces accepted: the deck has no contact" in said
    assert "fields accepted: " in said
    table = signorom("predict", "results/part/model.h5", "--at", f"P={LOAD}", folder=tmp_path).splitlines()
    answer = dict(zip(table[0].split(","), table[1].split(","), strict=True))
    assert answer["status"] == "answered"
    assert float(answer["contact_force"]) == 0


def test_bodies_that_nothing_holds(signorom, tmp_path):
    """Without a contact the upper block flies away: the load that drives it is named."""
    held = "  - {boundary: upper_face, displacement: {x: 0, y: 0}}\n"
    deck = write_deck(tmp_path, **{held: ""})
    assert "the load on 'top' drives the body 'upper', which nothing holds" in refuse(
        signorom, "solve", deck, folder=tmp_path
    )


def test_empty_list(signorom, tmp_path):
    """`contact: []` says the same."""
    deck = write_deck(tmp_path, **{"solver: {}": "contact: []"})
    assert NOTE in signorom("solve", deck, folder=tmp_path)
    assert np.isfinite(read_fields(tmp_path / "results" / "part" / "fields.h5")["displacement"]).all()
