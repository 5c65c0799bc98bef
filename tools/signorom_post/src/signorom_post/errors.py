# SPDX-License-Identifier: BSD-3-Clause
"""Errors of the files that the user gives."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


class InputError(Exception):
    """What the user gave, mostly a file, cannot be used. The message is `<file or command>: error: <sentence>`."""

    def __init__(self, path: Path | str, sentence: str) -> None:
        super().__init__(f"{path}: error: {sentence}")
        self.path = Path(path)
        self.sentence = sentence


@contextmanager
def writing(what: str, place: Path) -> Iterator[None]:
    """Turns an OSError in its `with` block into an InputError with the sentence `<what> cannot be written (reason)`.

    The InputError names the file of the OSError, or `place` if this has none.
    """
    try:
        yield
    except BrokenPipeError:  # of the terminal, not of the file
        raise
    except OSError as error:
        raise InputError(error.filename or place, f"{what} cannot be written ({error.strerror})") from error


class MissingFileError(InputError):
    """A file is missing. The command `figures` leaves out the figures that need it, and does not fail because of it."""
