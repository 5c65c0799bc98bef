# SPDX-License-Identifier: BSD-3-Clause
"""Paper case a: the program against the paper's limits and the figures of tests/reference."""

import json

import h5py
import numpy as np
import pytest
import yaml

from contact_reference import checksum
from runs import ROOT, read_snapshots, read_table

DECKS = {"elastic_lifting": "half_disks", "multiplier": "half_disks_multiplier"}
# Two codes that factor K differently agree to rounding times cond(K), about 1e4.
SAME_SOLUTION = 1e-8
# Solvers that factor the same K.
SAME_SOLVER = 1e-9
PROBLEM, SOURCE = "case a, half disks", "independent NumPy code"
# Reduced multipliers differ by rounding times cond(K_r), and errors of 1e-5 show that magnified.
SAME_ERROR = 1e-4
# Non-negative least squares on nearly dependent snapshots: coefficients are less sharply defined.
SAME_RECONSTRUCTION = 5e-2
TRAINING_STEP = 0.01


@pytest.fixture(scope="module")
def expected():
    """Committed output of the reference, which must be of the committed mesh."""
    return json.loads((ROOT / "tests" / "reference" / "half_disks_expected.json").read_text())


@pytest.fixture(scope="module", params=["elastic_lifting", "multiplier"])
def results(request, signorom, tmp_path_factory, expected):
    """Results folder of `run` (the paper's way on two ranks), the treatment, what the reference expects."""
    folder = tmp_path_factory.mktemp("half_disks")
    name = DECKS[request.param]
    n_ranks = 2 if request.param == "multiplier" else 1
    signorom("run", ROOT / "input" / f"{name}.yaml", folder=folder, n_ranks=n_ranks)
    found = folder / "results" / name
    with h5py.File(found / "model.h5") as file:
        mesh_hash = file.attrs["mesh_hash"]
        mesh_hash = mesh_hash.decode() if isinstance(mesh_hash, bytes) else str(mesh_hash)
    assert mesh_hash == expected["mesh_hash"], "another mesh: rerun tests/reference/half_disks.py --write"
    return found, request.param, expected[request.param]


def test_full_order_solutions(results, expected, figures):
    """Displacement and multipliers at five training points."""
    snapshots = read_snapshots(results[0] / "snapshots.h5")
    assert snapshots["displacement"].shape == (31, 2 * expected["n_nodes"])
    assert snapshots["multipliers"].shape == (31, expected["n_multipliers"])
    worst = compare_solutions(snapshots, expected)
    name = f"u and lambda at 5 points, deck with {results[1]}"
    figures.at_most(PROBLEM, name, worst, SAME_SOLUTION, SOURCE)


@pytest.mark.parametrize(
    ("solver", "n_ranks"), [("active_set", 1), ("active_set", 3), ("snesvi", 1), ("snesvi", 2)]
)
def test_solvers_agree(signorom, tmp_path, expected, figures, solver, n_ranks):
    """The other two full-order solvers give the same multipliers and displacements as the reference."""
    text = (ROOT / "input" / "half_disks.yaml").read_text()
    assert "type: condensed" in text
    text = text.replace("../meshes", str(ROOT / "meshes")).replace("type: condensed", f"type: {solver}")
    deck = tmp_path / "half_disks.yaml"
    deck.write_text(text)
    signorom("sample", deck, folder=tmp_path, n_ranks=n_ranks)
    snapshots = read_snapshots(tmp_path / "results" / "half_disks" / "snapshots.h5")
    name = f"u and lambda, {solver}, {n_ranks} rank{'s' if n_ranks > 1 else ''}"
    figures.at_most(PROBLEM, name, compare_solutions(snapshots, expected), SAME_SOLVER, SOURCE)


def compare_solutions(snapshots, expected):
    """Largest relative difference of displacement and multipliers at the training points that the reference kept."""
    assert (snapshots["reasons"] > 0).all()
    worst = 0.0
    for point in expected["training_points"]:
        i_point = int(np.abs(snapshots["parameters"][:, 0] - point["squeeze"]).argmin())
        assert snapshots["parameters"][i_point, 0] == pytest.approx(point["squeeze"], rel=1e-14)
        u, multipliers = snapshots["displacement"][i_point], snapshots["multipliers"][i_point]
        norm = point["displacement_norm"]
        difference = np.abs(multipliers - point["multipliers"]).max() / point["multipliers_norm"]
        sums = abs(checksum(u) - point["displacement_checksum"]) / norm
        worst = max(worst, difference, sums, abs(np.linalg.norm(u) / norm - 1))
        assert (multipliers > 0).sum() == point["n_active"]
    return worst


def test_contact_conditions_hold(results):
    """Residuals of equilibrium, penetration, sign and complementarity of every snapshot."""
    snapshots = read_snapshots(results[0] / "snapshots.h5")
    assert (snapshots["reasons"] > 0).all()
    assert np.abs(snapshots["residuals"]).max() <= 1e-9


def test_reduced_model(results):
    """Modes, interpolation nodes, reduced domain and condition numbers."""
    folder, _, reference = results
    with h5py.File(folder / "model.h5") as file:
        cluster = file["clusters/1"]
        assert cluster["basis"].shape[0] == reference["n_basis_columns"]
        assert sorted(cluster["seed_nodes"][()].tolist()) == sorted(reference["seed_nodes"])
        assert cluster["facing_nodes"][()].tolist() == reference["facing_nodes"]
        assert cluster["contact_rows"][()].tolist() == reference["contact_rows"]
        assert cluster["cells"].shape == (reference["n_cells"],)
        assert cluster["interior_dofs"].shape == (reference["n_interior_dofs"],)
        assert cluster["interface_dofs"].shape == (reference["n_interface_dofs"],)
        assert cluster.attrs["condition_number"] == pytest.approx(reference["condition_number"], rel=1e-6)
        assert cluster.attrs["stiffness_condition"] == pytest.approx(
            reference["stiffness_condition"], rel=1e-6
        )
        assert cluster.attrs["rank"] == reference["n_contact_rows"]
        n_kept = reference["n_modes"] + 1
        found = cluster["singular_values"][:n_kept]
    np.testing.assert_allclose(found, reference["singular_values"][:n_kept], rtol=1e-7)


def test_errors_are_those_of_the_reference(results):
    """Minimum, median, p95 and maximum of (17)-(19) over the 101 points."""
    folder, _, reference = results
    table = read_table(folder / "validation.csv")
    assert len(table["squeeze"]) == 101
    for name in ("e_u", "e_lambda_rid"):
        for key, value in statistics(table[name]).items():
            assert value == pytest.approx(reference["errors"][name][key], rel=SAME_ERROR, abs=1e-9), (
                name,
                key,
            )
    for name in ("e_energy", "e_energy_rid", "e_energy_relative", "e_energy_rid_relative"):
        for key in ("median", "max"):
            value = statistics(table[name])[key]
            assert value == pytest.approx(reference["errors"][name][key], rel=SAME_ERROR, abs=1e-11), (
                name,
                key,
            )
    for key in ("median", "p95", "max"):
        value = statistics(table["e_lambda_all"])[key]
        assert value == pytest.approx(reference["errors"]["e_lambda_all"][key], rel=SAME_RECONSTRUCTION), key
    limit = SAME_ERROR * np.array(reference["e_lambda_rid_of_points"]) + 1e-9
    assert (np.abs(table["e_lambda_rid"] - reference["e_lambda_rid_of_points"]) <= limit).all()


def statistics(values):
    """As in the reference."""
    return {
        "min": values.min(),
        "median": np.median(values),
        "p95": np.percentile(values, 95),
        "max": values.max(),
    }


def test_errors_stay_within_the_paper(results, expected, figures):
    """Section 5.1: e_u < 5e-4, e_ener < 1e-4; e_lambda above 8e-3 only beside a change of status."""
    folder, _, reference = results
    table = read_table(folder / "validation.csv")
    treatment = results[1]
    figures.at_most(
        PROBLEM, f"e_u, largest of 101 points, {treatment}", table["e_u"].max(), 5e-4, "the paper, 5.1"
    )
    name = f"e_ener, largest of 101 points, {treatment}"
    figures.at_most(PROBLEM, name, table["e_energy"].max(), 1e-4, "the paper, 5.1")
    assert table["e_energy_rid"].max() <= 1e-4
    assert np.median(table["e_lambda_rid"]) <= 2e-3
    rows = set(reference["contact_rows"])
    changes = [change["squeeze"] for change in expected["status_changes"] if rows & set(change["rows"])]
    for squeeze in table["squeeze"][table["e_lambda_rid"] > 8e-3]:
        distance = np.abs(np.array(changes) - squeeze).min()
        assert distance <= TRAINING_STEP, f"squeeze = {squeeze} is {distance} away from a change of status"


def test_sizes_of_the_paper(results, figures):
    """Section 5.1, prescribed values as in the paper: l = 9, 8 multipliers, kappa = 3.4 (3.2 here)."""
    folder, treatment, reference = results
    if treatment == "multiplier":
        with h5py.File(folder / "model.h5") as file:
            n_rows = len(file["clusters/1/contact_rows"])
            kappa = file["clusters/1"].attrs["condition_number"]
        source = "the paper, 5.1"
        n_modes = yaml.safe_load((folder / "report.yaml").read_text())["reduction"]["n_modes"]
        figures.compare(PROBLEM, "modes at 1e-8", n_modes, 9, 0, source, kind="absolute")
        figures.compare(PROBLEM, "contact pairs in the RID", n_rows, 8, 0, source, kind="absolute")
        # half a unit of the paper's last digit, and what another mesh of the interior makes (meshes/README.md)
        figures.compare(PROBLEM, "kappa of the contact rows", kappa, 3.4, 0.35, source, kind="absolute")
    report = (folder / "report.yaml").read_text()
    assert f"n_modes: {reference['n_modes']}\n" in report
    assert f"n_contact_rows: {reference['n_contact_rows']}\n" in report


def test_left_out_modes_carry_the_tail(results):
    """POD: sum of squared projection errors = sum of the squared singular values left out."""
    folder, treatment, reference = results
    snapshots = read_snapshots(folder / "snapshots.h5")
    with h5py.File(folder / "model.h5") as file:
        basis, lifting = file["clusters/1/basis"][()], file["clusters/1/lifting"][()]
        values = file["clusters/1/singular_values"][()]
    n_modes = reference["n_modes"]
    fields, modes = snapshots["displacement"], basis
    if treatment == "elastic_lifting":
        assert snapshots["term_texts"] == ["1", "squeeze", "-squeeze"]
        squeeze = snapshots["parameters"][:, 0]
        theta = np.stack([np.ones_like(squeeze), squeeze, -squeeze], axis=1)
        fields = fields - theta @ snapshots["free_response"]
        np.testing.assert_allclose(basis @ basis.T, np.eye(n_modes), rtol=0, atol=1e-12)
    else:
        # the modes are split into those that keep the prescribed values and one that carries them
        modes = np.linalg.svd(np.vstack([basis, lifting]), full_matrices=False)[2][:n_modes]
    error = np.sum((fields - fields @ modes.T @ modes) ** 2)
    assert error == pytest.approx(np.sum(values[n_modes:] ** 2), rel=1e-6)


def test_fields_hold_both_answers(results, expected):
    """fields.h5 at squeeze = 0.3: the reference's multipliers, reduced ones with the reference's error."""
    folder, _, reference = results
    point = next(p for p in expected["training_points"] if abs(p["squeeze"] - 0.3) < 1e-12)
    rows = np.array(reference["contact_rows"]) - 1
    with h5py.File(folder / "fields.h5") as file:
        assert file["mesh/coordinates"].shape == (expected["n_nodes"], 3)
        at_point = [group for group in file["points"].values() if is_at(group, 0.3)]
        assert len(at_point) == 1
        multipliers = at_point[0]["multipliers_full_order"][()]
        reduced = at_point[0]["multipliers_reduced"][()]
        u = at_point[0]["displacement"][()]
    full_order = np.array(point["multipliers"])
    np.testing.assert_allclose(
        multipliers, full_order, rtol=0, atol=SAME_SOLUTION * point["multipliers_norm"]
    )
    assert np.linalg.norm(u) == pytest.approx(point["displacement_norm"], rel=SAME_SOLUTION)
    error = np.linalg.norm(reduced[rows] - full_order[rows]) / np.linalg.norm(full_order[rows])
    assert error == pytest.approx(reference["e_lambda_rid_of_points"][50], rel=SAME_ERROR, abs=1e-9)


def is_at(group, squeeze):
    """The group's parameter point is this one."""
    return abs(float(np.ravel(group.attrs["parameters"])[0]) - squeeze) < 1e-12
