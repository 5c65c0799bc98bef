# SPDX-License-Identifier: BSD-3-Clause
"""What `run` and `solve` leave behind: the report, the tables, fields that VTK opens."""

import re
import shutil
import xml.etree.ElementTree as ElementTree
from datetime import UTC, datetime, timedelta

import h5py
import numpy as np
import pytest
import yaml

from results import read_snapshots, read_table
from runs import refuse, write_deck
from vtk_fields import read_with_vtk

ERRORS = (
    "e_u",
    "e_lambda_rid",
    "e_lambda_all",
    "e_energy",
    "e_energy_rid",
    "e_energy_relative",
    "e_energy_rid_relative",
    "e_u_energy",
    "e_u_energy_relative",
    "e_von_mises_largest",
    "e_von_mises",
    "e_pressure",
)
N_TEST = 7
CORNERS = ["1 - 16", "15 - 30"]


@pytest.fixture(scope="module")
def study(signorom, tmp_path_factory):
    """Folder of a finished run on the small half disks."""
    folder = tmp_path_factory.mktemp("study")
    deck = write_deck("small_disks", folder)
    signorom("run", deck.name, "--benchmark", folder=folder)
    return folder


@pytest.fixture(scope="module")
def results(study):
    """Its results folder."""
    return study / "results" / "small_disks"


@pytest.fixture(scope="module")
def report(results):
    """Its report."""
    return yaml.safe_load((results / "report.yaml").read_text())


def test_files(results):
    """Exactly these files; what is hidden is a lock."""
    names = sorted(path.name for path in results.iterdir() if not path.name.startswith("."))
    assert names == [
        "contact.h5",
        "contact.xdmf",
        "enrichment.csv",
        "fields.h5",
        "fields.xdmf",
        "model.h5",
        "report.yaml",
        "snapshots.h5",
        "validation.csv",
    ]


def keys_of(section, path=""):
    """All key paths of nested mappings."""
    if not isinstance(section, dict):
        return {path}
    return {key for name, below in section.items() for key in keys_of(below, f"{path}/{name}")}


def test_stages_complete_the_report(signorom, report, tmp_path):
    """One command after the other says what `run` says; what a later training makes wrong is gone."""
    deck = write_deck("small_disks", tmp_path)
    path = tmp_path / "results" / "small_disks" / "report.yaml"

    def report_after(*arguments):
        signorom(*arguments, folder=tmp_path)
        return yaml.safe_load(path.read_text())

    signorom("sample", deck.name, folder=tmp_path)
    report_after("solve", deck.name)
    report_after("train", deck.name)
    assert keys_of(report_after("validate", deck.name, "--benchmark")) == keys_of(report)
    trained = report_after("train", deck.name)
    assert "errors" not in trained
    assert "speed_up" not in trained
    assert "query" not in trained["times"]
    assert trained["points"].keys() == report["points"].keys()
    deck.write_text(deck.read_text().replace("title: Two small half disks", "title: Others"))
    assert "points" not in report_after("train", deck.name)


def test_report_echoes_the_deck(signorom, study, report):
    """The effective deck, with every default."""
    effective = yaml.safe_load(signorom("check", "small_disks.yaml", folder=study))
    assert report["deck"] == effective
    assert report["deck"]["reduction"]["rank_tolerance"] > 0
    assert re.fullmatch(r"\d+\.\d+\.\d+", report["version"]["signorom"])
    assert {"petsc", "slepc", "mpi"} <= set(report["version"])
    assert re.fullmatch("[0-9a-f]{7,40}|", report["version"]["commit"])
    run = report["run"]
    assert re.fullmatch("[0-9a-f]{16}", run["mesh"])
    assert run["host"]
    assert "signorom" in run["command"]
    age = datetime.now(UTC) - datetime.fromisoformat(run["date"])
    assert timedelta(0) <= age + timedelta(seconds=1) < timedelta(hours=1)


def test_report_sizes_and_reduction(results, report):
    sizes = report["sizes"]
    assert (sizes["n_nodes"], sizes["n_cells"], sizes["n_dofs"], sizes["n_multipliers"]) == (88, 128, 176, 13)
    assert sizes["inert_pairs"] == CORNERS
    with h5py.File(results / "model.h5") as file:
        cluster = file["clusters/1"]
        reduction = report["reduction"]
        assert reduction["n_modes"] == cluster["basis"].shape[0]
        # numpy sees a Fortran array (n_rows, n_modes) transposed
        matrix = cluster["contact_matrix"][()].T
        stiffness = cluster["reduced_stiffness"][()]
    assert matrix.shape == (reduction["n_contact_rows"], reduction["n_modes"])
    # kappa is the ratio of the extreme singular values of M, cond that of K_r
    values = np.linalg.svd(matrix, compute_uv=False)
    assert reduction["condition_number"] == pytest.approx(values[0] / values[-1], rel=1e-10)
    assert reduction["rank"] == np.linalg.matrix_rank(matrix)
    assert reduction["stiffness_condition"] == pytest.approx(np.linalg.cond(stiffness), rel=1e-10)
    assert reduction["warnings"] == []


def test_history_of_the_enrichment_is_in_model_and_table(results):
    with h5py.File(results / "model.h5") as file:
        cluster = file["clusters/1"]
        history = cluster["enrichment"]
        # no enrichment: the state before the first hat is that of the model
        assert list(history["rows"]) == list(history["nodes"]) == [0]
        assert history["condition_numbers"][0] == cluster.attrs["condition_number"]
        assert history["stiffness_conditions"][0] == cluster.attrs["stiffness_condition"]
        assert history["n_columns"][0] == cluster.attrs["n_pod_modes"] == cluster["basis"].shape[0]
        assert cluster.attrs["stiffness_rank"] == cluster.attrs["basis_rank"] == cluster["basis"].shape[0]
        table = read_table(results / "enrichment.csv")
        assert list(table) == [
            *("cluster", "hat", "pair", "node", "n_columns", "rank", "condition_number", "singular_ratio"),
            "stiffness_condition",
        ]
        assert table["rank"] == cluster.attrs["rank"]
        # the table has seven digits
        assert table["condition_number"] == pytest.approx(cluster.attrs["condition_number"], rel=1e-6)


def test_report_iterations_residuals_and_times(report):
    assert 1 <= report["iterations"]["full_order"]["min"] <= report["iterations"]["full_order"]["max"] <= 50
    for name in ("equilibrium", "penetration", "negative_multiplier", "complementarity", "force_balance"):
        assert 0 <= report["residuals"][name] < 1e-10, name
    assert report["sampling"] == {"n_points": 15, "not_converged": []}
    times = report["times"]
    assert times["sample_per_point"]["median"] > 0
    assert all(times[name] > 0 for name in ("train", "query", "full_order_per_point", "refactored_per_point"))
    speed_up = report["speed_up"]
    assert speed_up["over_refactored"] == pytest.approx(times["refactored_per_point"] / times["query"])
    assert speed_up["over_condensed"] == pytest.approx(times["full_order_per_point"] / times["query"])
    for point in report["points"].values():
        assert point["status"] == "converged"
        assert all(0 <= value < 1e-10 for value in point["residuals"].values())


def test_report_statistics_are_those_of_the_table(results, report):
    table = read_table(results / "validation.csv")
    assert report["errors"]["n_points"] == N_TEST
    for name in ERRORS:
        values = table[name]
        statistics = report["errors"][name]
        # the table has seven digits
        assert statistics["min"] == pytest.approx(values.min(), rel=1e-6), name
        assert statistics["median"] == pytest.approx(np.median(values), rel=1e-6), name
        assert statistics["max"] == pytest.approx(values.max(), rel=1e-6), name
        assert np.sort(values)[-2] <= statistics["p95"] * (1 + 1e-6), name
        assert statistics["p95"] <= values.max() * (1 + 1e-6), name
    with h5py.File(results / "model.h5") as file:
        names = [name.decode() for name in file["validation/names"][()]]
        medians = dict(zip(names, file["validation/median"][()], strict=True))
    for name in ERRORS:
        assert medians[name] == pytest.approx(report["errors"][name]["median"], rel=1e-12)


def test_validation_table(results):
    table = read_table(results / "validation.csv")
    assert list(table) == [
        "squeeze",
        "cluster",
        *ERRORS,
        "n_active",
        "n_active_full_order",
        "solver",
        "n_solutions",
        "error_bound",
        "displacement_bound",
        "full_order",
    ]
    np.testing.assert_allclose(table["squeeze"], np.linspace(0.15, 0.45, N_TEST), rtol=1e-14)
    assert set(table["cluster"]) == {1}
    assert (table["n_active_full_order"] > 0).all()


def test_fields_are_complete(results):
    """Displacement, force, pressure, gap and reduced domain of each point, with units and meanings."""
    snapshots = read_snapshots(results / "snapshots.h5")
    with h5py.File(results / "fields.h5") as file:
        assert list(file["points"]) == ["0001", "0002"]
        assert file["mesh/coordinates"].shape == (88, 3)
        assert file["mesh/topology"].shape == (128, 3)
        first, second = (file[f"contact/{side}/nodes"][()] - 1 for side in ("first", "second"))
        coordinates = file["mesh/coordinates"][()]
        np.testing.assert_allclose(coordinates[first, 0], coordinates[second, 0], atol=1e-12)
        for point, squeeze in zip(file["points"].values(), (0.2, 0.4), strict=True):
            assert point.attrs["parameters"] == pytest.approx([squeeze])
            for name, dataset in point.items():
                assert dataset.attrs["unit"], name
                assert dataset.attrs["description"], name
            displacement, force, gap = (point[name][()] for name in ("displacement", "contact_force", "gap"))
            multipliers = point["multipliers_full_order"][()]
            # contact pushes the lower body down and the upper body up, with the multipliers
            np.testing.assert_allclose(force[first], -force[second], atol=1e-14)
            np.testing.assert_allclose(-force[first, 1], multipliers, atol=1e-14)
            np.testing.assert_array_equal(force[:, [0, 2]], 0)
            opening = (coordinates + displacement)[second, 1] - (coordinates + displacement)[first, 1]
            np.testing.assert_allclose(gap[first], opening, atol=1e-13)
            assert np.abs(opening[multipliers > 0]).max() < 1e-12
            assert opening.min() > -1e-12
            on_base = np.isclose(coordinates[:, 1], -1.05)
            np.testing.assert_allclose(displacement[on_base, 1], squeeze, rtol=1e-14)
            assert set(point["reduced_domain"][()]) == {0, 1}
            n_other = np.count_nonzero(np.isnan(gap))
            assert n_other == 88 - 2 * 13
    # 0.2 and 0.4 lie off the training grid; what is between two training points is between their solutions
    assert snapshots["displacement"].shape == (15, 176)


def test_xdmf_names_every_field_of_the_mesh(results):
    root = ElementTree.parse(results / "fields.xdmf").getroot()
    grids = root.findall("./Domain/Grid/Grid")
    assert len(grids) == 2
    with h5py.File(results / "fields.h5") as file:
        for grid, point in zip(grids, file["points"].values(), strict=True):
            numbers = {attribute.get("Name") for attribute in grid.findall("Attribute[@Center='Grid']")}
            assert numbers == {"squeeze [m]", "contact_1_area [m]"}
            names = {attribute.get("Name") for attribute in grid.findall("Attribute")} - numbers
            arrays = {
                name for name, dataset in point.items() if dataset.shape and dataset.shape[0] in (88, 128)
            }
            # it has no number off the contact surfaces
            assert names == arrays - {"gap"}
            for item in grid.iterfind(".//DataItem[@Format='HDF']"):
                name, path = item.text.strip().split(":")
                assert name == "fields.h5"
                # a tensor is a matrix of one row
                sizes = tuple(size for size in map(int, item.get("Dimensions").split()) if size > 1)
                assert file[path].shape == sizes


def test_vtk_opens_the_fields(results, tmp_path):
    """The folder may be moved; each point is a time step; values are those of HDF5."""
    moved = shutil.copytree(results, tmp_path / "moved")
    shown = read_with_vtk(moved / "fields.xdmf")
    assert list(shown) == [1.0, 2.0]
    with h5py.File(results / "fields.h5") as file:
        for step, point in zip(shown.values(), file["points"].values(), strict=True):
            assert (len(step.points), step.n_cells) == (88, 128)
            np.testing.assert_allclose(step.points, file["mesh/coordinates"][()], rtol=0, atol=1e-7)
            assert {"displacement", "contact_pressure", "stress_smoothed"} <= step.nodes.keys()
            assert {"reduced_domain", "stress", "region", "contact_status"} <= step.cells.keys()
            for name, values in (step.nodes | step.cells).items():
                np.testing.assert_array_equal(values, point[name][()], err_msg=name)
                assert np.isfinite(values).all(), name


def test_contact_surface_stands_alone(results):
    """The first surface as cells of its own: the values of the fields at its nodes, and which pairs are closed."""
    shown = read_with_vtk(results / "contact.xdmf")
    assert list(shown) == [1.0, 2.0]
    with h5py.File(results / "contact.h5") as file, h5py.File(results / "fields.h5") as fields:
        nodes, owners = file["mesh/nodes"][()] - 1, fields["contact/first/nodes"][()] - 1
        assert (len(nodes), len(owners)) == (15, 13)
        for step, point, whole in zip(
            shown.values(), file["points"].values(), fields["points"].values(), strict=True
        ):
            assert (len(step.points), step.n_cells) == (15, 14)
            for name in ("displacement", "contact_force", "contact_pressure", "gap"):
                np.testing.assert_array_equal(step.nodes[name], whole[name][()][nodes], err_msg=name)
            # nodes that are prescribed on both sides have no row
            is_closed = np.isin(nodes, owners[whole["multipliers_full_order"][()] > 0])
            expected = np.where(is_closed, 2, np.where(np.isin(nodes, owners), 1, 0))
            np.testing.assert_array_equal(step.nodes["status"], expected)
            assert 0 < is_closed.sum() < 13
            reduced = whole["multipliers_reduced"][()] / fields["contact/areas"][()]
            found = dict(zip(nodes, step.nodes["contact_pressure_reduced"], strict=True))
            np.testing.assert_allclose([found[node] for node in owners], reduced, rtol=1e-12)
            np.testing.assert_array_equal(step.cells["contact"], 1)
            for name, values in (step.nodes | step.cells).items():
                np.testing.assert_array_equal(values, point[name][()], err_msg=name)


def test_contact_surface_of_an_earlier_run_goes(signorom, tmp_path):
    """A run that writes no fields of contact leaves none of an earlier one."""
    deck = write_deck("small_disks", tmp_path)
    files = [tmp_path / "results" / "small_disks" / name for name in ("contact.h5", "contact.xdmf")]
    signorom("solve", deck.name, "--at", "squeeze=0.4", folder=tmp_path)
    assert all(file.exists() for file in files)
    deck.write_text(deck.read_text().replace("output:\n", "output:\n  fields: [displacement]\n"))
    signorom("solve", deck.name, "--at", "squeeze=0.3", folder=tmp_path)
    assert not any(file.exists() for file in files)


@pytest.mark.parametrize("n_ranks", [1, 3])
def test_solve_at_a_point(signorom, tmp_path, results, n_ranks):
    """No training, no model: the full-order fields of `run`, at a point of the command line."""
    deck = write_deck("small_disks", tmp_path)
    printed = signorom("solve", deck.name, "--at", "squeeze=0.4", folder=tmp_path, n_ranks=n_ranks)
    assert printed.splitlines()[-1].startswith("fields at 1 point: ")
    penetration, balance = re.search(r"largest penetration (\S+) m, force balance (\S+)", printed).groups()
    assert 0 <= float(penetration) < 1e-12
    assert 0 <= float(balance) < 1e-10
    folder = tmp_path / "results" / "small_disks"
    with h5py.File(folder / "fields.h5") as a, h5py.File(results / "fields.h5") as b:
        assert list(a["points"]) == ["0001"]
        for name in ("displacement", "contact_force"):
            found, expected = a["points/0001"][name][()], b["points/0002"][name][()]
            np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())
    report = yaml.safe_load((folder / "report.yaml").read_text())
    assert report["points"]["1"]["point"] == "squeeze = 0.4 m"
    reactions = report["points"]["1"]["reactions"]
    assert [entry["boundary"] for entry in reactions.values()] == ["lower_base", "upper_base"]
    pushed = report["points"]["1"]["contact_force"]
    assert reactions["1"]["y"] == pytest.approx(pushed, rel=1e-9)
    assert reactions["2"]["y"] == pytest.approx(-pushed, rel=1e-9)


@pytest.mark.parametrize(
    ("at", "message"),
    [
        (
            "squeeze=1.1",
            "small_disks.yaml:11:13: error: the prescribed displacements and the gap press nodes 1 and 16",
        ),
        ("squeez=0.2", "error: unknown parameter 'squeez' in --at; the parameters are squeeze"),
    ],
)
def test_solve_at_a_wrong_point(signorom, tmp_path, at, message):
    deck = write_deck("small_disks", tmp_path)
    assert refuse(signorom, "solve", deck.name, "--at", at, folder=tmp_path).startswith(message)


def test_stages_one_by_one_leave_what_run_leaves(signorom, tmp_path, results):
    deck = write_deck("small_disks", tmp_path)
    for command in ("sample", "train", "validate"):
        signorom(command, deck.name, folder=tmp_path)
    folder = tmp_path / "results" / "small_disks"
    a, b = read_table(folder / "validation.csv"), read_table(results / "validation.csv")
    assert list(a) == list(b)
    for name in ("e_u", "n_active", "n_active_full_order"):
        np.testing.assert_allclose(a[name], b[name], rtol=0, atol=1e-14)


def test_deck_without_test_points(signorom, tmp_path):
    """`run` leaves the validation out; `validate` asks for points."""
    deck = write_deck("small_disks", tmp_path, **{"test: {grid: {squeeze: 7}}\n": ""})
    signorom("run", deck.name, folder=tmp_path)
    folder = tmp_path / "results" / "small_disks"
    assert (folder / "model.h5").is_file()
    assert not (folder / "validation.csv").exists()
    words = refuse(signorom, "validate", deck.name, folder=tmp_path)
    assert words.startswith("small_disks.yaml: error: the deck has no test section")


def test_deck_without_training_points(signorom, tmp_path):
    deck = write_deck("small_disks", tmp_path, **{"training: {grid: {squeeze: 15}}\n": ""})
    for command in ("sample", "train", "run"):
        words = refuse(signorom, command, deck.name, folder=tmp_path)
        assert words.startswith("small_disks.yaml: error: the deck has no training section")


def test_deck_without_output_points(signorom, tmp_path):
    """Fields are then written at the middle of the ranges."""
    deck = write_deck(
        "small_disks", tmp_path, **{"output:\n  points: [{squeeze: 0.2}, {squeeze: 0.4}]\n": ""}
    )
    signorom("solve", deck.name, folder=tmp_path)
    report = yaml.safe_load((tmp_path / "results" / "small_disks" / "report.yaml").read_text())
    assert [point["point"] for point in report["points"].values()] == ["squeeze = 0.3 m"]


@pytest.mark.parametrize("n_ranks", [1, 2])
def test_points_that_do_not_converge(signorom, tmp_path, n_ranks):
    """Three steps are too few for some points: they are marked and left out, the rest is used, exit code 3."""
    changes = {"{type: condensed}": "{type: active_set, max_iterations: 3}", "max: 0.45": "max: 0.9"}
    deck = write_deck("small_disks", tmp_path, **changes)
    sampled = signorom.run("sample", deck.name, folder=tmp_path, n_ranks=n_ranks)
    assert sampled.returncode == 3
    n_failed = int(re.search(r"warning: (\d+) of the points did not converge", sampled.stderr).group(1))
    snapshots = read_snapshots(tmp_path / "results" / "small_disks" / "snapshots.h5")
    assert 0 < n_failed == (snapshots["reasons"] < 0).sum() < 15
    failed = snapshots["parameters"][snapshots["reasons"] < 0][0, 0]
    deck.write_text(deck.read_text().replace("{squeeze: 0.4}", f"{{squeeze: {float(failed)!r}}}"))
    done = signorom.run("run", deck.name, folder=tmp_path, n_ranks=n_ranks)
    assert done.returncode == 3, done.stderr
    assert len(re.findall(r"warning: training without squeeze = ", done.stderr)) == n_failed
    report = yaml.safe_load((tmp_path / "results" / "small_disks" / "report.yaml").read_text())
    assert len(report["sampling"]["not_converged"]) == n_failed
    # the files have the fields of the points that converged, and no others
    solved = [point["point"] for point in report["points"].values() if point["status"] == "converged"]
    assert solved == ["squeeze = 0.2 m"]
    with h5py.File(tmp_path / "results" / "small_disks" / "fields.h5") as file:
        assert [point.attrs["label"] for point in file["points"].values()] == solved
    # enough steps: the marked points are tried again, the others kept
    deck.write_text(deck.read_text().replace("max_iterations: 3", "max_iterations: 20"))
    assert f"({15 - n_failed} were there)" in signorom("run", deck.name, folder=tmp_path, n_ranks=n_ranks)


def test_no_point_converges(signorom, tmp_path):
    """A numerical failure, not a fault of the user: exit code 3, and no model."""
    deck = write_deck(
        "small_disks", tmp_path, **{"{type: condensed}": "{type: active_set, max_iterations: 1}"}
    )
    done = signorom.run("run", deck.name, folder=tmp_path)
    assert done.returncode == 3
    assert "error: none of the 15 training points has a full-order solution" in done.stderr
    assert not (tmp_path / "results" / "small_disks" / "model.h5").exists()
