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


NAMES = ["half_disks", "pellet_cladding_whole_edges", "bracket"]


@pytest.fixture(scope="module", params=NAMES)
def sampled(request, signorom, tmp_path_factory):
    """Name and deck of a study, and the folder with its snapshots, which all models are trained on."""
    deck, folder = shipped_deck(request.param), tmp_path_factory.mktemp(request.param)
    write(folder, deck)
    signorom("sample", "deck.yaml", folder=folder)
    return request.param, deck, folder


def test_bound_is_never_below_the_error(signorom, sampled):
    name, deck, folder = sampled
    write(folder, deck)
    signorom("train", "deck.yaml", folder=folder)
    lines, said = check(folder / "results/deck/model.h5")
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


def test_bound_without_the_matrix_of_all_contacts(signorom, sampled):
    """By a lift and the snapshots; W, for the errors, comes from a condensed model of the same snapshots."""
    name, deck, folder = sampled
    deck = deck | {
        "certificate": {"max_error": 0.05},
        "reduction": deck.get("reduction", {}) | {"method": "hhr"},
    }
    write(folder, deck)
    # once more where snapshots without displacements were enough
    signorom("sample", "deck.yaml", folder=folder)
    # a stiffness that may not be factored is none that W comes from
    write(folder, deck | {"solver": {"linear": "gamg"}})
    said = signorom("train", "deck.yaml", folder=folder)
    assert "certificate without the matrix of all contacts" in said
    model = folder / "results/deck/model.h5"
    reduced = model.rename(folder / "reduced.h5")
    write(folder, deck | {"reduction": {"method": "condensed"}})
    signorom("train", "deck.yaml", folder=folder)
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
