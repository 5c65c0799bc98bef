# SPDX-License-Identifier: BSD-3-Clause
"""The command line: help, version, words that are none, options of PETSc, and what is said while the program runs."""

import fcntl
import os
import pty
import re
import select
import struct
import subprocess
import termios
import time

import pytest

from program import ENVIRONMENT, ROOT, finish, is_sanitized, kill, mpi_needs_large_files, wait_until
from runs import SOON, on_ranks, refuse, write_deck

COMMANDS = ("init", "check", "solve", "sample", "train", "validate", "run", "predict", "describe")


@pytest.mark.parametrize("n_ranks", [1, 3])
def test_version(signorom, tmp_path, n_ranks):
    version = re.search(
        r"VERSION\s+([\d.]+)", (ROOT / "CMakeLists.txt").read_text().partition("project(")[2]
    ).group(1)
    assert signorom("--version", folder=tmp_path, n_ranks=n_ranks) == f"signorom {version}\n"


def test_help_names_every_command_and_exit_code(signorom, tmp_path):
    text = signorom("--help", folder=tmp_path)
    assert all(f"  {command} " in text for command in COMMANDS)
    assert all(f"{code} " in text for code in (0, 1, 2, 3, 130))
    assert signorom("-h", folder=tmp_path) == text


@pytest.mark.parametrize("command", COMMANDS)
def test_help_about_a_command(signorom, tmp_path, command):
    text = signorom(command, "--help", folder=tmp_path)
    assert text.startswith(f"usage: signorom {command} ")
    assert "Exit codes" not in text
    for arguments in (("--help", command), ("-h", command), ("help", command)):
        assert signorom(*arguments, folder=tmp_path) == text


@pytest.mark.parametrize(
    ("arguments", "message", "n_ranks"),
    on_ranks(
        [
            (
                [],
                r"error: no command; one of init, check, solve, sample, train, validate, run, predict, describe is",
            ),
            (["chekc", "a.yaml"], r"error: unknown command 'chekc'.*\n.*did you mean 'check'"),
            (["check", "a.yaml", "--fast"], r"error: unknown option '--fast'"),
            (["check", "a.yaml", "--quite"], r"error: unknown option '--quite'\n.*did you mean '--quiet'"),
            (["--help", "chekc"], r"error: unknown command 'chekc'.*\n.*did you mean 'check'"),
            (["check"], r"error: the command check needs a deck"),
            (["predict"], r"error: the command predict needs a model"),
            (["check", "a.yaml", "b.yaml"], r"error: unexpected argument 'b.yaml'"),
            (["predict", "model.h5"], r"error: predict needs one of --at and --points"),
            (["predict", "model.h5", "--at"], r"error: the option --at needs a value"),
            (
                ["run", "a.yaml", "--at", "a=1"],
                r"error: --at goes with check, solve and predict, not with run",
            ),
            (["sample", "a.yaml", "--share", "0/4"], r"error: --share is '0/4'; it must be K/N"),
            (["sample", "a.yaml", "--share"], r"error: the option --share needs a value"),
            (["run", "a.yaml", "--share", "1/4"], r"error: --share goes with sample, not with run"),
            (["run", "a.yaml", "--strict"], r"error: --strict goes with predict, not with run"),
        ]
    ),
)
def test_wrong_words(signorom, tmp_path, arguments, message, n_ranks):
    assert re.match(message, refuse(signorom, *arguments, folder=tmp_path, n_ranks=n_ranks))


@pytest.mark.parametrize("n_ranks", [1, 3])
def test_left_over_option_of_petsc(signorom, tmp_path, n_ranks):
    deck = write_deck("patch", tmp_path)
    done = signorom.run("run", deck.name, "-nonsense", 3, folder=tmp_path, n_ranks=n_ranks, time_limit=SOON)
    assert done.returncode == 2
    assert re.search(r"error: .*-nonsense", done.stderr)


def test_left_over_option_of_petsc_in_the_deck(signorom, tmp_path):
    deck = write_deck("patch", tmp_path)
    deck.write_text(deck.read_text() + "petsc_options: -fom_ksp_ttype preonly\n")
    done = signorom.run("run", deck.name, folder=tmp_path, time_limit=SOON)
    assert done.returncode == 2
    assert re.search(r"error: .*-fom_ksp_ttype", done.stderr)


def test_option_of_petsc_with_predict(signorom, tmp_path):
    words = refuse(signorom, "predict", "model.h5", "--at", "push=0.05", "-nonsense", 3, folder=tmp_path)
    assert re.match(r"error: .* -nonsense 3\n", words)


@pytest.mark.parametrize("option", ["-fom_mat_mumps_icntl_7 2", "-fom_pc_factor_mat_solver_type petsc"])
def test_option_that_the_solver_uses(signorom, tmp_path, option):
    """It is welcome in the deck, also where a command does not solve, and on the command line."""
    deck = write_deck("patch", tmp_path)
    signorom("sample", deck.name, *option.split(), folder=tmp_path)
    deck.write_text(deck.read_text() + f"petsc_options: {option}\n")
    for command in ("check", "run"):
        signorom(command, deck.name, folder=tmp_path)


@pytest.mark.skipif(mpi_needs_large_files(), reason="Open MPI 5 keeps a folder for each process")
def test_lone_process_has_no_session_folder(signorom, tmp_path, monkeypatch):
    """Open MPI 4 would give all lone processes of a user the same one, and start some of them in vain."""
    sessions = tmp_path / "sessions"
    sessions.mkdir()
    monkeypatch.setitem(ENVIRONMENT, "OMPI_MCA_orte_tmpdir_base", str(sessions))
    deck = write_deck("patch", tmp_path, **{"grid: {push: 5}": "grid: {push: 20000}"})
    process = signorom.start("sample", deck.name, folder=tmp_path)
    try:
        wait_until((tmp_path / "results" / "patch" / ".lock").exists, process)
        assert list(sessions.iterdir()) == []
    finally:
        kill(process)
    assert list(sessions.iterdir()) == []


@pytest.mark.parametrize("limit", [250, 300, 350, 400, 420, 450])
def test_too_little_memory(signorom, tmp_path, limit):
    """[MB] OpenBLAS asks for 128 MB in a loop without an end; other libraries fail in their own way, but they end."""
    if is_sanitized(signorom.executable):
        pytest.skip("sanitizers take terabytes of address space")
    deck = write_deck("patch", tmp_path)
    command = f'ulimit -v {limit * 1000}; exec "$0" run "$1"'
    done = subprocess.run(
        ["bash", "-c", command, signorom.executable, deck.name],
        cwd=tmp_path,
        env=os.environ | ENVIRONMENT,
        capture_output=True,
        text=True,
        timeout=SOON,
    )
    sentences = ("error: too little memory", "the cause is probably too little memory", "shared librar")
    assert done.returncode == 0 or any(words in done.stderr for words in sentences), done.stderr


@pytest.mark.parametrize("n_ranks", [1, 2])
def test_file_of_options(signorom, tmp_path, n_ranks):
    """One that is missing, or holds something else, is an error of the user without a trace of PETSc."""
    deck = write_deck("patch", tmp_path)
    arguments = ("solve", deck.name, "-options_file", "options")
    words = refuse(signorom, *arguments, folder=tmp_path, n_ranks=n_ranks)
    assert words.startswith("error: PETSc refuses the options of the command line: Unable to open")
    (tmp_path / "options").write_text("some words\n")
    words = refuse(signorom, *arguments, folder=tmp_path, n_ranks=n_ranks)
    assert words.startswith("error: PETSc refuses the options of the command line: ")
    (tmp_path / "options").write_text("-fom_mat_mumps_icntl_7 2\n")
    signorom(*arguments, folder=tmp_path, n_ranks=n_ranks)


def test_option_that_writes_a_file(signorom, tmp_path):
    """On the command line it may; a deck may not (decks/invalid)."""
    deck = write_deck("patch", tmp_path)
    signorom("solve", deck.name, "-fom_ksp_view", "ascii:view.txt", folder=tmp_path)
    assert (tmp_path / "view.txt").exists()
    (tmp_path / "view.txt").unlink()
    deck.write_text(deck.read_text() + "petsc_options: '-fom_ksp_view ascii:view.txt'\n")
    assert "which may write a file" in refuse(signorom, "solve", deck.name, folder=tmp_path)
    assert not (tmp_path / "view.txt").exists()
    deck.write_text(deck.read_text().replace("ascii:view.txt", "::ascii_info"))
    signorom("solve", deck.name, folder=tmp_path)


def test_bodies_that_never_touch(signorom, tmp_path):
    """They are loaded, so this is what is said: the gap of 0.01 m does not close."""
    deck = write_deck("patch", tmp_path, **{"push: {min: 0.02, max: 0.1": "push: {min: 0.001, max: 0.009"})
    deck.write_text(deck.read_text().partition("output:")[0] + "reduction: {method: hhr}\n")
    signorom("sample", deck.name, folder=tmp_path)
    words = refuse(signorom, "train", deck.name, folder=tmp_path)
    assert "patch.yaml: error: the bodies touch at none of these training points" in words


def test_thousands_of_parameters(signorom, tmp_path):
    """As many as a deck has room for, each with a load of its own; it took 26 times as long."""
    n = 1300
    names = [f"p{i}" for i in range(n)]
    deck = write_deck(
        "patch",
        tmp_path,
        **{"grid: {push: 5}": "latin_hypercube: 5", "grid: {push: 7}": "latin_hypercube: 5"},
    )
    text = deck.read_text().partition("output:")[0]
    box = "".join(f"  {name}: {{min: 0, max: 1}}\n" for name in names)
    text = text.replace(
        "parameters: {push: {min: 0.02, max: 0.1, unit: m}}\n",
        f"parameters:\n  push: {{min: 0.02, max: 0.1}}\n{box}",
    )
    loads = "".join(f"  - {{boundary: top, traction: {{x: {name}}}}}\n" for name in names)
    deck.write_text(f"{text}loads:\n{loads}")
    done = signorom.run("check", deck.name, folder=tmp_path, time_limit=SOON)
    assert done.returncode == 0, done.stderr
    assert "p1299" in done.stdout


def test_quiet(signorom, tmp_path):
    deck = write_deck("patch", tmp_path)
    done = signorom.run("run", deck.name, "--quiet", folder=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert (tmp_path / "results" / "patch" / "report.yaml").is_file()
    words = refuse(signorom, "check", "nothing.yaml", "--quiet", folder=tmp_path)
    assert words.startswith("nothing.yaml: error: ")


def test_log_without_terminal_is_sparse(signorom, tmp_path):
    """No bar, no control characters, a handful of lines."""
    deck = write_deck(
        "patch", tmp_path, **{"grid: {push: 5}": "grid: {push: 3000}", "grid: {push: 7}": "grid: {push: 500}"}
    )
    done = signorom.run("run", deck.name, folder=tmp_path)
    assert done.returncode == 0
    assert done.stderr == ""
    assert re.search(r"^sampling: 3000 of 3000 in ", done.stdout, re.MULTILINE)
    assert len(done.stdout.splitlines()) < 24  # the table of errors has eleven
    assert not re.search(r"[\x00-\x09\x0b-\x1f]", done.stdout)


def test_bar_on_a_terminal(signorom, tmp_path):
    """stderr is a terminal: a bar with counts and time left is drawn over itself, and is gone at the end."""
    deck = write_deck("patch", tmp_path, **{"grid: {push: 5}": "grid: {push: 1000}"})
    deck.write_text(deck.read_text() + "solver: {type: active_set}\n")
    master, slave = pty.openpty()
    process = signorom.start("sample", deck.name, folder=tmp_path, stderr=slave)
    os.close(slave)
    drawn = read_terminal(master)
    done = finish(process)
    assert done.returncode == 0
    assert re.search(r"\rsampling \[=+ +\] \d+/1000, [\d.]+ (s|min \d+ s) left", drawn)
    assert drawn.endswith("\r")
    assert re.search(r"^sampling: 1000 of 1000 in ", done.stdout, re.MULTILINE)


def test_progress_fits_a_narrow_terminal(signorom, tmp_path):
    """Without the bar, and never wider than the terminal."""
    deck = write_deck("patch", tmp_path, **{"grid: {push: 5}": "grid: {push: 1000}"})
    deck.write_text(deck.read_text() + "solver: {type: active_set}\n")
    n_columns = 40
    master, slave = pty.openpty()
    fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 24, n_columns, 0, 0))
    process = signorom.start("sample", deck.name, folder=tmp_path, stderr=slave)
    os.close(slave)
    drawn = read_terminal(master)
    assert finish(process).returncode == 0
    assert re.search(r"\rsampling: \d+ of 1000, [\d.]+ (s|min \d+ s) left", drawn)
    assert max(map(len, drawn.split("\r"))) < n_columns


@pytest.mark.parametrize("n_ranks", [1, 2])
def test_log_file(signorom, tmp_path, n_ranks):
    """All that is said, once and with a date; a second command adds its own, and --quiet changes nothing in it."""
    deck = write_deck("small_disks", tmp_path)
    said = signorom("sample", deck.name, "--log", "run.log", folder=tmp_path, n_ranks=n_ranks)
    logged = (tmp_path / "run.log").read_text()
    assert re.sub(r"(?m)^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d[+-]\d\d:\d\d ", "", logged) == said
    assert signorom("train", deck.name, "--quiet", "--log", "run.log", folder=tmp_path, n_ranks=n_ranks) == ""
    longer = (tmp_path / "run.log").read_text()
    assert longer.startswith(logged)
    assert "trained" in longer[len(logged) :]


def test_log_that_cannot_be_written(signorom, tmp_path):
    """A user's error before any work is done."""
    deck = write_deck("small_disks", tmp_path)
    said = refuse(signorom, "sample", deck.name, "--log", "missing/run.log", folder=tmp_path, n_ranks=2)
    assert "missing/run.log: error: cannot write the log: no such file or directory" in said


def read_terminal(master):
    """Everything that the program draws until it closes the terminal."""
    drawn = b""
    start = time.monotonic()
    while time.monotonic() - start < SOON:
        if not select.select([master], [], [], 1)[0]:
            continue
        try:
            drawn += os.read(master, 65536)
        except OSError:  # Linux says so when the other side is closed
            break
    os.close(master)
    return drawn.decode()
