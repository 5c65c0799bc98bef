# SPDX-License-Identifier: BSD-3-Clause
"""`signorom-post paper` with a program that writes results by formulas."""

import csv
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import h5py
import numpy as np
import pytest
from half_disk_results import SINGULAR_VALUES as disk_singular_values  # noqa: N811
from half_disk_results import HalfDisks, reduced_multipliers, write_fields, write_model

from signorom_post.cli import main
from signorom_post.paper.command import ENTRIES
from signorom_post.paper.maps import statistics
from signorom_post.paper.variants import IRREGULAR_POINTS
from signorom_post.readers.validation import read_validation

pytestmark = pytest.mark.slow

SIGNATURE = b"\x89PNG\r\n"
#: the energy tail after l modes is 10**(-2 l / 11.9): below 1e-6 at l = 36 and not before
SINGULAR_VALUES = 10.0 ** (-np.arange(120) / 11.9)
#: snapshots of each cluster, 1-based; heights are 1 to 5 mm
CENTERS = [[5.0, 1.0], [5.0, 2.0], [5.0, 3.0], [5.0, 4.0], [5.0, 5.0]]
MEMBERS = {"1": [1, 2], "2": [2, 3, 4], "3": [4, 5]}
POINTS = ((170.0, 3.2), (30.0, 5.25))


def make_program(folder: Path) -> Path:
    """An executable that runs fake_signorom.py, with the model and the fields that it copies: half disks."""
    folder.mkdir(exist_ok=True)
    path = folder / "signorom"
    path.write_text((Path(__file__).parent / "fake_signorom.py").read_text())
    path.write_text(f"#!{sys.executable}\n{path.read_text()}")
    path.chmod(0o755)
    disks = HalfDisks()
    write_model(folder / "model.h5", disks)
    with h5py.File(folder / "model.h5", "r+") as file:
        del file["clusters/1/singular_values"], file["reduction/pod_tolerance"]
        file["clusters/1/singular_values"] = SINGULAR_VALUES
        file["reduction/pod_tolerance"] = 1e-6
    with h5py.File(folder / "irregular.h5", "w") as file:
        file["parameter_names"], file["parameters"] = ["P1", "h1"], CENTERS
    labels = [f"{point[0]},{point[1]},{label}" for point, label in zip(CENTERS, (1, 1, 2, 3, 3), strict=True)]
    (folder / "labels.csv").write_text("\n".join(["P1,h1,cluster", *labels]) + "\n")
    write_model(folder / "clusters.h5", disks, n_clusters=3)
    with h5py.File(folder / "clusters.h5", "r+") as file:
        for name in ("names", "units", "minimum", "maximum", "training_points"):
            del file["parameters"][name]
        file["parameters/names"], file["parameters/units"] = ["P1", "h1"], ["MPa", "mm"]
        file["parameters/minimum"], file["parameters/maximum"] = [5.0, 0.6], [200.0, 6.0]
        file["parameters/training_points"] = CENTERS
        for name, members in MEMBERS.items():
            del file[f"clusters/{name}/training_points"]
            file[f"clusters/{name}/training_points"] = members
    write_fields(folder / "fields.h5", disks, (0.3, 0.2))
    with h5py.File(folder / "fields.h5", "r+") as file:
        for name, point in zip(("0001", "0002"), POINTS, strict=True):
            file[f"points/{name}"].attrs["parameter_names"] = "P1,h1"
            file[f"points/{name}"].attrs["parameters"] = point
    return path


@pytest.fixture
def fake(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The stand-in, named by the variable; its folder gets a line per start."""
    path = make_program(tmp_path / "bin")
    monkeypatch.setenv("SIGNOROM_EXECUTABLE", str(path))
    return path


@pytest.fixture(scope="module")
def everything(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Path, list[str]]]:
    """All entries, made once: the output folder and the starts of the program."""
    folder = tmp_path_factory.mktemp("everything")
    program = make_program(folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SIGNOROM_EXECUTABLE", str(program))
        assert main(["paper", "--output", str(folder / "out"), "--map", "4", "--jobs", "4"]) == 0
        yield folder / "out", calls(program)


def calls(program: Path) -> list[str]:
    path = program.parent / "calls.txt"
    return path.read_text().splitlines() if path.exists() else []


def read_table(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def test_every_entry_has_a_table_and_a_figure(everything: tuple[Path, list[str]]) -> None:
    names = set(ENTRIES) - {"fig09", "fig17", "fig20", "fig21", "table2"}
    names |= {"fig09a", "fig09b", "fig17a", "fig17b", "fig17c", "fig21a", "fig21b", "fig21c"}
    output = everything[0]
    for name in names:
        assert (output / f"{name}.png").read_bytes().startswith(SIGNATURE)
        assert read_table(output / f"{name}.csv")
    written = {path.name for path in output.iterdir()}
    others = {"runs", "summary.md", "summary.csv", "table2.csv", "fig20.png", "fig20a.csv", "fig20b.csv"}
    assert written == {f"{n}.{e}" for n in names for e in ("png", "csv")} | others


def test_snapshots_are_made_once_per_load_and_no_run_is_repeated(everything: tuple[Path, list[str]]) -> None:
    starts = everything[1]
    assert len(starts) == len(set(starts))
    assert [start for start in starts if start.startswith("sample")] == [
        "sample whole_edges/snapshots",
        "sample cut/snapshots",
        "sample whole_edges/irregular_snapshots",
    ]


def test_large_files_are_kept_only_where_figures_need_them(everything: tuple[Path, list[str]]) -> None:
    runs = everything[0] / "runs"
    assert (runs / "whole_edges" / "rid34_plus0_cladding_kappa1_fields" / "model.h5").is_file()
    assert not (runs / "whole_edges" / "rid34_plus0_cladding_kappa1_hats3" / "model.h5").exists()
    assert (runs / "whole_edges" / "rid34_plus0_cladding_kappa1_hats3" / "validation.csv").is_file()


def test_errors_after_each_hat(everything: tuple[Path, list[str]]) -> None:
    """The stand-in's dual error is 40 % / (hats + 1), its kappa 10^(4 - 4 hats / 34)."""
    table = read_table(everything[0] / "fig10.csv")
    assert [int(row["hats"]) for row in table] == [*range(35), *range(35)]
    assert [int(row["extra_modes"]) for row in table] == [0] * 35 + [9] * 35
    np.testing.assert_allclose(
        [float(row["e_lambda_170_3.2"]) for row in table[:35]], 0.4 / np.arange(1, 36), rtol=1e-12
    )
    kappa = [float(row["condition_number"]) for row in table[:35]]
    assert np.isinf(kappa[:4]).all()
    np.testing.assert_allclose(kappa[4:], 10.0 ** (4.0 - 4.0 * np.arange(4, 35) / 34))
    assert read_table(everything[0] / "fig03.csv") == table[:35]


def summary(folder: Path) -> dict[tuple[str, str], dict[str, str]]:
    return {(row["where"], row["quantity"]): row for row in read_table(folder / "summary.csv")}


def test_numbers_stand_next_to_the_papers(everything: tuple[Path, list[str]]) -> None:
    """kappa <= 10 needs hats >= 3 / 4 of the rows: 26 of 34, 45 of 60; 36 and 45 modes before."""
    numbers = summary(everything[0])
    expected = {
        ("Fig. 9a", "modes l"): (36, 36, 36, "within"),
        ("Fig. 9b", "contact pairs in the RID"): (34, 34, 34, "within"),
        ("Fig. 12", "contact pairs in the RID"): (60, 60, 60, "within"),
        ("Fig. 10", "l-bar where (11) holds first, FE"): (40, 40, "", "-"),
        ("Fig. 10", "dual error at kappa_max = 10, FE"): (0.063, 0.4 / 27, "", "-"),
        ("Fig. 11", "l-bar at kappa_max = 10, FE"): (55, 62, 62, "within"),
        ("Fig. 11", "l-bar at kappa_max = 10, POD + 9 and FE"): (62, 71, 71, "OUTSIDE"),
        ("Fig. 13", "l-bar at kappa_max = 10, FE"): (83, 81, 81, "within"),
        ("Fig. 14", "dual error at (170 MPa, 3.2 mm), 34 pairs, all hats"): (
            0.025,
            0.4 / 35,
            0.2 / 35,
            "within",
        ),
        ("Fig. 16", "snapshots"): (500, 31, "", "OUTSIDE"),
        ("Table 1", "final l-bar, + 26"): (96, 96, 96, "within"),
        ("Table 1", "energy tail behind l + 3 modes"): (7.5e-7, 10.0 ** (-2 * 39 / 11.9), None, "-"),
    }
    for key, (paper, ours, cut, verdict) in expected.items():
        row = numbers[key]
        assert float(row["paper"]) == pytest.approx(paper)
        assert float(row["ours"]) == pytest.approx(ours, rel=1e-2)
        assert row["verdict"] == verdict
        if cut is not None:
            assert (
                row["ours_cut"] == "" if cut == "" else float(row["ours_cut"]) == pytest.approx(cut, rel=1e-9)
            )


@pytest.mark.parametrize(
    ("quantity", "limit", "is_robust"),
    [
        ("dual error at (170 MPa, 3.2 mm), + 0, cladding hats", 1.3 * 0.025, True),
        ("dual error at (170 MPa, 3.2 mm), + 15, cladding hats", 1.3 * 0.017, True),
        ("dual error at (170 MPa, 3.2 mm), + 18, cladding hats", 2 * 0.014, True),
        ("dual error at (170 MPa, 3.2 mm), + 0, fuel hats", 2 * 0.025, True),
        ("dual error at (30 MPa, 5.25 mm), + 9, cladding hats", 2 * 0.056, False),
        ("primal error at (170 MPa, 3.2 mm), + 12, cladding hats", 2 * 0.014, True),
        ("primal error at (170 MPa, 3.2 mm), + 15, cladding hats", 2 * 0.019, False),
    ],
)
def test_what_table_1_allows(
    everything: tuple[Path, list[str]], quantity: str, limit: float, is_robust: bool
) -> None:
    row = summary(everything[0])["Table 1", quantity]
    assert float(row["allowed_max"]) == pytest.approx(limit)
    assert row["is_robust"] == str(is_robust)


def test_statistics_of_a_map(everything: tuple[Path, list[str]]) -> None:
    """4 x 4 points: 2 without contact, 2 infinite, 4 of 20 % (70 MPa), 8 of 5 % (135 and 200 MPa)."""
    path = everything[0] / "runs" / "whole_edges" / "rid34_plus0_cladding_kappa10_map4" / "validation.csv"
    found = statistics(read_validation(path))
    assert (found.median, found.p95) == (0.05, np.inf)
    assert found.above_10 == pytest.approx(6 / 14)
    row = summary(everything[0])["Fig. 11", "map, FE: points above 10 %"]
    assert float(row["ours"]) == pytest.approx(6 / 14)
    assert float(row["allowed_max"]) == pytest.approx(1.3 * 0.35)


def test_contact_forces_are_those_of_the_fields(everything: tuple[Path, list[str]]) -> None:
    disks = HalfDisks()
    table = [row for row in read_table(everything[0] / "fig14.csv") if row["pairs_paper"] == "34"]
    assert len(table) == disks.n_pairs
    full = sorted(float(row["full_order_N"]) for row in table)
    np.testing.assert_allclose(full, sorted(disks.multipliers(0.3)))
    reduced = sorted(float(row["reduced_N"]) for row in table if row["reduced_N"])
    np.testing.assert_allclose(reduced, sorted(reduced_multipliers(disks, 0.3)[disks.reduced_rows]))


def test_clusters_come_by_falling_height(everything: tuple[Path, list[str]]) -> None:
    """The stand-in's clusters 3, 2, 1 hold the heights 4 and 5; 2, 3 and 4; 1 and 2 mm."""
    table = read_table(everything[0] / "fig15.csv")
    found = [(int(row["cluster"]), float(row["h1_mm"])) for row in table]
    assert found == [(1, 4.0), (1, 5.0), (2, 2.0), (2, 3.0), (2, 4.0), (3, 1.0), (3, 2.0)]
    numbers = summary(everything[0])
    assert [float(numbers["Fig. 15", f"snapshots of cluster {i}"]["ours"]) for i in (1, 2, 3)] == [2, 3, 2]
    assert float(numbers["Fig. 17", "contact pairs of cluster 2"]["ours"]) == 40
    row = numbers["Fig. 18", "map at kappa_max = 10: 95th percentile"]
    assert (row["verdict"], float(row["allowed_max"])) == ("OUTSIDE", 0.18)
    assert float(numbers["Fig. 18", "map at kappa_max = 1: median of the dual error"]["allowed_max"]) == 0.015
    assert numbers["Fig. 18", "map at kappa_max = 1: 95th percentile"]["verdict"] == "-"
    assert {row["max_condition_number"] for row in read_table(everything[0] / "fig18.csv")} == {"10.0", "1.0"}


def test_irregular_snapshots_have_no_agreed_numbers(everything: tuple[Path, list[str]]) -> None:
    """36 modes and 45 hats of 60 pairs, with 9 more 90; 30 hats of the 40 pairs of a cluster."""
    places = ("Fig. 19", "Fig. 20", "Fig. 21", "Fig. 22")
    numbers = {key: row for key, row in summary(everything[0]).items() if key[0] in places}
    assert {row["verdict"] for row in numbers.values()} == {"-"}
    expected = {
        ("Fig. 19", "l-bar at kappa_max = 10, FE"): ("60", "81"),
        ("Fig. 19", "l-bar at kappa_max = 10, POD + FE"): ("82", "90"),
        ("Fig. 19", "more modes at 3.5e-7"): ("5", "9"),
        ("Fig. 20", "snapshots"): ("200", "5"),
        ("Fig. 21", "contact pairs of cluster 3"): ("56", "40"),
    }
    for key, (paper, ours) in expected.items():
        assert (numbers[key]["paper"], float(numbers[key]["ours"])) == (paper, float(ours))
    assert numbers["Fig. 22", "map, three clusters: 95th percentile"]["paper"] == ""
    assert all("criterion" in row["remark"] for row in numbers.values())


def test_forest_parts_the_box(everything: tuple[Path, list[str]]) -> None:
    """A row per point of the map; the second cluster has no more votes than the first."""
    table = read_table(everything[0] / "fig20b.csv")
    assert len(table) == 16
    ratios = [float(row["second_over_first"]) for row in table]
    assert 0.0 <= min(ratios) < max(ratios) <= 1.0
    assert len(read_table(everything[0] / "fig20a.csv")) == sum(len(members) for members in MEMBERS.values())


def test_other_snapshots_run_the_models_again(
    fake: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    arguments = ["paper", "--output", str(tmp_path / "out"), "--only", "fig21", "--map", "3"]
    assert main(arguments) == 0
    greedy = {**IRREGULAR_POINTS["greedy"], "max_points": 100}
    monkeypatch.setitem(IRREGULAR_POINTS, "greedy", greedy)
    assert main(arguments) == 0
    assert [call.split()[0] for call in calls(fake)] == ["sample", "run"] * 2


def test_table_2(everything: tuple[Path, list[str]]) -> None:
    """All 40 hats: 40 % / 41."""
    for row, limit in zip(read_table(everything[0] / "table2.csv"), (1.3 * 0.020, 1.3 * 0.024), strict=True):
        assert (int(row["n_modes"]), int(row["n_columns"])) == (36, 76)
        assert float(row["e_lambda"]) == pytest.approx(0.4 / 41)
        text = f"dual error at ({float(row['P1_MPa']):g} MPa, {float(row['h1_mm']):g} mm)"
        assert float(summary(everything[0])["Table 2", text]["allowed_max"]) == pytest.approx(limit)


def test_energy_tail(everything: tuple[Path, list[str]]) -> None:
    table = read_table(everything[0] / "fig16.csv")
    squares = SINGULAR_VALUES**2
    assert float(table[36]["energy_tail"]) == pytest.approx(squares[36:].sum() / squares.sum())
    # the half disks' own, in each of the clusters
    squares = disk_singular_values**2
    for i in (1, 2, 3):
        assert float(table[9][f"energy_tail_of_cluster_{i}"]) == pytest.approx(
            squares[9:].sum() / squares.sum()
        )
        assert float(table[1][f"singular_value_of_cluster_{i}"]) == pytest.approx(disk_singular_values[0])
        assert not table[len(squares) + 1][f"singular_value_of_cluster_{i}"]


def test_second_call_only_draws(fake: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["paper", "--output", str(tmp_path / "out"), "--only", "fig14"]
    assert main(arguments) == 0
    first = calls(fake)
    assert len(first) == 6  # snapshots and two models for each load
    assert "run 1 of 2" in capsys.readouterr().err
    (tmp_path / "out" / "fig14.png").unlink()
    assert main(arguments) == 0
    assert calls(fake) == first
    assert "run" not in capsys.readouterr().err
    assert (tmp_path / "out" / "fig14.png").exists()


def test_another_program_runs_again_from_new_snapshots(fake: Path, tmp_path: Path) -> None:
    arguments = ["paper", "--output", str(tmp_path / "out"), "--only", "fig08"]
    assert main(arguments) == 0
    snapshots = tmp_path / "out" / "runs" / "whole_edges" / "snapshots" / "snapshots.h5"
    snapshots.write_text("of the old program")
    fake.write_text(fake.read_text() + "# changed\n")
    assert main(arguments) == 0
    assert len(calls(fake)) == 4
    assert snapshots.read_text() == ""


def test_program_that_fails_is_quoted(
    fake: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("BROKEN", "1")
    assert main(["paper", "--output", str(tmp_path / "out"), "--only", "fig08"]) == 2
    said = capsys.readouterr().err
    assert "signorom sample ended with exit code 2:\ndeck.yaml:1:1: error: nothing is right" in said
    monkeypatch.delenv("BROKEN")
    assert main(["paper", "--output", str(tmp_path / "out"), "--only", "fig08"]) == 0
    assert len(calls(fake)) == 3


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_stopped_run_goes_on(fake: Path, tmp_path: Path, number: signal.Signals) -> None:
    command = [sys.executable, "-m", "signorom_post", "paper", "--only", "fig08"]
    command += ["--output", str(tmp_path / "out")]
    environment = os.environ | {"SLOW": "1", "PYTHONPATH": os.pathsep.join(sys.path)}
    process = subprocess.Popen(command, env=environment, stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 120
    while len(calls(fake)) < 2 and time.monotonic() < deadline:
        time.sleep(0.02)
    process.send_signal(number)
    _, said = process.communicate(timeout=120)
    assert process.returncode == 130
    assert said.endswith("stopped; run the same command again\n")
    assert main(command[3:]) == 0
    assert [call.split()[0] for call in calls(fake)] == ["sample", "run", "run"]
