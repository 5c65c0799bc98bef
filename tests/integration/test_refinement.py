# SPDX-License-Identifier: BSD-3-Clause
"""Local models up to a target error: more clusters, or splits and added snapshots, on candidates that outlive a kill."""

import os
import re
import shutil
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
import yaml
from signorom_post.forest import features_of, fit, read_labels

from program import ROOT, kill, wait_until
from results import read_snapshots, read_table
from runs import files_in, refuse, write_deck

pytestmark = pytest.mark.slow

N_GRID = 21
N_CANDIDATES = 60
N_ROUND = 4
CANDIDATES = f"candidates: {{sobol: {N_CANDIDATES}, seed: 3}}"
REFINE = f"refine: {{max_points: 20, points_per_round: {N_ROUND}}}"
REGULAR = f"number: 1, max_number: 4, target: {{error: 0.004, measure: e_lambda_rid, {CANDIDATES}}}, {REFINE}"
NUMBER = f"number: auto, max_number: 3, target: {{error: 1.0e-9, measure: e_lambda_rid, {CANDIDATES}}}"


def changes_of(clusters, points="grid: {squeeze: 7, shift: 3}"):
    """Changes of decks/shifted_disks.yaml; hats, so that multipliers are unique and small errors mean something."""
    return {
        "grid: {squeeze: 7, shift: 3}": points,
        "reduction: {method: hhr, pod_tolerance: 1.0e-5}": f"clusters: {{{clusters}}}\n"
        "reduction: {method: hhr, pod_tolerance: 1.0e-5, enrichment: {type: greedy}}",
    }


def run(signorom, folder, clusters, *commands, n_ranks=1, **points):
    """Results folder of sample and train."""
    deck = write_deck("shifted_disks", folder, **changes_of(clusters, **points))
    for command in commands or ("sample", "train"):
        signorom(command, deck.name, folder=folder, n_ranks=n_ranks)
    return folder / "results" / "shifted_disks"


@pytest.fixture(scope="module")
def refined(signorom, tmp_path_factory):
    """Results of a refinement that begins with one model of grid points."""
    return run(signorom, tmp_path_factory.mktemp("refined"), REGULAR)


def rounds_of(results):
    """The columns of refinement.csv."""
    return {name: np.array(values) for name, values in read_table(results / "refinement.csv").items()}


def points_of(model):
    """Training points, and those of each cluster as numbers from 0."""
    with h5py.File(model) as file:
        numbers = [file[f"clusters/{k + 1}/training_points"][()] - 1 for k in range(file.attrs["n_clusters"])]
        return file["parameters/training_points"][()], numbers


def errors_at(signorom, results, points, folder, clusters):
    """e_lambda_rid and cluster of a model at points, by `validate`."""
    folder.mkdir()
    shutil.copytree(results, folder / "results" / "shifted_disks")
    lines = ["squeeze,shift", *(",".join(map(repr, map(float, point))) for point in points)]
    (folder / "points.csv").write_text("\n".join(lines) + "\n")
    changes = changes_of(clusters) | {"grid: {squeeze: 5, shift: 4}": "file: points.csv"}
    deck = write_deck("shifted_disks", folder, **changes)
    signorom("validate", deck.name, folder=folder)
    table = read_table(folder / "results" / "shifted_disks" / "validation.csv")
    return table["e_lambda_rid"], table["cluster"]


def same_rows(found, expected):
    """Two refinement.csv; the errors to the rounding of small errors."""
    assert (found["action"] == expected["action"]).all()
    for name in ("cluster", "n_clusters", "n_snapshots", "n_candidates", "worst_cluster"):
        np.testing.assert_array_equal(found[name], expected[name])
    for name in ("median", "p95", "max"):
        np.testing.assert_allclose(found[name], expected[name], rtol=1e-6)


def test_rounds_are_written_down(refined):
    """A round adds snapshots to the worst cluster or splits it; all are measured on one half of the candidates."""
    rows = rounds_of(refined)
    assert rows["action"][0] == "start"
    assert {"add", "split"} == set(rows["action"][1:])
    is_split = rows["action"][1:] == "split"
    np.testing.assert_array_equal(np.diff(rows["n_clusters"]), is_split)
    np.testing.assert_array_equal(np.diff(rows["n_snapshots"]), np.where(is_split, 0, N_ROUND))
    assert set(rows["n_candidates"]) == {N_CANDIDATES / 2}
    np.testing.assert_array_equal(rows["cluster"][1:], rows["worst_cluster"][:-1])
    assert (rows["p95"][:-1] > 0.004).all()
    assert rows["p95"][-1] <= 0.004
    assert rows["p95"].argmin() == len(rows["p95"]) - 1
    report = yaml.safe_load((refined / "report.yaml").read_text())["reduction"]
    assert report["refinement"]["n_rounds"] == len(rows["round"]) - 1
    assert report["refinement"]["best_round"] == len(rows["round"]) - 1
    assert report["refinement"]["target_reached"] == "yes"
    assert report["n_clusters"] == rows["n_clusters"][-1]


def halves_of(results):
    """The candidates, as rows of points, that are kept for measuring, and those that may become snapshots (seed 1)."""
    points = read_snapshots(results / "candidates.h5")["parameters"]
    trained = {tuple(point) for point in points_of(results / "model.h5")[0]}
    return points, np.array([tuple(point) in trained for point in points])


def test_model_is_the_one_of_the_last_round(signorom, refined, tmp_path):
    """At half of the candidates, none of them a snapshot, `validate` measures what the last row says."""
    points, clusters = points_of(refined / "model.h5")
    rows = rounds_of(refined)
    assert len(points) == rows["n_snapshots"][-1]
    assert sorted(set(np.concatenate(clusters))) == list(range(len(points)))
    candidates, is_trained = halves_of(refined)
    assert is_trained.sum() == len(points) - N_GRID
    errors, _ = errors_at(signorom, refined, candidates[~is_trained], tmp_path / "check", REGULAR)
    # which half is drawn is the program's matter; its largest error and middle two are among these
    assert np.isclose(errors, rows["max"][-1], rtol=1e-5).any()
    n = N_CANDIDATES // 2
    assert rows["max"][-1] >= np.sort(errors)[n - 1]
    pairs = (errors[:, None] + errors[None, :]) / 2
    assert np.isclose(pairs, rows["median"][-1], rtol=1e-5).any()


def test_all_measure_where_no_snapshot_is_added(signorom, refined, tmp_path):
    """max_points 0: clusters are split only, and every candidate counts."""
    shutil.copytree(refined, tmp_path / "results" / "shifted_disks")
    clusters = REGULAR.replace("max_points: 20", "max_points: 0").replace("max_number: 4", "max_number: 2")
    results = run(signorom, tmp_path, clusters, "train")
    rows = rounds_of(results)
    assert rows["action"].tolist() == ["start", "split"]
    # the start is better here: its model stays
    best = int(rows["p95"].argmin())
    candidates, is_trained = halves_of(results)
    assert not is_trained.any()
    errors, answered = errors_at(signorom, results, candidates, tmp_path / "check", clusters)
    for name, value in (
        ("median", np.median(errors)),
        ("p95", np.percentile(errors, 95)),
        ("max", errors.max()),
    ):
        np.testing.assert_allclose(rows[name][best], value, rtol=1e-5)
    worst = max(set(answered), key=lambda k: np.percentile(errors[answered == k], 95))
    assert rows["worst_cluster"][best] == worst
    assert len(set(answered)) == rows["n_clusters"][best]


def test_worst_candidates_join_first(signorom, refined, tmp_path):
    """The first snapshots that are added have the largest errors of the start, of those that may be taken."""
    start = run(signorom, tmp_path, "number: 1")
    candidates = read_snapshots(refined / "candidates.h5")["parameters"]
    errors, _ = errors_at(signorom, start, candidates, tmp_path / "check", "number: 1")
    added = points_of(refined / "model.h5")[0][N_GRID : N_GRID + N_ROUND]
    places = [np.flatnonzero((np.isclose(candidates, point, rtol=1e-14)).all(axis=1))[0] for point in added]
    assert (np.diff(errors[places]) < 0).all()
    # half of the candidates cannot be taken: of the 8 worst, 4 on average
    assert set(places) <= set(np.argsort(-errors)[: 4 * N_ROUND])


@pytest.mark.parametrize("n_ranks", [2, 3])
def test_ranks_refine_alike(signorom, refined, tmp_path, n_ranks):
    other = run(signorom, tmp_path, REGULAR, n_ranks=n_ranks)
    same_rows(rounds_of(other), rounds_of(refined))
    for found, expected in zip(points_of(other / "model.h5"), points_of(refined / "model.h5"), strict=True):
        np.testing.assert_array_equal(np.concatenate(found), np.concatenate(expected))


def test_target_that_is_met_changes_nothing(signorom, refined, tmp_path):
    """One round, and the model without a target."""
    shutil.copytree(refined, tmp_path / "results" / "shifted_disks")
    loose = run(signorom, tmp_path, REGULAR.replace("error: 0.004", "error: 0.5"), "train")
    assert rounds_of(loose)["action"].tolist() == ["start"]
    with h5py.File(loose / "model.h5") as a:
        found = a["clusters/1/reduced_stiffness"][()]
    plain = run(signorom, tmp_path, "number: 1", "train")
    with h5py.File(plain / "model.h5") as b:
        np.testing.assert_array_equal(found, b["clusters/1/reduced_stiffness"][()])


def test_number_is_raised_and_the_best_stays(signorom, refined, tmp_path):
    """A target out of reach: every number up to the largest, and the model of the best one, with a warning."""
    shutil.copytree(refined, tmp_path / "results" / "shifted_disks")
    deck = write_deck("shifted_disks", tmp_path, **changes_of(NUMBER))
    done = signorom.run("train", deck.name, folder=tmp_path)
    assert done.returncode == 0
    results = tmp_path / "results" / "shifted_disks"
    rows = rounds_of(results)
    assert rows["action"].tolist() == ["number"] * 3
    assert rows["n_clusters"].tolist() == [1, 2, 3]
    assert set(rows["n_snapshots"]) == {N_GRID}
    best = int(rows["n_clusters"][np.argmin(rows["p95"])])
    assert "above the target of 1.0e-9; no number of clusters up to 3 does better" in done.stderr
    _, found = points_of(results / "model.h5")
    _, expected = points_of(run(signorom, tmp_path, f"number: {best}", "train") / "model.h5")
    np.testing.assert_array_equal(np.concatenate(found), np.concatenate(expected))


def test_scattered_snapshots_and_their_forest(signorom, tmp_path, monkeypatch):
    """The model of the best round has its snapshots, and its forest, which scikit-learn trains again from labels.csv."""
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}:{os.environ['PATH']}")
    clusters = REGULAR.replace("number: 1, max_number: 4", "number: 2, max_number: 3, method: irregular")
    results = run(signorom, tmp_path, clusters, "sample", "train", "validate", points="sobol: 20")
    rows = rounds_of(results)
    assert {"add", "split"} == set(rows["action"][1:])
    points, numbers = points_of(results / "model.h5")
    best = int(rows["p95"].argmin())
    assert best < len(rows["p95"]) - 1
    assert (len(points), len(numbers)) == (rows["n_snapshots"][best], rows["n_clusters"][best])
    assert sorted(np.concatenate(numbers)) == list(range(len(points)))
    names, labeled, labels = read_labels(results / "labels.csv")
    np.testing.assert_allclose(labeled, points[: len(labels)], rtol=1e-14)
    table = read_table(results / "validation.csv")
    classifier = fit(features_of(labeled, labeled), labels, 100, 1)
    tested = np.array([table[name] for name in names]).T
    np.testing.assert_array_equal(table["cluster"], classifier.predict(features_of(tested, labeled)))


def test_candidates_are_solved_once(signorom, tmp_path):
    """Killed in the middle, the same command goes on; train tells what is missing before."""
    count = 8000
    clusters = REGULAR.replace(f"sobol: {N_CANDIDATES}", f"sobol: {count}")
    changes = changes_of(clusters) | {"solver: {type: condensed}": "solver: {type: active_set}"}
    deck = write_deck("shifted_disks", tmp_path, **changes)
    results = tmp_path / "results" / "shifted_disks"
    process = signorom.start("sample", deck.name, folder=tmp_path, n_ranks=2)
    wait_until(
        lambda: sum(shard.stat().st_size for shard in results.glob("candidates.part-*")) > 3e5, process
    )
    kill(process)
    assert (results / "snapshots.h5").exists()
    assert len(list(results.glob("candidates.part-*"))) == 2
    message = refuse(signorom, "train", deck.name, folder=tmp_path)
    assert "candidates.h5: error: there are no solved candidates yet" in message
    # what was solved are the first points of either group, and Sobol's points do not depend on their number
    changes = {key: value.replace(f"sobol: {count}", "sobol: 300") for key, value in changes.items()}
    deck = write_deck("shifted_disks", tmp_path, **changes)
    log = signorom("sample", deck.name, folder=tmp_path)
    assert int(re.search(r"solved 300 candidates \((\d+) were there\)", log).group(1)) > 100
    assert not list(results.glob("*.part-*"))
    before = files_in(tmp_path)
    assert "solved 300 candidates (300 were there)" in signorom("sample", deck.name, folder=tmp_path)
    assert files_in(tmp_path) == before
    deck.write_text(deck.read_text().replace("seed: 3", "seed: 4"))
    message = refuse(signorom, "train", deck.name, folder=tmp_path, n_ranks=2)
    assert re.search(r"candidates.h5: error: the file lacks \d+ of the 300 candidates of the deck", message)


def test_candidates_that_are_all_trained_on(signorom, tmp_path):
    """Nothing is left to measure on: named at the candidates' place in the deck."""
    clusters = REGULAR.replace(CANDIDATES, "candidates: {grid: {squeeze: 7, shift: 3}}")
    deck = write_deck("shifted_disks", tmp_path, **changes_of(clusters))
    signorom("sample", deck.name, folder=tmp_path)
    message = refuse(signorom, "train", deck.name, folder=tmp_path, n_ranks=2)
    assert re.search(
        r"shifted_disks.yaml:\d+:\d+: error: no candidate can measure the error: each of the 21", message
    )


def test_number_that_cannot_be_trained_ends_the_search(signorom, tmp_path):
    """One of four clusters of this wide grid has bodies that never touch: the best of fewer clusters stays."""
    wanted = "clusters: {number: auto, max_number: 4, target: {error: 1.0e-16, candidates: {sobol: 40}}}"
    deck = write_deck(
        "small_disks", tmp_path, **{"min: 0.15": "min: 0.01", "reduction:": f"{wanted}\nreduction:"}
    )
    done = signorom.run("run", deck.name, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "warning: 4 clusters give no model, so larger numbers are not tried: " in done.stdout + done.stderr
    assert "no number of clusters up to 3 does better" in done.stdout + done.stderr
    assert (tmp_path / "results" / "small_disks" / "model.h5").exists()


@pytest.mark.parametrize("measure", ["e_lambda_all", "e_lambda_rid"])
def test_candidates_that_fail_count(signorom, tmp_path, measure):
    """Nothing touches on a coarse domain at some points: they have no error there, which counts as infinite."""
    deck = tmp_path / "bracket.yaml"
    text = (ROOT / "input" / "bracket.yaml").read_text().replace("../meshes", str(ROOT / "meshes"))
    text = text.replace("test: {sobol: 500, seed: 1}", "test: {sobol: 100, seed: 1}")
    wanted = "" if measure == "e_lambda_all" else f"measure: {measure}, "
    deck.write_text(
        f"{text}certificate: {{max_error: none}}\n"
        "reduction: {method: hhr, pod_tolerance: 1.0e-5, enrichment: {type: none}, zones_of_interest: [shelf], "
        "max_full_order_size: 0}\n"
        "clusters: {number: auto, max_number: 1, method: irregular, "
        f"target: {{error: 0.01, {wanted}candidates: {{sobol: 100, seed: 1}}}}}}\n"
    )
    done = signorom.run("run", deck.name, folder=tmp_path)
    results = tmp_path / "results" / "bracket"
    rows, table = rounds_of(results), read_table(results / "validation.csv")
    errors = np.where(
        (np.array(table["solver"]) == "none") | np.isnan(table[measure]), np.inf, table[measure]
    )
    n_failed = np.isinf(errors).sum()
    assert measure == "e_lambda_all" or n_failed > 5
    assert rows["n_failed"][0] == n_failed
    assert rows["n_candidates"][0] == 100
    assert rows["share_above_0.1"][0] == np.mean(errors > 0.1)
    assert rows["max"][0] == pytest.approx(errors.max(), rel=1e-5)
    assert (
        yaml.safe_load((results / "report.yaml").read_text())["reduction"]["refinement"]["n_failed"]
        == n_failed
    )
    assert n_failed == 0 or f"{n_failed} failed" in done.stdout + done.stderr
