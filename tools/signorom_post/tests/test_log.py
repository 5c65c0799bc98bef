# SPDX-License-Identifier: BSD-3-Clause
"""What commands say, the file that keeps it, and progress on terminals."""

import fcntl
import io
import os
import pty
import re
import struct
import subprocess
import sys
import termios
from pathlib import Path

import pytest

from signorom_post import log
from signorom_post.cli import main
from signorom_post.log import Log, Progress, duration, last_line

DATE = re.compile(r"(?m)^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d[+-]\d\d:\d\d ")
REFUSED = "there is no such folder"


@pytest.mark.usefixtures("undrawn")
def test_file_has_all_that_is_said(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """With dates; errors, too; a second command goes on in the same file."""
    file = tmp_path / "said.log"
    (folder / "fields.h5").unlink()
    assert main(["figures", str(folder), "--log", str(file)]) == 0
    said = capsys.readouterr()
    assert said.err == ""
    assert "left out: multipliers" in said.out
    assert DATE.sub("", file.read_text()) == said.out
    assert len(DATE.findall(file.read_text())) == len(said.out.splitlines())
    before = file.read_text()
    assert main(["summary", str(tmp_path / "nothing"), "--log", str(file)]) == 2
    assert DATE.sub("", file.read_text().removeprefix(before)) == capsys.readouterr().err
    assert REFUSED in file.read_text()


def test_log_that_cannot_be_written(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A user's error, before any work."""
    path = tmp_path / "missing" / "said.log"
    assert main(["report", str(folder), "--log", str(path)]) == 2
    assert capsys.readouterr().err == f"{path}: error: cannot write the log: No such file or directory\n"
    assert not (folder / "report.html").exists()


@pytest.mark.usefixtures("undrawn")
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full")
def test_full_disk_under_the_log_does_not_end_the_work(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["report", str(folder), "--log", "/dev/full"]) == 2
    assert (folder / "report.html").is_file()
    assert capsys.readouterr().err == "/dev/full: error: cannot write everything: No space left on device\n"


class Terminal(io.StringIO):
    """Standard error that calls itself a terminal; without a width of its own it has 80 columns."""

    def isatty(self) -> bool:
        return True


def drawn(monkeypatch: pytest.MonkeyPatch, stream: io.StringIO, times: list[float], detail: str = "") -> str:
    """What eight steps draw, the k-th of which ends at the k-th time [s]."""
    clock = iter([0.0, 0.0, *times])
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setattr(log.time, "monotonic", lambda: next(clock))
    with Progress(Log(), "runs", 8) as progress:
        for k in range(1, len(times) + 1):
            progress.advance(k, detail)
    return stream.getvalue()


def test_bar_tells_the_time_left(monkeypatch: pytest.MonkeyPatch) -> None:
    """2 of 8 steps in 10 s: the other 6 take 30 s. 7 of 30 columns are 2/8 of the bar. It is gone at the end."""
    frames = drawn(monkeypatch, Terminal(), [5.0, 10.0]).split("\r")
    assert frames[-2:] == [" " * len(frames[-2]), ""]
    assert f"runs [{'=' * 7}{' ' * 23}] 2/8, 30 s left" in [frame.rstrip() for frame in frames]


def test_detail_is_shown_where_there_is_room(monkeypatch: pytest.MonkeyPatch) -> None:
    assert "1/8, 35 s left; sampling: 3 of 9" in drawn(monkeypatch, Terminal(), [5.0], "sampling: 3 of 9")
    assert "sampling" not in drawn(monkeypatch, Terminal(), [5.0], "sampling " * 10)


def test_lines_without_a_terminal_are_sparse(monkeypatch: pytest.MonkeyPatch) -> None:
    """At most one each ten seconds; none for what is short."""
    said = drawn(monkeypatch, io.StringIO(), [4.0, 8.0, 12.0, 16.0, 24.0])
    assert said == "runs: 3 of 8, 20 s left\nruns: 5 of 8, 14 s left\n"
    assert drawn(monkeypatch, io.StringIO(), [1.0, 2.0]) == ""


def test_bar_fits_a_narrow_terminal(folder: Path, tmp_path: Path) -> None:
    """The whole command on a terminal of 24 columns; the bar needs more and is left out."""
    n_columns = 24
    master, slave = pty.openpty()
    fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 24, n_columns, 0, 0))
    command = [sys.executable, "-m", "signorom_post", "report", str(folder), "--log", str(tmp_path / "log")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=slave) as process:
        os.close(slave)
        said = b""
        try:
            while part := os.read(master, 4096):
                said += part
        except OSError:  # so Linux ends a terminal that nobody writes to any more
            pass
        assert process.stdout is not None
        assert process.stdout.read().decode() == f"{folder / 'report.html'}\n"
    assert process.returncode == 0
    frames = said.decode().split("\r")
    assert any(re.match(r"figures: \d+ of \d+", frame) for frame in frames)
    assert max(map(len, frames)) < n_columns
    assert frames[-1] == ""
    assert DATE.sub("", (tmp_path / "log").read_text()) == f"{folder / 'report.html'}\n"


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.344, "0.34 s"), (12.4, "12 s"), (185.0, "3 min 05 s"), (7380.0, "2 h 03 min")],
)
def test_durations_are_those_of_the_program(seconds: float, text: str) -> None:
    assert duration(seconds) == text


def test_last_line_of_a_file(tmp_path: Path) -> None:
    path = tmp_path / "log.txt"
    assert last_line(path) == ""
    path.write_text("first\n" + "x" * 5000 + "\nsampling: 3 of 9\n\n")
    assert last_line(path) == "sampling: 3 of 9"
