# SPDX-License-Identifier: BSD-3-Clause
"""Models with all defaults: exact on all contacts; certificates; the verdict of a validation."""

import subprocess
import sys

import h5py
import numpy as np
import pytest
import yaml

from results import read_table
from runs import refuse, write_deck

HHR = "reduction: {method: hhr, "
DEFAULT = {HHR: "reduction: {"}
NO_LIMIT = "certificate: {max_error: none}"
EXACT = 1e-12  # what a certificate calls exact
ROUNDING = 1e-9  # of the largest error: |e|_W is a difference of numbers that may agree to many digits


@pytest.fixture(scope="module")
def default(signorom, tmp_path_factory):
    """Results of `run` on half disks, default model."""
    folder = tmp_path_factory.mktemp("default")
    deck = write_deck("small_disks", folder, **DEFAULT)
    return signorom("run", deck.name, folder=folder), folder / "results" / "small_disks"


@pytest.fixture(scope="module")
def bounded(signorom, tmp_path_factory):
    """The same, hyper-reduced, with bounds and no limit that an answer could miss."""
    folder = tmp_path_factory.mktemp("bounded")
    deck = write_deck("small_disks", folder, **{NO_LIMIT: "certificate: {max_error: 1.0e+9}"})
    signorom("run", deck.name, folder=folder)
    return folder / "results" / "small_disks"


def test_default_is_exact_on_all_contacts(default):
    _, folder = default
    errors = read_table(folder / "validation.csv")
    assert max(map(float, errors["e_lambda_all"])) <= 1e-8
    assert max(map(float, errors["error_bound"])) <= EXACT
    assert set(errors["solver"]) == {"condensed"}
    report = yaml.safe_load((folder / "report.yaml").read_text())
    assert report["reduction"]["kind"] == "condensed"
    assert report["validation"]["accepted"] is True


def test_run_ends_with_a_verdict(default):
    said, _ = default
    for words in (
        "e_lambda_all",
        "error_bound",
        "without an answer       0 of",
        "accepted: p95 of e_lambda_all is",
    ):
        assert words in said, said


def test_answers_have_certificates(signorom, post, default):
    _, folder = default
    with post.Model(folder / "model.h5") as model:
        answer = model.query(squeeze=0.31)
    assert 0 <= answer.relative_bound <= EXACT
    assert answer.method == "condensed"
    line = signorom("predict", "model.h5", "--at", "squeeze=0.31", folder=folder).splitlines()
    row = dict(zip(line[0].split(","), line[1].split(","), strict=True))
    assert 0 <= float(row["error_bound"]) <= EXACT


def test_bound_is_never_below_the_error(post, default, bounded):
    """|e| in the norm of W against the bound, at random points, effectivity as in the definition of the certificate."""
    with h5py.File(bounded / "model.h5") as file:
        compliance = file["fallback/compliance"][()]
        largest = file["fallback/largest_size"][()] if "fallback/largest_size" in file else 0.0
    random = np.random.default_rng(5)
    effectivities = []
    with post.Model(bounded / "model.h5") as reduced, post.Model(default[1] / "model.h5") as exact:
        for squeeze in random.uniform(0.15, 0.45, 300):
            answer = reduced.query(squeeze=squeeze)
            assert answer.bound is not None
            force = exact.query(squeeze=squeeze).multipliers
            wrong = answer.multipliers - force
            error = np.sqrt(max(0.0, wrong @ compliance @ wrong))
            size = np.sqrt(force @ compliance @ force)
            assert answer.bound >= error - ROUNDING * size
            if error > 1e-10 * max(size, 1e-3 * largest):
                effectivities.append(answer.bound / error)
    assert len(effectivities) > 50  # elsewhere the answer is exact but for rounding
    assert np.median(effectivities) <= 2


def test_answers_above_the_limit_fall_back(signorom, tmp_path):
    deck = write_deck("small_disks", tmp_path, **{NO_LIMIT: "certificate: {max_error: 1.0e-9}"})
    said = signorom("run", deck.name, folder=tmp_path)
    errors = read_table(tmp_path / "results/small_disks/validation.csv")
    assert max(map(float, errors["e_lambda_all"])) <= 1e-8
    n_fallbacks = errors["solver"].count("condensed")
    assert n_fallbacks > 0
    assert f"by the fallback         {n_fallbacks}" in said


def test_condensed_without_room_is_refused(signorom, tmp_path):
    deck = write_deck(
        "small_disks", tmp_path, **{HHR: "reduction: {method: condensed, max_full_order_size: 1.0e-4, "}
    )
    signorom("sample", deck.name, folder=tmp_path)
    assert "more than reduction.max_full_order_size" in refuse(signorom, "train", deck.name, folder=tmp_path)


def test_auto_without_room_is_hyper_reduced(signorom, tmp_path):
    deck = write_deck("small_disks", tmp_path, **{HHR: "reduction: {max_full_order_size: 1.0e-4, "})
    said = signorom("run", deck.name, folder=tmp_path)
    assert "hyper-reduction (reduction.method: auto): its matrix of all contacts takes 1 MB" in said
    assert "no error_bound" in said


def test_model_that_is_not_good_enough_is_named(signorom, tmp_path):
    deck = write_deck("small_disks", tmp_path, **{NO_LIMIT: NO_LIMIT + "\nvalidation: {accept: 1.0e-12}"})
    done = signorom.run("run", deck.name, folder=tmp_path)
    assert done.returncode == 0
    assert "NOT accepted: p95 of e_lambda_all is" in done.stderr
    described = signorom("describe", "model.h5", folder=tmp_path / "results" / "small_disks")
    assert "NOT accepted: p95 of e_lambda_all is" in described


def test_figures_of_a_condensed_model(default):
    folder = default[1]
    command = [sys.executable, "-m", "signorom_post", "figures", str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert {"errors.png", "multipliers.png"} <= {path.name for path in (folder / "figures").iterdir()}


def test_point_without_an_answer_is_exit_code_3(signorom, tmp_path):
    """A root of a negative number outside of the box."""
    rooted = {"{x: 0, y: squeeze}": "{x: 0, y: squeeze + 0 * sqrt(squeeze - 0.05)}"}
    deck = write_deck("small_disks", tmp_path, **DEFAULT, **rooted)
    signorom("sample", deck.name, folder=tmp_path)
    signorom("train", deck.name, folder=tmp_path)
    model = tmp_path / "results" / "small_disks" / "model.h5"
    done = signorom.run("predict", model, "--at", "squeeze=0.01", folder=tmp_path)
    assert done.returncode == 3
    assert "not a number at this point" in done.stdout
    assert "1 of 1 point without an answer" in done.stderr
    assert signorom.run("predict", model, "--at", "squeeze=0.2", folder=tmp_path).returncode == 0
