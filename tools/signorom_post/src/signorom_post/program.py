# SPDX-License-Identifier: BSD-3-Clause
"""Where the program and the deck of case b are, and how the program is started and ended."""

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
#: exit codes of a run whose results can be used: all done; done, but some points did not converge
USABLE = (0, 3)
#: one core per run
ENVIRONMENT = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "OMPI_MCA_btl_vader_single_copy_mechanism": "none",
    "HWLOC_HIDE_ERRORS": "2",
}


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


def program_environment() -> dict[str, str]:
    """The program starts the tool that trains the forest: the one that runs now."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", os.defpath)])
    return os.environ | ENVIRONMENT | {"PATH": path}


@contextmanager
def terminable() -> Iterator[None]:
    """SIGTERM ends the runs as Ctrl-C does."""

    def interrupt(_number: int, _frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)
