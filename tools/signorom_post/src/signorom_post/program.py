# SPDX-License-Identifier: BSD-3-Clause
"""Finds the program and the deck of case b; environment and end of runs of the program."""

import os
import shutil
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

from signorom_post.errors import InputError

VARIABLE = "SIGNOROM_EXECUTABLE"
BASE_DECK = Path("input/pellet_cladding_whole_edges.yaml")
#: exit codes of runs whose results can be used: 0 everything converged, 3 some points did not converge
USABLE = (0, 3)
#: environment variables with which each run uses one core
ENVIRONMENT = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "OMPI_MCA_btl_vader_single_copy_mechanism": "none",
    "HWLOC_HIDE_ERRORS": "2",
}


def find_program() -> Path:
    """Returns the path of the program; InputError if it is not found, or if SIGNOROM_EXECUTABLE names no file.

    The variable SIGNOROM_EXECUTABLE comes first, then PATH, then the folders build/* in the folders of `_roots`, with
    `release` before the others.
    """
    wanted = os.environ.get(VARIABLE)
    if wanted:
        if not Path(wanted).is_file():
            raise InputError(
                wanted, f"there is no such file; the variable {VARIABLE} must be the path of the program"
            )
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
        "signorom", f"the program is neither in PATH nor in build/*; build it, or set {VARIABLE} to its path"
    )


def find_base_deck() -> Path:
    """Returns the path of the deck of case b in a clone; InputError if none of the folders of `_roots` has it."""
    for root in _roots():
        if (root / BASE_DECK).is_file():
            return root / BASE_DECK
    raise InputError(BASE_DECK, "there is no such deck; run this in a clone of Signorom")


def _roots() -> Iterator[Path]:
    """Yields the folders that may be the clone: the current one, Python's environment, this file, and their parents."""
    for start in (Path.cwd(), Path(sys.prefix), Path(__file__).resolve()):
        yield from (start, *start.parents)


def program_environment() -> dict[str, str]:
    """Returns the environment of a run on one core: that of this process, with the variables of ENVIRONMENT.

    PATH begins with the folder of this Python, in which the program finds signorom-post to train forests.
    """
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", os.defpath)])
    return os.environ | ENVIRONMENT | {"PATH": path}


@contextmanager
def terminable() -> Iterator[None]:
    """In its `with` block, SIGTERM raises KeyboardInterrupt, so that it ends the runs as Ctrl-C does.

    Afterwards SIGTERM does what it did before. ValueError outside of the main thread.
    """

    def interrupt(_number: int, _frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)
