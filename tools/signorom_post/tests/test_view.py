# SPDX-License-Identifier: BSD-3-Clause
"""Pictures by VTK: drawn without a screen, in the colors of their fields; and a script for ParaView."""

import ast
import shutil
from pathlib import Path

import h5py
import matplotlib as mpl
import matplotlib.image
import numpy as np
import pytest

from signorom_post.cli import main
from signorom_post.results import Results
from signorom_post.view import PICTURES

pytest.importorskip("vtk")


@pytest.fixture(scope="module")
def view(pristine: tuple[Path, object], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The pictures of the half disks."""
    output = tmp_path_factory.mktemp("view")
    assert main(["view", str(pristine[0]), "--output", str(output)]) == 0
    return output


def test_picture_of_each_field(view: Path, results: Results) -> None:
    """Of those that the point has."""
    point = results.fields.points[len(results.fields.points) // 2]
    expected = {f"{name}.png" for name, (field, _) in PICTURES.items() if field in point.fields}
    assert expected
    assert {path.name for path in view.glob("*.png")} == expected


def test_colors_are_those_of_the_field(view: Path) -> None:
    """Plane bodies show viridis and nothing between its colors and the paper: no light falls on them."""
    picture = matplotlib.image.imread(view / "displacement.png")
    pixels = np.round(255 * picture[:, :, :3]).reshape(-1, 3).astype(int)
    colored = pixels[np.ptp(pixels, axis=1) > 20]
    assert len(colored) > 0.05 * len(pixels)
    table = np.round(255 * mpl.colormaps["viridis"](np.linspace(0, 1, 256))[:, :3]).astype(int)
    kinds, counts = np.unique(colored, axis=0, return_counts=True)
    away = np.abs(kinds[:, None] - table[None]).max(axis=2).min(axis=1)
    # the rest are the rims of edges and letters
    assert counts[away <= 2].sum() >= 0.97 * counts.sum()


def test_script_for_paraview(view: Path, pristine: tuple[Path, object]) -> None:
    """Python that names the file and a point of it."""
    text = (view / "in_paraview.py").read_text()
    ast.parse(text)
    assert str(pristine[0] / "fields.xdmf") in text
    assert "TIME = " in text


def test_file_without_points(
    pristine: tuple[Path, object], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A sentence and the exit code of a user's error."""
    shutil.copytree(pristine[0], tmp_path / "empty")
    with h5py.File(tmp_path / "empty" / "fields.h5", "a") as file:
        for name in list(file["points"]):
            del file["points"][name]
    assert main(["view", str(tmp_path / "empty")]) == 2
    assert "fields.h5: error: there is no parameter point" in capsys.readouterr().err


def test_wrong_point(
    pristine: tuple[Path, object], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A user's error that names the points."""
    assert main(["view", str(pristine[0]), "--output", str(tmp_path), "--point", "99"]) == 2
    assert "there is no point '99'" in capsys.readouterr().err
