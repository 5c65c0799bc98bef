# SPDX-License-Identifier: BSD-3-Clause
"""Results folders shared by the tests."""

import shutil
from pathlib import Path

import pytest
from half_disk_results import HalfDisks, write_results
from matplotlib.figure import Figure

from signorom_post.readers.fields import FieldFile
from signorom_post.results import Results


@pytest.fixture(scope="session")
def pristine(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, HalfDisks]:
    """A complete results folder, not to be changed, and what it was made from."""
    folder = tmp_path_factory.mktemp("results") / "half_disks"
    return folder, write_results(folder)


@pytest.fixture
def folder(pristine: tuple[Path, HalfDisks], tmp_path: Path) -> Path:
    """A copy of the results folder that a test may damage."""
    return Path(shutil.copytree(pristine[0], tmp_path / "half_disks"))


@pytest.fixture(scope="session")
def disks(pristine: tuple[Path, HalfDisks]) -> HalfDisks:
    return pristine[1]


@pytest.fixture(scope="session")
def results(pristine: tuple[Path, HalfDisks]) -> Results:
    return Results(pristine[0])


@pytest.fixture(scope="session")
def fields(results: Results) -> FieldFile:
    return results.fields


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures are made but not drawn, which takes most of their time: their files are empty."""
    monkeypatch.setattr(Figure, "savefig", lambda _, path, **__: Path(path).write_bytes(b""))
