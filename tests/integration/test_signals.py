# SPDX-License-Identifier: BSD-3-Clause
"""SIGINT and SIGTERM where no point is about to be finished: in a call that waits for ever, in answers, in a helper."""

import errno
import os
import signal
import subprocess
from pathlib import Path

import pytest

from program import descendants, finish, wait_until
from runs import HERE, files_in, write_deck

# [s] the process ends itself after a second; the rest is for a busy machine. Without that it would wait for ever.
SOON = 30
LAST_WORDS = (
    "stopped by a signal: the work in progress is lost, all files are complete; run the same command again\n"
)
NO_FILE = "stopped by a signal; no file was written; if --output is a device or a pipe, answers may be missing there\n"
MESH = HERE / "meshes" / "two_blocks.msh"


@pytest.fixture
def endless_deck(tmp_path):
    """A deck whose mesh is a pipe that nobody closes: it stands for a call of a library that takes very long."""
    deck = write_deck("patch", tmp_path)
    mesh = tmp_path / "pipe.msh"
    deck.write_text(
        deck.read_text().replace(str(MESH), str(mesh)).replace("../meshes/two_blocks.msh", str(mesh))
    )
    assert str(mesh) in deck.read_text()
    os.mkfifo(mesh)
    descriptor = os.open(mesh, os.O_RDWR)
    yield deck
    os.close(descriptor)


def wait_for_reader(path, process):
    """Wait until the process, or a rank that mpirun started, has the file open."""
    wait_until(
        lambda: any(path in files_of(pid) for pid in [process.pid, *descendants(process.pid)]), process
    )


def files_of(pid):
    """Open files of a process."""
    links = []
    for link in Path(f"/proc/{pid}/fd").glob("*"):
        try:
            links.append(link.readlink())
        except OSError:  # closed meanwhile
            continue
    return links


@pytest.mark.parametrize(
    ("command", "number"), [("check", signal.SIGTERM), ("sample", signal.SIGINT), ("run", signal.SIGTERM)]
)
def test_end_in_a_call_that_does_not_return(signorom, endless_deck, command, number):
    """The same command goes on: the lock of the folder went with the process."""
    folder = endless_deck.parent
    before = files_in(folder).keys()
    process = signorom.start(command, endless_deck.name, folder=folder)
    wait_for_reader(folder / "pipe.msh", process)
    process.send_signal(number)
    done = finish(process, SOON)
    assert (done.returncode, done.stdout, done.stderr) == (130, LAST_WORDS, "")
    assert files_in(folder).keys() == before
    (folder / "pipe.msh").unlink()
    (folder / "pipe.msh").symlink_to(MESH)
    signorom(command, endless_deck.name, folder=folder)


@pytest.mark.parametrize("i_rank", [0, 2])
@pytest.mark.usefixtures("patient_mpirun")
def test_one_rank_ends_the_others(signorom, endless_deck, i_rank):
    process = signorom.start("run", endless_deck.name, folder=endless_deck.parent, n_ranks=3)
    wait_for_reader(endless_deck.parent / "pipe.msh", process)
    ranks = [pid for pid in descendants(process.pid) if is_rank(pid, signorom)]
    assert len(ranks) == 3
    os.kill(ranks[i_rank], signal.SIGTERM)
    done = finish(process, SOON)
    assert done.returncode == 130
    assert done.stdout.count(LAST_WORDS) <= 1
    assert not any(is_rank(pid, signorom) for pid in ranks)


def is_rank(pid, signorom):
    """Whether a process runs the program under test."""
    try:
        return Path(f"/proc/{pid}/exe").readlink() == signorom.executable
    except OSError:
        return False


def test_half_written_file_is_removed(signorom, tmp_path):
    """Answers wait for more points from a pipe that nobody closes: their table is there in part."""
    signorom("run", write_deck("patch", tmp_path), folder=tmp_path)
    os.mkfifo(tmp_path / "points.csv")
    descriptor = os.open(tmp_path / "points.csv", os.O_RDWR)
    before = files_in(tmp_path)
    asked = ("predict", "results/patch/model.h5", "--points", "points.csv", "--output", "answers.csv")
    process = signorom.start(*asked, folder=tmp_path)
    # more than are answered at once, and no end
    os.write(descriptor, b"push\n" + b"0.05\n" * 4500)
    wait_until((tmp_path / "answers.csv.partial").exists, process)
    process.send_signal(signal.SIGTERM)
    done = finish(process, SOON)
    os.close(descriptor)
    assert (done.returncode, done.stdout, done.stderr) == (
        130,
        NO_FILE,
        "",
    )
    assert files_in(tmp_path) == before


@pytest.fixture(scope="module")
def many_questions(signorom, tmp_path_factory):
    """Folder with a model and more points than can be answered soon."""
    folder = tmp_path_factory.mktemp("questions")
    signorom("run", write_deck("patch", folder), folder=folder)
    (folder / "points.csv").write_text("push\n" + "0.05\n" * 3000000)
    return folder


def test_end_of_answers_in_a_file(signorom, many_questions):
    asked = ("predict", "results/patch/model.h5", "--points", "points.csv", "--output", "answers.csv")
    process = signorom.start(*asked, folder=many_questions)
    wait_until((many_questions / "answers.csv.partial").exists, process)
    process.send_signal(signal.SIGTERM)
    done = finish(process, SOON)
    assert (done.returncode, done.stdout, done.stderr) == (
        130,
        NO_FILE,
        "",
    )
    assert list(many_questions.glob("answers*")) == []


def test_end_of_answers_on_standard_output(signorom, many_questions):
    """What was printed is whole lines, and it is said that lines are missing."""
    table = many_questions / "printed.csv"
    with table.open("w") as output:
        process = signorom.start(
            "predict",
            "results/patch/model.h5",
            "--points",
            "points.csv",
            folder=many_questions,
            stdout=output,
        )
        wait_until(lambda: table.stat().st_size > 0, process)
        process.send_signal(signal.SIGINT)
        done = finish(process, SOON)
    assert done.returncode == 130
    assert done.stderr == "warning: stopped by a signal; answers may be missing at the end of the table\n"
    lines = table.read_text().splitlines()
    assert 1 < len(lines) < 3000000
    assert len({line.count(",") for line in lines}) == 1


@pytest.mark.parametrize(("number", "is_check"), [(signal.SIGINT, "="), (signal.SIGTERM, "!=")])
def test_end_of_the_forest(signorom, tmp_path, monkeypatch, number, is_check):
    """The tool that trains the forest is another process: the signal reaches it, and nobody waits for it any more."""
    tools = tmp_path / "tools"
    tools.mkdir()
    text = f"#!/bin/sh\n[ $2 {is_check} --check ] || exit 0\necho $$ >'{tmp_path}/tool'\nexec sleep 1000\n"
    (tools / "signorom-post").write_text(text)
    (tools / "signorom-post").chmod(0o755)
    monkeypatch.setenv("PATH", f"{tools}:{os.environ['PATH']}")
    changes = {
        "grid: {squeeze: 7, shift: 3}": "sobol: 24, seed: 5",
        "reduction: {": "clusters: {number: 3, method: irregular, seed: 2}\nreduction: {",
    }
    deck = write_deck("shifted_disks", tmp_path, **changes)
    process = signorom.start("run", deck.name, folder=tmp_path)
    wait_until(
        lambda: (tmp_path / "tool").exists() and (tmp_path / "tool").read_text().endswith("\n"), process
    )
    process.send_signal(number)
    done = finish(process, SOON)
    assert done.returncode == 130
    assert done.stdout.endswith("stopped by a signal; there is no forest yet\n")
    assert done.stderr == ""
    assert not Path(f"/proc/{(tmp_path / 'tool').read_text().strip()}").exists()


def test_no_failure_is_told_of_files_that_the_end_removed(tmp_path):
    """A file of a process that is being ended is gone: its writer waits for the end. Other failures come back."""
    source = HERE.parents[1] / "src"
    parts = ["base/partial_files", "base/system", "files/file_system", "files/output_stream"]
    program = tmp_path / "commit_at_end"
    command = [
        "cc",
        "-std=gnu11",
        HERE / "files" / "commit_at_end.c",
        *(source / f"{part}.c" for part in parts),
    ]
    command += [f"-I{HERE.parents[1] / 'include'}", "-lpthread", "-o", program]
    subprocess.run(command, check=True)
    for ends in [[], ["ends"]]:
        (tmp_path / "part").touch()
        found = subprocess.run(
            [program, "part", "whole", *ends], cwd=tmp_path, capture_output=True, text=True
        )
        if ends:
            assert (found.returncode, found.stdout) == (-signal.SIGALRM, "")
        else:
            assert (found.returncode, found.stdout) == (0, f"{errno.ENOENT}\n")
