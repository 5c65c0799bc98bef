# SPDX-License-Identifier: BSD-3-Clause
"""Local models: clusters of grid cells against all pairs of medoids, of scattered points with a forest, answers."""

import itertools
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

from results import read_snapshots, read_table, table_of
from runs import refuse, run_shifted_disks, write_deck
from seals import seal

pytestmark = pytest.mark.slow

GRID = (7, 3)
BOX = np.array([[0.15, 0.45], [-0.05, 0.1]])
CELL_POD_TOLERANCE = 1e-6
REGULAR = {"reduction: {": "clusters: {number: 2}\nreduction: {"}
IRREGULAR = {
    "grid: {squeeze: 7, shift: 3}": "sobol: 24, seed: 5",
    "reduction: {": "clusters: {number: 3, method: irregular, seed: 2}\nreduction: {",
}


@pytest.fixture(scope="module")
def regular(signorom, tmp_path_factory):
    """Results with clusters of grid cells."""
    return run_shifted_disks(signorom, tmp_path_factory.mktemp("regular"), **REGULAR)


@pytest.fixture(scope="module")
def irregular(signorom, tmp_path_factory):
    """Results with clusters of scattered points; the program finds signorom-post of the Python that runs the tests."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PATH", f"{Path(sys.executable).parent}:{os.environ['PATH']}")
        return run_shifted_disks(signorom, tmp_path_factory.mktemp("irregular"), **IRREGULAR)


def corners_of_cells():
    """Point numbers at the corners of each cell, from 0; the first parameter is the slowest."""
    n = GRID[1]
    return [
        [i * n + j, i * n + j + 1, (i + 1) * n + j, (i + 1) * n + j + 1]
        for i in range(GRID[0] - 1)
        for j in range(n - 1)
    ]


def basis_of(columns):
    """POD basis by the energy tail."""
    vectors, values, _ = np.linalg.svd(columns, full_matrices=False)
    tails = np.append(np.cumsum((values**2)[::-1])[::-1], 0) / (values**2).sum()
    return vectors[:, : int(np.flatnonzero(tails < CELL_POD_TOLERANCE)[0])]


def distance(a, b):
    """(14), in full space; small angles by their sines."""
    if a.shape[1] < b.shape[1]:
        a, b = b, a
    cosines = np.linalg.svd(a.T @ b, compute_uv=False)
    sines = np.linalg.svd(b - a @ (a.T @ b), compute_uv=False)[::-1]
    angles = np.where(cosines > 0.7, np.arcsin(np.minimum(sines, 1)), np.arccos(np.minimum(cosines, 1)))
    return np.sqrt(np.pi**2 / 4 * (a.shape[1] - b.shape[1]) + (angles**2).sum())


def test_cells_have_the_best_medoids(regular):
    """The labels have the smallest loss of all pairs of medoids."""
    snapshots = read_snapshots(regular / "snapshots.h5")["displacement"].T
    bases = [basis_of(snapshots[:, corners]) for corners in corners_of_cells()]
    dissimilarity = np.array([[distance(a, b) for b in bases] for a in bases])
    pairs = list(itertools.combinations(range(len(bases)), 2))
    best = min(pairs, key=lambda pair: dissimilarity[:, pair].min(axis=1).sum())
    with h5py.File(regular / "model.h5") as model:
        labels = model["choice/cells/clusters"][()]
    np.testing.assert_array_equal(labels, 1 + dissimilarity[:, best].argmin(axis=1))


def test_clusters_share_the_points_on_their_border(regular):
    """A cluster has the corners of its cells, and the report says how many."""
    with h5py.File(regular / "model.h5") as model:
        labels = model["choice/cells/clusters"][()]
        points = [model[f"clusters/{k}/training_points"][()] for k in (1, 2)]
        modes = [model[f"clusters/{k}"].attrs["n_pod_modes"] for k in (1, 2)]
    for k in (1, 2):
        corners = {
            1 + point
            for cell, label in zip(corners_of_cells(), labels, strict=True)
            for point in cell
            if label == k
        }
        assert sorted(corners) == points[k - 1].tolist()
    assert sum(map(len, points)) > GRID[0] * GRID[1]
    report = yaml.safe_load((regular / "report.yaml").read_text())["reduction"]
    assert report["n_clusters"] == 2
    assert [report["clusters"][k]["n_snapshots"] for k in ("1", "2")] == [len(numbers) for numbers in points]
    assert [report["clusters"][k]["n_modes"] for k in ("1", "2")] == modes


def test_cluster_of_the_cell_answers(signorom, regular, tmp_path):
    """validate and predict ask the cluster of the cell; both give the same errors or answers."""
    with h5py.File(regular / "model.h5") as model:
        labels = model["choice/cells/clusters"][()].reshape(GRID[0] - 1, GRID[1] - 1)
    table = read_table(regular / "validation.csv")
    points = np.array([table["squeeze"], table["shift"]]).T
    parts = (points - BOX[:, 0]) / (BOX[:, 1] - BOX[:, 0]) * (np.array(GRID) - 1)
    # on a border the lower cell
    cells = np.clip(np.ceil(parts - 1e-8).astype(int) - 1, 0, np.array(GRID) - 2)
    np.testing.assert_array_equal(table["cluster"], labels[cells[:, 0], cells[:, 1]])
    assert set(table["cluster"]) == {1, 2}
    assert np.median(table["e_u"]) < 1e-2
    shutil.copy(regular / "model.h5", tmp_path)
    (tmp_path / "points.csv").write_text("squeeze,shift\n0.2,0.03\n0.44,0.09\n")
    answers = table_of(
        signorom("predict", "model.h5", "--points", "points.csv", folder=tmp_path).split("\n\n")[-1]
    )
    assert answers["cluster"].tolist() == [labels[1, 1], labels[5, 1]]
    # of two clusters the next is the other one
    assert (answers["cluster"] + answers["next_cluster"]).tolist() == [3, 3]


def clusters_of(model):
    """All datasets and attributes below `clusters`, each by its path."""
    found = {}

    def keep(name, item):
        found.update({f"{name}@{key}": value for key, value in item.attrs.items()})
        if isinstance(item, h5py.Dataset):
            found[name] = item[()]

    with h5py.File(model) as file:
        file["clusters"].visititems(keep)
    return found


@pytest.fixture(scope="module")
def three_clusters(signorom, regular, tmp_path_factory):
    """Folder with a deck of three clusters, its results on one rank, and the clusters of its model."""
    folder = tmp_path_factory.mktemp("three_clusters")
    shutil.copytree(regular, folder / "results" / "shifted_disks")
    deck = write_deck("shifted_disks", folder, **{"reduction: {": "clusters: {number: 3}\nreduction: {"})
    signorom("train", deck.name, folder=folder)
    return folder, clusters_of(folder / "results/shifted_disks/model.h5")


@pytest.mark.parametrize("n_ranks", [2, 3, 4])
def test_groups_of_ranks_train_the_same_clusters(signorom, three_clusters, tmp_path, n_ranks):
    """Three clusters by two, three and four ranks, in groups: what one rank trains one after the other."""
    folder, expected = three_clusters
    shutil.copytree(folder, tmp_path, dirs_exist_ok=True)
    signorom("train", "shifted_disks.yaml", folder=tmp_path, n_ranks=n_ranks)
    found = clusters_of(tmp_path / "results/shifted_disks/model.h5")
    assert found.keys() == expected.keys()
    stiffness = {k: np.abs(expected[f"{k}/reduced_stiffness"]).max() for k in "123"}
    for name, values in expected.items():
        if np.asarray(values).dtype.kind != "f":
            np.testing.assert_array_equal(found[name], values, err_msg=name)
        elif not name.endswith(("singular_values", "stiffness_conditions", "@stiffness_condition")):
            # an elastic lifting is in equilibrium: its load is the rounding of a product with the stiffness
            # what a body that supports hold has none of is empty
            size = stiffness[name[0]] if name.endswith("load") else np.abs(values).max(initial=0)
            np.testing.assert_allclose(found[name], values, rtol=0, atol=1e-10 * size, err_msg=name)


@pytest.mark.parametrize("n_ranks", [1, 2, 3])
def test_cluster_that_cannot_be_trained_is_named(signorom, three_clusters, tmp_path, n_ranks):
    """More modes than its snapshots have: the first such cluster, whichever rank had it; no rank waits for ever."""
    folder, _ = three_clusters
    shutil.copytree(folder, tmp_path, dirs_exist_ok=True)
    deck = tmp_path / "shifted_disks.yaml"
    with h5py.File(tmp_path / "results/shifted_disks/model.h5") as model:
        sizes = [len(model[f"clusters/{k}/training_points"]) for k in "123"]
    deck.write_text(deck.read_text().replace("pod_tolerance: 1.0e-5", f"n_modes: {min(sizes) + 1}"))
    message = refuse(signorom, "train", deck.name, folder=tmp_path, n_ranks=n_ranks)
    assert f"cluster {1 + np.argmin(sizes)}: the keys of reduction ask for" in message


def test_forest_chooses_among_scattered_points(irregular):
    """Every point has one cluster, labels.csv says which, and validate asks the one that scikit-learn predicts."""
    names, points, labels = read_labels(irregular / "labels.csv")
    assert names == ["squeeze", "shift"]
    assert set(labels) == {1, 2, 3}
    np.testing.assert_allclose(points, read_snapshots(irregular / "snapshots.h5")["parameters"], rtol=1e-15)
    with h5py.File(irregular / "model.h5") as model:
        for k in (1, 2, 3):
            found = model[f"clusters/{k}/training_points"][()]
            np.testing.assert_array_equal(found, 1 + np.flatnonzero(labels == k))
    table = read_table(irregular / "validation.csv")
    classifier = fit(features_of(points, points), labels, 100, 2)
    tested = np.array([table["squeeze"], table["shift"]]).T
    np.testing.assert_array_equal(table["cluster"], classifier.predict(features_of(tested, points)))
    assert len(set(table["cluster"])) > 1


def test_number_of_clusters_by_silhouette(signorom, regular, tmp_path):
    """`auto` has the largest mean silhouette of all numbers, and the report says how large."""
    silhouettes = {}
    shutil.copytree(regular, tmp_path / "results" / "shifted_disks")
    for number in (2, 3, 4, "auto"):
        changes = {"reduction: {": f"clusters: {{number: {number}, max_number: 4}}\nreduction: {{"}
        deck = write_deck("shifted_disks", tmp_path, **changes)
        signorom("train", deck.name, folder=tmp_path)
        report = yaml.safe_load((tmp_path / "results" / "shifted_disks" / "report.yaml").read_text())[
            "reduction"
        ]
        silhouettes[number] = (report["clustering"]["silhouette"], report["n_clusters"])
    best = max((2, 3, 4), key=lambda number: silhouettes[number][0])
    assert silhouettes["auto"] == (silhouettes[best][0], best)


@pytest.mark.parametrize("clusters", ["{number: auto, max_number: 2}", "{number: 2}"])
def test_clusters_are_not_left_out_by_default(signorom, regular, tmp_path, clusters):
    """With all defaults of `reduction` a deck with clusters gets them, also where a condensed model would fit."""
    shutil.copytree(regular, tmp_path / "results" / "shifted_disks")
    changes = {"reduction: {method: hhr, pod_tolerance: 1.0e-5}": f"clusters: {clusters}"}
    deck = write_deck("shifted_disks", tmp_path, **changes)
    assert "the deck asks for clusters" in signorom("train", deck.name, folder=tmp_path)


def test_snapshot_without_load_is_named(signorom, tmp_path):
    """A point where nothing moves has no direction."""
    changes = REGULAR | {
        "min: 0.15, max: 0.45": "min: 0.0, max: 0.45",
        "min: -0.05, max: 0.1": "min: 0.0, max: 0.1",
    }
    deck = write_deck("shifted_disks", tmp_path, **changes)
    signorom("sample", deck.name, folder=tmp_path)
    assert "error: snapshot 1 (squeeze = 0.0, shift = 0.0) is zero" in refuse(
        signorom, "train", deck.name, folder=tmp_path
    )


def with_tool(monkeypatch):
    """The program finds signorom-post of the Python that runs the tests."""
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}:{os.environ['PATH']}")


def scattered(**clusters):
    """Changes of the deck for twelve points and clusters of them."""
    words = "".join(f", {key}: {value}" for key, value in clusters.items())
    return {
        "grid: {squeeze: 7, shift: 3}": "sobol: 12",
        "reduction: {": f"clusters: {{method: irregular{words}}}\nreduction: {{",
    }


def test_small_clusters_are_refused_or_merged(signorom, tmp_path, monkeypatch):
    """Eight clusters of twelve points leave some point alone; merged, every cluster has two points at least."""
    with_tool(monkeypatch)
    deck = write_deck("shifted_disks", tmp_path, **scattered(number=8))
    signorom("sample", deck.name, folder=tmp_path)
    assert re.search(
        r"error: cluster \d of 8 has 1 snapshot; its basis needs at least 2 \(clusters.min_snapshots\)\n"
        "hint: .* small_clusters: merge",
        refuse(signorom, "train", deck.name, folder=tmp_path),
    )
    deck = write_deck("shifted_disks", tmp_path, **scattered(number=8, small_clusters="merge"))
    log = signorom("train", deck.name, folder=tmp_path)
    merged = re.findall(
        r"cluster \d of (\d) has 1 snapshot, fewer than 2: merged into cluster \d .* nearest", log
    )
    n_clusters = 8 - len(merged)
    assert merged == [str(number) for number in range(8, n_clusters, -1)]
    _, _, labels = read_labels(tmp_path / "results/shifted_disks/labels.csv")
    assert np.bincount(labels)[1:].min() >= 2
    assert len(set(labels)) == n_clusters == labels.max() < 8


def test_opposite_snapshots_differ_if_asked(signorom, tmp_path, monkeypatch):
    """(16) as printed, against all pairs of medoids; snapshots pushed to both sides are then not the same line."""
    with_tool(monkeypatch)
    sides = {
        "{x: 0, y: -squeeze - shift^2}": "{x: shift, y: -squeeze}",
        "min: -0.05, max: 0.1": "min: -4, max: 4",
        "min: 0.15, max: 0.45": "min: 0.1, max: 0.12",
        "squeeze: 0.2, shift": "squeeze: 0.11, shift",
    }
    deck = write_deck(
        "shifted_disks", tmp_path, **scattered(number=2, opposite_snapshots="different"), **sides
    )
    signorom("sample", deck.name, folder=tmp_path)
    signorom("train", deck.name, folder=tmp_path)
    snapshots = read_snapshots(tmp_path / "results/shifted_disks/snapshots.h5")["displacement"]
    directions = snapshots / np.linalg.norm(snapshots, axis=1)[:, None]
    cosines = np.clip(directions @ directions.T, -1, 1)
    best = {}
    for is_signed, angles in ((True, np.arccos(cosines)), (False, np.arccos(np.abs(cosines)))):
        pair = min(
            itertools.combinations(range(12), 2),
            key=lambda pair, angles=angles: angles[:, pair].min(axis=1).sum(),
        )
        best[is_signed] = 1 + angles[:, pair].argmin(axis=1)
    _, _, labels = read_labels(tmp_path / "results/shifted_disks/labels.csv")
    np.testing.assert_array_equal(labels, best[True])
    assert (best[True] != best[False]).any()


def test_more_clusters_than_listed_points(signorom, tmp_path):
    """How many points a file has is known when it is read."""
    (tmp_path / "points.csv").write_text("squeeze,shift\n0.2,0.0\n0.3,0.05\n0.4,0.1\n")
    changes = scattered(number=5) | {"grid: {squeeze: 7, shift: 3}": "file: points.csv"}
    deck = write_deck("shifted_disks", tmp_path, **changes)
    signorom("sample", deck.name, folder=tmp_path)
    said = refuse(signorom, "train", deck.name, folder=tmp_path, n_ranks=2)
    assert "shifted_disks.yaml: error: there are 3 items to cluster (" in said
    assert "5 clusters cannot be made" in said


@pytest.mark.parametrize("changes", [REGULAR, {}], ids=["clusters", "one_model"])
def test_snapshot_that_is_no_number_is_named(signorom, regular, tmp_path, changes):
    """NaN in the snapshots: neither training nor more sampling goes on from it."""
    results = tmp_path / "results" / "shifted_disks"
    shutil.copytree(regular, results)
    with h5py.File(results / "snapshots.h5", "r+") as file:
        file["displacement"][5, 7] = np.nan
        squeeze, shift = file["parameters"][5]
    seal(results / "snapshots.h5")
    deck = write_deck("shifted_disks", tmp_path, **changes)
    for command, n_ranks in (("train", 1), ("train", 3), ("sample", 1)):
        message = refuse(signorom, command, deck.name, folder=tmp_path, n_ranks=n_ranks)
        assert f"snapshots.h5: error: the snapshots are damaged: that of squeeze = {squeeze:.10g}" in message
        assert f"shift = {shift:.10g} contains infinite values or values that are not numbers" in message


def test_equal_snapshots_are_named(signorom, regular, tmp_path):
    """Two points with the same snapshot: a warning, and clusters all the same."""
    results = tmp_path / "results" / "shifted_disks"
    shutil.copytree(regular, results)
    with h5py.File(results / "snapshots.h5", "r+") as file:
        file["displacement"][5] = file["displacement"][4]
    seal(results / "snapshots.h5")
    deck = write_deck("shifted_disks", tmp_path, **REGULAR)
    done = signorom.run("train", deck.name, folder=tmp_path)
    assert done.returncode == 0
    assert re.search(
        r"warning: the snapshots at squeeze = 0.2 m, shift = 0.025 m and at squeeze = 0.2 m, shift = 0.1 m are equal",
        done.stderr,
    )
