# SPDX-License-Identifier: BSD-3-Clause
"""Draws the set-up of a deck that `signorom check DECK --fields` wrote."""

from collections.abc import Iterator
from pathlib import Path

from signorom_post.log import Log
from signorom_post.plots.check_bodies import check_bodies
from signorom_post.plots.check_contact import check_contact
from signorom_post.readers.check import CheckFile
from signorom_post.style import save, styled

FORMATS = ("png", "pdf", "svg")


def write_pictures(check: CheckFile, output: Path, file_format: str) -> Iterator[Path]:
    """Writes a picture of the bodies with supports and loads, then one of each contact; yields the path of each.

    The pictures are in the folder `output`, which must exist. `file_format` is one of FORMATS: png, pdf, svg. OSError
    if a file cannot be written.
    """
    with styled():
        path = output / f"check_bodies.{file_format}"
        save(check_bodies(check), path)
        yield path
        for entry in range(1, len(check.names["contacts"]) + 1):
            path = output / f"check_contact_{entry}.{file_format}"
            save(check_contact(check, entry), path)
            yield path


def follow_pictures(log: Log, check: CheckFile, output: Path, file_format: str) -> Iterator[Path]:
    """Writes the pictures like `write_pictures`, yields the path of each, and shows the progress."""
    n_pictures = 1 + len(check.names["contacts"])
    return log.follow("pictures", write_pictures(check, output, file_format), n_pictures)
