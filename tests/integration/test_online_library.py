# SPDX-License-Identifier: BSD-3-Clause
"""The online library: from C and from Python it says what the program says, and refuses what the program refuses."""

import os
import shutil
import subprocess
import sys
import sysconfig
import warnings
from pathlib import Path

import numpy as np
import pytest

from c_programs import SOURCES, compile_c, run_c
from results import table_of
from runs import CRASH, write_deck

# [-] predict prints shortest decimals that read back the same; the C example prints 12 digits
PRINTED = 1e-11
POINT = {"squeeze": 0.31, "shift": 0.02}


@pytest.fixture(scope="module")
def study(signorom, tmp_path_factory):
    """Results of a run; its model errs by more than rounding."""
    folder = tmp_path_factory.mktemp("study")
    deck = write_deck("shifted_disks", folder)
    signorom("run", deck.name, folder=folder)
    return folder / "results" / "shifted_disks"


@pytest.fixture(scope="module")
def model(study):
    """A trained model."""
    return study / "model.h5"


@pytest.fixture(scope="module")
def ask_model(library, tmp_path_factory):
    """The example of the README."""
    return compile_c("ask_model", library, tmp_path_factory.mktemp("ask"))


def predict(signorom, model, **point):
    """What the program answers at a point: row of its table."""
    at = ",".join(f"{name}={value}" for name, value in point.items())
    table = table_of(signorom("predict", model, "--at", at, folder=model.parent))
    return {name: values[0] for name, values in table.items()}


def forces_of(row):
    """Contact forces of a row of predict."""
    return np.array([value for name, value in row.items() if name.startswith("lambda_")])


def test_example_in_c_agrees_with_predict(signorom, ask_model, model):
    done = run_c(ask_model, model, *POINT.values())
    assert done.returncode == 0, done.stderr
    row = predict(signorom, model, **POINT)
    force = float(done.stdout.split("contact force ")[1].split()[0])
    assert force == pytest.approx(row["contact_force"], rel=PRINTED)
    assert f"on {int(row['n_active'])} of {len(forces_of(row))} pairs" in done.stdout
    assert "squeeze = 0.31 m" in done.stdout


def test_program_in_c_needs_neither_mpi_nor_petsc(ask_model):
    needed = subprocess.run(["ldd", ask_model], capture_output=True, text=True, check=True).stdout
    assert "libsignorom_online" in needed
    assert "not found" not in needed
    assert not [word for word in ("mpi", "petsc", "slepc") if word in needed.lower()]


def test_threads_share_a_model_and_nothing_is_allocated(library, model, tmp_path):
    """Bit by bit the same from four threads as from one; a warm query allocates nothing; bad arguments are refused."""
    done = run_c(compile_c("check_library", library, tmp_path), model, 300)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "answered 300 of 300, 4 threads agree" in done.stdout
    assert "allocations in 300 queries: 0" in done.stdout
    assert "wrong arguments refused" in done.stdout


def damage(path, how):
    """Spoil a copy of a model file."""
    content = path.read_bytes()
    if how == "text":
        path.write_text("squeeze: 0.2\n")
    elif how == "empty":
        path.write_bytes(b"")
    elif how == "cut":
        path.write_bytes(content[: len(content) // 3])
    elif how == "newer":
        path.write_bytes(content.replace(b"SIGNOROM SEAL 1", b"SIGNOROM SEAL 2", 1))
    elif how == "changed":
        middle = len(content) // 2
        path.write_bytes(content[:middle] + bytes([content[middle] ^ 4]) + content[middle + 1 :])
    elif how == "missing":
        path.unlink()


@pytest.mark.parametrize(
    ("how", "words"),
    [
        ("text", "this is not an HDF5 file"),
        ("empty", "this is not an HDF5 file"),
        ("cut", "the file is cut off"),
        ("newer", "a newer version of the program wrote the file"),
        ("changed", "the file was changed or damaged"),
        ("missing", "no such file"),
        ("snapshots", "this file is no signorom model; it says that it is 'signorom snapshots'"),
    ],
)
def test_bad_file_is_refused_alike(signorom, study, post, ask_model, tmp_path, how, words):
    """One sentence from the program, from C and from Python."""
    path = tmp_path / "model.h5"
    shutil.copy(study / ("snapshots.h5" if how == "snapshots" else "model.h5"), path)
    damage(path, how)
    told = signorom.run("predict", "model.h5", "--at", "squeeze=0.2,shift=0", folder=tmp_path)
    described = signorom.run("describe", "model.h5", folder=tmp_path)
    done = run_c(ask_model, path, *POINT.values())
    assert (told.returncode, described.returncode, done.returncode) == (2, 2, 2)
    for text in (told.stderr, described.stderr, done.stderr):
        assert words in text
        assert not [word for word in CRASH if word in text]
    with pytest.raises(post.ModelError, match=words):
        post.Model(path)


def test_python_agrees_with_predict(signorom, post, model):
    row = predict(signorom, model, **POINT)
    with post.Model(model) as asked:
        answer = asked.query(**POINT)
        side = asked.contact_sides[0]
        tags = side.tags[side.starts[:-1]]
        many = asked.query_many(np.array([list(POINT.values()), [0.2, 0.0]]))
    assert answer.multipliers == pytest.approx(forces_of(row), rel=1e-15)
    assert [f"lambda_{tag}" for tag in tags] == [name for name in row if name.startswith("lambda_")]
    assert answer.contact_force == pytest.approx(row["contact_force"], rel=1e-14)
    assert (answer.method, answer.is_inside_box) == ("active_set", True)
    assert answer.residual < 1e-12
    assert (many.multipliers[0] == answer.multipliers).all()


def test_python_tells_the_nodes_of_contacts(post, model):
    """Each pair has one node on either side, which face each other in x; the areas add up to the first surface."""
    with post.Model(model) as asked:
        first, second = asked.contact_sides
        areas, (tags, coordinates) = asked.contact_areas, asked.nodes
    assert (first.starts == np.arange(len(areas) + 1)).all()
    assert (first.weights == 1).all()
    for side in (first, second):
        places = coordinates[[int(np.flatnonzero(tags == tag)[0]) for tag in side.tags]]
        np.testing.assert_array_equal(side.coordinates, places)
    np.testing.assert_allclose(first.coordinates[:, 0], second.coordinates[:, 0], atol=1e-12)
    assert (areas > 0).all()


def test_python_tells_the_displacement(post, model):
    """Base nodes move as the deck says; chosen nodes are rows of the whole field."""
    with post.Model(model) as asked:
        tags, coordinates = asked.nodes
        whole = asked.query(**POINT)
        chosen = asked.query(**POINT, nodes=[int(tags[5]), int(tags[2])])
        bottom = np.flatnonzero(coordinates[:, 1] == coordinates[:, 1].min())
        with pytest.raises(ValueError, match="no node 999999"):
            asked.query(**POINT, nodes=[999999])
    assert whole.displacement.shape == coordinates.shape
    assert whole.displacement[bottom, 0] == pytest.approx(POINT["shift"], rel=1e-9)
    assert whole.displacement[bottom, 1] == pytest.approx(POINT["squeeze"], rel=1e-9)
    assert chosen.displacement == pytest.approx(whole.displacement[[5, 2]], rel=1e-14)


def test_python_names_a_wrong_parameter(post, model):
    with post.Model(model) as asked:
        with pytest.raises(TypeError, match="no value for the parameter 'shift'"):
            asked.query(squeeze=0.2)
        with pytest.raises(TypeError, match="unknown parameter 'speed'; the parameters are squeeze, shift"):
            asked.query(squeeze=0.2, shift=0.0, speed=1.0)
        for value in (np.nan, np.inf):
            with pytest.raises(
                ValueError, match=f"the parameter 'squeeze' must be a finite number, not {value}"
            ):
                asked.query(squeeze=value, shift=0.0)
            with pytest.raises(
                ValueError, match=rf"'shift' must be a finite number; at points\[1\] it is {value}"
            ):
                asked.query_many(np.array([[0.2, 0.0], [0.2, value]]))
        with pytest.raises(ValueError, match=r"shape \(n_points, 2\), not \(1, 3\)"):
            asked.query_many(np.zeros((1, 3)))
    with pytest.raises(ValueError, match="closed"):
        asked.query(**POINT)


def test_many_points_have_the_answers_of_single_ones(post, model):
    """Bit by bit, with displacements of chosen nodes; pressures are forces over areas."""
    with post.Model(model) as asked:
        nodes = asked.nodes[0][[5, 2]]
        points = np.array([list(POINT.values()), [0.2, 0.0], [0.44, -0.01]])
        many = asked.query_many(points, nodes=nodes)
        areas = asked.contact_areas
        single = [asked.query(squeeze=point[0], shift=point[1], nodes=nodes) for point in points]
        assert asked.query_many(points).displacement.shape == (3, 0, 2)
        assert len(asked.query_many(points[:0])) == 0
    assert many.has_answer.all()
    for name in ("multipliers", "pressure", "displacement", "method", "cluster", "is_inside_box", "distance"):
        np.testing.assert_array_equal(getattr(many, name), [getattr(answer, name) for answer in single])
    for name in ("residual", "n_solutions", "contact_force"):
        np.testing.assert_array_equal(getattr(many, name), [getattr(answer, name) for answer in single])
    for name in ("bound", "relative_bound", "displacement_bound", "relative_displacement_bound"):
        bounds = [getattr(answer, name) for answer in single]
        np.testing.assert_array_equal(
            getattr(many, name), [np.nan if bound is None else bound for bound in bounds]
        )
    for name in ("areas", "forces", "moments"):
        summed = [getattr(answer.resultants, name) for answer in single]
        np.testing.assert_array_equal(getattr(many.resultants, name), summed)
    np.testing.assert_allclose(many.pressure * areas, many.multipliers, rtol=1e-15)


def test_extrapolation_is_said_once_per_call(post, model):
    """The parameter and its range are named; points of the box say nothing."""
    with post.Model(model) as asked:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            asked.query(squeeze=0.45, shift=0.0)
            asked.query_many(np.array([[0.15, 0.0]]))
        with pytest.warns(post.ExtrapolationWarning) as said:
            assert not asked.query(squeeze=0.5, shift=0.0).is_inside_box
        assert [str(one.message) for one in said] == [
            "the model extrapolates: squeeze (0.5) lies outside of 0.15 to 0.45 m"
        ]
        assert said[0].filename == __file__
        with pytest.warns(post.ExtrapolationWarning) as said:
            many = asked.query_many(np.array([[0.5, 0.0], [0.3, 0.0], [0.6, 0.0]]))
        assert [str(one.message) for one in said] == [
            "the model extrapolates at 2 of 3 points: squeeze (0.5 to 0.6) lies outside of 0.15 to 0.45 m"
        ]
        assert said[0].filename == __file__
    assert many.is_inside_box.tolist() == [False, True, False]


def test_model_says_what_it_is(post, model):
    """Also when it is closed."""
    with post.Model(model) as asked:
        text = repr(asked)
    assert text == repr(asked)
    for words in (
        "'Two small half disks with two parameters'",
        "squeeze 0.15 to 0.45 m",
        "contact forces); hhr>",
    ):
        assert words in text


@pytest.fixture(scope="module")
def installed(library, tmp_path_factory):
    """Prefix of an installation."""
    build = library.parents[2]
    prefix = tmp_path_factory.mktemp("installed")
    command = ["cmake", "--install", build, "--prefix", prefix]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return prefix


def test_c_builds_against_an_installation(installed, ask_model, model, tmp_path):
    """With pkg-config alone, whatever the prefix of the configuration was, and from where the prefix was moved to."""
    moved = installed.rename(tmp_path / "moved")
    folder = next(moved.rglob("signorom_online.pc")).parent
    environment = os.environ | {"PKG_CONFIG_PATH": str(folder)}

    def config(*options):
        command = ["pkg-config", *options, "signorom_online"]
        return subprocess.run(
            command, capture_output=True, text=True, check=True, env=environment
        ).stdout.split()

    program = tmp_path / "ask_model"
    rpath = f"-Wl,-rpath,{config('--variable=libdir')[0]}"
    command = ["cc", SOURCES / "ask_model.c", *config("--cflags", "--libs"), rpath, "-o", program]
    subprocess.run(command, check=True, cwd=tmp_path)
    needed = subprocess.run(["ldd", program], capture_output=True, text=True, check=True).stdout
    assert f"{moved}/" in needed.split("libsignorom_online.so.0 => ")[1].splitlines()[0]
    assert run_c(program, model, *POINT.values()).stdout == run_c(ask_model, model, *POINT.values()).stdout
    assert run_c(moved / "bin" / "signorom", "describe", model).returncode == 0
    moved.rename(installed)


def test_python_finds_an_installation_on_the_loaders_path(installed, model, post, tmp_path):
    """With the package outside of the sources, where no build folder is near; without the path it says what to do."""
    shutil.copytree(Path(post.__file__).parent, tmp_path / "signorom_post")
    question = f"Model({str(model)!r}).query(squeeze=0.31, shift=0.02)"
    script = f"from signorom_post import Model; print({question}.contact_force)"
    environment = {key: value for key, value in os.environ.items() if key != "SIGNOROM_LIBRARY"}
    environment["PYTHONPATH"] = f"{tmp_path}:{sysconfig.get_path('purelib')}"
    found = next(installed.rglob("libsignorom_online.so.0")).parent

    def ask(**more):
        command = [
            sys.executable,
            "-S",
            "-c",
            script,
        ]  # -S: an editable installation does not come before the path
        return subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, env=environment | more)

    done = ask(LD_LIBRARY_PATH=str(found))
    assert done.returncode == 0, done.stderr
    assert float(done.stdout) == pytest.approx(post.Model(model).query(**POINT).contact_force, rel=PRINTED)
    assert "libsignorom_online.so.0 was not found: install" in ask().stderr


def test_missing_library_is_named(post, model, monkeypatch):
    monkeypatch.setenv("SIGNOROM_LIBRARY", "/nowhere/libsignorom_online.so")
    with pytest.raises(post.LibraryError, match=r"/nowhere/libsignorom_online\.so cannot be used"):
        post.Model(model)


def test_describe_tells_what_a_reader_wants(signorom, post, model):
    text = signorom("describe", model, folder=model.parent)
    for words in (
        "Two small half disks with two parameters",
        "squeeze               0.15 to 0.45 m",
        "training points         21",
        "kappa",
        "e_lambda_rid",
        "by active_set",
        "the full-order model answers (forces and displacements)",
        "model format 6",
    ):
        assert words in text, text
    with post.Model(model) as asked:
        assert asked.describe() == text.rstrip("\n")
