# SPDX-License-Identifier: BSD-3-Clause
"""`signorom-post compare`: one table of models of one problem, and the runs that make them."""

import csv
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
import yaml
from half_disk_results import REPORT, write_results, write_validation

from signorom_post.answer import Parameter
from signorom_post.arrays import FloatArray
from signorom_post.cli import main
from signorom_post.compare import command, timing
from signorom_post.compare.variants import read_variants

ROOT = Path(__file__).resolve().parents[3]
VARIANTS = sorted((ROOT / "input" / "compare").glob("*.yaml"))
#: what a report of `run --benchmark` has beside those of the other tests
SECTIONS: dict[str, Any] = {
    "provenance": "0123456789abcdef",
    "solver": {"type": "condensed"},
    "sampling": {"n_points": 31},
    "answers": {"none": 0, "condensed": 0, "by_fallback": 3},
}
HHR = {"kind": "hhr", "n_reduced_unknowns": 9, "n_contact_rows": 8}
CONDENSED = {"kind": "condensed", "n_contact_rows": 53}
TIMES = {
    "sample_per_point": {"median": 0.001},
    "train": 2.0,
    "full_order_setup": 0.5,
    "full_order_per_point": 3e-5,
    "refactored_per_point": 0.015,
}
ROW = {
    "squeeze": 0.2,
    "cluster": 1,
    "e_u": 0.1,
    "e_lambda_rid": 0.1,
    "e_lambda_all": 0.1,
    "e_energy": 0.1,
    "e_energy_rid": 0.1,
    "n_active": 4,
    "n_active_full_order": 8,
    "solver": "active_set",
    "full_order": "converged",
}


def write_model_results(
    folder: Path, errors: tuple[float, ...] = (0.01, 0.02, 0.04), **sections: Any
) -> Path:
    """A results folder with these errors on all contacts and these sections of the report."""
    write_results(folder)
    write_rows(
        folder, [ROW | {"squeeze": 0.1 * i, "e_lambda_all": error} for i, error in enumerate(errors, start=1)]
    )
    report = yaml.safe_load(REPORT) | SECTIONS | {"reduction": HHR, "times": TIMES} | sections
    (folder / "report.yaml").write_text(yaml.safe_dump(report), encoding="utf-8")
    (folder / "model.h5").write_bytes(bytes(2_500_000))
    return folder


def write_rows(folder: Path, rows: list[dict[str, object]]) -> None:
    write_validation(folder / "validation.csv", rows)


@pytest.fixture
def two(tmp_path: Path) -> list[Path]:
    """A hyper-reduced and a condensed model of one problem."""
    return [
        write_model_results(tmp_path / "paper"),
        write_model_results(tmp_path / "exact", (1e-15, 2e-15, 3e-15), reduction=CONDENSED),
    ]


@pytest.fixture
def known_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """Queries take 12 microseconds; the models are not opened."""
    monkeypatch.setattr(command, "query_time", lambda *_: 12e-6)


def cells(line: str) -> list[str]:
    return [cell.strip() for cell in line.strip("|\n").split("|")]


def table(text: str) -> dict[str, dict[str, str]]:
    """Rows of the printed Markdown table by their first cell; a full-order solver's by its kind, too."""
    lines = [cells(line) for line in text.splitlines() if line.startswith("|")]
    assert set("".join(lines[1])) == {"-"}
    rows = [dict(zip(lines[0], line, strict=True)) for line in lines[2:]]
    return {row["model"]: row for row in rows}


def say(folders: list[Path], *options: str) -> list[str]:
    return ["compare", *map(str, folders), *options]


@pytest.mark.usefixtures("known_time")
def test_table(two: list[Path], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(say(two)) == 0
    said = capsys.readouterr().out
    assert [list(row.values()) for row in table(said).values()] == [
        ["full order, factored anew", "active_set", "1356", *"- 53 - -".split(), "15.0 ms", *"-----"],
        ["full order", "condensed", "53", *"- 53 -".split(), "500 ms", "30.0 us", *"-----"],
        "paper|hhr|9|8|53|2.5|2.53 s|12.0 us|2.0e-02|3.8e-02|4.0e-02|3|0".split("|"),
        "exact|condensed|53|-|53|2.5|2.53 s|12.0 us|2.0e-15|2.9e-15|3.0e-15|3|0".split("|"),
    ]
    assert "at 3 test points" in said
    assert "mean of 1000 random points of its box (seed 1)" in said


def test_without_times_nothing_depends_on_the_machine(
    two: list[Path], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(say(two, "--no-times")) == 0
    said = capsys.readouterr().out
    assert table(said)["paper"]["largest"] == "4.0e-02"
    assert not {"offline", "query"} & set(table(said)["paper"])
    assert "Query" not in said


@pytest.mark.usefixtures("known_time")
def test_csv_has_the_numbers(two: list[Path], tmp_path: Path) -> None:
    assert main(say(two, "--csv", str(tmp_path / "table.csv"))) == 0
    with (tmp_path / "table.csv").open(newline="") as file:
        rows = {row["name"]: row for row in csv.DictReader(file)}
    paper = rows["paper"]
    assert float(paper["offline"]) == pytest.approx(0.5 + 31 * 0.001 + 2.0)
    assert float(paper["median"]) == 0.02
    assert float(paper["p95"]) == pytest.approx(0.02 + 0.9 * 0.02)
    assert (paper["file_size"], paper["n_fallbacks"], paper["n_unanswered"]) == ("2500000", "3", "0")
    assert rows["exact"]["domain_contacts"] == ""


def test_points_that_fail_are_counted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """No answer is infinitely wrong, as is 0/0 in contact; no contact is right; no full-order solution is left out."""
    folder = write_model_results(tmp_path / "some", answers={"none": 1, "by_fallback": 0})
    fates: list[dict[str, object]] = [
        {"e_lambda_all": "nan", "solver": "none"},
        {"e_lambda_all": "nan", "n_active_full_order": 0},
        {"e_lambda_all": "nan", "full_order": "not_converged"},
        *({"e_lambda_all": 0.1 * i} for i in range(1, 5)),
    ]
    write_rows(folder, [ROW | fate for fate in fates])
    assert main(say([folder], "--no-times")) == 0
    row = table(capsys.readouterr().out)["some"]
    # of 0, 0.1, 0.2, 0.3, 0.4 and the infinite one
    assert [row[key] for key in ("e_λ median", "95 %", "largest", "no answer")] == [
        "2.5e-01",
        "inf",
        "inf",
        "1",
    ]
    write_rows(folder, [ROW | {"e_lambda_all": "nan"}])
    assert main(say([folder], "--no-times")) == 0
    assert table(capsys.readouterr().out)["some"]["e_λ median"] == "inf"


def test_clusters_show_their_ranges(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    parts = {
        str(i): {"kind": "hhr", "n_reduced_unknowns": n, "n_contact_rows": 8} for i, n in ((1, 57), (2, 53))
    }
    folder = write_model_results(tmp_path / "parts", reduction={"n_clusters": 2, "clusters": parts})
    assert main(say([folder], "--no-times")) == 0
    row = table(capsys.readouterr().out)["parts"]
    assert [row[key] for key in ("kind", "unknowns", "contacts in the RID")] == [
        "hhr, 2 clusters",
        "53 to 57",
        "8",
    ]


def test_any_other_kind_shows_its_contacts(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = write_model_results(tmp_path / "large", reduction={"kind": "tied", "n_contact_rows": 181})
    assert main(say([folder], "--no-times")) == 0
    row = table(capsys.readouterr().out)["large"]
    assert [row[key] for key in ("kind", "unknowns", "contacts in the RID")] == ["tied", "181", "-"]


def test_folders_of_one_name_keep_their_paths(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folders = [write_model_results(tmp_path / name / "results") for name in ("one", "two")]
    assert main(say(folders, "--no-times")) == 0
    assert set(map(str, folders)) <= set(table(capsys.readouterr().out))


def test_times_that_no_report_has(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Without --benchmark and without the library the table has gaps, and the library's is explained."""
    monkeypatch.setenv("SIGNOROM_LIBRARY", "/nowhere/libsignorom_online.so")
    folder = write_model_results(tmp_path / "plain", times={})
    assert main(say([folder])) == 0
    captured = capsys.readouterr()
    assert {row[key] for row in table(captured.out).values() for key in ("offline", "query")} == {"-"}
    assert captured.err.startswith(
        "queries are not timed: the library /nowhere/libsignorom_online.so cannot be used"
    )


def test_another_problem_is_refused(two: list[Path], capsys: pytest.CaptureFixture[str]) -> None:
    write_model_results(two[1], provenance="fedcba9876543210")
    assert main(say(two)) == 2
    assert capsys.readouterr().err == (
        f"{two[1]}: error: this is another problem than {two[0]} (provenance fedcba9876543210, not 0123456789abcdef): "
        "mesh, units, names of parameters, materials, loads, imposed strains, boundary conditions or contact differ, "
        "so the errors cannot be compared\n"
    )


def test_other_test_points_are_refused(two: list[Path], capsys: pytest.CaptureFixture[str]) -> None:
    write_model_results(two[1], (0.1, 0.1))
    assert main(say(two)) == 2
    assert f"{two[1]}: error: this was validated at other points than {two[0]}" in capsys.readouterr().err


@pytest.mark.parametrize("missing", ["report.yaml", "validation.csv", "model.h5"])
def test_missing_file_is_named_with_what_makes_it(
    missing: str, two: list[Path], capsys: pytest.CaptureFixture[str]
) -> None:
    (two[1] / missing).unlink()
    assert main(say(two, "--no-times")) == 2
    assert capsys.readouterr().err == (
        f"{two[1] / missing}: error: there is no such file; this makes it: signorom run DECK --benchmark\n"
    )


@pytest.mark.parametrize("section", ["provenance", "reduction", "answers"])
def test_report_of_another_command(section: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = write_model_results(tmp_path / "trained", **{section: None})
    assert main(say([folder])) == 2
    assert f"there is no section '{section}'" in capsys.readouterr().err


@pytest.mark.parametrize("arguments", [[], ["results/a", "--run", "b.yaml"]])
def test_folders_or_a_file_of_models(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["compare", *arguments]) == 2
    assert "give either results folders or --run FILE, and not both" in capsys.readouterr().err


class FakeModel:
    """Remembers where it was asked."""

    def __init__(self, asked: list[FloatArray]) -> None:
        self.parameters = [Parameter("a", "m", 1.0, 2.0), Parameter("b", "m", -5.0, -3.0)]
        self._asked = asked

    def __enter__(self) -> "FakeModel":
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def query_many(self, points: FloatArray) -> None:
        self._asked.append(points.copy())
        sum(range(20000))


def test_queries_are_timed_at_points_of_the_box(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[FloatArray] = []
    monkeypatch.setattr(timing, "Model", lambda _: FakeModel(asked))
    assert 0 < timing.query_time(Path("model.h5"), 50, 7) < 0.1
    assert len(asked) == 1 + timing.N_REPETITIONS
    assert asked[0].shape == (50, 2)
    assert np.all((asked[0] >= [1, -5]) & (asked[0] <= [2, -3]))
    timing.query_time(Path("model.h5"), 50, 7)
    assert all(np.array_equal(points, asked[0]) for points in asked)


PROGRAM = f"""#!{sys.executable}
import os, shutil, sys, time
assert sys.argv[1:] == ["run", "deck.yaml", "--benchmark"]
if "BROKEN" in os.environ:
    print("deck.yaml:1:1: error: nothing is right")
    sys.exit(2)
if "SLOW" in os.environ:
    with open("started", "w") as file:
        file.write(str(os.getpid()))
    time.sleep(60)
for name in ("report.yaml", "validation.csv", "model.h5"):
    shutil.copy(os.path.join(os.path.dirname(sys.argv[0]), name), name)
sys.exit(3)
"""
DECK = """mesh: {file: meshes/disks.msh, model: plane_strain}
test: {grid: {squeeze: 3}}
training: {file: points.csv}
reduction: {method: hhr, n_modes: 3}
certificate: {max_error: none}
output: {fields: [displacement]}
"""
MODELS = """deck: deck.yaml
models:
  paper: {}
  exact: {reduction: {method: condensed}, certificate: null}
"""


@pytest.fixture
def study(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A file of two models, and a program that makes the same results of each."""
    home = write_model_results(tmp_path / "home")
    program = home / "signorom"
    program.write_text(PROGRAM)
    program.chmod(0o755)
    monkeypatch.setenv("SIGNOROM_EXECUTABLE", str(program))
    monkeypatch.chdir(tmp_path)
    (tmp_path / "deck.yaml").write_text(DECK)
    (tmp_path / "models.yaml").write_text(MODELS)
    return tmp_path / "models.yaml"


def test_models_of_a_file_are_run(study: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["compare", "--run", "models.yaml", "--no-times"]) == 0
    captured = capsys.readouterr()
    assert captured.err.splitlines() == ["paper ...", "exact ..."]
    assert {"paper", "exact"} <= set(table(captured.out))
    output = study.parent / "results" / "compare" / "models"
    paper, exact = (yaml.safe_load((output / name / "deck.yaml").read_text()) for name in ("paper", "exact"))
    assert paper == yaml.safe_load(DECK) | {
        "mesh": {"file": str(study.parent / "meshes" / "disks.msh"), "model": "plane_strain"},
        "training": {"file": str(study.parent / "points.csv")},
        "output": {"directory": "."},
    }
    assert exact["reduction"] == {"method": "condensed"}
    assert "certificate" not in exact
    # the folders are results as any others
    assert main(["compare", str(output / "paper"), str(output / "exact"), "--no-times"]) == 0
    assert capsys.readouterr().out == captured.out


def test_program_that_fails_is_quoted(
    study: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("BROKEN", "1")
    assert main(["compare", "--run", "models.yaml", "--output", "here"]) == 2
    assert capsys.readouterr().err.endswith(
        "error: signorom run ended with exit code 2:\ndeck.yaml:1:1: error: nothing is right\n"
    )
    assert (study.parent / "here" / "paper" / "log.txt").is_file()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_signal_ends_the_program(study: Path, number: signal.Signals) -> None:
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path), "SLOW": "1"}
    command = [sys.executable, "-m", "signorom_post", "compare", "--run", "models.yaml", "--output", "here"]
    process = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    started = study.parent / "here" / "paper" / "started"
    deadline = time.monotonic() + 60
    while not (started.is_file() and started.read_text()) and time.monotonic() < deadline:
        time.sleep(0.05)
    process.send_signal(number)
    process.communicate(timeout=30)
    assert process.returncode == 130
    with pytest.raises(ProcessLookupError):
        os.kill(int(started.read_text()), 0)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("models: {a: {}}", "this needs two keys"),
        ("deck: deck.yaml\nmodels: {}", "this needs two keys"),
        ("deck: deck.yaml\nmodels: {../a: {}}", "the model's name '../a' cannot be used; it needs"),
        ("deck: deck.yaml\nmodels: {a: }", "the model 'a' needs the sections that it replaces in the deck"),
        ("deck: nothing.yaml\nmodels: {a: {}}", "nothing.yaml: error: there is no such file"),
        ("[]", "this is not a list of models"),
    ],
)
def test_wrong_file_of_models(
    text: str, sentence: str, study: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    study.write_text(text)
    assert main(["compare", "--run", "models.yaml"]) == 2
    assert sentence in capsys.readouterr().err


@pytest.mark.parametrize("path", VARIANTS, ids=lambda path: path.stem)
def test_shipped_models_are_decks(path: Path) -> None:
    schema = json.loads((ROOT / "input" / "deck.schema.json").read_text(encoding="utf-8"))
    decks = read_variants(path)
    assert len(decks) >= 3
    assert any(deck.get("reduction", {}).get("method", "condensed") == "condensed" for deck in decks.values())
    for deck in decks.values():
        assert Path(deck["mesh"]["file"]).is_file()
        jsonschema.validate(deck, schema)


def test_there_are_shipped_models() -> None:
    assert [path.stem for path in VARIANTS] == ["bracket", "fuel_rod", "half_disks", "pellet_cladding"]
