# SPDX-License-Identifier: BSD-3-Clause
"""Where the program and the deck of case b are."""

import os
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

from signorom_post.errors import InputError

VARIABLE = "SIGNOROM_EXECUTABLE"
BASE_DECK = Path("input/pellet_cladding_whole_edges.yaml")


def find_program() -> Path:
    """The program by the variable SIGNOROM_EXECUTABLE, then in PATH, then in a build folder, release first."""
    wanted = os.environ.get(VARIABLE)
    if wanted:
        if not Path(wanted).is_file():
            raise InputError(wanted, f"there is no such program; the variable {VARIABLE} names it")
        return Path(wanted).resolve()
    in_path = shutil.which("signorom")
    if in_path:
        return Path(in_path).resolve()
    for root in _roots():
        built = [root / "build" / "release" / "signorom", *sorted(root.glob("build/*/signorom"))]
        for path in built:
            if path.is_file():
                return path
    raise InputError(
        "signorom", f"the program is neither in {VARIABLE} nor in PATH nor in build/; build it first"
    )


def find_base_deck() -> Path:
    """The deck of case b in the clone that holds the current folder or this package."""
    for root in _roots():
        if (root / BASE_DECK).is_file():
            return root / BASE_DECK
    raise InputError(BASE_DECK, "there is no such deck; run this in a clone of Signorom")


def _roots() -> Iterator[Path]:
    """Folders that may be the clone: the current one, that of the environment and of this file, upwards."""
    for start in (Path.cwd(), Path(sys.prefix), Path(__file__).resolve()):
        yield from (start, *start.parents)
