# SPDX-License-Identifier: BSD-3-Clause
"""The table of the verification: from the rows that tests wrote, and a sentence where there are none."""

import csv
from itertools import pairwise
from pathlib import Path

import pytest

from signorom_post.cli import main
from signorom_post.plots.verification_table import verification_table
from signorom_post.readers.verification import COLUMNS, HOW_TO_MAKE, read_verification
from signorom_post.style import styled
from signorom_post.verification import format_markdown, table_of, worst_of_alike

HERTZ = [
    "cylinder",
    "half-width",
    "mm",
    "6.2146",
    "Hertz",
    "6.17340623",
    "-0.00662854",
    "0.02",
    "relative",
    "yes",
]
ORDER = ["punch", "order", "", "1.0", "singular edge", "1.02974", "", "0.9", "at_least", "yes"]
BALANCE = ["cylinder", "reactions + loads", "", "", "equilibrium", "1.69e-13", "", "1e-09", "at_most", "yes"]
MODES = ["case b", "modes", "", "36.0", "the paper", "37.0", "1.0", "0.0", "absolute", "no"]
BROKEN = ["test_loads", "test_weight", "", "", "", "", "", "", "", "no"]


def write(path: Path, *rows: list[str]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([COLUMNS, *rows])


@pytest.fixture
def results(tmp_path: Path) -> Path:
    folder = tmp_path / "verification"
    folder.mkdir()
    write(folder / "test_a.csv", HERTZ, ORDER)
    write(folder / "test_b.csv", BALANCE)
    write(folder / "test_c.csv")
    return folder


def test_rows_of_a_problem_stand_together(results: Path) -> None:
    figures = read_verification(results)
    assert [figure.quantity for figure in figures] == ["half-width", "reactions + loads", "order"]


def test_cells(results: Path) -> None:
    write(results / "test_d.csv", MODES, BROKEN)
    assert table_of(read_verification(results)) == [
        ["cylinder", "half-width", "6.2146 mm", "Hertz", "6.17341 mm", "-0.66 %", "± 2 %", "pass"],
        ["cylinder", "reactions + loads", "", "equilibrium", "1.7e-13", "", "≤ 1e-9", "pass"],
        ["punch", "order", "1", "singular edge", "1.02974", "", "≥ 0.9", "pass"],
        ["case b", "modes", "36", "the paper", "37", "+1", "± 0", "FAIL"],
        ["test_loads", "test_weight", "", "", "", "", "", "FAIL"],
    ]


def test_small_relative_differences_are_no_percentages(results: Path) -> None:
    tight = [*HERTZ[:6], "-3.2e-11", "1e-09", *HERTZ[8:]]
    write(results / "test_a.csv", tight)
    assert table_of(read_verification(results))[0][5:7] == ["-3e-11", "± 1e-9"]


def test_picture_shows_the_worst_of_those_alike(results: Path) -> None:
    larger = ["cylinder", "other balance", *BALANCE[2:5], "2e-10", *BALANCE[6:]]
    failed = [*larger[:5], "3e-9", *larger[6:9], "no"]
    write(results / "test_d.csv", larger, failed)
    figures = read_verification(results)
    assert len(figures) == 5
    shown = worst_of_alike(figures)
    assert [figure.quantity for figure in shown] == [
        "half-width",
        "other balance (worst of 2)",
        "other balance",
        "order",
    ]
    assert [figure.is_passed for figure in shown] == [True, True, False, True]


def test_markdown_is_aligned_and_has_a_verdict(results: Path) -> None:
    lines = format_markdown(read_verification(results)).splitlines()
    assert len(lines) == 2 + 3 + 2
    assert len({len(line) for line in lines[:5]}) == 1
    assert lines[-1] == "3 numbers, all within what is allowed."


def test_command_prints_and_draws(results: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verification", str(results)]) == 0
    captured = capsys.readouterr()
    assert "| punch    | order " in captured.out
    assert captured.err == ""
    written = sorted(path.name for path in (results / "table").iterdir())
    assert written == ["verification.csv", "verification.png"]
    assert (results / "table" / "verification.png").read_bytes().startswith(b"\x89PNG\r\n")
    with (results / "table" / "verification.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))
    assert rows[1][:3] == ["cylinder", "half-width", "6.2146 mm"]
    assert main(["verification", str(results), "--output", str(results / "elsewhere")]) == 0
    assert (results / "elsewhere" / "verification.png").is_file()


def test_failure_is_shown_counted_and_in_the_exit_code(
    results: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write(results / "test_d.csv", MODES)
    assert main(["verification", str(results)]) == 1
    assert capsys.readouterr().out.splitlines()[-1] == "4 numbers, 1 FAILED."


def test_every_cell_is_drawn_inside_the_figure(results: Path) -> None:
    write(results / "test_d.csv", MODES, BROKEN)
    with styled():
        figure = verification_table(read_verification(results))
        figure.canvas.draw()
    width, height = figure.canvas.get_width_height()
    texts = figure.axes[0].texts
    shown = [text.get_text() for text in texts]
    for row in table_of(read_verification(results)):
        assert all(cell in shown for cell in row)
    for text in texts:
        box = text.get_window_extent()
        assert 0 <= box.x0 <= box.x1 <= width
        assert 0 <= box.y0 <= box.y1 <= height
    # columns do not run into each other
    rows = {}
    for text in texts[1:]:
        if text.get_text():
            rows.setdefault(round(text.get_position()[1], 6), []).append(text.get_window_extent())
    for boxes in rows.values():
        for left, right in pairwise(boxes):
            assert left.x1 < right.x0


def test_no_results_say_how_to_make_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    missing = tmp_path / "verification"
    assert main(["verification", str(missing)]) == 2
    said = f"{missing}: error: there are no verification results; {HOW_TO_MAKE}\n"
    assert capsys.readouterr().err == said
    missing.mkdir()
    write(missing / "test_a.csv")
    assert main(["verification", str(missing)]) == 2
    assert "error: the folder has no verification results; `ctest" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("a,b\n1,2\n", "the columns are not problem, quantity"),
        (",".join(COLUMNS) + "\na,b\n", "line 2 has 2 values for 10 columns"),
        (",".join(COLUMNS) + "\n" + ",".join([*HERTZ[:9], "maybe"]), "is not yes or no"),
        (",".join(COLUMNS) + "\n" + ",".join([*HERTZ[:8], "near", "yes"]), "'near' is unknown"),
        (",".join(COLUMNS) + "\n" + ",".join([*HERTZ[:5], "six", *HERTZ[6:]]), "'six' is not a number"),
        ("\x00\x01", "the columns are not"),
    ],
)
def test_damaged_file(results: Path, content: str, message: str, capsys: pytest.CaptureFixture[str]) -> None:
    (results / "test_a.csv").write_text(content)
    assert main(["verification", str(results)]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"{results / 'test_a.csv'}: error: ")
    assert message in said
    assert not (results / "table").exists()


def test_output_that_is_a_file(results: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "taken").write_text("keep me")
    assert main(["verification", str(results), "--output", str(tmp_path / "taken")]) == 2
    assert "error: the table cannot be written" in capsys.readouterr().err
    assert (tmp_path / "taken").read_text() == "keep me"
