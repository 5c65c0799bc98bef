# SPDX-License-Identifier: BSD-3-Clause
"""The same answer on any number of ranks, in any division of them, from any solver, in any units."""

import h5py
import meshio
import numpy as np
import pytest
import yaml

from results import read_snapshots, read_table
from runs import run_shifted_disks, write_deck

pytestmark = pytest.mark.slow

# Ranks only change the order of sums: rounding, magnified by the condition of the stiffness (about 1e3).
SAME = 1e-10
# Three ways to solve the same full-order problem.
SAME_SOLVER = 1e-9
SAME_UNITS = 1e-9
AUTO, ONE = {}, {"groups: auto": "groups: 1"}
INDEX_SETS = (
    "contact_rows",
    "seed_nodes",
    "facing_nodes",
    "cells",
    "interior_dofs",
    "interface_dofs",
    "contact_dofs",
)
BLOCKS = ("basis", "lifting", "reduced_stiffness", "contact_matrix", "gap", "dual_snapshots")


@pytest.fixture(scope="module")
def one_rank(signorom, tmp_path_factory):
    """Results of one rank."""
    return run_shifted_disks(signorom, tmp_path_factory.mktemp("one_rank"))


def same(found, expected, tolerance):
    """Arrays agree relative to the largest entry."""
    scale = np.abs(expected).max()
    np.testing.assert_allclose(found, expected, rtol=0, atol=tolerance * scale)


def same_snapshots(found, expected, tolerance):
    """Points in the same order, displacement and multipliers alike at each."""
    a, b = read_snapshots(found / "snapshots.h5"), read_snapshots(expected / "snapshots.h5")
    np.testing.assert_array_equal(a["parameters"], b["parameters"])
    np.testing.assert_array_equal(a["reasons"] > 0, b["reasons"] > 0)
    assert a["term_texts"] == b["term_texts"]
    same(a["free_response"], b["free_response"], tolerance)
    for i_point in range(len(a["parameters"])):
        same(a["displacement"][i_point], b["displacement"][i_point], tolerance)
        same(a["multipliers"][i_point], b["multipliers"][i_point], tolerance)
    # else equal multipliers would say little
    assert len({tuple(row > 0) for row in b["multipliers"]}) > 3


def same_models(found, expected):
    """Everything that a query reads."""
    with h5py.File(found / "model.h5") as a, h5py.File(expected / "model.h5") as b:
        assert a.attrs["provenance"] == b.attrs["provenance"]
        assert a.attrs["mesh_hash"] == b.attrs["mesh_hash"]
        a, b = a["clusters/1"], b["clusters/1"]
        for name in INDEX_SETS:
            np.testing.assert_array_equal(a[name][()], b[name][()], err_msg=name)
        for name in BLOCKS:
            same(a[name][()], b[name][()], SAME)
        # an elastic lifting is in equilibrium: its load is the rounding of a product with the stiffness
        stiffness = np.abs(b["reduced_stiffness"][()]).max()
        np.testing.assert_allclose(a["load"][()], b["load"][()], rtol=0, atol=SAME * stiffness)
        n_modes = b["basis"].shape[0]
        same(a["singular_values"][:n_modes], b["singular_values"][:n_modes], SAME)
        for name in ("condition_number", "stiffness_condition"):
            assert a.attrs[name] == pytest.approx(b.attrs[name], rel=SAME)
        assert a.attrs["rank"] == b.attrs["rank"]


def same_validation(found, expected):
    """The table (seven digits) and the statistics of the report (all digits)."""
    a, b = read_table(found / "validation.csv"), read_table(expected / "validation.csv")
    assert list(a) == list(b)
    for name in b:
        if isinstance(b[name], list) or name.startswith("n_"):
            np.testing.assert_array_equal(a[name], b[name], err_msg=name)
        elif name.startswith(("e_u", "e_lambda")):
            np.testing.assert_allclose(a[name], b[name], rtol=2e-6, err_msg=name)
    a, b = (yaml.safe_load((folder / "report.yaml").read_text())["errors"] for folder in (found, expected))
    assert b["e_u"]["median"] > 1e-4  # a model that errs: errors made of rounding could not be compared
    for name in ("e_u", "e_lambda_rid", "e_lambda_all"):
        for statistic in ("min", "median", "p95", "max"):
            # an error is a difference of two results of size 1
            assert a[name][statistic] == pytest.approx(b[name][statistic], abs=SAME), (name, statistic)


@pytest.mark.parametrize("groups", [AUTO, ONE], ids=["groups_of_one_rank", "one_group"])
@pytest.mark.parametrize("n_ranks", [2, 3, 4])
def test_ranks(signorom, tmp_path, one_rank, n_ranks, groups):
    """Results stand in the order of the mesh file, whoever made them."""
    found = run_shifted_disks(signorom, tmp_path, n_ranks, **groups)
    same_snapshots(found, one_rank, SAME)
    same_models(found, one_rank)
    same_validation(found, one_rank)


TRAININGS = {
    "normalized": {"pod_tolerance: 1.0e-5": "pod_tolerance: 1.0e-5, normalize: true"},
    "cells": {"reduction: {": "clusters: {number: 3}\nreduction: {"},
    "snapshots": {"reduction: {": "clusters: {number: 2, method: irregular}\nreduction: {"},
    "modes": {"method: hhr": "method: condensed, displacement: {boundaries: [lower_arc], elsewhere: modes}"},
    "target": {
        "reduction: {": "clusters: {number: 1, max_number: 3, target: {error: 1.0e-9, measure: e_u, "
        "candidates: {sobol: 40}}, refine: {points_per_round: 2, max_points: 4}}\nreduction: {"
    },
}


@pytest.mark.parametrize("training", TRAININGS.values(), ids=TRAININGS)
def test_training_on_spread_snapshots(signorom, tmp_path, training):
    """One sampling; each rank trains on its rows of the displacements."""
    deck = write_deck("shifted_disks", tmp_path, **training)
    signorom("sample", deck.name, folder=tmp_path)
    models = []
    # the random forest takes seconds
    for n_ranks in (1, 3) if training is TRAININGS["snapshots"] else (1, 2, 3, 4):
        signorom("train", deck.name, folder=tmp_path, n_ranks=n_ranks)
        models.append(real_datasets(tmp_path / "results" / "shifted_disks" / "model.h5"))
    for found in models[1:]:
        assert list(found) == list(models[0])
        for name, expected in models[0].items():
            # what is rounding: values beyond the modes, loads of a lifting in equilibrium
            if expected.size > 0 and not name.endswith(("singular_values", "/load")):
                same(found[name], expected, SAME)


def real_datasets(path):
    """By their names."""
    found = {}
    with h5py.File(path) as file:
        file.visititems(lambda name, item: found.setdefault(name, item))
        found = {name: item for name, item in found.items() if isinstance(item, h5py.Dataset)}
        return {name: item[()] for name, item in found.items() if item.dtype.kind == "f"}


def test_groups_of_unequal_size(signorom, tmp_path, one_rank):
    """Two groups out of three ranks."""
    found = run_shifted_disks(signorom, tmp_path, 3, **{"groups: auto": "groups: 2"})
    same_snapshots(found, one_rank, SAME)
    same_models(found, one_rank)


def test_paper_treatment_on_three_ranks(signorom, tmp_path):
    """dirichlet: multiplier has a null space of its own to get wrong."""
    results = []
    for n_ranks in (1, 3):
        folder = tmp_path / str(n_ranks)
        folder.mkdir()
        change = {"pod_tolerance: 1.0e-5": "pod_tolerance: 1.0e-5, dirichlet: multiplier"}
        results.append(run_shifted_disks(signorom, folder, n_ranks, **change))
    same_models(results[1], results[0])
    same_validation(results[1], results[0])


def test_enrichment_on_three_ranks(signorom, tmp_path):
    """Domain, hats and their order are choices: rounding must not make them."""
    change = {
        "pod_tolerance: 1.0e-5": "pod_tolerance: 1.0e-5, extra_modes: 1, dual_pod_tolerance: 1.0e-3, "
        "enrichment: {type: greedy, side: second, max_condition_number: 1}"
    }
    results, histories = [], []
    for n_ranks in (1, 3):
        folder = tmp_path / str(n_ranks)
        folder.mkdir()
        results.append(run_shifted_disks(signorom, folder, n_ranks, **change))
        with h5py.File(results[-1] / "model.h5") as file:
            cluster = file["clusters/1"]
            histories.append({name: values[()] for name, values in cluster["enrichment"].items()})
            assert cluster.attrs["n_hats"] == len(cluster["contact_rows"]) > 3
            assert cluster.attrs["basis_rank"] == len(cluster["basis"])
    same_models(results[1], results[0])
    for name in ("rows", "nodes", "ranks", "n_columns"):
        np.testing.assert_array_equal(histories[1][name], histories[0][name], err_msg=name)
    # the smallest singular values are 1e-4 of the largest
    np.testing.assert_allclose(histories[1]["singular_ratios"], histories[0]["singular_ratios"], rtol=1e-9)


@pytest.mark.parametrize("n_ranks", [1, 3])
@pytest.mark.parametrize("solver", ["active_set", "snesvi"])
def test_solvers(signorom, tmp_path, one_rank, solver, n_ranks):
    """Each solver's snapshots are those of the condensed one, on one rank and distributed."""
    deck = write_deck("shifted_disks", tmp_path, **ONE, **{"type: condensed": f"type: {solver}"})
    signorom("sample", deck.name, folder=tmp_path, n_ranks=n_ranks)
    same_snapshots(tmp_path / "results" / "shifted_disks", one_rank, SAME_SOLVER)


def test_units(signorom, tmp_path, one_rank):
    """mm, N, MPa against m, N, Pa: the same physics, the mesh file untouched."""
    changes = {
        "plane_strain}": "plane_strain, length_unit: m}\nunits: {length: mm, force: N}",
        "min: 0.15, max: 0.45, unit: m": "min: 150, max: 450, unit: mm",
        "min: -0.05, max: 0.1, unit: m": "min: -50, max: 100, unit: mm",
        "modulus: 15.0": "modulus: 15.0e-6",
        "modulus: 25.0": "modulus: 25.0e-6",
        "- shift^2": "- 1000 * (shift / 1000)^2",
        "{squeeze: 0.2, shift: 0.03}": "{squeeze: 200, shift: 30}",
    }
    found = run_shifted_disks(signorom, tmp_path, **changes)
    a, b = (read_snapshots(folder / "snapshots.h5") for folder in (found, one_rank))
    same(a["parameters"], 1000 * b["parameters"], 1e-14)
    same(a["displacement"], 1000 * b["displacement"], SAME_UNITS)
    same(a["multipliers"], b["multipliers"] / 1000, SAME_UNITS)  # N/mm and N/m
    with h5py.File(found / "model.h5") as a, h5py.File(one_rank / "model.h5") as b:
        for name in INDEX_SETS:
            np.testing.assert_array_equal(a["clusters/1"][name][()], b["clusters/1"][name][()], err_msg=name)
        kappa = b["clusters/1"].attrs["condition_number"]
        assert a["clusters/1"].attrs["condition_number"] == pytest.approx(kappa, rel=SAME_UNITS)
    same_validation(found, one_rank)
    with h5py.File(found / "fields.h5") as a, h5py.File(one_rank / "fields.h5") as b:
        same(a["mesh/coordinates"][()], 1000 * b["mesh/coordinates"][()], 1e-14)
        a, b = a["points/0001"], b["points/0001"]
        same(a["stress"][()], 1e-6 * b["stress"][()], SAME_UNITS)
        same(a["contact_pressure"][()], 1e-6 * b["contact_pressure"][()], SAME_UNITS)
        same(np.nan_to_num(a["gap"][()]), 1000 * np.nan_to_num(b["gap"][()]), SAME_UNITS)
        same(a["displacement_reduced"][()], 1000 * b["displacement_reduced"][()], SAME_UNITS)
        units = {name: a[name].attrs["unit"] for name in ("displacement", "stress", "gap", "contact_force")}
    decoded = {name: unit.decode() if isinstance(unit, bytes) else str(unit) for name, unit in units.items()}
    assert decoded == {"displacement": "mm", "stress": "MPa", "gap": "mm", "contact_force": "N/mm"}


def test_mesh_in_another_unit_than_the_deck(signorom, tmp_path, one_rank):
    """A mesh file in mm (1000 times the coordinates) and a deck in m."""
    deck = write_deck("shifted_disks", tmp_path, **{"plane_strain}": "plane_strain, length_unit: mm}"})
    mesh = next(word.rstrip(",") for word in deck.read_text().split() if word.endswith("small_disks.msh,"))
    scaled = meshio.read(mesh)
    scaled.points *= 1000
    meshio.write(tmp_path / "scaled.msh", scaled, file_format="gmsh22", binary=False)
    deck.write_text(deck.read_text().replace(mesh, "scaled.msh"))
    signorom("sample", deck.name, folder=tmp_path)
    a = read_snapshots(tmp_path / "results" / "shifted_disks" / "snapshots.h5")
    b = read_snapshots(one_rank / "snapshots.h5")
    same(a["displacement"], b["displacement"], SAME)
    same(a["multipliers"], b["multipliers"], SAME)


def test_more_ranks_than_points(signorom, tmp_path):
    """Two points on four ranks: two groups of two, or one of four."""
    displacements = []
    for n_ranks in (1, 4):
        deck = write_deck(
            "patch", tmp_path, **{"grid: {push: 5}": "grid: {push: 2}", "grid: {push: 7}": "grid: {push: 2}"}
        )
        signorom("run", deck.name, folder=tmp_path, n_ranks=n_ranks)
        displacements.append(read_snapshots(tmp_path / "results" / "patch" / "snapshots.h5")["displacement"])
        (tmp_path / "results").rename(tmp_path / f"results_{n_ranks}")
    same(displacements[1], displacements[0], SAME)
