# SPDX-License-Identifier: BSD-3-Clause
"""Case b with 100 cells of the pellet facing 73 of the cladding: reduced models on rows that mortar makes."""

import itertools
import re
import shutil

import numpy as np
import pytest

from gmsh_mesh import make_mesh
from runs import INPUT, MESHES, read_report, read_snapshots, read_table, write_input

NAME = "pellet_cladding"
TEXT = (INPUT / f"{NAME}.yaml").read_text()
REDUCTION = "reduction:" + TEXT.split("\nreduction:")[1].split("output:")[0]
CERTIFICATE = TEXT[TEXT.index("certificate:") :]
N_COARSE = 73
MORTAR = "case b, 100 facing 73 cells"


@pytest.fixture(scope="module")
def meshes(tmp_path_factory):
    """The mesh of the case, and one whose cladding has fewer cells along the axis."""
    folder = tmp_path_factory.mktemp("meshes")
    source = (MESHES / f"{NAME}.geo").read_text()
    old = "= n_axial + 1;"
    assert source.count(old) == 1
    (folder / "coarse.geo").write_text(source.replace(old, f"= n_axial + 1 - body * (n_axial - {N_COARSE});"))
    return {
        "matching": MESHES / f"{NAME}.msh",
        "mortar": make_mesh(folder / "coarse.geo", folder / "coarse.msh"),
    }


def write_case(folder, mesh, changes):
    """The deck with fewer points on one of the meshes."""
    few = {
        "grid: {P1: 10, h1: 50}": "grid: {P1: 8, h1: 25}",
        "grid: {P1: 80, h1: 80}": "grid: {P1: 9, h1: 9}",
    }
    deck = write_input(NAME, folder, few | changes)
    deck.write_text(deck.read_text().replace(str(MESHES / f"{NAME}.msh"), str(mesh)))
    return deck


def test_default_model_is_exact(signorom, tmp_path, figures, meshes):
    """The forces of the default model against active_set, which knows nothing of W."""
    points = np.random.default_rng(73).uniform([5, 0.6], [200, 6], (12, 2))
    lines = "\n".join(",".join(map(repr, row)) for row in points.tolist())
    deck = write_case(tmp_path, meshes["mortar"], {REDUCTION: "", CERTIFICATE: ""})
    (tmp_path / "points.csv").write_text(f"P1,h1\n{lines}\n")
    assert "'fuel_surface' faces 'cladding_inside'" in signorom("check", deck, folder=tmp_path)
    signorom("sample", deck, folder=tmp_path)
    signorom("train", deck, folder=tmp_path)
    model = tmp_path / "results" / NAME / "model.h5"
    signorom("predict", model, "--points", "points.csv", "--output", "answers.csv", folder=tmp_path)
    answers = read_table(tmp_path / "answers.csv")
    assert set(answers["status"]) == {"answered"}
    found = np.column_stack([answers[name] for name in answers if name.startswith("lambda_")])
    shutil.rmtree(tmp_path / "results")
    text = deck.read_text().replace("grid: {P1: 8, h1: 25}", "file: points.csv")
    deck.write_text(text.replace("solver: {type: condensed}", "solver: {type: active_set}"))
    signorom("sample", deck, folder=tmp_path)
    expected = read_snapshots(tmp_path / "results" / NAME / "snapshots.h5")["multipliers"]
    worst = (np.linalg.norm(found - expected, axis=1) / np.linalg.norm(expected, axis=1)).max()
    figures.at_most(MORTAR, "forces of the default model", worst, 1e-9, "solver active_set")


def line_mortar(n_first, n_second):
    """Rows of dual mortar contact of two lines from 0 to 1: owners, then shares, by two Gauss points per common part."""
    first, second = np.linspace(0, 1, n_first + 1), np.linspace(0, 1, n_second + 1)
    cuts = np.union1d(first, second)
    shares = np.zeros((n_first + 1, n_second + 1))
    areas = np.zeros(n_first + 1)
    for start, end in itertools.pairwise(cuts):
        for place in (start + end + np.array([-1, 1]) * (end - start) / np.sqrt(3)) / 2:
            i, k = np.searchsorted(first, place) - 1, np.searchsorted(second, place) - 1
            s, t = place * n_first - i, place * n_second - k
            # 2 N_1 - N_2 and 2 N_2 - N_1 are dual to the linear functions of an edge
            dual = np.array([2 - 3 * s, 3 * s - 1]) * (end - start) / 2
            areas[i : i + 2] += dual
            shares[i : i + 2, k : k + 2] += np.outer(dual, [1 - t, t])
    return np.hstack([np.eye(n_first + 1), -shares / areas[:, None]])


def test_condition_number_of_the_rows(signorom, tmp_path, figures, meshes):
    """On straight edges of a cylinder 2 pi r cancels: rows of two lines, whose ends are as free as their middles."""
    expected = np.linalg.cond(line_mortar(100, N_COARSE))
    deck = write_case(tmp_path, meshes["mortar"], {})
    said = signorom("check", deck, folder=tmp_path)
    (found,) = re.findall(r"# condition number of the contact matrix B: ([\d.]+)", said)
    figures.compare(
        MORTAR, "condition number of B", float(found), expected, 1e-3, "rows by NumPy; elsewhere: 1.5"
    )


def test_hyper_reduction_is_as_with_matching_nodes(signorom, tmp_path, figures, meshes):
    """With the keys of the paper; hats are of the nodes that own a row. Their condition number is at most the deck's."""
    medians = {}
    for name, mesh in meshes.items():
        folder = tmp_path / name
        folder.mkdir()
        deck = write_case(folder, mesh, {"side: second": "side: first"})
        for command in ("sample", "train", "validate"):
            signorom(command, deck, folder=folder)
        report = read_report(folder, NAME)
        errors = read_table(folder / "results" / NAME / "validation.csv")["e_lambda_rid"]
        medians[name] = np.nanmedian(errors)
        condition = report["reduction"]["condition_number"]
        figures.at_most(f"case b, {name}", "condition number of B", condition, 10.0, "max_condition_number")
    figures.at_most(
        MORTAR,
        "median of e_lambda_rid over that of matching nodes",
        medians["mortar"] / medians["matching"],
        1.5,
        "as good",
    )
