# SPDX-License-Identifier: BSD-3-Clause
"""Pictures by VTK: drawn without a screen, in the colors of their fields; and a script for ParaView."""

import ast
import runpy
import shutil
import sys
from dataclasses import replace
from pathlib import Path
from unittest.mock import MagicMock

import h5py
import matplotlib as mpl
import matplotlib.image
import numpy as np
import pytest
from pairs import contact_of_pairs
from test_solid_figures import cubes_with_fields

from signorom_post.arrays import Quantity
from signorom_post.cli import main
from signorom_post.errors import InputError
from signorom_post.figures import choose_point
from signorom_post.mesh import Mesh
from signorom_post.readers.fields import FieldFile, FieldPoint
from signorom_post.results import Results
from signorom_post.view import PICTURES, write_view

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


def test_nothing_touches_the_edge(view: Path) -> None:
    """Not the titles of the color bars either."""
    for path in view.glob("*.png"):
        border = matplotlib.image.imread(path)[:, :, :3].min(axis=2)
        border[15:-15, 15:-15] = 1.0
        assert (border == 1.0).all(), path.name


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


def test_script_shows_the_pictures_at_the_time_of_the_point(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A stand-in for ParaView, whose views take their time from the animation: tests/paraview has the real one."""
    (folder / "contact.xdmf").touch()
    output = tmp_path / "view"
    assert main(["view", str(folder), "--point", "3", "--output", str(output)]) == 0
    simple, times = MagicMock(), []
    simple.GetColorTransferFunction.return_value.RGBPoints = [0.0] * 8
    simple.CreateRenderView.side_effect = lambda **_: (
        times.append(simple.GetAnimationScene().AnimationTime) or MagicMock()
    )
    monkeypatch.setitem(sys.modules, "paraview", MagicMock(simple=simple))
    runpy.run_path(str(output / "in_paraview.py"))
    read = [call.kwargs["FileName"] for call in simple.Xdmf3ReaderT.call_args_list]
    assert read == [[str(folder / "fields.xdmf")], [str(folder / "contact.xdmf")]]
    pictures = {Path(call.args[0]).name for call in simple.SaveScreenshot.call_args_list}
    assert pictures == {f"paraview_{path.name}" for path in output.glob("*.png")}
    assert times == [3.0] * len(pictures)


def stretched(fields: FieldFile, factors: tuple[float, float, float], label: str = "load = 1") -> FieldFile:
    """The bodies with their coordinates times factors, and a displacement that is so large that it is not magnified."""
    mesh = replace(fields.mesh, coordinates=fields.mesh.coordinates * factors)
    displacement = Quantity(mesh.coordinates / 3, "mm")
    return replace(
        fields, mesh=mesh, points=[FieldPoint(label, [], np.empty(0), {"displacement": displacement})]
    )


LONG_LABEL = ", ".join(f"parameter_{i} = {i}00000.0 N/mm" for i in range(1, 9))


@pytest.mark.parametrize("label", ["load = 1", LONG_LABEL])
@pytest.mark.parametrize("factors", [(1, 6, 1), (6, 1, 1)], ids=["tall", "wide"])
def test_plane_bodies_fit(
    fields: FieldFile, tmp_path: Path, factors: tuple[int, int, int], label: str
) -> None:
    check_room(stretched(fields, factors, label), tmp_path)


@pytest.mark.parametrize("factors", [(1, 1, 5), (8, 1, 1), (1, 1, 1)], ids=["tall", "wide", "thick"])
def test_solid_bodies_fit(tmp_path: Path, factors: tuple[int, int, int]) -> None:
    check_room(stretched(cubes_with_fields("H8"), factors, LONG_LABEL), tmp_path)


def check_room(fields: FieldFile, folder: Path) -> None:
    """Nothing is cut off; the bodies lie below the caption and left of the color bar, and are as large as they can."""
    list(write_view(fields, fields.points[0], folder))
    picture = np.round(255 * matplotlib.image.imread(folder / "displacement.png")[:, :, :3]).astype(int)
    is_paper = picture.min(axis=2) == 255
    border = np.ones_like(is_paper)
    border[15:-15, 15:-15] = False
    assert is_paper[border].all()
    is_colored = np.ptp(picture, axis=2) > 20
    columns = np.flatnonzero(is_colored.any(axis=0))
    # the color bar is the last group of columns
    columns = columns[: np.flatnonzero(np.diff(columns) > 1)[-1] + 1]
    gap = columns[-1] + np.flatnonzero(is_paper[:, columns[-1] :].all(axis=0))
    assert gap.size, "the bodies touch the color bar or its title"
    rows = np.flatnonzero(is_colored[:, : gap[0]].any(axis=1))
    blank = np.flatnonzero(is_paper[: rows[0], : gap[0]].all(axis=1))
    # below the first blank rows is the caption, and other blank rows divide it from the bodies
    assert blank[-1] - blank[0] >= blank.size, "no caption"
    assert rows[0] - blank[-1] <= 5, "the caption touches the bodies"
    assert max(np.ptp(columns) / gap[0], np.ptp(rows) / (len(picture) - blank[-1])) > 0.85


def test_outline_at_rest_fits(fields: FieldFile, tmp_path: Path) -> None:
    """Bodies that move to the right by more than their width: their pale outline is left of all colors."""
    moved = replace(
        fields.points[0], fields={"displacement": Quantity(np.tile([3.0, 0, 0], (fields.mesh.n_nodes, 1)))}
    )
    list(write_view(replace(fields, points=[moved]), moved, tmp_path))
    picture = np.round(255 * matplotlib.image.imread(tmp_path / "displacement.png")[100:, :, :3]).astype(int)
    is_paper = picture.min(axis=2) == 255
    first_colored = np.flatnonzero((np.ptp(picture, axis=2) > 20).any(axis=0))[0]
    columns = np.flatnonzero(~is_paper.all(axis=0))
    assert columns[0] >= 15
    assert first_colored - columns[0] > 200


def plate_and_block(direction: tuple[int, int, int]) -> FieldFile:
    """A flat plate of 6 x 6 x 1 or the like in the middle, and a small block that stands off it in a direction."""
    corners = np.array(list(np.ndindex(2, 2, 2)))[[0, 4, 6, 2, 1, 5, 7, 3]] - 0.5
    axis = np.abs(direction)
    plate = corners * (6 - 5 * axis)
    block = corners + np.array(direction)
    mesh = Mesh(np.vstack([plate, block]).astype(float), [np.arange(8), np.arange(8, 16)], 3, "mm")
    point = FieldPoint("load = 1", [], np.empty(0), {"displacement": Quantity(np.zeros((16, 3)), "mm")})
    return FieldFile(
        Path("fields.h5"), mesh, [point], contact_of_pairs(np.array([0]), np.array([8]), np.ones(1))
    )


@pytest.mark.parametrize("direction", [(0, -1, 0), (0, 1, 0), (1, 0, 0), (-1, 0, 0), (0, 0, 1), (0, 0, -1)])
def test_camera_sees_the_block_on_the_plate(direction: tuple[int, int, int]) -> None:
    """The viewer is on the block's side of the plate, and above unless the block is below."""
    from signorom_post.plots.vtk_scene import Scene

    fields = plate_and_block(direction)
    towards = Scene(fields, fields.points[0], 1.0, ("", "")).camera.towards
    assert towards @ direction > 0
    if not direction[2]:
        assert towards[2] > 0


def test_chosen_camera(tmp_path: Path) -> None:
    """The script has it, too: from the focus to the camera it is the direction of the user."""
    fields = cubes_with_fields("T4")
    list(write_view(fields, fields.points[0], tmp_path, np.array([0.0, 3.0, 4.0])))
    names = {}
    for line in (tmp_path / "in_paraview.py").read_text().splitlines():
        if "view.CameraPosition" in line:
            names["position"], names["focus"] = map(np.array, ast.literal_eval(line.split(" = ")[1]))
    towards = names["position"] - names["focus"]
    np.testing.assert_allclose(towards / np.linalg.norm(towards), [0.0, 0.6, 0.8], atol=1e-12)


@pytest.mark.parametrize("text", ["1,2", "0,0,0", "a,b,c", "nan,1,1", "1,2,3,4"])
def test_wrong_direction(
    pristine: tuple[Path, object], text: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """A user's error that shows what is wanted."""
    with pytest.raises(SystemExit, match="2"):
        main(["view", str(pristine[0]), f"--camera={text}"])
    assert "give three numbers, for instance 1,-2,1" in capsys.readouterr().err


def test_wrong_point_of_many(fields: FieldFile) -> None:
    """The error names nine points and the last one."""
    many = replace(fields, points=[FieldPoint(f"load = {i}", [], np.empty(0), {}) for i in range(1, 1001)])
    with pytest.raises(InputError) as caught:
        choose_point(many, "1001")
    assert caught.value.sentence.endswith("8 (load = 8), 9 (load = 9), ..., 1000 (load = 1000)")


def test_camera_for_plane_mesh(
    pristine: tuple[Path, object], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    output = tmp_path / "view"
    assert main(["view", str(pristine[0]), "--output", str(output), "--camera=1,1,1"]) == 2
    assert "the mesh is plane" in capsys.readouterr().err
    assert not output.exists()


def test_without_vtk(
    pristine: tuple[Path, object],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """A hint, and no empty folder."""
    monkeypatch.setattr("signorom_post.view.find_spec", lambda _: None)
    output = tmp_path / "view"
    assert main(["view", str(pristine[0]), "--output", str(output)]) == 2
    assert "pip install 'vtk>=9.2'" in capsys.readouterr().err
    assert not output.exists()


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
