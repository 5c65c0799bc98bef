# SPDX-License-Identifier: BSD-3-Clause
"""Case b at five points in both load modes, against an independent code (tests/reference/pellet_cladding.py)."""

import json

import h5py
import numpy as np
import pytest

from decks import copy_deck
from gmsh_ascii import read_mesh
from program import ROOT
from runs import read_fields

EXPECTED = json.loads((ROOT / "tests" / "reference" / "pellet_cladding_expected.json").read_text())
DECKS = {"cut": "pellet_cladding", "whole_edges": "pellet_cladding_whole_edges"}
TOLERANCE = 1e-8
PROBLEM, SOURCE = "case b, pellet and cladding", "independent NumPy code"
OLD_POINTS = "points: [{P1: 170, h1: 3.2}, {P1: 30, h1: 5.25}]"


def points_text(mode, length_scale=1.0, pressure_scale=1.0):
    """The reference's points as a deck has them."""
    entries = [
        f"{{P1: {point['pressure'] * pressure_scale}, h1: {point['length'] * length_scale}}}"
        for point in EXPECTED[mode]
    ]
    return "points: [" + ", ".join(entries) + "]"


def solve(signorom, folder, mode, changes):
    """Fields of every point, and the nodes of the contact rows."""
    deck = copy_deck(ROOT / "input" / f"{DECKS[mode]}.yaml", folder, **changes)
    signorom("solve", deck, folder=folder)
    path = folder / "results" / DECKS[mode] / "fields.h5"
    with h5py.File(path) as file:
        rows = file["contact/first/nodes"][()] - 1
    return [read_fields(path, i + 1) for i in range(len(EXPECTED[mode]))], rows


@pytest.fixture(scope="module")
def mesh():
    """The mesh by the reference's reader."""
    return read_mesh(ROOT / "meshes" / "pellet_cladding.msh")


def compare(answers, mode, mesh, length_scale=1.0):
    """Largest relative difference of multipliers by height and displacements at probes; fields in mm / length_scale."""
    fields, rows = answers
    by_height = np.argsort(mesh.coordinates[rows, 1])
    worst = 0.0
    probes = np.array(EXPECTED["probes"])
    coordinates = mesh.coordinates[:, :2]
    nodes = [int(np.argmin(np.linalg.norm(coordinates - probe, axis=1))) for probe in probes]
    assert np.linalg.norm(coordinates[nodes] - probes, axis=1).max() < 1e-9
    for result, point in zip(fields, EXPECTED[mode], strict=True):
        force = result["multipliers_full_order"][by_height]
        expected = np.array(point["multipliers"])
        worst = max(worst, np.abs(force - expected).max() / max(expected.max(), 1.0))
        u = result["displacement"][nodes, :2] / length_scale
        expected = np.array(point["displacement_at_probes"])
        worst = max(worst, np.abs(u - expected).max() / np.abs(expected).max())
    return worst


@pytest.mark.parametrize("mode", list(DECKS))
def test_case_b_agrees_with_an_independent_code(signorom, tmp_path, mesh, figures, mode):
    """Displacements and multipliers to 1e-8."""
    worst = compare(solve(signorom, tmp_path, mode, {OLD_POINTS: points_text(mode)}), mode, mesh)
    figures.at_most(PROBLEM, f"u and lambda at 5 points, {mode}", worst, TOLERANCE, SOURCE)


@pytest.mark.parametrize("mode", list(DECKS))
def test_meters_give_the_same(signorom, tmp_path, mesh, figures, mode):
    """The same problem in m, N, Pa: h1 = 5.25e-3 m is node 75 as well."""
    changes = {
        OLD_POINTS: points_text(mode, 1e-3, 1e6),
        "length: mm": "length: m",
        "model: axisymmetric": "model: axisymmetric, length_unit: mm",
        "min: 5.0, max: 200.0, unit: MPa": "min: 5.0e6, max: 200.0e6, unit: Pa",
        "min: 0.6, max: 6.0, unit: mm": "min: 0.6e-3, max: 6.0e-3, unit: m",
        "190.0e3": "190.0e9",
        "78.0e3": "78.0e9",
    }
    worst = compare(solve(signorom, tmp_path, mode, changes), mode, mesh, 1e-3)
    figures.at_most(PROBLEM, f"the same in m, N, Pa, {mode}", worst, TOLERANCE, SOURCE)
