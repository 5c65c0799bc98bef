# SPDX-License-Identifier: BSD-3-Clause
"""Displacements of condensed models: of all nodes, of named ones, by modes or none; what snapshots hold for that."""

import h5py
import numpy as np
import pytest
from signorom_post.readers.snapshots import read_snapshots

from results import read_table
from runs import refuse, write_deck

HHR = "reduction: {method: hhr, "
SQUEEZE = 0.31
ROUNDING = 1e-12  # of the largest displacement: two ways of adding up the same sum
NONE, BY_MODES, EXACT = 0, 1, 2


def run(signorom, folder, reduction, n_ranks=1, **changes):
    """Results of `run` with more keys in the section `reduction`."""
    folder.mkdir(exist_ok=True)
    deck = write_deck("small_disks", folder, **{HHR: f"reduction: {{{reduction}"}, **changes)
    signorom("run", deck.name, folder=folder, n_ranks=n_ranks)
    return folder / "results" / "small_disks"


@pytest.fixture(scope="module")
def whole(signorom, tmp_path_factory):
    """Exact displacements of all nodes: the default where there is room."""
    return run(signorom, tmp_path_factory.mktemp("whole"), "")


@pytest.fixture(scope="module", params=["none", "modes"])
def named(signorom, tmp_path_factory, request):
    """Exact displacements on an arc, without room for those of all nodes; nothing or modes elsewhere."""
    displacement = f"displacement: {{boundaries: [upper_arc], elsewhere: {request.param}}}"
    folder = tmp_path_factory.mktemp(request.param)
    reduction = f"{displacement}, displacement_tolerance: 0.3, max_full_order_size: 0.02, "
    return request.param, run(signorom, folder, reduction)


def ask(post, folder, nodes=None):
    """The model's answer, and where its displacements come from."""
    with post.Model(folder / "model.h5") as model:
        return model.query(squeeze=SQUEEZE, nodes=nodes), model.displacement_sources, model.nodes[0]


def test_boundary_is_exact_and_the_rest_as_told(signorom, post, whole, named):
    elsewhere, folder = named
    expected, sources, _ = ask(post, whole)
    assert set(sources) == {EXACT}
    answer, sources, tags = ask(post, folder)
    on_arc = sources == EXACT
    assert 0 < on_arc.sum() < len(sources) / 4
    largest = abs(expected.displacement).max()
    wrong = abs(answer.displacement - expected.displacement)
    assert wrong[on_arc].max() <= ROUNDING * largest
    if elsewhere == "none":
        assert set(sources[~on_arc]) == {NONE}
        assert np.isnan(answer.displacement[~on_arc]).all()
    else:
        assert set(sources[~on_arc]) == {BY_MODES}
        assert 1e-9 * largest < wrong[~on_arc].max() <= 0.3 * largest
    # some nodes, in C a refusal where one of them has none
    chosen = [int(tags[on_arc][0]), int(tags[~on_arc][0])]
    some = ask(post, folder, chosen)[0].displacement
    same = answer.displacement[[np.flatnonzero(tags == tag)[0] for tag in chosen]]
    np.testing.assert_allclose(some, same, atol=ROUNDING * largest)
    text = signorom("describe", "model.h5", folder=folder)
    assert "exact at the nodes of upper_arc, " + {"none": "none", "modes": "by"}[elsewhere] in text


def test_files_say_where_displacements_come_from(whole, named):
    elsewhere, folder = named
    with h5py.File(folder / "fields.h5") as file, h5py.File(whole / "fields.h5") as other:
        sources = file["points/0001/displacement_reduced_source"][()]
        reduced = file["points/0001/displacement_reduced"][()]
        full = file["points/0001/displacement"][()]
        assert set(other["points/0001/displacement_reduced_source"][()]) == {EXACT}
    np.testing.assert_allclose(reduced[sources == EXACT], full[sources == EXACT], atol=1e-9 * abs(full).max())
    assert np.isnan(reduced[sources == NONE][:, :2]).all()
    assert (NONE in sources) == (elsewhere == "none")
    errors = read_table(folder / "validation.csv")
    assert max(map(float, errors["e_u"])) <= (1e-9 if elsewhere == "none" else 1e-2)


def test_ranks_agree(signorom, tmp_path, post):
    reduction = "displacement: {boundaries: [upper_arc, lower_base]}, "
    one = ask(post, run(signorom, tmp_path / "one", reduction))[0].displacement
    two = ask(post, run(signorom, tmp_path / "two", reduction, n_ranks=2))[0].displacement
    np.testing.assert_allclose(two, one, atol=ROUNDING * np.nanmax(abs(one)))


def test_no_displacements_at_all(signorom, tmp_path, post):
    folder = run(signorom, tmp_path, "displacement: none, ")
    answer, sources, _ = ask(post, folder)
    assert set(sources) == {NONE}
    assert np.isnan(answer.displacement).all()
    assert answer.multipliers.max() > 0
    assert "none: contact forces only" in signorom("describe", "model.h5", folder=folder)


def test_snapshots_of_condensed_models_hold_forces_only(named, whole):
    _, folder = named
    with h5py.File(folder / "snapshots.h5") as file, h5py.File(whole / "snapshots.h5") as other:
        assert file["displacement"].shape == other["displacement"].shape == (15, 0)
        np.testing.assert_allclose(file["multipliers"][()], other["multipliers"][()], atol=1e-12)


def test_another_deck_that_needs_displacements(signorom, tmp_path):
    """Contact forces alone are no snapshots for hyper-reduction: `train` says so, `sample` solves the points again."""
    folder = run(signorom, tmp_path, "")
    assert read_snapshots(folder / "snapshots.h5").displacement.values.shape == (15, 0)
    deck = write_deck("small_disks", tmp_path)
    said = refuse(signorom, "train", deck.name, folder=tmp_path)
    assert "the snapshots hold contact forces only, and this deck's model needs displacements" in said
    assert "signorom sample" in said
    said = signorom("run", deck.name, folder=tmp_path)
    assert "its points are solved again" in said
    assert read_snapshots(folder / "snapshots.h5").displacement.values.shape[1] > 0
    # and the other way round they do no harm
    said = signorom("run", write_deck("small_disks", tmp_path, **{HHR: "reduction: {"}).name, folder=tmp_path)
    assert "15 were there" in said
    assert read_snapshots(folder / "snapshots.h5").displacement.values.shape[1] > 0


def test_stopped_run_goes_on_without_displacements(signorom, tmp_path):
    """More points than before: those of the file and the new ones are one set."""
    run(signorom, tmp_path, "")
    deck = write_deck("small_disks", tmp_path, **{HHR: "reduction: {", "{squeeze: 15}": "{squeeze: 29}"})
    assert "15 were there" in signorom("run", deck.name, folder=tmp_path)
    with h5py.File(tmp_path / "results/small_disks/snapshots.h5") as file:
        assert file["displacement"].shape == (29, 0)
