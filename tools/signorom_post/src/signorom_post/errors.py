# SPDX-License-Identifier: BSD-3-Clause
"""What can be wrong with the files that the user gives."""

from pathlib import Path


class InputError(Exception):
    """A file that cannot be used: one sentence, begun by the name of the file."""

    def __init__(self, path: Path | str, sentence: str) -> None:
        super().__init__(f"{path}: error: {sentence}")
        self.path = Path(path)
        self.sentence = sentence


class MissingFileError(InputError):
    """A file that is not there; figures that need it are left out, which is no failure."""
