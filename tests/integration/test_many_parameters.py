# SPDX-License-Identifier: BSD-3-Clause
"""One, three and four parameters, scattered snapshots, local models: every command that a user gives."""

import csv
import os
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
import yaml
from signorom_post.cli import main
from signorom_post.forest import features_of, fit, read_labels

from c_programs import compile_c, run_c
from results import read_snapshots, read_table, table_of
from runs import HERE

pytestmark = pytest.mark.slow

#: name -> range, and what it is where a deck does not have it
PARAMETERS = {
    "squeeze": ((0.15, 0.45), 0.3),
    "shift": ((-0.05, 0.1), 0.0),
    "lift": ((0.0, 0.05), 0.0),
    "slide": ((-0.05, 0.05), 0.0),
}
N_CLUSTERS = 3


def deck_of(n_parameters, **sections):
    """decks/shifted_disks.yaml with the first of the parameters, each of which moves a base on its own."""
    deck = yaml.safe_load((HERE / "decks" / "shifted_disks.yaml").read_text())
    names = list(PARAMETERS)[:n_parameters]
    value = {name: name if name in names else PARAMETERS[name][1] for name in PARAMETERS}
    deck["mesh"]["file"] = str(HERE / "meshes" / "small_disks.msh")
    deck["parameters"] = {name: dict(zip(("min", "max"), PARAMETERS[name][0], strict=True)) for name in names}
    deck["boundary_conditions"][0]["displacement"] = {"x": value["shift"], "y": value["squeeze"]}
    upper = f"-{value['squeeze']} + {value['lift']}"
    deck["boundary_conditions"][1]["displacement"] = {"x": value["slide"], "y": upper}
    deck["output"] = {"points": [{name: sum(PARAMETERS[name][0]) / 2 for name in names}]}
    return deck | sections


def start(signorom, folder, n_parameters, **sections):
    """Results folder of `run` on such a deck."""
    (folder / "disks.yaml").write_text(yaml.safe_dump(deck_of(n_parameters, **sections), sort_keys=False))
    signorom("run", "disks.yaml", folder=folder)
    return folder / "results" / "disks"


@pytest.fixture(scope="module", params=[1, pytest.param(3, marks=pytest.mark.long), 4])
def study(request, signorom, tmp_path_factory):
    """Number of parameters, and results of scattered snapshots in three clusters."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PATH", f"{Path(sys.executable).parent}:{os.environ['PATH']}")
        sections = {
            "training": {"sobol": 48},
            "test": {"sobol": 30, "seed": 1},
            "clusters": {"number": N_CLUSTERS, "method": "irregular"},
        }
        folder = tmp_path_factory.mktemp(f"parameters_{request.param}")
        return request.param, start(signorom, folder, request.param, **sections)


def points_of(table, n_parameters):
    """Points of a table, shape (n_points, n_parameters)."""
    return np.column_stack([table[name] for name in list(PARAMETERS)[:n_parameters]])


def write_points(path, points, names):
    """A list of points with the parameters in the order of names."""
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerows([names, *([repr(float(x)) for x in point] for point in points)])


def test_forest_of_any_number_of_parameters_chooses(study):
    """Labels of all snapshots in their box, and the cluster that scikit-learn predicts at each test point."""
    n, results = study
    names, points, labels = read_labels(results / "labels.csv")
    assert names == list(PARAMETERS)[:n]
    np.testing.assert_allclose(points, read_snapshots(results / "snapshots.h5")["parameters"], rtol=1e-15)
    assert set(labels) == set(range(1, N_CLUSTERS + 1))
    table = read_table(results / "validation.csv")
    classifier = fit(features_of(points, points), labels, 100, 1)
    np.testing.assert_array_equal(
        table["cluster"], classifier.predict(features_of(points_of(table, n), points))
    )
    # a pressed disk is smooth in the strokes of the bases
    assert np.median(table["e_u"]) < 1e-2


def test_answers_of_the_program_of_python_and_of_c_agree(signorom, library, post, study, tmp_path):
    """Cluster, next cluster and forces; columns of the points in any order; a wrong number of values is refused."""
    n, results = study
    validation = read_table(results / "validation.csv")
    names, points = list(PARAMETERS)[:n], points_of(validation, n)
    write_points(tmp_path / "points.csv", points[:, ::-1], names[::-1])
    signorom(
        "predict", results / "model.h5", "--points", "points.csv", "--output", "answers.csv", folder=tmp_path
    )
    answers = read_table(tmp_path / "answers.csv")
    np.testing.assert_array_equal(points_of(answers, n), points)
    np.testing.assert_array_equal(answers["cluster"], validation["cluster"])
    assert (answers["next_cluster"] != answers["cluster"]).all()
    votes = votes_of(results, points)
    np.testing.assert_array_equal(answers["next_cluster"], 1 + np.argsort(-votes, kind="stable")[:, 1])
    with h5py.File(results / "model.h5") as file, post.Model(results / "model.h5") as model:
        assert [parameter.name for parameter in model.parameters] == names
        for i, point in enumerate(points[:5]):
            answer = model.query(**dict(zip(names, point, strict=True)))
            assert answer.cluster == answers["cluster"][i] - 1
            assert answer.next_cluster == answers["next_cluster"][i] - 1
            assert answer.contact_force == pytest.approx(answers["contact_force"][i], rel=1e-13)
            rows = file[f"clusters/{answer.cluster + 1}/contact_rows"][()] - 1
            np.testing.assert_array_equal(answer.domain_contacts, rows)
            np.testing.assert_array_equal(answer.domain_multipliers, answer.multipliers[rows])
    point = ",".join(f"{name}={value}" for name, value in zip(names, points[0], strict=True))
    alone = table_of(signorom("predict", results / "model.h5", "--at", point, folder=tmp_path))
    assert alone["contact_force"][0] == answers["contact_force"][0]
    done = run_c(compile_c("ask_model", library, tmp_path), results / "model.h5", *points[0])
    clusters = [int(answers[name][0]) for name in ("cluster", "next_cluster")]
    assert "cluster {} of 3, next to it {}\n".format(*clusters) in done.stdout
    done = signorom.run("predict", results / "model.h5", "--at", f"{point},speed=1", folder=tmp_path)
    assert done.returncode == 2
    assert "speed" in done.stderr


def votes_of(results, points):
    """Shares of the trees for each cluster, shape (n_points, n_clusters)."""
    _, training, labels = read_labels(results / "labels.csv")
    forest = fit(features_of(training, training), labels, 100, 1)
    return forest.predict_proba(features_of(points, training))


def test_description_names_all_parameters(signorom, study):
    n, results = study
    text = signorom("describe", "model.h5", folder=results)
    for name in list(PARAMETERS)[:n]:
        low, high = PARAMETERS[name][0]
        assert f"  {name:<22}{low} to {high}" in text
    assert "clusters                3; a random forest chooses" in text
    _, _, labels = read_labels(results / "labels.csv")
    assert f"  training points       {np.sum(labels == 2)}\n" in text


def test_figures_of_any_number_of_parameters(study, tmp_path, capsys):
    n, results = study
    names = ["clusters", "errors", "multipliers"]
    assert main(["figures", str(results), "--output", str(tmp_path), "--only", *names]) == 0, n
    assert sorted(path.stem for path in tmp_path.iterdir()) == names
    assert main(["summary", str(results)]) == 0
    assert f"Errors at {30} points" in capsys.readouterr().out


def test_points_of_the_fields_know_their_domain(study):
    """The pairs of the reduced domain are those of the cluster that answers there."""
    n, results = study
    middle = dict(zip(PARAMETERS, (sum(box) / 2 for box, _ in PARAMETERS.values()), strict=True))
    votes = votes_of(results, np.array([list(middle.values())[:n]]))
    with h5py.File(results / "model.h5") as model, h5py.File(results / "fields.h5") as fields:
        rows = model[f"clusters/{1 + votes[0].argmax()}/contact_rows"][()]
        found = fields["points/0001/rows_in_reduced_domain"][()]
    np.testing.assert_array_equal(1 + np.flatnonzero(found), rows)


def test_cells_of_three_parameters(signorom, tmp_path):
    """Eight corners each; on a border of cells the lower one answers, as along one parameter."""
    counts = (4, 3, 2)
    results = start(
        signorom,
        tmp_path,
        3,
        training={"grid": dict(zip(PARAMETERS, counts, strict=False))},
        test={"grid": dict(zip(PARAMETERS, (5, 4, 3), strict=False))},
        clusters={"number": 2},
    )
    shape = np.array(counts) - 1
    with h5py.File(results / "model.h5") as model:
        labels = model["choice/cells/clusters"][()].reshape(shape)
        members = [model[f"clusters/{k}/training_points"][()] - 1 for k in (1, 2)]
    numbers = np.arange(np.prod(counts)).reshape(counts)
    for k in (1, 2):
        corners = {
            int(number)
            for i, j, m in zip(*np.nonzero(labels == k), strict=True)
            for number in numbers[i : i + 2, j : j + 2, m : m + 2].ravel()
        }
        assert sorted(corners) == members[k - 1].tolist()
    table = read_table(results / "validation.csv")
    box = np.array([PARAMETERS[name][0] for name in list(PARAMETERS)[:3]])
    parts = (points_of(table, 3) - box[:, 0]) / (box[:, 1] - box[:, 0]) * shape
    cells = np.clip(np.ceil(parts - 1e-8).astype(int) - 1, 0, shape - 1)
    np.testing.assert_array_equal(table["cluster"], labels[tuple(cells.T)])
    assert set(table["cluster"]) == {1, 2}


def test_quiet_run_says_nothing(signorom, tmp_path, monkeypatch):
    """Not even the tool that trains the forest."""
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}:{os.environ['PATH']}")
    sections = {"training": {"sobol": 8}, "test": {"sobol": 2}}
    deck = deck_of(1, clusters={"number": 2, "method": "irregular"}, **sections)
    (tmp_path / "disks.yaml").write_text(yaml.safe_dump(deck))
    signorom("sample", "disks.yaml", folder=tmp_path)
    assert signorom("train", "disks.yaml", "--quiet", folder=tmp_path) == ""


def test_blank_between_parameters_is_explained(signorom, tmp_path):
    """The shell makes two words of it."""
    done = subprocess.run(
        [signorom.executable, "predict", "model.h5", "--at", "squeeze=0.2", "shift=0.1"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert "unexpected argument 'shift=0.1'" in done.stderr
    assert "hint: write --at squeeze=0.2,shift=0.1" in done.stderr
