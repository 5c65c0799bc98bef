# SPDX-License-Identifier: BSD-3-Clause
"""Models with all defaults: exact on all contacts; certificates; the verdict of a validation."""

import re
import subprocess
import sys
import warnings

import h5py
import numpy as np
import pytest
import yaml

from c_programs import compile_c, run_c
from program import ROOT
from results import read_table
from runs import refuse, write_deck

HHR = "reduction: {method: hhr, "
DEFAULT = {HHR: "reduction: {"}
NO_LIMIT = "certificate: {max_error: none}"
EXACT = 1e-12  # what a certificate calls exact
LOOSE = 6  # measured 4.1: the place of a body is found by its forces, which are wrong themselves
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


def test_host_may_trap_exceptions(default, library, tmp_path):
    """The energy error in the RID of a condensed model is not a number; telling it must not end a host in C."""
    _, folder = default
    assert run_c(compile_c("trap_exceptions", library, tmp_path), folder / "model.h5").returncode == 0


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


def floating_deck(folder, *sections):
    """A part that only contact holds, with further sections in its deck."""
    deck = folder / "bracket.yaml"
    text = (ROOT / "input" / "bracket.yaml").read_text().replace("../meshes", str(ROOT / "meshes"))
    deck.write_text("\n".join([text, *sections, ""]))
    return deck.name


def test_bound_holds_for_bodies_that_only_contact_holds(signorom, post, tmp_path):
    """Hyper-reduced forces of a bracket: resultants of the exact ones; |e| in the norm with closed anchors."""
    models = {}
    for name, *sections in (
        ("exact",),
        ("reduced", "reduction: {method: hhr}", "certificate: {max_error: 1.0e+9}"),
    ):
        (tmp_path / name).mkdir()
        deck = floating_deck(tmp_path / name, *sections)
        signorom("sample", deck, folder=tmp_path / name)
        signorom("train", deck, folder=tmp_path / name)
        models[name] = tmp_path / name / "results" / "bracket" / "model.h5"
    with h5py.File(models["reduced"]) as file:
        compliance, anchors = file["fallback/compliance"][()].T, file["fallback/anchors"][()] - 1
        closing = file["clusters/1/motion_closing"][()]
    others = np.setdiff1d(np.arange(len(compliance)), anchors)
    random = np.random.default_rng(5)
    effectivities = []
    with post.Model(models["reduced"]) as reduced, post.Model(models["exact"]) as exact:
        for bolt, pressure, place in random.uniform([17, 0, 7.3], [93, 64, 21.9], (300, 3)):
            point = {"bolt": bolt, "P": pressure, "place": place}
            answer, force = reduced.query(**point), exact.query(**point).multipliers
            np.testing.assert_allclose(closing @ answer.multipliers, closing @ force, atol=1e-9 * force.sum())
            wrong = (answer.multipliers - force)[others]
            error = np.sqrt(max(0.0, wrong @ compliance[np.ix_(others, others)] @ wrong))
            assert answer.bound >= error * (1 - ROUNDING)
            effectivities.append(answer.bound / error)
    assert np.median(effectivities) <= LOOSE


@pytest.mark.parametrize("room", ["64", "0"])
def test_no_force_is_no_answer_where_loads_are_carried(signorom, tmp_path, room):
    """A coarse domain on which nothing touches at some points: by the fallback, or refused with its reason."""
    reduction = "method: hhr, pod_tolerance: 1.0e-5, enrichment: none, zones_of_interest: [shelf]"
    deck = floating_deck(tmp_path, f"reduction: {{{reduction}, max_full_order_size: {room}}}")
    done = signorom.run("run", deck, folder=tmp_path)
    table = read_table(tmp_path / "results/bracket/validation.csv")
    errors, is_blind = np.array(table["e_lambda_all"]), table["n_active"] == 0
    is_refused = np.array(table["solver"]) == "none"
    assert is_blind.sum() > 5
    assert done.returncode == (3 if room == "0" else 0)
    if room == "0":
        np.testing.assert_array_equal(is_refused, is_blind)
        point = [f"{name}={float(table[name][is_blind][0])!r}" for name in ("bolt", "P", "place")]
        asked = signorom.run(
            "predict", "model.h5", "--at", ",".join(point), folder=tmp_path / "results" / "bracket"
        )
        assert asked.returncode == 3
        assert "no contact closes in the reduced integration domain" in asked.stdout
    else:
        assert not is_refused.any()
        assert max(errors[np.array(table["solver"]) == "condensed"]) <= 1e-8
        assert max(map(float, table["error_bound"])) <= 0.05


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
    told = re.search(
        r"hyper-reduction \(reduction.method: auto\): the matrix of all contacts takes (\S+) MB", said
    )
    assert 1e-4 < float(told[1]) < 0.01  # 8 bytes for each of at most 20 * 22 numbers
    assert "no error_bound" in said


HANGING = {
    "  - {boundary: top, displacement: {y: -push}}\n": "",
    "contact:": "loads:\n  - {boundary: top, pressure: 1.0e+6 * push}\ncontact:",
    "young_modulus: 2.0e6": "young_modulus: 2.0e+7 * push",
}
SMALL = {HHR: "reduction: {method: hhr, max_full_order_size: 0, ", NO_LIMIT: ""}


@pytest.mark.parametrize(
    ("name", "changes", "reason"),
    [
        (
            "patch",
            HANGING,
            "the stiffness depends on the parameters, and only contact holds a body; "
            "a model with reduction.method: condensed has bounds",
        ),
        ("small_disks", {}, "certificate.max_error is none"),
        ("small_disks", SMALL, "reduction.max_full_order_size is 0"),
    ],
    ids=["hanging", "none", "no_room"],
)
def test_training_says_why_there_is_no_bound(signorom, tmp_path, name, changes, reason):
    """Once, where answers of a hyper-reduced model have no bound."""
    deck = write_deck(name, tmp_path, **changes)
    signorom("sample", deck.name, folder=tmp_path)
    done = signorom.run("train", deck.name, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    said = done.stdout + done.stderr
    assert said.count("no bound") == 1
    assert f"hyper-reduced answers will have no bound of their error (certificate): {reason}\n" in said
    signorom("validate", deck.name, folder=tmp_path)
    errors = read_table(tmp_path / "results" / name / "validation.csv")
    assert "none" in set(errors["error_bound"])


def test_condensed_model_of_a_hanging_body_has_bounds(signorom, tmp_path):
    deck = write_deck("patch", tmp_path, **HANGING, **{"method: hhr": "method: condensed"})
    assert "no error_bound" not in signorom("run", deck.name, folder=tmp_path)


def test_model_that_is_not_good_enough_is_named(signorom, post, tmp_path):
    """By the program, and by the Python package when it opens the model."""
    deck = write_deck("small_disks", tmp_path, **{NO_LIMIT: NO_LIMIT + "\nvalidation: {accept: 1.0e-12}"})
    done = signorom.run("run", deck.name, folder=tmp_path)
    assert done.returncode == 0
    assert "NOT accepted: p95 of e_lambda_all is" in done.stderr
    folder = tmp_path / "results" / "small_disks"
    described = signorom("describe", "model.h5", folder=folder)
    assert "NOT accepted: p95 of e_lambda_all is" in described
    said = signorom.run("predict", "model.h5", "--at", "squeeze=0.2", folder=folder).stderr
    assert "the validation of this model: NOT accepted: p95 of e_lambda_all is" in said
    with pytest.warns(post.NotAcceptedWarning) as warned:
        post.Model(folder / "model.h5").close()
    assert [f"warning: {one.message}\n" for one in warned] == [said]
    assert warned[0].filename == __file__
    command = [sys.executable, "-m", "signorom_post", "fmu", "model.h5"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stderr == said


def test_accepted_model_opens_without_a_warning(post, default):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        post.Model(default[1] / "model.h5").close()


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
    (tmp_path / "points.csv").write_text("squeeze\n0.01\n0.2\n")
    arguments = ("--points", tmp_path / "points.csv", "--output", tmp_path / "answers.csv")
    assert signorom.run("predict", model, *arguments, folder=tmp_path).returncode == 3
    header, without, with_one = (
        line.split(",") for line in (tmp_path / "answers.csv").read_text().splitlines()
    )
    for name in ("n_active", "contact_force", header[-1], "contact_1_area"):
        assert without[header.index(name)] == "nan"
        assert float(with_one[header.index(name)]) >= 0
