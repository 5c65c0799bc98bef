# SPDX-License-Identifier: BSD-3-Clause
"""Where the program writes: every write is checked, links stay, and nothing that is no plain file is replaced."""

import os
import shutil
import stat
import threading
from pathlib import Path

import pytest

from program import finish
from runs import refuse, write_deck

AT = ("--at", "push=0.05")
LOST = "standard output: error: cannot write everything: no space left on device\n"


@pytest.fixture(scope="module")
def study(signorom, tmp_path_factory):
    """Folder with a deck that was run."""
    folder = tmp_path_factory.mktemp("study")
    signorom("run", write_deck("patch", folder), folder=folder)
    return folder


@pytest.fixture
def folder(study, tmp_path):
    """A copy of it."""
    return shutil.copytree(study, tmp_path / "study")


MODEL = "results/patch/model.h5"


@pytest.mark.parametrize(
    "arguments",
    [
        ("describe", MODEL),
        ("predict", MODEL, *AT),
        ("predict", MODEL, "--points", "points.csv"),
        ("check", "patch.yaml"),
        ("solve", "patch.yaml"),
        ("train", "patch.yaml"),
        ("--help",),
        ("--version",),
    ],
    ids=" ".join,
)
def test_full_standard_output(signorom, folder, arguments):
    """The answers go to a disk that takes nothing."""
    rows = "".join(f"{0.02 + 0.08 * i / 20000:.8f}\n" for i in range(20001))
    (folder / "points.csv").write_text(f"push\n{rows}")
    with Path("/dev/full").open("w") as full:
        process = signorom.start(*arguments, folder=folder, stdout=full)
        done = finish(process, 120)
    assert done.returncode == 2
    assert done.stderr == LOST


def test_output_into_a_pipe(signorom, folder):
    """A named pipe is written to, and is still one afterwards."""
    pipe = folder / "answers"
    os.mkfifo(pipe)
    read = []
    reader = threading.Thread(target=lambda: read.append(pipe.read_text()))
    reader.start()
    signorom("predict", MODEL, *AT, "--output", "answers", folder=folder)
    reader.join(60)
    assert read == [signorom("predict", MODEL, *AT, folder=folder)]
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    assert not (folder / "answers.partial").exists()


def test_output_to_the_standard_output_by_name(signorom, folder):
    """As a pipe and as a file."""
    expected = signorom("predict", MODEL, *AT, folder=folder)
    arguments = ("predict", MODEL, *AT, "--output", "/dev/stdout", "--quiet")
    assert signorom(*arguments, folder=folder) == expected
    with (folder / "answers.csv").open("w") as file:
        finish(signorom.start(*arguments, folder=folder, stdout=file))
    assert (folder / "answers.csv").read_text() == expected


@pytest.mark.parametrize("is_there", [True, False])
def test_output_goes_through_a_link(signorom, folder, is_there):
    """The link stays; what it leads to is new."""
    (folder / "far").mkdir()
    if is_there:
        (folder / "far" / "real.csv").write_text("old\n")
    (folder / "near.csv").symlink_to("far/real.csv")
    (folder / "answers.csv").symlink_to(folder / "near.csv")
    signorom("predict", MODEL, *AT, "--output", "answers.csv", folder=folder)
    assert (folder / "answers.csv").is_symlink()
    assert (folder / "near.csv").is_symlink()
    assert (folder / "far" / "real.csv").read_text() == signorom("predict", MODEL, *AT, folder=folder)
    assert [path.name for path in (folder / "far").iterdir()] == ["real.csv"]


def test_links_round_about_are_refused(signorom, folder):
    (folder / "a.csv").symlink_to("b.csv")
    (folder / "b.csv").symlink_to("a.csv")
    words = refuse(signorom, "predict", MODEL, *AT, "--output", "a.csv", folder=folder)
    assert words.startswith("a.csv: error: cannot write here: too many levels of symbolic links")


def test_link_in_place_of_the_partial_file(signorom, folder):
    """Files grow beside their place; a link there leads nowhere."""
    victim = folder / "victim"
    victim.write_text("mine")
    for name in ("answers.csv", "results/patch/model.h5", "results/patch/enrichment.csv"):
        (folder / f"{name}.partial").symlink_to(victim)
    signorom("predict", MODEL, *AT, "--output", "answers.csv", folder=folder)
    signorom("train", "patch.yaml", folder=folder)
    assert victim.read_text() == "mine"


@pytest.mark.parametrize("kind", ["symbolic", "dangling", "hard"])
def test_lock_that_is_a_link(signorom, folder, kind):
    """The number of the process is not written into another file."""
    victim, lock = folder / "victim", folder / "results" / "patch" / ".lock"
    lock.unlink()
    if kind != "dangling":
        victim.write_text("mine")
    if kind == "hard":
        os.link(victim, lock)
    else:
        lock.symlink_to(victim)
    words = refuse(signorom, "train", "patch.yaml", folder=folder)
    assert words.startswith("results/patch: error: the file .lock of this folder is a link or no plain file")
    assert victim.exists() == (kind != "dangling")
    assert kind == "dangling" or victim.read_text() == "mine"


def test_results_behind_links(signorom, folder):
    """Large files kept on another disk stay there."""
    far = folder / "far"
    far.mkdir()
    for name in ("model.h5", "enrichment.csv"):
        path = folder / "results" / "patch" / name
        shutil.move(path, far / name)
        path.symlink_to(far / name)
        (far / name).write_text("old")
    signorom("train", "patch.yaml", folder=folder)
    assert all((folder / "results/patch" / name).is_symlink() for name in ("model.h5", "enrichment.csv"))
    assert "reduced model" in signorom("describe", far / "model.h5", folder=folder)
