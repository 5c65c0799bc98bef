# SPDX-License-Identifier: BSD-3-Clause
"""A contact whose matrix has no room: rows that change are kept, others tied or open, or the point is refused."""

import re

import h5py
import numpy as np
import pytest

from block_meshes import Mesh
from results import read_table, table_of
from runs import refuse

SAME = 1e-8
N_ACROSS = 180  # contact pairs less one: W of all takes 0.27 MB
DECK = """\
title: A strip on its bed
mesh: {{file: strip.msh, model: plane_strain}}
parameters: {{press: {{min: 1.0e-3, max: 2.0e-3, unit: m}}, tilt: {{min: 0.008, max: 0.012}}}}
materials:
  bed: {{regions: [lower], young_modulus: 2.0e6, poisson_ratio: 0.3}}
  strip: {{regions: [upper], young_modulus: 7.0e6, poisson_ratio: 0.2}}
boundary_conditions:
  - {{boundary: bottom, displacement: {{x: 0, y: 0}}}}
  - {{boundary: top, displacement: {{x: 0, y: "-press + tilt * (x - 0.4)"}}}}
contact:
  - {{first: lower_face, second: upper_face, direction: [0, 1]}}
training: {{grid: {{press: 4, tilt: 4}}}}
test: {{grid: {{press: 5, tilt: 3}}}}
reduction: {{{reduction}}}
"""
TIED = "method: condensed, max_full_order_size: 0.15"


def write_strip(folder, reduction):
    """Mesh and deck: a thin strip on a bed, lifted on the right."""
    folder.mkdir(exist_ok=True)
    across = np.linspace(0.0, 1.0, N_ACROSS + 1)
    mesh = Mesh()
    mesh.add_block(
        "lower", [across, np.linspace(-0.06, 0.0, 4)], "Q4", {(1, 0): "bottom", (1, 1): "lower_face"}
    )
    mesh.add_block("upper", [across, np.linspace(0.0, 0.03, 3)], "Q4", {(1, 0): "upper_face", (1, 1): "top"})
    mesh.write(folder / "strip.msh")
    deck = folder / "strip.yaml"
    deck.write_text(DECK.format(reduction=reduction))
    return deck


@pytest.fixture(scope="module")
def tied(signorom, tmp_path_factory):
    """What `run` says, and its results."""
    folder = tmp_path_factory.mktemp("tied")
    deck = write_strip(folder, TIED + ", displacement: {boundaries: [upper_face]}")
    return signorom("run", deck.name, folder=folder), folder / "results" / "strip"


@pytest.fixture(scope="module")
def whole(signorom, tmp_path_factory):
    """The same with W of all contacts."""
    folder = tmp_path_factory.mktemp("whole")
    signorom("run", write_strip(folder, "").name, folder=folder)
    return folder / "results" / "strip"


def test_answers_equal_the_full_order(tied):
    said, folder = tied
    errors = read_table(folder / "validation.csv")
    assert max(map(float, errors["e_lambda_all"])) <= SAME
    assert max(map(float, errors["e_u"])) <= SAME
    assert "cluster 1: " in said
    with h5py.File(folder / "model.h5") as file:
        status = file["clusters/1/tied/1/status"][()]
        assert file["clusters/1"].attrs["kind"] in (b"tied", "tied")
        assert file["clusters/1/tied/1/operator"].shape == ((status == 2).sum(), N_ACROSS + 1)
    # all three kinds of rows
    assert set(status) == {0, 1, 2}
    assert (status == 2).sum() < N_ACROSS / 2


def test_answers_equal_those_with_the_whole_matrix(post, tied, whole):
    random = np.random.default_rng(3)
    with post.Model(tied[1] / "model.h5") as some, post.Model(whole / "model.h5") as all_rows:
        for press, tilt in random.uniform([1e-3, 0.008], [2e-3, 0.012], (40, 2)):
            a, b = (model.query(press=press, tilt=tilt) for model in (some, all_rows))
            assert np.linalg.norm(a.multipliers - b.multipliers) <= SAME * np.linalg.norm(b.multipliers)
            known = ~np.isnan(a.displacement[:, 0])
            assert known.sum() == N_ACROSS + 1
            largest = abs(b.displacement).max()
            np.testing.assert_allclose(a.displacement[known], b.displacement[known], atol=SAME * largest)
            assert a.relative_bound is None


def test_point_beyond_the_trained_rows_is_refused(signorom, tied):
    folder = tied[1]
    done = signorom.run("predict", "model.h5", "--at", "press=4e-3,tilt=0.004", folder=folder)
    assert done.returncode == 3
    row = table_of(done.stdout)
    assert "a contact opens or closes that does not change at the training points nearby" in done.stdout
    assert row["solver"] == ["none"]


def test_clusters_where_one_has_no_room(signorom, tmp_path):
    """Lifted on the right or on the left: every row changes in all, few do on each side."""
    deck = write_strip(tmp_path, TIED)
    text = deck.read_text().replace("tilt: {min", "side: {min: -1, max: 1}, tilt: {min")
    text = text.replace("tilt * (x - 0.4)", "tilt * side * (x - 0.5) + 0.1 * tilt")
    text = text.replace("{press: 4, tilt: 4}", "{press: 4, tilt: 4, side: 2}")
    deck.write_text(text.replace("{press: 5, tilt: 3}", "{press: 5, tilt: 3, side: 2}"))
    done = signorom.run("run", deck.name, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    said = done.stdout
    assert "cluster 2: " in said
    assert "cluster 3: " not in said
    errors = read_table(tmp_path / "results" / "strip" / "validation.csv")
    assert set(errors["solver"]) == {"condensed"}
    assert max(map(float, errors["e_lambda_all"])) <= SAME


def test_no_row_changes(signorom, tmp_path):
    """The whole strip stays on its bed: the tied problem alone is the answer, with its displacement."""
    deck = write_strip(tmp_path, TIED)
    deck.write_text(deck.read_text().replace("{min: 0.008, max: 0.012}", "{min: 0.0, max: 1.0e-4}"))
    said = signorom("run", deck.name, folder=tmp_path)
    assert f"cluster 1: 0 contacts may change, {N_ACROSS + 1} stay closed" in said
    errors = read_table(tmp_path / "results" / "strip" / "validation.csv")
    assert max(map(float, errors["e_lambda_all"])) <= SAME
    assert max(map(float, errors["e_u"])) <= SAME


def test_too_many_changing_rows_are_refused(signorom, tmp_path):
    deck = write_strip(tmp_path, "method: condensed, max_full_order_size: 0.01")
    signorom("sample", deck.name, folder=tmp_path)
    said = refuse(signorom, "train", deck.name, folder=tmp_path)
    told = re.search(r"with unknowns only at contacts that change it still takes (\S+) MB", said)
    assert 0.01 < float(told[1]) < 1
    assert "or a larger reduction.max_full_order_size" in said


def test_auto_turns_to_hyper_reduction_then(signorom, tmp_path):
    deck = write_strip(tmp_path, "max_full_order_size: 0.01")
    said = signorom("sample", deck.name, folder=tmp_path) + signorom("train", deck.name, folder=tmp_path)
    told = re.search(
        r"hyper-reduction \(reduction.method: auto\): the matrix of all contacts takes (\S+) MB", said
    )
    assert 0.01 < float(told[1]) < 1


def test_ranks_agree(signorom, tmp_path, post, tied):
    deck = write_strip(tmp_path, TIED + ", displacement: {boundaries: [upper_face]}")
    signorom("sample", deck.name, folder=tmp_path, n_ranks=3)
    signorom("train", deck.name, folder=tmp_path, n_ranks=3)
    point = {"press": 1.37e-3, "tilt": 0.0105}
    with post.Model(tied[1] / "model.h5") as one, post.Model(tmp_path / "results/strip/model.h5") as three:
        a, b = one.query(**point), three.query(**point)
    assert np.linalg.norm(a.multipliers - b.multipliers) <= SAME * np.linalg.norm(a.multipliers)
    np.testing.assert_allclose(a.displacement, b.displacement, atol=1e-12)
