# SPDX-License-Identifier: BSD-3-Clause
"""The command forest; that the program's walk agrees with scikit-learn is in tests/integration/test_forest.py."""

import sys
import tomllib
from pathlib import Path

import h5py
import numpy as np
import pytest

from signorom_post.cli import main
from signorom_post.forest import REQUIREMENT, fit, flat_arrays, read_labels


@pytest.fixture
def labels(tmp_path: Path) -> Path:
    """Three clusters of scattered points, separated by lines; the label column in the middle."""
    points = np.random.default_rng(4).uniform(size=(300, 2))
    clusters = 1 + (points[:, 0] > 0.5) + (points.sum(axis=1) > 1.3)
    path = tmp_path / "labels.csv"
    lines = [f"{x!r}, {cluster}, {y!r}" for (x, y), cluster in zip(points.tolist(), clusters, strict=True)]
    path.write_text("load, cluster, height\n# a comment\n" + "\n".join(lines) + "\n")
    return path


def test_trees_are_written_and_repeated_by_the_seed(labels: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["forest", str(labels), "--trees", "20", "--seed", "3"]) == 0
    printed = capsys.readouterr().out
    assert "out-of-bag accuracy: 9" in printed
    assert main(["forest", str(labels), "--trees", "20", "--seed", "3", "--output", str(labels) + ".h5"]) == 0
    with h5py.File(labels.with_name("forest.h5")) as first, h5py.File(str(labels) + ".h5") as second:
        assert [name.decode() for name in first["parameter_names"]] == ["load", "height"]
        assert len(first["tree_starts"]) == 21
        assert first["shares"].shape == (first["tree_starts"][-1], 3)
        np.testing.assert_allclose(first["shares"][()].sum(axis=1), 1, rtol=1e-12)
        for name in first:
            assert (first[name][()] == second[name][()]).all(), name


@pytest.mark.parametrize("unit", [1e-18, 1e18])
def test_trees_are_the_same_in_other_units(labels: Path, unit: float) -> None:
    """scikit-learn alone would find no clusters in loads from 0 to 1e-18."""
    assert main(["forest", str(labels), "--trees", "5"]) == 0
    header, *lines = labels.read_text().splitlines()
    rows = [line.split(",") for line in lines if not line.startswith("#")]
    other = labels.with_name("other.csv")
    scaled = [f"{float(load) * unit!r}, {', '.join(others)}" for load, *others in rows]
    other.write_text("\n".join([header, *scaled]))
    assert main(["forest", str(other), "--trees", "5", "--output", str(other) + ".h5"]) == 0
    with h5py.File(labels.with_name("forest.h5")) as first, h5py.File(str(other) + ".h5") as second:
        np.testing.assert_allclose(second["highest"][()], first["highest"][()] * [unit, 1])
        for name in ("tree_starts", "feature", "left", "right", "shares"):
            assert (first[name][()] == second[name][()]).all(), name


def test_absent_cluster_keeps_its_column(labels: Path) -> None:
    _, points, clusters = read_labels(labels)
    arrays = flat_arrays(fit(points, np.where(clusters == 2, 4, clusters), 5, 1), 4)
    assert arrays["shares"].shape[1] == 4
    assert (arrays["shares"][:, 1] == 0).all()
    assert (arrays["shares"][:, 3] > 0).any()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "the first line must name the parameters and one column 'cluster'"),
        ("load,height\n1,2\n", "the first line must name the parameters and one column 'cluster'"),
        ("load,cluster\n", "the table has no points"),
        ("load,cluster\n1,x\n", "the table is not made of numbers"),
        ("load,cluster\n1,2\n3\n", "the table is not made of numbers in lines of equal length"),
        ("load,cluster\n1,2,3\n", "each line needs 2 finite numbers"),
        ("load,cluster\nnan,1\n", "each line needs 2 finite numbers"),
        ("load,cluster\n1,0\n", "the values of 'cluster' must be whole numbers from 1"),
        ("load,cluster\n1,1.5\n", "the values of 'cluster' must be whole numbers from 1"),
    ],
)
def test_bad_tables_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str, message: str
) -> None:
    path = tmp_path / "bad.csv"
    path.write_text(text)
    assert main(["forest", str(path)]) == 2
    assert f"{path}: error: {message}" in capsys.readouterr().err
    assert not (tmp_path / "forest.h5").exists()


def test_missing_table_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["forest", str(tmp_path / "none.csv")]) == 2
    assert "there is no such file" in capsys.readouterr().err


def test_missing_scikit_learn_is_named(
    labels: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert main(["forest", "--check"]) == 0
    monkeypatch.setitem(sys.modules, "sklearn", None)
    for arguments in ([str(labels)], ["--check"]):
        assert main(["forest", *arguments]) == 2
        expected = f"scikit-learn is not installed; hint: {sys.executable} -m pip install 'scikit-learn>=1.3'"
        assert expected in capsys.readouterr().err


def test_broken_scikit_learn_is_named(
    labels: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """An installation that is there, but cannot be imported."""
    monkeypatch.setitem(sys.modules, "sklearn.ensemble", None)
    assert main(["forest", str(labels)]) == 2
    assert "scikit-learn cannot be imported (" in capsys.readouterr().err


def test_requirement_is_that_of_the_package() -> None:
    project = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text())
    assert project["project"]["optional-dependencies"]["forest"] == [REQUIREMENT]


def test_no_table_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["forest"]) == 2
    assert "give the table LABELS.csv, or --check" in capsys.readouterr().err
