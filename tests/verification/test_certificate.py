# SPDX-License-Identifier: BSD-3-Clause
"""Bounds of answers, and of forces that were spoiled in three ways, against true errors at random points.

`tests/verification/certificates.py` does the same for every shipped deck at 10 000 points.
"""

import re
import subprocess

import pytest
import yaml

from program import find_program
from runs import INPUT

CHECK = find_program().executable.parent / "tests" / "check_certificate"
N_POINTS = 400
LINE = re.compile(r"^(.{24}) +(\d+) points +(\d+) violations(?: +\d+ errors, effectivity +([\d.]+))?", re.M)
# of the forces of a model, and of spoiled ones; where W is not there
LARGEST_MEDIAN = 2.0
LARGEST_LIFTED_MEDIAN = 3.0


@pytest.mark.parametrize("name", ["half_disks", "pellet_cladding_whole_edges", "bracket"])
def test_bound_is_never_below_the_error(signorom, tmp_path, name):
    deck = shipped_deck(name)
    write(tmp_path, deck)
    signorom("sample", "deck.yaml", folder=tmp_path)
    signorom("train", "deck.yaml", folder=tmp_path)
    lines, said = check(tmp_path / "results/deck/model.h5")
    # where contact alone holds a body only its answers have a bound, and these are exact
    assert len(lines) == (1 if name == "bracket" else 4)
    for _, n_points, n_violations, median in lines:
        assert int(n_points) > 0.9 * N_POINTS  # without contact there is nothing to spoil
        assert int(n_violations) == 0
        assert bool(median) == (name != "bracket")
        assert not median or 1 <= float(median) <= LARGEST_MEDIAN
    assert "0 without an answer, 0 without a reference" in said


@pytest.mark.parametrize("name", ["bracket", "saddle"])
def test_hyper_reduced_answers_of_floating_bodies(signorom, tmp_path, name):
    """Their forces come from a projection on the balance, without those on open contacts."""
    deck = shipped_deck(name)
    deck["reduction"] = {"method": "hhr"}
    write(tmp_path, deck)
    signorom("sample", "deck.yaml", folder=tmp_path)
    signorom("train", "deck.yaml", folder=tmp_path)
    lines, _ = check(tmp_path / "results/deck/model.h5")
    assert len(lines) == 1
    assert int(lines[0][2]) == 0
    assert 1 <= float(lines[0][3]) <= LARGEST_MEDIAN
    assert int(lines[0][1]) == N_POINTS


@pytest.mark.parametrize("name", ["half_disks", "pellet_cladding_whole_edges", "bracket"])
def test_bound_without_the_matrix_of_all_contacts(signorom, tmp_path, name):
    """By a lift and the snapshots; W, for the errors, comes from a condensed model of the same snapshots."""
    deck = shipped_deck(name)
    deck["certificate"] = {"max_error": 0.05}
    deck["reduction"] = deck.get("reduction", {}) | {"method": "hhr"}
    write(tmp_path, deck)
    signorom("sample", "deck.yaml", folder=tmp_path)
    # a stiffness that may not be factored is none that W comes from
    write(tmp_path, deck | {"solver": {"linear": "gamg"}})
    said = signorom("train", "deck.yaml", folder=tmp_path)
    assert "certificate without the matrix of all contacts" in said
    model = tmp_path / "results/deck/model.h5"
    reduced = model.rename(tmp_path / "reduced.h5")
    write(tmp_path, deck | {"reduction": {"method": "condensed"}})
    signorom("train", "deck.yaml", folder=tmp_path)
    lines, _ = check(reduced, model)
    assert len(lines) == (1 if name == "bracket" else 4)
    for _, n_points, n_violations, median in lines:
        assert int(n_points) > 0.9 * N_POINTS
        assert int(n_violations) == 0
        assert not median or 1 <= float(median) <= LARGEST_LIFTED_MEDIAN


def shipped_deck(name):
    """A deck of input/, which may stand anywhere."""
    deck = yaml.safe_load((INPUT / f"{name}.yaml").read_text())
    deck["mesh"]["file"] = str((INPUT / deck["mesh"]["file"]).resolve())
    return deck


def write(folder, deck):
    """As deck.yaml."""
    (folder / "deck.yaml").write_text(yaml.safe_dump(deck, sort_keys=False))


def check(*models):
    """Lines of the table: kind, points, violations, median of the effectivity; and all that was said."""
    command = [CHECK, models[0], str(N_POINTS), "3", *models[1:]]
    done = subprocess.run(command, capture_output=True, text=True)
    print(done.stdout)
    assert done.returncode == 0, done.stdout + done.stderr
    return LINE.findall(done.stdout), done.stdout
