# SPDX-License-Identifier: BSD-3-Clause
"""Histories of materials that flow, chosen by the estimates of the model's own error."""

import re

import numpy as np
import pytest
import yaml

from program import kill, wait_until
from results import read_snapshots, read_table
from test_flow_commands import write_deck

N_TIMES, N_CANDIDATES, INITIAL, MAX_POINTS = 4, 20, 3, 6
NAMES = ("stroke", "sy")
SELECT = (
    f"training: {{greedy: {{candidates: {{sobol: {N_CANDIDATES}}}, initial: {INITIAL}, "
    f"max_points: {MAX_POINTS}}}, groups: auto}}"
)
CHANGES = {
    "{stroke: {min: 0, max: 0.02}}": "{stroke: {min: 0, max: 0.002}, sy: {min: 150, max: 250}}",
    "yield_stress: 200": "yield_stress: sy",
    "output: {points: [{stroke: 0.004}, {stroke: 0.01}]}\n": "",
}
TIGHT = "reduction: {inelastic_tolerance: 1.0e-4}\n"


def study(folder, training=SELECT, more=TIGHT):
    """Deck of two blocks, one of which yields and creeps, over stroke and yield stress."""
    folder.mkdir(exist_ok=True)
    deck = write_deck(folder, **CHANGES, **{"training: {sobol: 4}": training})
    deck.write_text(deck.read_text() + more)
    return deck


def selection_of(folder):
    """Columns of selection.csv, why it ended, and the largest estimate left."""
    text = (folder / "results" / "part" / "selection.csv").read_text()
    path = folder / "rows.csv"
    path.write_text("".join(line for line in text.splitlines(keepends=True) if not line.startswith("#")))
    reason = re.search(r"^# stopped by (\w+)$", text, re.M).group(1)
    return (
        read_table(path),
        reason,
        float(re.search(r"^# largest indicator left (\S+)$", text, re.M).group(1)),
    )


def points_of(folder):
    table = selection_of(folder)[0]
    return np.array([table[name] for name in NAMES]).T


@pytest.fixture(scope="module")
def selected(signorom, tmp_path_factory):
    """Folder of a selection that ends by its budget."""
    folder = tmp_path_factory.mktemp("selected")
    signorom("sample", study(folder), folder=folder)
    return folder


def forces(table):
    """Contact forces, shape (n_histories, n_times, n_contacts)."""
    columns = np.array([table[name] for name in table if name.startswith("lambda_")]).T
    return columns.reshape(-1, N_TIMES, columns.shape[1])


def over_history(differences, sizes):
    """Largest size of the differences at any time, over the largest size at any time."""
    return np.linalg.norm(differences, axis=2).max(axis=1) / np.linalg.norm(sizes, axis=2).max(axis=1)


def candidates_of(signorom, folder):
    """The candidates, from the snapshots of a deck that has them as training points."""
    deck = study(folder, f"training: {{sobol: {N_CANDIDATES}}}")
    signorom("sample", deck, folder=folder)
    return read_snapshots(folder / "results" / "part" / "snapshots.h5")


def write_points(path, points):
    lines = [",".join(NAMES), *(",".join(repr(float(x)) for x in point) for point in points)]
    path.write_text("\n".join(lines) + "\n")


def test_choice_is_that_of_the_estimates(signorom, selected, tmp_path):
    """A model of the first histories alone, asked at all candidates: its worst one is the next history."""
    table, reason, left = selection_of(selected)
    assert reason == "max_points"
    points = points_of(selected)
    assert len(points) == MAX_POINTS
    assert np.isnan(table["indicator"][:INITIAL]).all()
    pool = candidates_of(signorom, tmp_path / "all")
    states, exact = pool["parameters"], pool["multipliers"]
    candidates = states[::N_TIMES, :2]
    exact = exact.reshape(N_CANDIDATES, N_TIMES, -1)
    for n in range(INITIAL, MAX_POINTS + 1):
        folder = tmp_path / str(n)
        deck = study(folder, "training: {file: first.csv}")
        write_points(folder / "first.csv", points[:n])
        write_points(folder / "candidates.csv", candidates)
        signorom("sample", deck, folder=folder)
        signorom("train", deck, folder=folder)
        model = folder / "results" / "part" / "model.h5"
        signorom("predict", model, "--points", "candidates.csv", "--output", "answers.csv", folder=folder)
        answers = read_table(folder / "answers.csv")
        found = forces(answers)
        moved = answers["error_estimate"].reshape(N_CANDIDATES, N_TIMES) * np.linalg.norm(found, axis=2)
        sizes = np.linalg.norm(found, axis=2).max(axis=1)
        estimates = moved.max(axis=1) / np.maximum(sizes, 0.01 * sizes.max())
        is_left = ~(candidates[:, None] == points[None, :n]).all(axis=2).any(axis=1)
        worst = estimates[is_left].max()
        if n == MAX_POINTS:
            assert worst == pytest.approx(left, rel=1e-3)
            return
        i = int(np.flatnonzero((candidates == points[n]).all(axis=1))[0])
        assert is_left[i]
        assert estimates[i] == pytest.approx(worst, rel=1e-6)
        assert table["indicator"][n] == pytest.approx(worst, rel=1e-3)
        error = over_history((found - exact)[i : i + 1], exact[i : i + 1])[0]
        assert table["error_lambda"][n] == pytest.approx(error, rel=0.02)
        assert 0 < table["error_stress"][n] < 1


@pytest.mark.parametrize(("n_ranks", "groups"), [(2, "auto"), (3, "1")])
def test_ranks_select_the_same(signorom, selected, tmp_path, n_ranks, groups):
    deck = study(tmp_path, SELECT.replace("groups: auto", f"groups: {groups}"))
    signorom("sample", deck, folder=tmp_path, n_ranks=n_ranks)
    np.testing.assert_array_equal(points_of(tmp_path), points_of(selected))
    found, table = selection_of(tmp_path)[0], selection_of(selected)[0]
    np.testing.assert_allclose(found["indicator"][INITIAL:], table["indicator"][INITIAL:], rtol=1e-3)


def n_rows(results):
    """Histories in selection.csv so far."""
    path = results / "selection.csv"
    return path.read_text().count("\n") - 3 if path.exists() else 0


def test_killed_rounds_go_on(signorom, selected, tmp_path):
    """SIGKILL between rounds: the same selection, and the histories of the table are not solved again."""
    deck = study(tmp_path)
    results = tmp_path / "results" / "part"
    process = signorom.start("sample", deck.name, folder=tmp_path)
    wait_until(lambda: n_rows(results) > INITIAL, process)
    kill(process)
    rows = n_rows(results)
    assert "stopped by" not in (results / "selection.csv").read_text()
    output = signorom("sample", deck.name, folder=tmp_path)
    there = int(re.search(rf"sampled {MAX_POINTS * N_TIMES} points \((\d+) were there\)", output).group(1))
    assert there >= rows * N_TIMES
    found, table = selection_of(tmp_path)[0], selection_of(selected)[0]
    for name in table:
        np.testing.assert_allclose(found[name], table[name], rtol=1e-6)


def test_run_to_the_tolerance(signorom, tmp_path):
    """Ends where the largest estimate, by the ratio of measured errors to estimates, is below the tolerance."""
    tolerance = 0.002
    more = f"reduction: {{inelastic_tolerance: {tolerance}, fields: true}}\ntest: {{sobol: 3, seed: 1}}\n"
    deck = study(tmp_path, SELECT.replace(f"max_points: {MAX_POINTS}", "max_points: none"), more)
    output = signorom("run", deck, folder=tmp_path)
    assert "3 training histories: largest estimate of 20 candidates" in output
    table, reason, left = selection_of(tmp_path)
    assert reason == "tolerance"
    estimates = table["indicator"][INITIAL:]
    ratios = np.maximum(table["error_lambda"], table["error_stress"])[INITIAL:] / estimates
    # where the model had no answer there is no ratio
    assert left * np.nanmax(ratios) <= tolerance
    # no round before would have ended
    assert len(ratios) > 1
    for i in range(1, len(ratios)):
        assert estimates[i] * np.nanmax(ratios[:i]) > tolerance
    report = yaml.safe_load((tmp_path / "results" / "part" / "report.yaml").read_text())["sampling"]
    assert report["n_points"] == N_TIMES * len(table["order"])
    assert report["greedy"]["indicator"] == "audit"
    assert f"sampled {report['n_points']} points ({report['n_points']} were there)" in signorom(
        "sample", deck, folder=tmp_path
    )


TEST = "test: {sobol: 3, seed: 1}\n"


@pytest.fixture(scope="module")
def validated(signorom, tmp_path_factory):
    """Folder of a run with a rough model, so that its errors are no rounding, and what it printed."""
    folder = tmp_path_factory.mktemp("validated")
    deck = study(
        folder, "training: {sobol: 4}", "reduction: {inelastic_tolerance: 0.5, fields: true}\n" + TEST
    )
    return folder, signorom("run", deck, folder=folder)


def test_validation_of_histories(signorom, validated, tmp_path):
    """Errors over histories, from the answers of predict and the full order of the same points."""
    folder, output = validated
    table = read_table(folder / "results" / "part" / "validation.csv")
    write_points(tmp_path / "points.csv", np.array([table[name] for name in NAMES]).T[::N_TIMES])
    signorom("sample", study(tmp_path, "training: {file: points.csv}"), folder=tmp_path)
    exact = read_snapshots(tmp_path / "results" / "part" / "snapshots.h5")["multipliers"].reshape(
        3, N_TIMES, -1
    )
    model = folder / "results" / "part" / "model.h5"
    signorom("predict", model, "--points", "points.csv", "--output", "answers.csv", folder=tmp_path)
    answers = read_table(tmp_path / "answers.csv")
    found = forces(answers)
    report = yaml.safe_load((folder / "results" / "part" / "report.yaml").read_text())
    histories = report["histories"]
    errors = over_history(found - exact, exact)
    assert errors.max() > 1e-4
    moved = answers["error_estimate"].reshape(3, N_TIMES) * np.linalg.norm(found, axis=2)
    estimates = moved.max(axis=1) / np.linalg.norm(found, axis=2).max(axis=1)
    for name, values in {"forces": errors, "error_estimate": estimates}.items():
        assert [histories[name][key] for key in ("min", "median", "max")] == pytest.approx(
            [values.min(), np.median(values), values.max()], rel=1e-4, abs=1e-9
        ), name
    assert histories["n_histories"] == 3
    assert f"forces {report['validation']['forces']}" in output
    assert f"strains {report['validation']['strains']}" in output
    assert (
        "error_estimate stands for the error before the correction of the forces, and is an estimate, not a bound"
        in output
    )


def test_columns_of_the_validation(validated):
    """|raw - exact| is |raw - answer| up to |answer - exact|; strains are relative to the largest of the history."""
    table = read_table(validated[0] / "results" / "part" / "validation.csv")
    moved, error, raw = (table[name] for name in ("error_estimate", "e_lambda_all", "e_lambda_raw"))
    size = 1 + error
    is_pressed = error >= 0
    assert np.count_nonzero(is_pressed) >= 6
    assert np.all((raw <= moved * size + error + 1e-9)[is_pressed])
    assert np.all((raw >= moved * (1 - error) - error - 1e-9)[is_pressed])
    assert np.any(raw[is_pressed] > error[is_pressed])
    for name in ("e_plastic_strain", "e_creep_strain"):
        assert np.all((table[name] >= 0) & (table[name] < 1))
    assert table["e_creep_strain"].max() > 0


def test_elastic_beginning(signorom, tmp_path):
    """The first history yields nowhere: its model has no modes, and a candidate that yields is found."""
    points = [(0.0, 200.0), (1e-6, 250.0), (2e-6, 150.0), (1.5e-3, 160.0), (1e-3, 240.0)]
    deck = study(tmp_path, "training: {greedy: {candidates: {file: pool.csv}, initial: 1, max_points: 2}}")
    # the middle of the box, where the choice begins, is at a stroke of about zero
    for old, new in {
        "    creep: {norton: {coefficient: 1e-12, exponent: 4}}\n": "",
        "stroke: {min: 0, max: 0.002}": "stroke: {min: -0.002, max: 0.002}",
    }.items():
        assert old in deck.read_text()
        deck.write_text(deck.read_text().replace(old, new))
    write_points(tmp_path / "pool.csv", points)
    signorom("sample", deck, folder=tmp_path)
    found = points_of(tmp_path)
    assert found[0][0] < 1e-5
    assert found[1][0] >= 1e-3
