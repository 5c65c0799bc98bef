# SPDX-License-Identifier: BSD-3-Clause
"""Where the program finds signorom-post for a forest, and what it says before it samples where there is none."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from program import Program
from runs import write_deck

IRREGULAR = {
    "grid: {squeeze: 7, shift: 3}": "sobol: 12",
    "reduction: {": "clusters: {number: 2, method: irregular}\nreduction: {",
}
# what it answers to --check is of no interest here, and scikit-learn takes a second to load
ABLE = f'[ "$2" = --check ] && exit 0; exec {sys.executable} -m signorom_post "$@"'
UNABLE = "echo 'no scikit-learn here' >&2; exit 2"
NOT_FOUND = "signorom-post, which trains the random forest of irregular clusters, is not found"


@pytest.fixture
def clone(signorom, tmp_path, monkeypatch):
    """A program in build/release of a folder, without signorom-post in PATH; the deck is in the folder."""
    monkeypatch.delenv("SIGNOROM_POST", raising=False)
    folders = os.environ["PATH"].split(":")
    monkeypatch.setenv(
        "PATH", ":".join(path for path in folders if not (Path(path) / "signorom-post").exists())
    )
    (tmp_path / "build" / "release").mkdir(parents=True)
    program = Program(Path(shutil.copy(signorom.executable, tmp_path / "build" / "release")))
    return program, write_deck("shifted_disks", tmp_path, **IRREGULAR).name, tmp_path


def put_tool(folder, text):
    """A shell script named signorom-post that notes its arguments beside itself: path of the notes."""
    folder.mkdir(parents=True, exist_ok=True)
    tool = folder / "signorom-post"
    tool.write_text(f'#!/bin/sh\necho "$@" >>"{folder}/calls"\n{text}\n')
    tool.chmod(0o755)
    return folder / "calls"


def no_snapshots(folder):
    """Nothing was sampled."""
    return not list(folder.glob("results/*/snapshots*"))


def test_run_refuses_before_it_samples(clone):
    program, deck, folder = clone
    done = program.run("run", deck, folder=folder)
    assert done.returncode == 2
    assert NOT_FOUND in done.stderr
    assert "hint: tools/install_dependencies.sh puts it into build/venv" in done.stderr
    assert no_snapshots(folder)


def test_check_and_sample_warn(clone):
    """Both end well: what is missing can still be mended."""
    program, deck, folder = clone
    for command in ("check", "sample"):
        done = program.run(command, deck, folder=folder)
        assert done.returncode == 0
        assert f"warning: train cannot work here yet: {NOT_FOUND}" in done.stderr
    for ranks in (1, 2):
        words = program.run("train", deck, folder=folder, n_ranks=ranks)
        assert (words.returncode, NOT_FOUND in words.stderr) == (2, True)


@pytest.mark.parametrize("place", ["build/release", "build/venv/bin", "build/release/venv/bin", "path"])
def test_tool_is_found(clone, monkeypatch, place):
    """Beside the program, in the environment of the build folder, in PATH; no word where it is there."""
    program, deck, folder = clone
    calls = put_tool(folder / place, ABLE)
    if place == "path":
        monkeypatch.setenv("PATH", f"{folder / place}:{os.environ['PATH']}")
    assert program.run("check", deck, folder=folder).stderr == ""
    assert calls.read_text() == "forest --check\n"


def test_tool_of_the_variable_wins(clone, monkeypatch):
    program, deck, folder = clone
    others = put_tool(folder / "build" / "venv" / "bin", ABLE)
    calls = put_tool(folder / "my tools", ABLE)
    monkeypatch.setenv("SIGNOROM_POST", str(folder / "my tools" / "signorom-post"))
    assert program.run("check", deck, folder=folder).stderr == ""
    assert calls.read_text() == "forest --check\n"
    assert not others.exists()
    monkeypatch.setenv("SIGNOROM_POST", str(folder / "nowhere"))
    words = program.run("run", deck, folder=folder).stderr
    assert f"SIGNOROM_POST names {folder / 'nowhere'}, which cannot be started: it, or" in words


def test_run_trains_with_the_tool_that_it_found(clone):
    program, deck, folder = clone
    calls = put_tool(folder / "build" / "venv" / "bin", ABLE)
    program("run", deck, folder=folder)
    assert "labels.csv --output" in calls.read_text()


def test_tool_without_scikit_learn_gives_way_to_another(clone, monkeypatch):
    """The one in PATH cannot; alone it is named with its message."""
    program, deck, folder = clone
    put_tool(folder / "path", UNABLE)
    monkeypatch.setenv("PATH", f"{folder / 'path'}:{os.environ['PATH']}")
    done = program.run("run", deck, folder=folder)
    assert done.returncode == 2
    assert done.stderr.startswith("no scikit-learn here\n")
    assert (
        "signorom-post is not able to train the random forest of irregular clusters; its message is printed above"
        in done.stderr
    )
    assert no_snapshots(folder)
    put_tool(folder / "build" / "venv" / "bin", ABLE)
    assert program.run("check", deck, folder=folder).stderr == ""


def test_exit_code_of_the_tool_is_seen_where_child_signals_are_ignored(clone):
    """As under some service managers: the system forgets the exit codes of children then."""
    program, deck, folder = clone
    put_tool(folder / "build" / "venv" / "bin", UNABLE)
    command = ["env", "--ignore-signal=CHLD", str(program.executable), "train", deck]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "signorom-post is not able to train the random forest" in done.stderr


@pytest.mark.parametrize("clusters", ["{number: 1, method: irregular}", "{number: 3}"])
def test_decks_that_need_no_forest_do_not_look(clone, clusters):
    program, _, folder = clone
    deck = write_deck("shifted_disks", folder, **{"reduction: {": f"clusters: {clusters}\nreduction: {{"})
    calls = put_tool(folder / "build" / "release", UNABLE)
    assert program.run("check", deck.name, folder=folder).stderr == ""
    assert not calls.exists()


def test_own_venv_is_enough(signorom, tmp_path, monkeypatch):
    """The tested program stands in build/<preset>: the environment that runs these tests is beside it."""
    venv = signorom.executable.parents[1] / "venv" / "bin" / "signorom-post"
    if not venv.is_file():
        pytest.skip("the tested program does not stand in a build folder with an environment")
    monkeypatch.setenv("PATH", "/usr/bin:/bin")
    monkeypatch.delenv("SIGNOROM_POST", raising=False)
    deck = write_deck("shifted_disks", tmp_path, **IRREGULAR)
    assert signorom.run("check", deck.name, folder=tmp_path).stderr == ""
