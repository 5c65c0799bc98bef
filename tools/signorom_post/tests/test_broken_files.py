# SPDX-License-Identifier: BSD-3-Clause
"""Missing, foreign, truncated and inconsistent files end in one sentence with the name of the file."""

import re
from collections.abc import Callable
from pathlib import Path

import h5py
import pytest

from signorom_post.errors import InputError, MissingFileError
from signorom_post.readers.enrichment import read_enrichment
from signorom_post.readers.fields import read_fields
from signorom_post.readers.model import read_model
from signorom_post.readers.report import read_report
from signorom_post.readers.snapshots import read_snapshots
from signorom_post.readers.validation import read_validation
from signorom_post.results import Results

READERS: dict[str, Callable[[Path], object]] = {
    "fields.h5": read_fields,
    "snapshots.h5": read_snapshots,
    "model.h5": read_model,
    "validation.csv": read_validation,
    "enrichment.csv": read_enrichment,
    "report.yaml": read_report,
}
HDF5_FILES = [name for name in READERS if name.endswith(".h5")]


def message_of(path: Path) -> str:
    """What the reader says, without the path; it must be one line that begins with the path."""
    with pytest.raises(InputError) as caught:
        READERS[path.name](path)
    text = str(caught.value)
    assert "\n" not in text
    assert text.startswith(f"{path}: error: ")
    return text.removeprefix(f"{path}: error: ")


@pytest.mark.parametrize("name", READERS)
def test_missing_file(tmp_path: Path, name: str) -> None:
    assert message_of(tmp_path / name) == "there is no such file"
    with pytest.raises(MissingFileError):
        READERS[name](tmp_path / name)


@pytest.mark.parametrize("name", READERS)
def test_unfinished_run(tmp_path: Path, name: str) -> None:
    (tmp_path / f"{name}.partial").write_bytes(b"half")
    assert f"there is only '{name}.partial'" in message_of(tmp_path / name)


@pytest.mark.parametrize("name", READERS)
def test_folder_in_place_of_a_file(tmp_path: Path, name: str) -> None:
    (tmp_path / name).mkdir()
    assert message_of(tmp_path / name) == "this is a folder, not a file"


@pytest.mark.parametrize("name", READERS)
def test_empty_file(tmp_path: Path, name: str) -> None:
    (tmp_path / name).touch()
    assert message_of(tmp_path / name) == "the file is empty"


@pytest.mark.parametrize("name", READERS)
def test_binary_rubbish(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_bytes(bytes(range(256)) * 40)
    assert re.match(r"this is not (an HDF5 file|a CSV file|YAML)", message_of(tmp_path / name))


@pytest.mark.parametrize("name", HDF5_FILES)
def test_truncated_hdf5(folder: Path, name: str) -> None:
    data = (folder / name).read_bytes()
    (folder / name).write_bytes(data[: len(data) * 2 // 3])
    assert "truncated" in message_of(folder / name)


@pytest.mark.parametrize("name", HDF5_FILES)
@pytest.mark.parametrize("signature", [b"TREE", b"HEAP", b"SNOD"])
@pytest.mark.parametrize("i_place", [0, -1])
def test_damage_inside_hdf5(folder: Path, name: str, signature: bytes, i_place: int) -> None:
    """Groups are found through these blocks of the file; h5py answers their loss in many ways."""
    data = (folder / name).read_bytes()
    places = [match.start() for match in re.finditer(signature, data)]
    (folder / name).write_bytes(data[: places[i_place]] + b"XXXX" + data[places[i_place] + 4 :])
    assert re.search("damaged|is missing", message_of(folder / name))


@pytest.mark.parametrize("name", HDF5_FILES)
def test_foreign_hdf5(folder: Path, name: str) -> None:
    path = folder / name
    with h5py.File(path, "r+") as file:
        file.attrs["format"] = "something else"
    assert "is a 'something else' file" in message_of(path)
    with h5py.File(path, "r+") as file:
        del file.attrs["format"]
    assert "has no attribute 'format'" in message_of(path)


@pytest.mark.parametrize("name", HDF5_FILES)
def test_other_format_version(folder: Path, name: str) -> None:
    with h5py.File(folder / name, "r+") as file:
        known = file.attrs["format_version"]
        # models without friction are written in the version before the newest one
        newest = known + (name == "model.h5")
        file.attrs["format_version"] = newest + 1
    expected = f"the file has format version {newest + 1}; this tool reads version {newest}"
    assert message_of(folder / name) == expected
    with h5py.File(folder / name, "r+") as file:
        file.attrs["format_version"] = known - 1
    expected = f"the file has format version {known - 1}; this tool reads version {newest}"
    assert message_of(folder / name) == f"{expected}; run the command that wrote it again"


@pytest.mark.parametrize(
    ("name", "dataset"),
    [
        ("snapshots.h5", "multipliers"),
        ("model.h5", "parameters/names"),
        ("model.h5", "clusters/1/basis"),
        ("fields.h5", "mesh/topology"),
    ],
)
def test_missing_dataset_is_named(folder: Path, name: str, dataset: str) -> None:
    with h5py.File(folder / name, "r+") as file:
        del file[dataset]
    assert message_of(folder / name) == f"dataset '/{dataset}' is missing"


@pytest.mark.parametrize(
    ("name", "dataset", "value", "sentence"),
    [
        ("fields.h5", "mesh/topology", [[0, 1, 9999]], "a node outside 0.."),
        ("fields.h5", "mesh/topology", [99, 0, 1], "the cell type 99"),
        ("fields.h5", "mesh/topology", [4, 0, 1], "ends within a cell"),
        ("fields.h5", "mesh/coordinates", [[0.0, 1.0]], "has 2 columns"),
        ("fields.h5", "contact/first/nodes", [0] * 11, "has the number 0; allowed are 1 to"),
        ("fields.h5", "contact/first/nodes", [1, 2], "do not fit each other"),
        ("fields.h5", "contact/second/starts", [0, 1], "do not fit each other"),
        ("fields.h5", "points/0002/displacement", [[0.0, 0.0, 0.0]], "has 1 entries"),
        ("fields.h5", "points/0001/multipliers_reduced", [0.0], "'/points/0001/multipliers_reduced' has 1"),
        ("fields.h5", "points/0001/displacement", "words", "is text; numbers are needed"),
        ("snapshots.h5", "seconds", [1.0], "'/seconds' has 1 rows for 31 points"),
        ("snapshots.h5", "parameters", [0.1, 0.2], "has 1 axes; 2 are needed"),
        ("snapshots.h5", "reasons", [0.5], "not integers"),
        ("model.h5", "parameters/units", ["m", "m"], "different lengths"),
    ],
)
def test_inconsistent_content(folder: Path, name: str, dataset: str, value: object, sentence: str) -> None:
    with h5py.File(folder / name, "r+") as file:
        del file[dataset]
        file[dataset] = value
    assert sentence in message_of(folder / name)


def test_point_without_parameters(folder: Path) -> None:
    with h5py.File(folder / "fields.h5", "r+") as file:
        del file["points/0001"].attrs["parameters"]
    assert "lacks the attribute 'parameters'" in message_of(folder / "fields.h5")


def test_model_without_clusters(folder: Path) -> None:
    with h5py.File(folder / "model.h5", "r+") as file:
        del file["clusters/1"]
    assert "no clusters" in message_of(folder / "model.h5")


def test_truncated_csv_names_the_line(folder: Path) -> None:
    path = folder / "validation.csv"
    lines = path.read_text().splitlines()
    path.write_text("\n".join([*lines[:5], lines[5][:30]]))
    assert message_of(path) == "line 6 has 3 values for 13 columns; is the file truncated?"


def test_csv_of_something_else(tmp_path: Path) -> None:
    path = tmp_path / "validation.csv"
    path.write_text("a,b\n1,2\n")
    assert message_of(path).startswith("the header lacks the columns cluster, e_u")


def test_csv_with_a_word_names_line_and_column(folder: Path) -> None:
    path = folder / "validation.csv"
    lines = path.read_text().splitlines()
    lines[3] = lines[3].replace(lines[3].split(",")[2], "oops", 1)
    path.write_text("\n".join(lines))
    assert message_of(path) == "line 4, column 'e_u': 'oops' is not a number"


@pytest.mark.parametrize(
    ("column", "value", "sentence"),
    [
        ("hat", "7", "the hats of cluster 1 are not numbered 0, 1, 2, ..."),
        ("n_columns", "9.5", "column 'n_columns' has values that are not integers"),
    ],
)
def test_inconsistent_enrichment(folder: Path, column: str, value: str, sentence: str) -> None:
    path = folder / "enrichment.csv"
    header, *lines = path.read_text().splitlines()
    cells = lines[1].split(",")
    cells[header.split(",").index(column)] = value
    path.write_text("\n".join([header, lines[0], ",".join(cells), *lines[2:]]))
    assert message_of(path) == sentence


def test_csv_without_points(folder: Path) -> None:
    path = folder / "validation.csv"
    path.write_text(path.read_text().splitlines()[0] + "\n")
    assert message_of(path) == "there is a header but no row below it"


def test_blank_lines_of_a_csv_count(folder: Path) -> None:
    path = folder / "enrichment.csv"
    lines = path.read_text().splitlines()
    path.write_text("\n".join([lines[0], "", "", lines[1] + ",1"]))
    assert message_of(path).startswith("line 4 has ")


@pytest.mark.parametrize("text", ["a: [1, 2", "a: 1\n b: 2\n", "\t- x"])
def test_broken_yaml_names_the_line(tmp_path: Path, text: str) -> None:
    path = tmp_path / "report.yaml"
    path.write_text(text)
    assert re.fullmatch(r"this is not YAML \(line \d+\)", message_of(path))


def test_yaml_that_is_no_report(tmp_path: Path) -> None:
    (tmp_path / "report.yaml").write_text("- 1\n- 2\n")
    assert message_of(tmp_path / "report.yaml") == "this is not a report: it has no sections"


def test_results_folder_must_be_one(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="there is no such folder"):
        Results(tmp_path / "nothing")
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="this is not a folder"):
        Results(tmp_path / "file")
