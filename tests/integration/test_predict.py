# SPDX-License-Identifier: BSD-3-Clause
"""The command predict: a model file is all it needs, its answers are those of validate, bad input is named."""

import os
import re
import resource
import shutil
import subprocess

import h5py
import numpy as np
import pytest

from program import finish, mpi_needs_large_files
from results import read_table, table_of
from runs import on_ranks, refuse, write_deck
from seals import change

# [-] the program computes both from the same blocks
SAME = 1e-12


@pytest.fixture(scope="module")
def study(signorom, tmp_path_factory):
    """Folder of a finished run with errors that are not rounding."""
    folder = tmp_path_factory.mktemp("study")
    changes = {
        "points: [{squeeze: 0.2, shift: 0.03}]": "points: [{squeeze: 0.2, shift: 0.03}, {squeeze: 0.41, shift: 0.0}]"
    }
    deck = write_deck("shifted_disks", folder, **changes)
    signorom("run", deck.name, folder=folder)
    return folder / "results" / "shifted_disks"


@pytest.fixture
def model_folder(study, tmp_path):
    """A folder with model.h5 and nothing else."""
    shutil.copy(study / "model.h5", tmp_path)
    return tmp_path


def multipliers(table):
    """Columns lambda_* as an array (n_points, n_multipliers)."""
    return np.column_stack([values for name, values in table.items() if name.startswith("lambda_")])


@pytest.mark.parametrize("n_ranks", [1, 3])
def test_needs_neither_deck_nor_mesh(signorom, model_folder, n_ranks):
    table = table_of(
        signorom(
            "predict", "model.h5", "--at", "squeeze=0.2,shift=0.03", folder=model_folder, n_ranks=n_ranks
        )
    )
    assert table["squeeze"] == [0.2]
    assert table["shift"] == [0.03]
    assert table["contact_force"] > 0
    assert table["status"] == ["answered"]
    assert sorted(path.name for path in model_folder.iterdir()) == ["model.h5"]


def test_agrees_with_the_fields(signorom, study, model_folder):
    """The reduced multipliers of fields.h5, which `run` wrote with mesh and deck at hand."""
    with h5py.File(study / "fields.h5") as file:
        for point in file["points"].values():
            squeeze, shift = point.attrs["parameters"]
            at = f"squeeze={squeeze!r},shift={shift!r}".replace("np.float64(", "").replace(")", "")
            table = table_of(signorom("predict", "model.h5", "--at", at, folder=model_folder))
            expected = point["multipliers_reduced"][()]
            np.testing.assert_allclose(multipliers(table)[0], expected, rtol=0, atol=SAME * expected.max())
            assert table["contact_force"][0] == pytest.approx(expected.sum(), rel=SAME)
            assert table["n_active"][0] == (expected > 0).sum()


def test_many_points_agree_with_the_validation(signorom, study, model_folder):
    """Same solver, same points in the same order, errors that full-order solutions of the snapshots confirm."""
    validation = read_table(study / "validation.csv")
    points = "\n".join(
        f"{shift},{squeeze}"
        for squeeze, shift in zip(validation["squeeze"], validation["shift"], strict=True)
    )
    (model_folder / "points.csv").write_text(f"shift,squeeze\n{points}\n")
    table = table_of(signorom("predict", "model.h5", "--points", "points.csv", folder=model_folder))
    for name in ("squeeze", "shift", "cluster"):
        np.testing.assert_array_equal(table[name], validation[name])
    assert table["solver"] == validation["solver"]
    # squeeze = 0.15, 0.3, 0.45 and the outer shifts are training points as well: the error is known from the snapshots
    found = multipliers(table)
    with h5py.File(study / "snapshots.h5") as file:
        parameters, full_order = file["parameters"][()], file["multipliers"][()]
    n_compared = 0
    for i, point in enumerate(zip(table["squeeze"], table["shift"], strict=True)):
        for k in np.flatnonzero(np.abs(parameters - point).max(axis=1) < 1e-12):
            error = np.linalg.norm(found[i] - full_order[k]) / np.linalg.norm(full_order[k])
            assert error == pytest.approx(validation["e_lambda_all"][i], rel=1e-5)
            n_compared += 1
    assert n_compared == 6


def test_one_point_and_many_agree(signorom, model_folder):
    (model_folder / "points.csv").write_text("squeeze,shift\n0.2,0.03\n0.4,-0.01\n")
    many = signorom("predict", "model.h5", "--points", "points.csv", folder=model_folder).splitlines()
    one = signorom(
        "predict", "model.h5", "--at", "shift=-0.01", "--at", "squeeze=0.4", folder=model_folder
    ).splitlines()
    assert many[0] == one[0]
    assert many[2] == one[1]
    signorom("predict", "model.h5", "--points", "points.csv", "--output", "answers.csv", folder=model_folder)
    assert (model_folder / "answers.csv").read_text().splitlines() == many


@pytest.mark.parametrize("n_ranks", [1, 3])
def test_point_outside_the_box(signorom, model_folder, n_ranks):
    """A warning and an answer; with --strict an error and none."""
    arguments = ("predict", "model.h5", "--at", "squeeze=0.5,shift=0.03")
    done = signorom.run(*arguments, folder=model_folder, n_ranks=n_ranks)
    assert done.returncode == 0
    assert table_of(done.stdout)["squeeze"] == [0.5]
    box = "(squeeze from 0.15 to 0.45, shift from -0.05 to 0.1)"
    sentence = f"squeeze = 0.5, shift = 0.03 lies outside the trained box {box}"
    assert done.stderr.startswith(f"warning: {sentence}")
    words = refuse(signorom, *arguments, "--strict", folder=model_folder, n_ranks=n_ranks)
    assert words.startswith(f"model.h5: error: {sentence}")


def test_strict_list_with_one_point_outside(signorom, model_folder):
    """Nothing is written when one of many points is refused."""
    (model_folder / "points.csv").write_text("squeeze,shift\n0.2,0.03\n0.5,-0.01\n")
    arguments = ("predict", "model.h5", "--points", "points.csv", "--output", "answers.csv")
    refuse(signorom, *arguments, "--strict", folder=model_folder)
    done = signorom.run(*arguments, folder=model_folder)
    assert done.returncode == 0
    assert done.stderr.count("warning: ") == 1
    assert len(read_table(model_folder / "answers.csv")["squeeze"]) == 2


@pytest.mark.parametrize("at", ["squeeze=0.15,shift=-0.05", "squeeze=0.45,shift=0.1"])
def test_corner_of_the_box_is_inside(signorom, model_folder, at):
    done = signorom.run("predict", "model.h5", "--at", at, "--strict", folder=model_folder)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize(
    ("at", "message", "n_ranks"),
    on_ranks(
        [
            ("squeeze=0.2", "error: --at squeeze=0.2 gives no value for shift"),
            (
                "squeez=0.2,shift=0",
                "error: unknown parameter 'squeez' in --at; the parameters are squeeze, shift",
            ),
            ("squeeze=0.2,shift=a", "error: --at: 'a' is not a number"),
            ("squeeze=0.2,shift=nan", "error: --at: 'nan' is not a number"),
            ("squeeze=0.2,shift=1e999", "error: --at: '1e999' is not a number"),
            ("squeeze=0.2,shift=", "error: --at: '' is not a number"),
            ("squeeze=0.2,squeeze=0.3", "error: --at gives squeeze twice"),
            ("0.2,0.3", "error: --at needs name=value, not '0.2'"),
        ]
    ),
)
def test_wrong_point(signorom, model_folder, at, message, n_ranks):
    assert refuse(
        signorom, "predict", "model.h5", "--at", at, folder=model_folder, n_ranks=n_ranks
    ).startswith(message)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("squeeze,shift\n0.2,0.1\n0.2,a\n", r"points.csv:3:5: error: .*'a'"),
        ("squeeze,shift\n0.2,0.1\n0.2\n", r"points.csv:3\S* error: "),
        ("squeeze\n0.2\n", r"points.csv:1\S* error: .*shift"),
        ("squeeze,shift,speed\n0.2,0.1,0\n", r"points.csv:1:15: error: .*'speed'"),
        ("squeeze,shift,shift\n0.2,0.1,0\n", r"points.csv:1\S* error: .*shift"),
        ("squeeze,shift\n", r"points.csv\S* error: "),
        ("", r"points.csv: error: .*empty"),
        ("\x00\x01\x02", r"points.csv: error: "),
        (None, r"points.csv: error: .*no such file"),
    ],
    ids=["word", "short_line", "missing", "unknown", "twice", "no_points", "empty", "binary", "no_file"],
)
def test_wrong_list_of_points(signorom, model_folder, content, message):
    if content is not None:
        (model_folder / "points.csv").write_text(content)
    words = refuse(signorom, "predict", "model.h5", "--points", "points.csv", folder=model_folder)
    assert re.match(message, words), words


def test_list_with_quotes(signorom, model_folder):
    """As write.csv of R makes it."""
    answers = []
    for content in (
        "squeeze,shift\n0.2,0.1\n",
        '"squeeze","shift"\n0.2,0.1\n',
        '\ufeff"shift","squeeze"\r\n"0.1","0.2"\r\n',
    ):
        (model_folder / "points.csv").write_text(content, encoding="utf-8", newline="")
        answers.append(signorom("predict", "model.h5", "--points", "points.csv", folder=model_folder))
    assert answers[1:] == answers[:1] * 2


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (
            "squeeze;shift\n0.2;0.1\n",
            r"points.csv:1:1: error: unknown column 'squeeze;shift'[^$]*separate the values",
        ),
        (
            "squeeze,shift\n0.2;0.1\n",
            r"points.csv:2:1: error: [^$]*separate the values",
        ),
        (
            '"","squeeze","shift"\n"1",0.2,0.1\n',
            r"points.csv:1:1: error: unknown column ''[^$]*row.names = FALSE",
        ),
        ("squeeze,shift\n0,2,0,1\n", r"points.csv:2:5: error: .*4 values[^$]*write decimals with a point"),
    ],
    ids=["semicolons", "semicolons_below", "row_names", "decimal_commas"],
)
def test_list_of_a_spreadsheet_gets_a_hint(signorom, model_folder, content, message):
    (model_folder / "points.csv").write_text(content)
    words = refuse(signorom, "predict", "model.h5", "--points", "points.csv", folder=model_folder)
    assert re.match(message, words), words


def put_version(version):
    """How to say that another version wrote the file."""

    def how(file):
        file.attrs["format_version"] = np.asarray(version, dtype=file.attrs["format_version"].dtype)

    return how


def lose(file):
    """One dataset less."""
    del file["clusters/1/contact_matrix"]


@pytest.mark.parametrize(
    ("how", "message", "n_ranks"),
    on_ranks(
        [
            (put_version(99), "version"),
            (put_version(0), "version"),
            (lose, "contact_matrix"),
        ]
    ),
    ids=["newer_version", "older_version", "lost_dataset", "newer_version_on_three_ranks"],
)
def test_model_that_cannot_be_read(signorom, model_folder, how, message, n_ranks):
    change(model_folder / "model.h5", how)
    words = refuse(
        signorom, "predict", "model.h5", "--at", "squeeze=0.2,shift=0", folder=model_folder, n_ranks=n_ranks
    )
    assert words.startswith("model.h5: error: ")
    assert any(part in words for part in message.split("|")), words


def test_model_that_was_changed(signorom, model_folder):
    """One bit in one block."""
    with h5py.File(model_folder / "model.h5", "r+") as file:
        file["clusters/1/reduced_stiffness"][0, 0] *= 1.0 + 1e-15
    words = refuse(signorom, "predict", "model.h5", "--at", "squeeze=0.2,shift=0", folder=model_folder)
    assert words.startswith("model.h5: error: the file was changed or damaged")


@pytest.mark.parametrize("n_ranks", [1, 3])
@pytest.mark.parametrize(
    "kind", ["text", "empty", "foreign", "truncated", "snapshots", "directory", "missing"]
)
def test_file_that_is_no_model(signorom, study, tmp_path, kind, n_ranks):
    path = tmp_path / "model.h5"
    if kind in ("text", "empty"):
        path.write_text("squeeze: 0.2\n" if kind == "text" else "")
    elif kind == "foreign":
        with h5py.File(path, "w") as file:
            file["something"] = np.arange(3)
    elif kind == "truncated":
        content = (study / "model.h5").read_bytes()
        path.write_bytes(content[: len(content) // 2])
    elif kind == "snapshots":
        shutil.copy(study / "snapshots.h5", path)
    elif kind == "directory":
        path.mkdir()
    words = refuse(
        signorom, "predict", "model.h5", "--at", "squeeze=0.2,shift=0", folder=tmp_path, n_ranks=n_ranks
    )
    assert words.startswith("model.h5: error: ")
    assert "HDF5-DIAG" not in words


def test_output_that_cannot_be_written(signorom, model_folder):
    (model_folder / "taken").mkdir()
    for output in ("taken", "nowhere/answers.csv"):
        arguments = ("--at", "squeeze=0.2,shift=0", "--output", output)
        words = refuse(signorom, "predict", "model.h5", *arguments, folder=model_folder)
        assert words.startswith(f"{output}: error: ")


@pytest.mark.skipif(mpi_needs_large_files(), reason="this MPI cannot start with small files")
def test_full_disk(signorom, model_folder):
    """A file that may not grow stands for it: a sentence, and no half table under the name that was asked for."""
    points = "".join(f"{0.15 + 0.3 * i / 999},0\n" for i in range(1000))
    (model_folder / "points.csv").write_text(f"squeeze,shift\n{points}")
    arguments = ("predict", "model.h5", "--points", "points.csv", "--output", "answers.csv")
    process = signorom.start(*arguments, folder=model_folder)
    resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (20000, 20000))
    done = finish(process, 60)
    assert done.returncode == 2, done.stderr
    assert done.stderr.startswith("answers.csv: error: ")
    assert sorted(path.name for path in model_folder.iterdir()) == ["model.h5", "points.csv"]


def test_points_from_a_pipe(signorom, model_folder):
    """The standard input, and a named pipe that is filled bit by bit."""
    lines = ["squeeze,shift\n", "0.2,0\n", "0.3,", "0.05\n# the end"]
    (model_folder / "points.csv").write_text("".join(lines))
    expected = signorom("predict", "model.h5", "--points", "points.csv", folder=model_folder)
    process = signorom.start(
        "predict", "model.h5", "--points", "/dev/stdin", folder=model_folder, stdin=subprocess.PIPE
    )
    stdout, _ = process.communicate("".join(lines), timeout=60)
    assert stdout == expected
    os.mkfifo(model_folder / "pipe")
    process = signorom.start("predict", "model.h5", "--points", "pipe", folder=model_folder)
    with (model_folder / "pipe").open("w") as pipe:
        for line in lines:
            pipe.write(line)
            pipe.flush()
    assert finish(process, 60).stdout == expected
    words = refuse(signorom, "predict", "model.h5", "--points", "/dev/null", folder=model_folder)
    assert words.startswith("/dev/null: error: the file is empty")


def test_output_replaces_an_older_file(signorom, model_folder):
    (model_folder / "answers.csv").write_text("old\n")
    signorom(
        "predict", "model.h5", "--at", "squeeze=0.2,shift=0", "--output", "answers.csv", folder=model_folder
    )
    assert read_table(model_folder / "answers.csv")["squeeze"] == [0.2]


def test_output_keeps_the_mode_of_an_older_file(signorom, model_folder):
    for mode in (0o600, 0o666):
        path = model_folder / f"answers_{mode:o}.csv"
        path.write_text("old\n")
        path.chmod(mode)
        signorom("predict", "model.h5", "--at", "squeeze=0.2,shift=0", "--output", path, folder=model_folder)
        assert path.read_text() != "old\n"
        assert path.stat().st_mode & 0o777 == mode


def test_order_and_bytes_do_not_depend_on_the_threads(signorom, model_folder):
    """More points than are answered at a time; the last line has no end."""
    points = "\n".join(f"{0.15 + 0.3 * ((7 * i) % 2500) / 2499},{0.05 * (i % 3)}" for i in range(2500))
    (model_folder / "points.csv").write_text(f"squeeze,shift\n{points}")
    for n_threads in (1, 3):
        signorom(
            *("predict", "model.h5", "--points", "points.csv", "--threads", n_threads),
            *("--output", f"answers_{n_threads}.csv"),
            folder=model_folder,
        )
    answers = (model_folder / "answers_1.csv").read_bytes()
    assert answers == (model_folder / "answers_3.csv").read_bytes()
    assert answers.count(b"\n") == 2501
    squeeze = read_table(model_folder / "answers_3.csv")["squeeze"]
    assert squeeze[:2] == pytest.approx([0.15, 0.15 + 0.3 * 7 / 2499], rel=1e-14)


@pytest.mark.parametrize("n_threads", ["0", "two", "1e9"])
def test_wrong_number_of_threads(signorom, model_folder, n_threads):
    arguments = ("predict", "model.h5", "--at", "squeeze=0.2,shift=0", "--threads", n_threads)
    words = refuse(signorom, *arguments, folder=model_folder)
    assert words.startswith(f"error: --threads is '{n_threads}'; it must be a whole number from 1 to 1000")
