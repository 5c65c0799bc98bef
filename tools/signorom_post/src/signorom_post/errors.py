# SPDX-License-Identifier: BSD-3-Clause
"""What can be wrong with the files that the user gives."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


class InputError(Exception):
    """A file that cannot be used: one sentence, begun by the name of the file."""

    def __init__(self, path: Path | str, sentence: str) -> None:
        super().__init__(f"{path}: error: {sentence}")
        self.path = Path(path)
        self.sentence = sentence


@contextmanager
def writing(what: str, place: Path) -> Iterator[None]:
    """Files that cannot be written below a place are an InputError: `<what> cannot be written`."""
    try:
        yield
    except OSError as error:
        raise InputError(error.filename or place, f"{what} cannot be written ({error.strerror})") from error


class MissingFileError(InputError):
    """A file that is not there; figures that need it are left out, which is no failure."""
