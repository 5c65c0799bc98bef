# SPDX-License-Identifier: BSD-3-Clause
"""Errors of displacements and stresses in validation.csv, computed anew from what the files of fields hold."""

import csv
import re
from pathlib import Path

import h5py
import numpy as np
import pytest
import yaml

from contact_reference import assemble, cell_stiffnesses, hooke_plane_strain
from decks import copy_deck
from gmsh_ascii import read_mesh
from results import read_fields, read_table

TESTS = Path(__file__).resolve().parents[1]
DECKS, MESH = TESTS / "integration" / "decks", TESTS / "integration" / "meshes" / "small_disks.msh"
POINTS = (0.15, 0.3, 0.45)
# E and nu of the deck
POISSON = 0.35
HOOKE = hooke_plane_strain(15.0, POISSON)
# the table has seven digits
ROUNDING = 1e-6


@pytest.fixture(scope="module")
def results(signorom, tmp_path_factory):
    """Results folder of a model with two modes, which are too few; its fields at the test points are there, too."""
    folder = tmp_path_factory.mktemp("disks")
    changes = {
        "{grid: {squeeze: 7}}": f"{{grid: {{squeeze: {len(POINTS)}}}}}",
        "pod_tolerance: 1.0e-8": "n_modes: 2, fields: true",
        "[{squeeze: 0.2}, {squeeze: 0.4}]": ", ".join(f"{{squeeze: {x}}}" for x in POINTS).join("[]"),
    }
    deck = copy_deck(DECKS / "small_disks.yaml", folder, **changes)
    signorom("run", deck.name, folder=folder)
    with (folder / "points.csv").open("w") as file:
        csv.writer(file).writerows([["squeeze"], *([x] for x in POINTS)])
    found = folder / "results" / "small_disks"
    asked = ("--points", "points.csv", "--fields", "--output", found / "found.csv")
    signorom("predict", found / "model.h5", *asked, folder=folder)
    return found


@pytest.fixture(scope="module")
def fields(results):
    """Fields of the answers and of the full order at each point."""
    return [
        (
            read_fields(results / "found_fields" / "fields.h5", i + 1),
            read_fields(results / "fields.h5", i + 1),
        )
        for i in range(len(POINTS))
    ]


def displacement_of(found):
    """Displacement of all dofs, node by node."""
    return found["displacement"][:, :2].ravel()


def test_energy_error_is_that_of_an_assembled_stiffness(results, fields, figures):
    """sqrt((u_r - u)' K (u_r - u)) over sqrt(u' K u), with K from the coordinates of the mesh."""
    mesh = read_mesh(MESH)
    with h5py.File(results / "fields.h5") as file:
        np.testing.assert_array_equal(file["mesh/coordinates"][:, :2], mesh.coordinates)
    stiffness = assemble(mesh, cell_stiffnesses(mesh, HOOKE))
    table = read_table(results / "validation.csv")
    assert table["e_u_energy_relative"].min() > 1e-3
    for i in range(len(POINTS)):
        reduced, exact = map(displacement_of, fields[i])
        wrong, whole = (np.sqrt(u @ stiffness @ u) for u in (reduced - exact, exact))
        found = table["e_u_energy_relative"][i]
        problem = f"half disks, two modes, squeeze = {POINTS[i]}"
        figures.compare(problem, "e_u_energy_relative", found, wrong / whole, ROUNDING, "assembled by NumPy")
        assert table["e_u_energy"][i] == pytest.approx(wrong, rel=ROUNDING)


def von_mises_of(displacement, cells, coordinates):
    """Von Mises stress of triangles in plane strain from the displacement, by the slopes of a linear function."""
    ends = coordinates[cells]
    edges = (ends[:, 1:] - ends[:, :1]).transpose(0, 2, 1)
    moved = displacement.reshape(-1, 2)[cells]
    changes = (moved[:, 1:] - moved[:, :1]).transpose(0, 2, 1)
    slopes = changes @ np.linalg.inv(edges)
    strains = np.stack([slopes[:, 0, 0], slopes[:, 1, 1], slopes[:, 0, 1] + slopes[:, 1, 0]])
    xx, yy, xy = HOOKE @ strains
    zz = POISSON * (xx + yy)
    return np.sqrt(((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * xy**2)


def test_errors_of_stresses_and_pressures(results, fields, figures):
    """The larger error of cells and nodes: cells by hand, smoothed values at nodes as the fields have them."""
    table = read_table(results / "validation.csv")
    with h5py.File(results / "fields.h5") as file:
        cells, coordinates = file["mesh/topology"][()], file["mesh/coordinates"][:, :2]
    for i in range(len(POINTS)):
        pairs = [
            [von_mises_of(displacement_of(found), cells, coordinates) for found in fields[i]],
            [found["von_mises_smoothed"] for found in fields[i]],
        ]
        largest = max(abs(answered.max() / exact.max() - 1) for answered, exact in pairs)
        anywhere = max(abs(answered - exact).max() / exact.max() for answered, exact in pairs)
        problem = f"half disks, two modes, squeeze = {POINTS[i]}"
        expected = {"e_von_mises_largest": largest, "e_von_mises": anywhere}
        answered, exact = (found["contact_pressure"] for found in fields[i])
        expected["e_pressure"] = abs(answered - exact).max() / exact.max()
        for name, error in expected.items():
            figures.compare(problem, name, table[name][i], error, ROUNDING, "fields of both, by NumPy")


def test_verdict_counts_fields(signorom, results):
    """The deck wants fields and two modes cannot give them: both sentences, repeated where the model is used."""
    report = yaml.safe_load((results / "report.yaml").read_text())["validation"]
    table = read_table(results / "validation.csv")
    energy, stress = (
        np.quantile(table[name], 0.95) for name in ("e_u_energy_relative", "e_von_mises_largest")
    )
    assert max(energy, stress) > 0.01
    assert report["accepted"] is False
    assert report["fields"].startswith("NOT accepted: p95 of e_u_energy_relative is ")
    told = [float(number) for number in re.findall(r"(?:is|largest) ([0-9.e-]+)[, ]", report["fields"])]
    assert told == pytest.approx([energy, stress, 0.01], rel=1e-3)
    done = signorom.run("predict", "model.h5", "--at", "squeeze=0.2", folder=results)
    assert "the validation of this model: NOT accepted: " in done.stderr
