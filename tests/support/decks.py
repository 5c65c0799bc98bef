# SPDX-License-Identifier: BSD-3-Clause
"""Copies of test decks, changed where a test wants them to be."""

import re
from pathlib import Path


def copy_deck(source, folder, **replacements):
    """Copy a deck into a folder with an absolute mesh path and `old` -> `new` texts replaced.

    The results of a deck in folder go to folder/results/<name> when the program runs there.
    """
    text = re.sub(
        r"\.\./\S+\.msh", lambda path: str((source.parent / path.group()).resolve()), source.read_text()
    )
    for old, new in replacements.items():
        assert old in text, f"{source.name} has no {old}"
        text = text.replace(old, new)
    path = Path(folder) / source.name
    path.write_text(text)
    return path
