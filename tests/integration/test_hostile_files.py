# SPDX-License-Identifier: BSD-3-Clause
"""Model and snapshot files that somebody made to deceive: refused with a sentence, whatever they claim.

Their seals fit; what fails is what stands in them. The library must outlive them inside the program that loads it."""

import os
import shutil
import subprocess
import sys

import h5py
import numpy as np
import pytest

from runs import refuse, write_deck
from seals import change

HUGE = 2**31 - 1
POINT = {"squeeze": 0.31, "shift": 0.02}
# [s] for hundreds of files
LIMIT = 300

# Opens the files that are its arguments, one after the other, and asks each that opens for an answer. A line per file:
# the sentence it is refused with, or "answered".
OPEN_ALL = f"""
import sys
import signorom_post
for path in sys.argv[1:]:
    print(path, end="\\t", flush=True)
    try:
        model = signorom_post.Model(path)
        model.describe()
        model.query(**{POINT!r})
        print("answered", flush=True)
    except (signorom_post.ModelError, signorom_post.NoAnswerError) as error:
        print(str(error).replace("\\n", " "), flush=True)
"""


@pytest.fixture(scope="module")
def study(signorom, tmp_path_factory):
    """Results of a run."""
    folder = tmp_path_factory.mktemp("study")
    signorom("run", write_deck("shifted_disks", folder), folder=folder)
    return folder


@pytest.fixture(scope="module")
def model(study):
    """A trained model."""
    return study / "results" / "shifted_disks" / "model.h5"


def open_all(library, paths):
    """What the library says of each file; it is loaded once, into a process that must live to the end."""
    done = subprocess.run(
        [sys.executable, "-c", OPEN_ALL, *map(str, paths)],
        env=os.environ | {"SIGNOROM_LIBRARY": str(library)},
        capture_output=True,
        text=True,
        timeout=LIMIT,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-300:] + done.stderr[-3000:]
    lines = [line.split("\t") for line in done.stdout.splitlines()]
    assert len(lines) == len(paths)
    return dict(lines)


def put(name, value, index=0):
    """How to overwrite one number of a dataset, or an attribute (object@name)."""

    def how(file):
        place, _, attribute = name.partition("@")
        if attribute:
            file[place or "/"].attrs[attribute] = np.asarray(value, file[place or "/"].attrs[attribute].dtype)
        else:
            values = file[name][()]
            np.atleast_1d(values).reshape(-1)[index] = value
            file[name][...] = values

    return how


def replace(name, **arguments):
    """How to put another dataset in the place of one."""

    def how(file):
        del file[name]
        file.create_dataset(name, **arguments)

    return how


def put_link(name, link):
    """How to put a link in the place of a dataset."""

    def how(file):
        del file[name]
        file[name] = link

    return how


def put_virtual(file):
    """The title as a view of a dataset of another file."""
    layout = h5py.VirtualLayout(shape=(1,), dtype="S9")
    layout[0] = h5py.VirtualSource("other.h5", "secret", shape=(1,))[0]
    del file["title"]
    file.create_virtual_dataset("title", layout)


def put_sparse(name, shape, dtype="f8", **arguments):
    """How to claim a shape of which nothing is stored."""

    def how(file):
        del file[name]
        kind = h5py.h5t.py_create(np.dtype(dtype), logical=True)
        creation = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
        if arguments.get("is_chunked"):
            creation.set_chunk((1024,) * len(shape))
        h5py.h5d.create(file.id, name.encode(), kind, h5py.h5s.create_simple(shape), creation)

    return how


HOSTILE = {
    "kind_0": (put("terms/sources/1@kind", 0), "'terms'"),
    "kind_-1": (put("terms/sources/1@kind", -1), "'terms'"),
    "kind_4": (put("terms/sources/1@kind", 4), "'terms'"),
    "kind_surface": (put("terms/sources/1@kind", 3), "answered"),
    "kind_places": (put("terms/sources/1@kind", 2), "'terms'"),
    "term_0": (put("terms/sources/1/terms", 0), "'terms'"),
    "term_huge": (put("terms/sources/1/terms", HUGE), "'terms'"),
    "sources": (put("terms@n_sources", HUGE), "the file holds"),
    "clusters": (put("@n_clusters", HUGE), "the file holds 1"),
    "no_cluster": (put("@n_clusters", -1), "the file holds 0"),
    "n_nodes": (put("@n_nodes", HUGE), "'node_tags'"),
    "n_dofs": (put("@n_dofs", HUGE), "'n_dofs'"),
    "n_dim": (put("@n_dim", 0), "'n_dim'"),
    "n_dim_1": (put("@n_dim", 1), "'n_dim'"),
    "n_multipliers": (put("@n_multipliers", -5), "'n_multipliers'"),
    "row_0": (put("clusters/1/contact_rows", 0), "'clusters/1/contact_rows'"),
    "row_huge": (put("clusters/1/contact_rows", HUGE, -1), "'clusters/1/contact_rows'"),
    "row_twice": (put("clusters/1/contact_rows", 1, slice(None)), "'clusters/1/contact_rows'"),
    "cell_0": (put("clusters/1/cells", 0), "'clusters/1/cells'"),
    "dof_huge": (put("clusters/1/interior_dofs", HUGE), "'clusters/1/interior_dofs'"),
    "snapshot_0": (put("clusters/1/training_points", 0), "'clusters/1/training_points'"),
    "nan_stiffness": (put("clusters/1/reduced_stiffness", np.nan), "'clusters/1/reduced_stiffness'"),
    "inf_basis": (put("clusters/1/basis", np.inf), "'clusters/1/basis'"),
    "nan_duals": (put("clusters/1/dual_snapshots", np.nan), "'clusters/1/dual_snapshots'"),
    "nan_compliance": (put("fallback/compliance", np.nan), "'fallback/compliance'"),
    "nan_box": (put("parameters/minimum", np.nan), "'box'"),
    "box_inside_out": (put("parameters/minimum", 1e9), "'box'"),
    "name": (replace("parameters/names", data=[b"squeeze", b"1=2"]), "'parameter_names'"),
    "sparse": (put_sparse("clusters/1/basis", (2**28, 2**28)), "claims more values"),
    "sparse_chunks": (
        put_sparse("clusters/1/basis", (2**30, 2**30), is_chunked=True),
        "are chunked, compressed",
    ),
    "overflow": (put_sparse("clusters/1/gap", (2**32, 2**32), is_chunked=True), "cannot read the dataset"),
    "no_values": (put_sparse("clusters/1/cells", (HUGE,), "i4"), "claims more values"),
    "many_texts": (put_sparse("terms/names", (2**33,), "S1"), "claims more values"),
    "wide_text": (put_sparse("title", (), f"S{2**28}"), "claims more values"),
    "packed": (replace("title", data=[b"a"] * 99, compression="gzip"), "are chunked, compressed"),
    "soft_link": (put_link("title", h5py.SoftLink("/deck")), "is reached by a soft or external link"),
    "round_link": (put_link("title", h5py.SoftLink("/title")), "is reached by a soft or external link"),
    "external_link": (
        put_link("title", h5py.ExternalLink("other.h5", "/secret")),
        "is reached by a soft or external link",
    ),
    "linked_group": (
        put_link("clusters/1", h5py.ExternalLink("other.h5", "/")),
        "is reached by a soft or external link",
    ),
    "external_values": (
        replace("title", shape=(1,), dtype="S9", external=[("other.txt", 0, 9)]),
        "in another file",
    ),
    "virtual": (put_virtual, "in another file"),
    "complex": (replace("clusters/1/gap", data=np.ones((2, 2), complex)), "another kind"),
    "labels": (put("clusters/1/start_sets", -1, slice(None)), "answered"),
}


def test_hostile_models_are_refused(library, signorom, model, tmp_path):
    """Each by its sentence, in one process; the program says the same."""
    paths = {}
    for name, (how, _) in HOSTILE.items():
        paths[name] = shutil.copy(model, tmp_path / f"{name}.h5")
        change(paths[name], how)
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["secret"] = [b"topsecret"]
    (tmp_path / "other.txt").write_text("topsecret")
    said = open_all(library, paths.values())
    said = {name: said[str(path)] for name, path in paths.items()}
    assert {name: words for name, words in said.items() if HOSTILE[name][1] not in words} == {}
    assert not any("topsecret" in words for words in said.values())
    for name in ("kind_0", "sparse", "external_values"):
        words = refuse(signorom, "describe", f"{name}.h5", folder=tmp_path)
        assert HOSTILE[name][1] in words


def numbers_of(path):
    """Names of all datasets and attributes of a file that hold numbers, with their kind: i or f."""
    names = []
    with h5py.File(path) as file:

        def visit(name, item):
            names.extend((f"{name}@{key}", np.asarray(value).dtype.kind) for key, value in item.attrs.items())
            if isinstance(item, h5py.Dataset) and item.size:
                names.append((name, item.dtype.kind))

        visit("", file)
        file.visititems(visit)
    return [(name, kind) for name, kind in names if kind in "if"]


def test_any_number_of_a_model_may_be_wrong(library, model, tmp_path):
    """A wild number in any place: the library refuses the file or answers, and goes on."""
    wild = {"i": (0, -1, HUGE, -HUGE - 1), "f": (np.nan, -np.inf, 1.7e308, 5e-324)}
    paths = []
    for i, (name, kind) in enumerate(numbers_of(model)):
        for k, value in enumerate(wild[kind]):
            paths.append(shutil.copy(model, tmp_path / f"{i}_{k}.h5"))
            change(paths[-1], put(name, value))
    assert len(paths) > 200
    said = open_all(library, paths)
    assert all(said.values())


@pytest.mark.parametrize(
    ("how", "sentence"),
    [
        (put_sparse("displacement", (2**28, 2**28)), "claims more values"),
        (
            put_link("displacement", h5py.ExternalLink("other.h5", "/secret")),
            "is reached by a soft or external link",
        ),
        (replace("multipliers", data=np.ones((21, 3))), "their sizes differ"),
        (put("parameters", np.nan), "a parameter of a point is infinite or not a number"),
    ],
    ids=["sparse", "link", "sizes", "point"],
)
def test_hostile_snapshots_are_refused(signorom, study, tmp_path, how, sentence):
    shutil.copytree(study, tmp_path / "study")
    change(tmp_path / "study/results/shifted_disks/snapshots.h5", how)
    words = refuse(signorom, "train", "shifted_disks.yaml", folder=tmp_path / "study")
    assert "snapshots.h5: error: " in words
    assert sentence in words


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_damaged_snapshots_are_refused(signorom, study, tmp_path, share):
    """One bit somewhere in the file."""
    shutil.copytree(study, tmp_path / "study")
    path = tmp_path / "study/results/shifted_disks/snapshots.h5"
    content = bytearray(path.read_bytes())
    content[int(share * len(content))] ^= 4
    path.write_bytes(content)
    for command in ("train", "sample"):
        words = refuse(signorom, command, "shifted_disks.yaml", folder=tmp_path / "study")
        assert "snapshots.h5: error: the file was changed or damaged" in words
