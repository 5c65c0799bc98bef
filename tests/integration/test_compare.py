# SPDX-License-Identifier: BSD-3-Clause
"""`signorom-post compare --run` with the program and the library: the models of case a in one table."""

import csv

import pytest
from signorom_post.cli import main

from program import ENVIRONMENT, ROOT

# [-] rounding of a condensed model's forces
EXACT = 1e-12


@pytest.fixture(scope="module")
def rows(signorom, library, tmp_path_factory):
    """Lines of the table by name."""
    folder = tmp_path_factory.mktemp("compare")
    with pytest.MonkeyPatch.context() as patch:
        for name, value in (ENVIRONMENT | {"SIGNOROM_LIBRARY": str(library)}).items():
            patch.setenv(name, value)
        patch.setenv("SIGNOROM_EXECUTABLE", str(signorom.executable))
        patch.chdir(folder)
        variants = ROOT / "input" / "compare" / "half_disks.yaml"
        assert main(["compare", "--run", str(variants), "--points", "50", "--csv", "table.csv"]) == 0
    with (folder / "table.csv").open(newline="") as file:
        return {row["name"]: row for row in csv.DictReader(file)}


def test_every_model_has_times_and_errors(rows):
    assert list(rows) == [
        "full order, factored anew",
        "full order",
        "paper",
        "lifting",
        "clusters",
        "condensed",
    ]
    for name, row in rows.items():
        assert float(row["query"]) > 0, name
        if "full" not in name:
            assert float(row["offline"]) > 0, name
            assert 0 < float(row["median"]) <= float(row["p95"]) <= float(row["largest"]), name
            assert row["n_unanswered"] == "0", name


def test_condensed_model_is_exact_and_reduced_ones_are_near(rows):
    assert float(rows["condensed"]["largest"]) <= EXACT
    for name in ("paper", "lifting", "clusters"):
        assert EXACT < float(rows[name]["p95"]) < 0.02, name


def test_factoring_anew_is_the_slowest(rows):
    times = {name: float(row["query"]) for name, row in rows.items()}
    slowest = times.pop("full order, factored anew")
    assert all(time < slowest for time in times.values())
