# SPDX-License-Identifier: BSD-3-Clause
"""Writes the messages of a command to the terminal and, if wanted, to a file; shows the progress of long tasks."""

import os
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from datetime import datetime
from pathlib import Path
from typing import Self, TextIO, TypeVar

from signorom_post.errors import InputError

#: [s] time between two drawings of a progress bar, and between two lines of progress
BAR_INTERVAL, LINE_INTERVAL = 0.1, 10.0
BAR_COLUMNS = 30
#: [s] time between two looks at the messages of a run of the program
LOOK_INTERVAL = 0.5
Item = TypeVar("Item")


class Log:
    """Writes the messages of a command. If there is a file, it gets all messages with dates."""

    def __init__(self, path: Path | None = None) -> None:
        """Opens the file `path` to append to it, if it is given; InputError if it cannot be written."""
        self.path = path
        #: why a message could not be written to the file; the command goes on without it
        self.failure = ""
        self._file: TextIO | None = None
        self._n_status_columns = 0
        if path is not None:
            try:
                self._file = path.open("a", encoding="utf-8", buffering=1)
            except OSError as error:
                raise InputError(path, f"cannot write the log: {error.strerror}") from error

    def close(self) -> None:
        """Closes the file; later messages go to stdout and stderr only. A failure is kept in `failure`."""
        if self._file is None:
            return
        try:
            self._file.close()
        except OSError as error:
            self.failure = self.failure or str(error.strerror)
        self._file = None

    def result(self, text: object) -> None:
        """Writes a result that the user asked for to stdout, and to the file if there is one."""
        self._say(str(text), sys.stdout)

    def note(self, text: object) -> None:
        """Writes a message about progress or errors to stderr, and to the file if there is one."""
        self._say(str(text), sys.stderr)

    def to_file_only(self, text: str) -> None:
        """Writes the date and a text as a line to the file, if there is one, and nothing to the terminal."""
        if self._file is None:
            return
        date = datetime.now().astimezone().isoformat(timespec="seconds")
        try:
            self._file.write(f"{date} {text}\n")
        except OSError as error:
            self.failure = self.failure or str(error.strerror)

    def _say(self, text: str, stream: TextIO) -> None:
        self.to_file_only(text)
        self.clear_status()
        print(text, file=stream, flush=True)

    def show_status(self, text: str) -> None:
        """Writes a status line to stderr in place of the last one; the next message removes it."""
        padding = " " * max(0, self._n_status_columns - len(text))
        print(f"\r{text}{padding}", end="", file=sys.stderr, flush=True)
        self._n_status_columns = len(text)

    def clear_status(self) -> None:
        """Removes the status line from stderr, if there is one."""
        if self._n_status_columns:
            print(f"\r{' ' * self._n_status_columns}\r", end="", file=sys.stderr, flush=True)
            self._n_status_columns = 0

    def follow(
        self, label: str, items: Iterable[Item], n_total: int, place: Callable[[Item], int] | None = None
    ) -> Iterator[Item]:
        """Yields the items, and shows their progress as a bar with the name `label` if stderr is a terminal.

        `n_total` is the number of all steps. `place` returns the number of steps that are done when an item comes;
        without it, each item is one step.
        """
        with Progress(self, label, n_total, has_lines=False) as progress:
            for i, item in enumerate(items, start=1):
                progress.advance(i if place is None else place(item))
                yield item


class Progress:
    """Progress of a task: a bar with the time left if stderr is a terminal, and a line now and then.

    The lines go to the log's file and, if there is no bar, to stderr. Use it in a `with` block, which removes the bar
    at its end.
    """

    def __init__(self, log: Log, label: str, n_total: int, has_lines: bool = True) -> None:
        """Begins a task of `n_total` steps; `label` is its name, `has_lines` whether there are lines."""
        self._log = log
        self._label = label
        self._n_total = n_total
        self._n_done = 0
        self._has_lines = has_lines
        self._is_bar = sys.stderr.isatty()
        self._start = self._noted = time.monotonic()
        self._shown = 0.0
        self.advance(0)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._log.clear_status()

    def advance(self, n_done: int, detail: str = "") -> None:
        """Shows that `n_done` steps in all are done; `detail` tells what goes on. It may be called often.

        The bar is drawn again after 0.1 s at the earliest. If the task has lines, the next one comes after 10 s at the
        earliest.
        """
        self._n_done = n_done
        now = time.monotonic()
        if self._is_bar and now - self._shown >= BAR_INTERVAL:
            self._shown = now
            self._log.show_status(self._bar(now - self._start, detail))
        if self._has_lines and now - self._noted >= LINE_INTERVAL:
            self._noted = now
            say = self._log.to_file_only if self._is_bar else self._log.note
            say(self._line(now - self._start, detail))

    def _bar(self, elapsed: float, detail: str) -> str:
        """Returns `runs [=======       ] 12/31, 7 s left`; shorter on a narrow terminal, without detail or bar."""
        n_filled = int(BAR_COLUMNS * min(1.0, self._n_done / max(1, self._n_total)))
        bar = f"{'=' * n_filled}{' ' * (BAR_COLUMNS - n_filled)}"
        counts = f"{self._n_done}/{self._n_total}{self._time_left(elapsed)}"
        n_columns = _terminal_columns()
        for text in (
            f"{self._label} [{bar}] {counts}{detail and f'; {detail}'}",
            f"{self._label} [{bar}] {counts}",
        ):
            if len(text) < n_columns:
                return text
        return self._line(elapsed, detail)[: max(0, n_columns - 1)]  # one column is for the cursor

    def _line(self, elapsed: float, detail: str) -> str:
        counts = f"{self._n_done} of {self._n_total}{self._time_left(elapsed)}"
        return f"{self._label}: {counts}{detail and f'; {detail}'}"

    def _time_left(self, elapsed: float) -> str:
        """Returns such as `, 7 s left`, if the other steps take as long as those done; empty if none or all are done."""
        if not 0 < self._n_done < self._n_total:
            return ""
        return f", {duration(elapsed * (self._n_total - self._n_done) / self._n_done)} left"


def _terminal_columns() -> int:
    try:
        return os.get_terminal_size(sys.stderr.fileno()).columns or 80
    except (OSError, ValueError):
        return 80


def duration(seconds: float) -> str:
    """Returns the text of a time as the program prints it: `0.34 s`, `12 s`, `3 min 05 s`, `2 h 03 min`."""
    whole = round(seconds)
    if seconds < 9.995:
        return f"{max(seconds, 0.0):.2f} s"
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60:02d} s"
    return f"{whole // 3600} h {whole % 3600 // 60:02d} min"


def last_line(path: Path) -> str:
    """Returns the last line that is not blank in the last 1000 bytes of a file to which a program writes.

    The result is empty if there is no such line or no such file.
    """
    try:
        with path.open("rb") as file:
            file.seek(max(0, path.stat().st_size - 1000))
            lines = file.read().decode("utf-8", errors="replace").split("\n")
    except OSError:
        return ""
    return next((line.strip() for line in reversed(lines) if line.strip()), "")
