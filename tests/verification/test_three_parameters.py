# SPDX-License-Identifier: BSD-3-Clause
"""pellet_cladding_three_parameters.yaml: two faces of its box are known, and its local models are measured."""

import json
import os
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

from gmsh_ascii import read_mesh
from lame import ThickCylinder
from runs import MESHES, ROOT, read_table, solve_deck, write_input

EXPECTED = json.loads((ROOT / "tests" / "reference" / "pellet_cladding_expected.json").read_text())["cut"]
NAME = "pellet_cladding_three_parameters"
POINTS = "[{P1: 170, h1: 3.2, P2: 0}, {P1: 30, h1: 5.25, P2: 8}]"
PROBLEM = "pellet and cladding, P1, h1, P2"
# mm, MPa
FUEL_RADIUS, GAP, THICKNESS, HEIGHT = 4.1, 2.0e-3, 0.57, 7.0
FUEL, CLADDING = (190.0e3, 0.3), (78.0e3, 0.34)
# what section 5.2.2 was agreed to mean for three clusters of two parameters: median, 95 %, share of points above 10 %
LIMITS = (0.04, 0.18, 0.12)


def solve_at(signorom, folder, points):
    """Fields at points (P1, h1, P2)."""
    text = ", ".join(f"{{P1: {p}, h1: {h}, P2: {q}}}" for p, h, q in points)
    return solve_deck(signorom, write_input(NAME, folder, {POINTS: f"[{text}]"}))[0]


def contact_pressure(outer_pressure):
    """[MPa] of a bar in a tube of any length, both held along the axis: gap = what each of them gives way, Lamé."""
    inner = FUEL_RADIUS + GAP

    def opening(pressure):
        tube = ThickCylinder(*CLADDING, inner, inner + THICKNESS, pressure, outer_pressure)
        bar = ThickCylinder(*FUEL, 0.0, FUEL_RADIUS, 0.0, pressure)
        return GAP + tube.displacement(inner) - bar.displacement(FUEL_RADIUS)

    # linear in the pressure
    return opening(0.0) / (opening(0.0) - opening(1.0))


def test_without_a_second_pressure_it_is_case_b(signorom, tmp_path, figures):
    """Contact forces of the independent code at five points."""
    fields = solve_at(signorom, tmp_path, [(p["pressure"], p["length"], 0.0) for p in EXPECTED])
    heights = read_mesh(MESHES / "pellet_cladding.msh").coordinates[:, 1]
    with h5py.File(tmp_path / "results" / NAME / "fields.h5") as file:
        rows = np.argsort(heights[file["contact/first/nodes"][()] - 1])
    worst = 0.0
    for field, point in zip(fields, EXPECTED, strict=True):
        expected = np.array(point["multipliers"])
        error = np.abs(field["multipliers_full_order"][rows] - expected).max()
        worst = max(worst, error / max(expected.max(), 1.0))
    figures.at_most(PROBLEM, "P2 = 0: lambda at 5 points", worst, 1e-8, "independent NumPy code")


def test_equal_pressures_press_evenly(signorom, tmp_path, figures):
    """Wherever the one ends and the other begins."""
    fields = solve_at(signorom, tmp_path, [(10.0, 1.234, 10.0), (10.0, 4.8, 10.0)])
    forces = [field["multipliers_full_order"] for field in fields]
    step = np.abs(forces[0] - forces[1]).max() / forces[0].max()
    figures.at_most(PROBLEM, "P1 = P2: lambda for two h1, difference", step, 1e-10, "the same load")
    area = 2 * np.pi * FUEL_RADIUS * HEIGHT
    pressure = contact_pressure(10.0)
    # nodes of the cladding lie 2 um, 0.05 %, further out than those of the fuel
    figures.compare(
        PROBLEM, "P1 = P2 = 10 MPa: contact pressure", forces[0].sum() / area, pressure, 2e-3, "Lamé", "MPa"
    )


@pytest.mark.slow
def test_ranks_choose_the_same_hats(signorom, tmp_path, figures, monkeypatch):
    """Pairs that are closed in all snapshots of a cluster have openings of rounding, which differ from rank to rank."""
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}:{os.environ['PATH']}")
    stiffness = []
    for n_ranks in (1, 2):
        folder = tmp_path / str(n_ranks)
        folder.mkdir()
        deck = write_input(NAME, folder, {"sobol: 800": "sobol: 80", "number: 4": "number: 3"})
        signorom("sample", deck, folder=folder, n_ranks=n_ranks)
        signorom("train", deck, folder=folder, n_ranks=n_ranks)
        with h5py.File(folder / "results" / NAME / "model.h5") as file:
            clusters = [file[f"clusters/{k}"] for k in (1, 2, 3)]
            stiffness.append([cluster["reduced_stiffness"][()] for cluster in clusters])
            ranks = [cluster["enrichment/ranks"][0] for cluster in clusters]
            n_modes = [cluster.attrs["n_pod_modes"] for cluster in clusters]
    assert any(rank < n for rank, n in zip(ranks, n_modes, strict=True)), "nothing is closed everywhere"
    worst = max(np.abs(a - b).max() / np.abs(a).max() for a, b in zip(*stiffness, strict=True))
    figures.at_most(PROBLEM, "reduced stiffness on two ranks", worst, 1e-10, "one rank")


@pytest.mark.slow
def test_local_models_of_scattered_snapshots(signorom, tmp_path, figures, monkeypatch):
    """The deck as users have it: 800 snapshots, four clusters; 400 points that are no snapshots."""
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}:{os.environ['PATH']}")
    signorom("run", write_input(NAME, tmp_path, {"sobol: 1000": "sobol: 400"}), folder=tmp_path)
    table = read_table(tmp_path / "results" / NAME / "validation.csv")
    assert set(table["cluster"]) == {1, 2, 3, 4}
    error = table["e_lambda_rid"][~np.isnan(table["e_lambda_rid"])]
    found = (np.median(error), np.quantile(error, 0.95), np.mean(error > 0.1))
    texts = ("median of the dual error", "95th percentile", "share of points above 10 %")
    for text, value, limit in zip(texts, found, LIMITS, strict=True):
        figures.at_most(PROBLEM, text, value, limit, "agreed for three clusters of case b")
