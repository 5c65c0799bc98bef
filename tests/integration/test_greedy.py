# SPDX-License-Identifier: BSD-3-Clause
"""Greedy selection of training points: the choice against NumPy, ranks, restarts, later stages."""

import re
import shutil

import numpy as np
import pytest
import yaml

from program import kill, wait_until
from results import read_snapshots, read_table
from runs import files_in, refuse, write_deck
from spread import spread

pytestmark = pytest.mark.slow

CANDIDATES = "grid: {squeeze: 7, shift: 3}, groups: auto"
INITIAL, MAX_POINTS = 3, 9
BOX = np.array([[0.15, 0.45], [-0.05, 0.1]])
# [-] a choice between errors nearer than this is a matter of rounding
TIE = 1e-8


def greedy(words):
    """Change of decks/shifted_disks.yaml: training by a greedy selection among 60 points."""
    return {CANDIDATES: f"greedy: {{candidates: {{sobol: 60}}, initial: {INITIAL}, {words}}}, groups: auto"}


DEFECT_POINTS = 30
DEFECT = greedy(f"indicator: defect, max_points: {DEFECT_POINTS}, batch: 2")
PROJECTION = greedy(f"max_points: {MAX_POINTS}, tolerance: 1.0e-9")


def select(signorom, folder, changes, n_ranks=1, command="sample"):
    """Results folder of a command on decks/shifted_disks.yaml with changes."""
    folder.mkdir(exist_ok=True)
    deck = write_deck("shifted_disks", folder, **changes)
    signorom(command, deck.name, folder=folder, n_ranks=n_ranks)
    return folder / "results" / "shifted_disks"


def points_of(results):
    """Points of selection.csv in their order, shape (n, 2)."""
    table = read_table_of_selection(results)
    return np.array([table["squeeze"], table["shift"]]).T


def read_table_of_selection(results):
    """Columns of selection.csv; lines that start with # are for people."""
    lines = (results / "selection.csv").read_text().splitlines(keepends=True)
    path = results.parent / "selection_without_comments.csv"
    path.write_text("".join(line for line in lines if not line.startswith("#")))
    return read_table(path)


def stop_of(results):
    """What ended the selection, and the largest indicator left."""
    text = (results / "selection.csv").read_text()
    reason = re.search(r"^# stopped by (\w+)$", text, re.M).group(1)
    return reason, float(re.search(r"^# largest indicator left (\S+)$", text, re.M).group(1))


@pytest.fixture(scope="module")
def projection(signorom, tmp_path_factory):
    """Results of a whole run with points selected by projection."""
    return select(signorom, tmp_path_factory.mktemp("projection"), PROJECTION, command="run")


@pytest.fixture(scope="module")
def defect(signorom, tmp_path_factory):
    """Results of a whole run with points selected by the model's defect."""
    return select(signorom, tmp_path_factory.mktemp("defect"), DEFECT, command="run")


def farthest(points, n):
    """Numbers of n points far from each other, the first one nearest to the middle of the box."""
    unit = (points - BOX[:, 0]) / (BOX[:, 1] - BOX[:, 0])
    chosen = [int(np.linalg.norm(unit - 0.5, axis=1).argmin())]
    while len(chosen) < n:
        distances = np.linalg.norm(unit[:, None] - unit[chosen][None], axis=2).min(axis=1)
        chosen.append(int(np.flatnonzero(distances >= distances.max() - TIE)[0]))
    return chosen


def vectors_of(pool):
    """What contact adds to the elastic response, relative to the displacement; one column per candidate."""
    squeeze, shift = pool["parameters"].T
    values = {
        "1": 1 + 0 * squeeze,
        "squeeze": squeeze,
        "shift": shift,
        "-squeeze - shift^2": -squeeze - shift**2,
    }
    theta = np.array([values[text] for text in pool["term_texts"]])
    fields = pool["displacement"].T - pool["free_response"].T @ theta
    return fields / np.linalg.norm(pool["displacement"], axis=1)


def test_selection_is_that_of_numpy(projection):
    """Initial points far apart, then each time the candidate farthest from the span; of equal ones the first."""
    pool = read_snapshots(projection / "candidates.h5")
    assert len(pool["parameters"]) == 60
    vectors = vectors_of(pool)
    chosen, errors = farthest(pool["parameters"], INITIAL), []
    while True:
        basis, values, _ = np.linalg.svd(vectors[:, chosen], full_matrices=False)
        basis = basis[:, values > 1e-12 * values[0]]
        rest = vectors - basis @ (basis.T @ vectors)
        distances = np.linalg.norm(rest, axis=0)
        if distances.max() < 1e-9 or len(chosen) == MAX_POINTS:
            break
        chosen.append(int(np.flatnonzero(distances >= (1 - TIE) * distances.max())[0]))
        errors.append(distances.max())
    np.testing.assert_array_equal(points_of(projection), pool["parameters"][chosen])
    table = read_table_of_selection(projection)
    assert np.isnan(table["indicator"][:INITIAL]).all()
    # seven digits in the table
    np.testing.assert_allclose(table["indicator"][INITIAL:], errors, rtol=1e-5)
    assert len(errors) > 1
    reason, left = stop_of(projection)
    assert reason == "tolerance"
    assert left < 1e-9


def test_later_stages_work_on_the_selection(projection):
    """snapshots.h5, the model and the report have the chosen points, in their order."""
    points = points_of(projection)
    snapshots = read_snapshots(projection / "snapshots.h5")
    np.testing.assert_array_equal(snapshots["parameters"], points)
    pool = read_snapshots(projection / "candidates.h5")
    for point, displacement in zip(points, snapshots["displacement"], strict=True):
        number = int(np.flatnonzero((pool["parameters"] == point).all(axis=1))[0])
        np.testing.assert_array_equal(displacement, pool["displacement"][number])
    report = yaml.safe_load((projection / "report.yaml").read_text())["sampling"]
    assert report["n_points"] == len(points)
    assert report["greedy"]["indicator"] == "projection"
    assert report["greedy"]["stopped_by"] == "tolerance"
    assert (projection / "validation.csv").exists()


@pytest.mark.parametrize(
    ("indicator", "ranks"), spread(["projection", "defect"], [(2, "auto"), (3, "1"), (4, "2")])
)
def test_ranks_select_the_same(signorom, request, tmp_path, ranks, indicator):
    n_ranks, groups = ranks
    changes = {"projection": PROJECTION, "defect": DEFECT}[indicator]
    changes = {key: text.replace("groups: auto", f"groups: {groups}") for key, text in changes.items()}
    found = select(signorom, tmp_path, changes, n_ranks)
    np.testing.assert_array_equal(points_of(found), points_of(request.getfixturevalue(indicator)))


def test_defect_bounds_the_error(defect):
    """Never below the energy errors of the answer, displacement or forces, at the points that were solved then."""
    table = read_table_of_selection(defect)
    assert len(table["order"]) == DEFECT_POINTS
    assert stop_of(defect)[0] == "max_points"
    chosen = slice(INITIAL, None)
    errors = np.maximum(table["error_u"], table["error_lambda"])
    assert (errors[chosen] <= table["indicator"][chosen] * (1 + 1e-6)).all()
    assert np.median(table["indicator"][chosen] / errors[chosen]) < 5
    assert np.isnan(errors[:INITIAL]).all()


def test_defect_solves_what_it_chooses(defect):
    """No pool of candidates; snapshots and report in the order of the choice."""
    assert not (defect / "candidates.h5").exists()
    np.testing.assert_array_equal(read_snapshots(defect / "snapshots.h5")["parameters"], points_of(defect))
    report = yaml.safe_load((defect / "report.yaml").read_text())["sampling"]["greedy"]
    assert report["indicator"] == "defect"
    assert report["stopped_by"] == "max_points"
    assert report["largest_indicator_left"] == pytest.approx(stop_of(defect)[1], rel=1e-6)
    assert (defect / "validation.csv").exists()


def n_rows(results):
    """Points in selection.csv so far."""
    path = results / "selection.csv"
    return path.read_text().count("\n") - 3 if path.exists() else 0


@pytest.mark.parametrize(("n_ranks", "n_ranks_after"), [(1, 1), (2, 1), (1, 2)])
def test_killed_rounds_go_on(signorom, defect, tmp_path, n_ranks, n_ranks_after):
    """SIGKILL between rounds: the same selection, and the points of the table are not solved again."""
    deck = write_deck("shifted_disks", tmp_path, **DEFECT)
    results = tmp_path / "results" / "shifted_disks"
    # on a busy machine the rounds may all have ended before this process looks: then once more
    for _ in range(5):
        shutil.rmtree(results, ignore_errors=True)
        process = signorom.start("sample", deck.name, folder=tmp_path, n_ranks=n_ranks)
        wait_until(lambda: n_rows(results) > INITIAL, process)
        kill(process)
        rows = n_rows(results)
        if rows < DEFECT_POINTS:
            break
    assert rows < DEFECT_POINTS
    assert "stopped by" not in (results / "selection.csv").read_text()
    output = signorom("sample", deck.name, folder=tmp_path, n_ranks=n_ranks_after)
    there = int(re.search(rf"sampled {DEFECT_POINTS} points \((\d+) were there\)", output).group(1))
    assert there >= rows
    np.testing.assert_array_equal(points_of(results), points_of(defect))


def test_killed_candidates_go_on(signorom, tmp_path):
    """SIGKILL while candidates are solved: none is solved twice, and the selection is that of an undisturbed run."""
    changes = greedy("max_points: 6") | {"solver: {type: condensed}": "solver: {type: active_set}"}
    changes = {key: text.replace("sobol: 60", "sobol: 2000") for key, text in changes.items()}
    undisturbed = select(signorom, tmp_path / "undisturbed", changes)
    deck = write_deck("shifted_disks", tmp_path, **changes)
    results = tmp_path / "results" / "shifted_disks"
    shard = results / "candidates.part-1"
    process = signorom.start("sample", deck.name, folder=tmp_path)
    wait_until(lambda: shard.exists() and shard.stat().st_size > 5e4, process)
    kill(process)
    assert not (results / "snapshots.h5").exists()
    output = signorom("sample", deck.name, folder=tmp_path)
    there = int(re.search(r"sampled 2000 points \((\d+) were there\)", output).group(1))
    assert 0 < there < 2000
    np.testing.assert_array_equal(points_of(results), points_of(undisturbed))


@pytest.mark.parametrize(("method", "n_notes"), [("", 1), ("method: condensed, ", 1), ("method: hhr, ", 0)])
def test_note_that_another_kind_is_judged(signorom, tmp_path, method, n_notes):
    """The defects are those of a hyper-reduced model, whatever the deck's own model will be."""
    changes = greedy("indicator: defect, max_points: 4") | {"method: hhr, ": method}
    deck = write_deck("shifted_disks", tmp_path, **changes)
    note = "judges a hyper-reduced model of the points so far, but the model of this deck will be condensed"
    assert signorom("sample", deck.name, folder=tmp_path).count(note) == n_notes
    assert note not in signorom("sample", deck.name, folder=tmp_path)  # nothing is selected again


def test_residuals_where_nothing_is_condensed(signorom, tmp_path):
    """With multigrid there is no W: the selection says that it bounds nothing, and goes on with residuals."""
    changes = greedy("indicator: defect, max_points: 6") | {
        "solver: {type: condensed}": "solver: {type: active_set, linear: gamg}"
    }
    deck = write_deck("shifted_disks", tmp_path, **changes)
    assert "which is no bound of the error" in signorom("sample", deck.name, folder=tmp_path)
    table = read_table_of_selection(tmp_path / "results" / "shifted_disks")
    assert (table["indicator"][INITIAL:] > 0).all()
    assert (table["error_u"][INITIAL:] > 0).all()
    assert np.isnan(table["error_lambda"]).all()


def test_more_points_go_on_from_the_selection(signorom, defect, tmp_path):
    """A larger budget adds points to those that are there; a smaller one takes the first of them."""
    results = tmp_path / "results" / "shifted_disks"
    shutil.copytree(defect, results)
    deck = write_deck("shifted_disks", tmp_path, **DEFECT)
    text = deck.read_text()
    deck.write_text(text.replace(f"max_points: {DEFECT_POINTS}", "max_points: 33"))
    assert f"sampled 33 points ({DEFECT_POINTS} were there)" in signorom("sample", deck.name, folder=tmp_path)
    np.testing.assert_array_equal(points_of(results)[:DEFECT_POINTS], points_of(defect))
    deck.write_text(text.replace(f"max_points: {DEFECT_POINTS}", "max_points: 12"))
    signorom("sample", deck.name, folder=tmp_path)
    np.testing.assert_array_equal(points_of(results), points_of(defect)[:12])


def test_second_run_does_nothing(signorom, projection, tmp_path):
    """A larger tolerance takes the beginning of the same selection, without a new full-order solution."""
    results = tmp_path / "results" / "shifted_disks"
    shutil.copytree(projection, results)
    deck = write_deck("shifted_disks", tmp_path, **PROJECTION)
    before = files_in(results)
    n = len(points_of(results))
    assert f"sampled {n} points ({n} were there)" in signorom("sample", deck.name, folder=tmp_path)
    assert files_in(results) == before
    table = read_table_of_selection(results)
    tolerance = float(table["indicator"][-1]) * 1.1
    deck.write_text(deck.read_text().replace("tolerance: 1.0e-9", f"tolerance: {tolerance}"))
    assert "(60 were there)" in signorom("sample", deck.name, folder=tmp_path)
    shorter = points_of(results)
    assert len(shorter) < n
    np.testing.assert_array_equal(shorter, np.array([table["squeeze"], table["shift"]]).T[: len(shorter)])


def test_training_needs_the_selection(signorom, projection, tmp_path):
    """Other candidates: the selection in the folder is not that of the deck."""
    shutil.copytree(projection, tmp_path / "results" / "shifted_disks")
    deck = write_deck("shifted_disks", tmp_path, **PROJECTION)
    deck.write_text(deck.read_text().replace("sobol: 60", "sobol: 50"))
    words = refuse(signorom, "train", deck.name, folder=tmp_path)
    assert "selection.csv: error: there is no finished selection of training points for this deck" in words
    assert "hint: run first: signorom sample" in words


def test_few_candidates_in_a_file_are_named(signorom, tmp_path):
    (tmp_path / "points.csv").write_text("squeeze,shift\n0.2,0\n0.3,0.01\n")
    changes = {CANDIDATES: "greedy: {candidates: {file: points.csv}, max_points: 9}"}
    deck = write_deck("shifted_disks", tmp_path, **changes)
    words = refuse(signorom, "sample", deck.name, folder=tmp_path)
    assert "the greedy selection begins with 5 points (initial); there are only 2 candidates" in words
