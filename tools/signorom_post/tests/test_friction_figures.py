# SPDX-License-Identifier: BSD-3-Clause
"""Figures of friction: hysteresis, stick and slip over the time; and the animation of a history."""

import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest
from half_disk_results import HalfDisks, write_dataset, write_fields
from matplotlib.collections import QuadMesh
from PIL import Image

from signorom_post.cli import main
from signorom_post.errors import InputError
from signorom_post.figures import FigureOptions, history_of, write_figures
from signorom_post.plots.animation import size_of
from signorom_post.plots.stick_slip import stick_slip
from signorom_post.readers.fields import read_fields
from signorom_post.readers.histories import read_curves
from signorom_post.results import Results

# the normal force along y keeps its sign, and has the larger range
TABLE = (
    "P,time,slide,status,contact_1_area,contact_1_force_x,contact_1_force_y,contact_1_slip_share,"
    "contact_1_dissipation\n"
    '2,0.5,1,"converged",1,3,-40,0,0\n2,1,-1,"converged",1,-3,-90,1,5\n'
    '7,0.5,1,"converged",1,6,-40,0,0\n7,1,-1,"not converged",nan,nan,nan,nan,nan\n7,3,0,"converged",1,-6,-10,1,5\n'
)
#: status of the node with the number k at time t: open, sticks, slips in turns
TIMES = (0.5, 1.0, 3.0)


def status_at(disks: HalfDisks, i_time: int) -> np.ndarray:
    status = np.zeros(disks.n_nodes)
    status[disks.first_nodes] = 1 + (np.arange(disks.n_pairs) + i_time) % 3
    return status


@pytest.fixture
def history(tmp_path: Path) -> tuple[Path, HalfDisks]:
    """A folder with two points at three times each."""
    folder = tmp_path / "part"
    folder.mkdir()
    disks = HalfDisks()
    write_fields(folder / "fields.h5", disks, (0.2, 0.3, 0.4, 0.3, 0.35, 0.4))
    with h5py.File(folder / "fields.h5", "a") as file:
        for i, group in enumerate(file["points"].values()):
            group.attrs["parameter_names"] = "P time"
            group.attrs["parameters"] = [2.0 if i < 3 else 7.0, TIMES[i % 3]]
            write_dataset(group, "friction_status", status_at(disks, i % 3), "-")
    (folder / "history.csv").write_text(TABLE)
    (folder / "report.yaml").write_text(
        "deck: {units: {length: m, force: N, time: h}, mesh: {model: plane_strain}, contact: []}\n"
    )
    return folder, disks


def test_columns_of_the_loop(history: tuple[Path, HalfDisks]) -> None:
    """By default the component that changes its sign over the table that rubs; else what the user says."""
    path = history[0] / "history.csv"
    (first, second), names = read_curves(path, None, None)
    assert names == ("slide", "contact_1_force_x")
    assert (first.point, second.point) == ({"P": 2.0}, {"P": 7.0})
    assert list(first.x) == [1, -1]
    assert list(first.y) == [3, -3]
    assert np.isnan(second.y[1])
    (first, _), names = read_curves(path, "time", "contact_1_dissipation")
    assert names == ("time", "contact_1_dissipation")
    assert list(first.y) == [0, 5]
    for name in ("status", "tau_1"):
        with pytest.raises(
            InputError, match=f"there is no column '{name}' of numbers; there are P, time, slide"
        ):
            read_curves(path, name, None)
    path.write_text(TABLE.replace(",3,-40", ",3,40").replace("-3,-90", "1,-90"))
    assert read_curves(path, None, None)[1][1] == "contact_1_force_y"
    # what happens before x changes does not count, nor another contact in which friction works less; nothing turns
    path.write_text(
        "time,slide,status,contact_1_force_x,contact_1_dissipation,contact_2_force_x,contact_2_force_y,"
        "contact_2_dissipation\n1,0,a,0,0,0,-90,0\n2,0,a,9,0,0,-900,0\n3,1,a,99,1,30,-890,2\n"
    )
    assert read_curves(path, None, None)[1][1] == "contact_2_force_x"
    # two tables: the first one presses, the second one rubs
    path.write_text(
        "time,press,pull,cluster,status,contact_1_force_x,contact_1_dissipation\n"
        "1,1,0,1,a,0,1\n2,2,0,1,a,1,1\n3,2,1,1,a,9,5\n4,2,0,1,a,-9,5\n"
    )
    assert read_curves(path, None, None)[1] == ("pull", "contact_1_force_x")
    path.write_text("time,status,n_active\n1,a,2\n")
    with pytest.raises(InputError, match="there is no contact whose friction could be shown; give --y"):
        read_curves(path, None, None)
    assert read_curves(path, None, "n_active")[1] == ("time", "n_active")


def test_figures_are_drawn(history: tuple[Path, HalfDisks], tmp_path: Path) -> None:
    """Without being asked for where there is friction; labels have units."""
    results = Results(history[0])
    outcomes = {
        o.name: o.path for o in write_figures(results, tmp_path, "svg", FigureOptions(y="contact_1_force_y"))
    }
    assert outcomes["hysteresis"] == tmp_path / "hysteresis.svg"
    assert outcomes["stick_slip"] == tmp_path / "stick_slip.svg"
    text = (tmp_path / "hysteresis.svg").read_text()
    assert "contact_1_force_y [N/m]" in text
    assert "P = 7" in text
    assert "time [h]" in (tmp_path / "stick_slip.svg").read_text()


def test_no_figures_without_friction(history: tuple[Path, HalfDisks], tmp_path: Path) -> None:
    """They are left out without a word, or with a reason if they are asked for."""
    folder, disks = history
    write_fields(folder / "fields.h5", disks)
    lines = TABLE.splitlines()
    (folder / "history.csv").write_text("\n".join(line.rsplit(",", 2)[0] for line in lines) + "\n")
    names = {outcome.name for outcome in write_figures(Results(folder), tmp_path, "png", FigureOptions())}
    assert not names & {"hysteresis", "stick_slip"}
    assert "histories" in names
    wanted = FigureOptions(only=("hysteresis", "stick_slip"))
    loop, status = write_figures(Results(folder), tmp_path, "png", wanted)
    assert loop.path is not None
    assert status.reason == f"{folder / 'fields.h5'}: there is no history with friction"


def test_status_over_the_time(history: tuple[Path, HalfDisks]) -> None:
    """Each node has the color of its status; a step ends at its time."""
    folder, disks = history
    fields = read_fields(folder / "fields.h5")
    states = history_of(fields, fields.points[4])
    assert [point.parameters[0] for point in states] == [7, 7, 7]
    figure = stick_slip(fields, states, Results(folder).surfaces.surfaces, unit="h")
    (axes,) = figure.axes
    (mesh,) = (shown for shown in axes.collections if isinstance(shown, QuadMesh))
    assert list(mesh.get_coordinates()[0, :, 0]) == [0, *TIMES]
    by_place = np.argsort(disks.coordinates[disks.first_nodes, 0])
    expected = np.stack([status_at(disks, i)[disks.first_nodes][by_place] for i in range(3)], axis=1)
    np.testing.assert_array_equal(np.asarray(mesh.get_array()).reshape(-1, 3), expected)
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["open", "sticks", "slips"]
    assert axes.get_xlabel() == "time [h]"


def test_animation(
    history: tuple[Path, HalfDisks], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A picture per time of the history of a point, without ffmpeg."""
    folder, _ = history
    path = tmp_path / "new" / "moved.gif"
    command = ["animation", str(folder), "--output", str(path)]
    assert main([*command, "--color", "contact_pressure", "--point", "5", "--rate", "5"]) == 0
    assert capsys.readouterr().out == f"{path}\n"
    with Image.open(path) as gif:
        assert gif.n_frames == 3
        assert gif.info["duration"] == 200
        frames = []
        for i in range(3):
            gif.seek(i)
            frames.append(np.asarray(gif.convert("RGB"), dtype=float))
    assert abs(frames[0] - frames[2]).max() > 50
    with h5py.File(folder / "fields.h5", "a") as file:
        for group in file["points"].values():
            group.attrs["parameter_names"] = "P Q"
    assert main(["animation", str(folder)]) == 0
    with Image.open(folder / "figures" / "animation.gif") as gif:
        assert gif.n_frames == 6


def test_pictures_have_the_shape_of_the_bodies() -> None:
    """With a margin of 3 % of the larger size on each side; a tall body is as wide as its title needs."""
    assert size_of(np.array([[0.0, 0.0, 0.0], [4.0, 1.0, 0.0]]), None) == (5.0, round(5 * 1.24 / 4.24, 1))
    assert size_of(np.array([[0.0, 0.0, 0.0], [1.0, 4.0, 0.0]]), None) == (2.6, 4.2)
    # seen along z, with room for the arrows and the bar of the scale below
    width, height = size_of(np.array([[0.0, 0.0, 0.0], [1.0, 1.0, 9.0]]), np.eye(3))
    assert height / width == pytest.approx(1.35 / 1.1, rel=0.02)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--output", "a.avi"], "an animation ends in .gif or .mp4"),
        (["--color", "pressure"], "has no field 'pressure'"),
        (["--color", "reduced_domain"], "'reduced_domain' has no number or vector for each node"),
        (["--rate", "0"], "a number above 0, up to 100, is needed"),
        (["--point", "99"], "there is no point '99'"),
    ],
)
def test_animation_that_is_refused(
    history: tuple[Path, HalfDisks], arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["animation", str(history[0]), *arguments]) == 2
    assert said in capsys.readouterr().err


@pytest.mark.skipif(shutil.which("ffmpeg") is not None, reason="ffmpeg is there")
def test_film_without_ffmpeg(
    history: tuple[Path, HalfDisks], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["animation", str(history[0]), "--output", str(tmp_path / "a.mp4")]) == 2
    assert "MP4 needs the program ffmpeg, which is not installed" in capsys.readouterr().err
