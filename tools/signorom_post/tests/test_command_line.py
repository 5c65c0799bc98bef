# SPDX-License-Identifier: BSD-3-Clause
"""The command: what it writes, what it says, and its exit codes."""

import os
import subprocess
import sys
from pathlib import Path

import h5py
import pytest
from half_disk_results import HISTORY, POINTS, HalfDisks, write_enrichment, write_model

from signorom_post import __version__
from signorom_post.cli import main

pytestmark = pytest.mark.slow

NAMES = ["initial_and_deformed", "reduced_domain", "multipliers", "errors", "singular_values", "enrichment"]
ONLY_BODIES = ["--only", "initial_and_deformed"]
SIGNATURES = {"png": b"\x89PNG\r\n", "pdf": b"%PDF-", "svg": b"<?xml"}


def written(output: Path) -> list[str]:
    return sorted(path.name for path in output.iterdir())


def test_all_figures_in_another_format(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Single figures as svg are in other tests."""
    output = tmp_path / "new" / "figures"
    assert main(["figures", str(folder), "--output", str(output), "--format", "pdf"]) == 0
    check_figures(output, "pdf", capsys)


def test_figures_are_png_below_the_results_by_default(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["figures", str(folder)]) == 0
    check_figures(folder / "figures", "png", capsys)


def check_figures(output: Path, file_format: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert written(output) == sorted(f"{name}.{file_format}" for name in NAMES)
    for path in output.iterdir():
        assert path.read_bytes().startswith(SIGNATURES[file_format])
    captured = capsys.readouterr()
    assert captured.out.splitlines() == [str(output / f"{name}.{file_format}") for name in NAMES]
    assert captured.err == ""


def test_two_runs_write_the_same_bytes(folder: Path, tmp_path: Path) -> None:
    for file_format in SIGNATURES:
        for run in ("a", "b"):
            output = ["--output", str(tmp_path / run), "--format", file_format]
            assert main(["figures", str(folder), *output, "--only", "reduced_domain"]) == 0
        content = (tmp_path / "a" / f"reduced_domain.{file_format}").read_bytes()
        assert content.startswith(SIGNATURES[file_format])
    assert len(written(tmp_path / "a")) == len(SIGNATURES)
    for path in (tmp_path / "a").iterdir():
        assert path.read_bytes() == (tmp_path / "b" / path.name).read_bytes()


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize(
    ("missing", "left_out"),
    [
        ("fields.h5", ["initial_and_deformed", "reduced_domain", "multipliers"]),
        ("model.h5", ["clusters", "singular_values"]),
        ("validation.csv", ["errors"]),
        ("enrichment.csv", ["enrichment"]),
    ],
)
def test_missing_file_leaves_figures_out_and_says_why(
    folder: Path, missing: str, left_out: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / missing).unlink()
    (folder / "snapshots.h5").unlink()
    (folder / "report.yaml").unlink()
    assert main(["figures", str(folder)]) == 0
    assert written(folder / "figures") == sorted(f"{name}.png" for name in NAMES if name not in left_out)
    captured = capsys.readouterr()
    said = [line for line in captured.out.splitlines() if line.startswith("left out: ")]
    assert said == [f"left out: {name} ({folder / missing}: there is no such file)" for name in left_out]
    assert captured.err == ""


@pytest.mark.usefixtures("undrawn")
def test_damaged_file_is_an_error_but_the_other_figures_are_drawn(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = folder / "fields.h5"
    path.write_bytes(path.read_bytes()[:5000])
    assert main(["figures", str(folder)]) == 2
    assert written(folder / "figures") == [
        "enrichment.png",
        "errors.png",
        "singular_values.png",
    ]
    assert capsys.readouterr().err == f"{path}: error: the file is truncated: its end is missing\n"


@pytest.mark.usefixtures("undrawn")
def test_clusters_of_a_single_model_are_left_out_when_asked_for(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["figures", str(folder), "--only", "clusters", "errors"]) == 0
    assert written(folder / "figures") == ["errors.png"]
    assert (
        f"left out: clusters ({folder / 'model.h5'}: the model does not have several hyper-reduced clusters)"
        in capsys.readouterr().out
    )


def test_nothing_to_draw(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["figures", str(tmp_path)]) == 2
    assert (
        capsys.readouterr().err == f"{tmp_path}: error: nothing can be drawn; the lines 'left out' say why\n"
    )


def test_no_such_results_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for command in ("figures", "summary"):
        assert main([command, str(tmp_path / "nothing")]) == 2
        assert capsys.readouterr().err == f"{tmp_path / 'nothing'}: error: there is no such folder\n"
    assert not (tmp_path / "nothing").exists()


def test_output_that_is_a_file(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "taken").write_text("keep me")
    assert main(["figures", str(folder), "--output", str(tmp_path / "taken")]) == 2
    assert capsys.readouterr().err.startswith(f"{tmp_path / 'taken'}: error: figures cannot be written")
    assert (tmp_path / "taken").read_text() == "keep me"


@pytest.mark.parametrize("wanted", ["3", f"squeeze = {POINTS[2]}"])
def test_point_by_number_or_label(folder: Path, wanted: str) -> None:
    assert main(["figures", str(folder), "--format", "svg", "--point", wanted, *ONLY_BODIES]) == 0
    assert f"squeeze = {POINTS[2]}" in (folder / "figures" / "initial_and_deformed.svg").read_text()


def test_middle_point_by_default(folder: Path) -> None:
    assert main(["figures", str(folder), "--format", "svg", *ONLY_BODIES]) == 0
    assert f"squeeze = {POINTS[1]}" in (folder / "figures" / "initial_and_deformed.svg").read_text()


def test_unknown_point_lists_the_known_ones(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["figures", str(folder), "--point", "9", *ONLY_BODIES]) == 2
    assert capsys.readouterr().err == (
        f"{folder / 'fields.h5'}: error: there is no point '9'; the file has "
        "1 (squeeze = 0.2), 2 (squeeze = 0.3), 3 (squeeze = 0.4)\n"
    )


def test_color_by_contact(folder: Path) -> None:
    assert main(["figures", str(folder), "--color", "contact", "--format", "svg", *ONLY_BODIES]) == 0
    assert "contact pressure [N/m2]" in (folder / "figures" / "initial_and_deformed.svg").read_text()


@pytest.mark.usefixtures("undrawn")
def test_field_that_the_deck_did_not_ask_for_leaves_the_figure_out(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with h5py.File(folder / "fields.h5", "r+") as file:
        del file["points/0002/displacement"]
    assert main(["figures", str(folder), "--only", "initial_and_deformed", "singular_values"]) == 0
    assert "the point 'squeeze = 0.3' has no field 'displacement'" in capsys.readouterr().out
    assert written(folder / "figures") == ["singular_values.png"]


@pytest.mark.usefixtures("undrawn")
def test_fields_without_points_multipliers_or_pairs(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "model.h5").unlink()
    with h5py.File(folder / "fields.h5", "r+") as file:
        del file["points"]
    assert main(["figures", str(folder)]) == 0
    said = capsys.readouterr().out
    assert "left out: initial_and_deformed" in said
    assert "no point has the field 'multipliers_full_order'" in said
    assert "no point has the field 'reduced_domain'" in said


@pytest.mark.usefixtures("undrawn")
def test_mesh_of_another_model_is_an_error(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with h5py.File(folder / "fields.h5", "r+") as file:
        del file["mesh"], file["points"], file["contact"]
        file["mesh/coordinates"] = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]]
        file["mesh/topology"] = [[0, 1, 2, 3]]
    assert main(["figures", str(folder)]) == 2
    assert "it does not belong to 'model.h5'" in capsys.readouterr().err


@pytest.mark.usefixtures("undrawn")
def test_model_without_hats_has_no_figure_of_them(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_enrichment(folder / "enrichment.csv", HISTORY[:1])
    assert main(["figures", str(folder), "--only", "enrichment", "errors"]) == 0
    assert "left out: enrichment" in capsys.readouterr().out
    assert written(folder / "figures") == ["errors.png"]


@pytest.mark.usefixtures("undrawn")
def test_each_cluster_has_its_domain(folder: Path, disks: HalfDisks) -> None:
    write_model(folder / "model.h5", disks, n_clusters=2)
    assert main(["figures", str(folder), "--only", "reduced_domain"]) == 0
    assert written(folder / "figures") == ["reduced_domain_1.png", "reduced_domain_2.png"]


def test_summary(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["summary", str(folder)]) == 0
    assert "kappa                       3.217" in capsys.readouterr().out


def test_summary_without_a_report(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "report.yaml").unlink()
    assert main(["summary", str(folder)]) == 2
    assert capsys.readouterr().err == f"{folder / 'report.yaml'}: error: there is no such file\n"


@pytest.mark.parametrize(
    "arguments",
    [
        [],
        ["draw"],
        ["figures"],
        ["figures", ".", "--format", "bmp"],
        ["figures", ".", "--only", "x"],
        ["--what"],
    ],
)
def test_wrong_arguments(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        main(arguments)
    assert caught.value.code == 2
    assert "usage: signorom-post" in capsys.readouterr().err


def test_version_and_help(capsys: pytest.CaptureFixture[str]) -> None:
    for arguments, text in (["--version"], f"signorom-post {__version__}"), (["--help"], "summary"):
        with pytest.raises(SystemExit) as caught:
            main(arguments)
        assert caught.value.code == 0
        assert text in capsys.readouterr().out


@pytest.mark.usefixtures("undrawn")
def test_only_some_figures(folder: Path) -> None:
    assert main(["figures", str(folder), "--only", "errors", "singular_values"]) == 0
    assert written(folder / "figures") == ["errors.png", "singular_values.png"]


def test_no_display_is_needed(folder: Path) -> None:
    """Even where the user's settings ask for a window, figures are drawn without one."""
    environment = {key: value for key, value in os.environ.items() if "DISPLAY" not in key}
    environment |= {"MPLBACKEND": "TkAgg", "PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, "-m", "signorom_post", "figures", str(folder), *ONLY_BODIES]
    run = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert (run.returncode, run.stderr) == (0, "")
    assert written(folder / "figures") == ["initial_and_deformed.png"]
