# SPDX-License-Identifier: BSD-3-Clause
"""What `signorom-post paper` is made of: comparisons, variants, the program and the deck that it finds, its options."""

import shutil
from pathlib import Path

import numpy as np
import pytest
import yaml

from signorom_post.cli import main
from signorom_post.errors import InputError
from signorom_post.paper import published
from signorom_post.paper.comparison import Comparison, about, at_most, count, exactly, markdown_table, percent
from signorom_post.paper.variants import IRREGULAR_POINTS, Variant
from signorom_post.program import find_base_deck, find_program


def test_irregular_points_are_those_of_the_deck() -> None:
    deck = yaml.safe_load((find_base_deck().parent / "pellet_cladding_greedy.yaml").read_text())
    assert deck["training"] == IRREGULAR_POINTS


def test_comparison_shows_what_is_allowed() -> None:
    def cells(**options: object) -> list[str]:
        return Comparison("x", "y", 0.025, 0.05, percent, **options).cells()  # type: ignore[arg-type]

    assert cells() == ["x", "y", "2.5 %", "5 %", "-", "-", "-"]
    assert cells(allowed=at_most(0.025, 2))[3:6] == ["5 %", "<= 5 %", "within"]
    assert cells(allowed=at_most(0.025, 1.3))[5] == "OUTSIDE"
    assert cells(allowed=at_most(0.025, 1.2), is_robust=False)[2:6] == [
        "2.5 % *",
        "5 %",
        "<= 3 %",
        "outside, not robust",
    ]
    assert cells(is_published=False)[2] == "(2.5 %)"
    assert Comparison("x", "y", 36, 37, count, exactly(36)).cells()[4:6] == ["36", "OUTSIDE"]
    assert Comparison("x", "y", 34, 28, count, about(34, 6)).cells()[4:6] == ["28 to 40", "within"]
    assert Comparison("x", "y", 34, np.nan, percent, about(34, 6)).verdict == "OUTSIDE"


def test_markdown_keeps_stars_and_counts_verdicts() -> None:
    items = [
        Comparison("Fig. 9", "pairs", 34, 33, count, about(34, 6), is_robust=False, cut=30),
        Comparison("Fig. 9", "modes", 36, 37, count, exactly(36), remark="a reason"),
    ]
    lines = markdown_table(items).splitlines()
    assert lines[2] == "| Fig. 9 | pairs | 34 \\* | 33 | 28 to 40 | within | 30 |"
    assert lines[5].startswith("- 2 numbers: 1 within what is allowed, 1 outside, 0 outside but not robust")
    assert lines[-1] == "- Fig. 9, modes: a reason."


def test_table_1_is_the_papers() -> None:
    """Each row has all hats, one per pair of the 34: l-bar = 36 + extra + 34."""
    for row in published.TABLE_1:
        assert row.n_columns == published.N_MODES + row.extra_modes + 34


def test_each_variant_has_its_folder() -> None:
    variants = [
        Variant(34),
        Variant(60),
        Variant(34, None),
        Variant(34, 1.0),
        Variant(34, 1.0, max_hats=0),
        Variant(34, extra_modes=9),
        Variant(34, side="fuel"),
        Variant(34, load="cut"),
        Variant(34, n_map=10),
        Variant(34, has_fields=True),
        Variant(None, n_clusters=3),
        Variant(None, n_clusters=4),
    ]
    assert len({variant.name for variant in variants}) == len(variants)


def test_program_is_found_by_variable_path_and_build(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program = tmp_path / "bin" / "signorom"
    program.parent.mkdir()
    program.write_text("#!/bin/sh\n")
    program.chmod(0o755)
    monkeypatch.setenv("SIGNOROM_EXECUTABLE", str(program))
    assert find_program() == program
    monkeypatch.setenv("SIGNOROM_EXECUTABLE", str(tmp_path / "missing"))
    with pytest.raises(InputError, match="the variable SIGNOROM_EXECUTABLE must be the path of the program"):
        find_program()
    monkeypatch.delenv("SIGNOROM_EXECUTABLE")
    monkeypatch.setenv("PATH", str(program.parent))
    assert find_program() == program
    monkeypatch.setenv("PATH", str(tmp_path))
    (tmp_path / "build" / "release").mkdir(parents=True)
    built = Path(shutil.copy(program, tmp_path / "build" / "release" / "signorom"))
    monkeypatch.chdir(tmp_path / "build")
    assert find_program() == built


def test_base_deck_is_that_of_the_clone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert (
        find_base_deck() == Path(__file__).resolve().parents[3] / "input" / "pellet_cladding_whole_edges.yaml"
    )


@pytest.mark.parametrize("option", [["--map", "1"], ["--jobs", "0"], ["--jobs", "x"], ["--only", "fig99"]])
def test_wrong_options(option: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        main(["paper", *option])
    assert caught.value.code == 2
    assert "usage: signorom-post paper" in capsys.readouterr().err
