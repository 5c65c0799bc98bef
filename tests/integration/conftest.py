# SPDX-License-Identifier: BSD-3-Clause
"""The program and the library under test, and where the helpers are."""

import subprocess
import sys
from pathlib import Path

import pytest

TESTS = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(TESTS / "support"), str(TESTS / "reference")]


def loadable(path):
    """The path of a shared library, unless only a program with sanitizers could load it: then the test is left out."""
    needed = subprocess.run(["ldd", path], capture_output=True, text=True, check=True).stdout
    if "libasan" in needed:
        pytest.skip("a program without sanitizers cannot load a library with them")
    return path


@pytest.fixture(scope="session")
def forest_walk(signorom):
    """Library of forest.c alone."""
    return loadable(signorom.executable.parent / "tests" / "libsig_forest_walk.so")


@pytest.fixture(scope="session")
def signorom():
    """Callable that runs the program and insists on success; `.run` takes any exit code."""
    from program import find_program

    return find_program()


@pytest.fixture
def patient_mpirun(monkeypatch):
    """mpirun as users have it: ranks that get a signal have a second to end before they are killed."""
    import program

    monkeypatch.delitem(program.ENVIRONMENT, "OMPI_MCA_odls_base_sigkill_timeout")


@pytest.fixture(scope="session")
def library(signorom):
    """The shared library beside the program."""
    path = signorom.executable.parent / "src" / "online" / "libsignorom_online.so"
    assert path.is_file(), f"{path} is missing: build the target signorom_online"
    return loadable(path)


@pytest.fixture(scope="module")
def post(library):
    """The Python package on the library under test."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SIGNOROM_LIBRARY", str(library))
        import signorom_post

        yield signorom_post
