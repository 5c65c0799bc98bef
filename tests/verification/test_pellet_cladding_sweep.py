# SPDX-License-Identifier: BSD-3-Clause
"""Case b over its ranges: other solvers against an independent code, the modes of 500 snapshots (section 5.2)."""

import json

import h5py
import numpy as np
import pytest

from decks import copy_deck
from gmsh_ascii import read_mesh
from runs import ROOT, read_snapshots

# made by tests/reference/pellet_cladding.py, which needs SciPy
EXPECTED = json.loads((ROOT / "tests" / "reference" / "pellet_cladding_expected.json").read_text())
# Both codes solve to rounding: what is left is the conditioning of the stiffness.
SAME_SOLUTION = 1e-8
# [-] what a solution leaves, relative; [mm] for the penetration
SMALL_RESIDUAL = 1e-9
SEED = 20220429
PROBLEM = "case b, pellet and cladding"
TRAINING = "training: {grid: {P1: 10, h1: 50}}"
# what the deck adds to the modes of (20) and to the domain that their interpolation points choose
ENRICHED = """  extra_modes: 9
  dual_pod_tolerance: 4.0e-4
  enrichment: {type: greedy, max_condition_number: 10, side: second}
"""


def sample(signorom, folder, solver, points):
    """Snapshots of a list of points (P1, h1), load `cut`."""
    folder.mkdir(exist_ok=True)
    changes = {"type: condensed": f"type: {solver}", TRAINING: "training: {file: points.csv}"}
    deck = copy_deck(ROOT / "input" / "pellet_cladding.yaml", folder, **changes)
    lines = [f"{pressure!r},{height!r}" for pressure, height in points]
    (folder / "points.csv").write_text("\n".join(["P1,h1", *lines, ""]))
    signorom("sample", deck, folder=folder)
    snapshots = read_snapshots(folder / "results" / "pellet_cladding" / "snapshots.h5")
    assert (snapshots["reasons"] > 0).all()
    assert len(snapshots["reasons"]) == len(points)
    return snapshots


@pytest.mark.parametrize("solver", ["active_set", "snesvi"])
def test_iterative_solvers_agree_with_the_reference(signorom, tmp_path, figures, solver):
    """Multipliers by height, norm of u and number of closed pairs at the reference's points, `cut`."""
    # SNESVI is the slower one
    points = EXPECTED["cut"][:: 2 if solver == "snesvi" else 1]
    snapshots = sample(signorom, tmp_path, solver, [(point["pressure"], point["length"]) for point in points])
    mesh = read_mesh(ROOT / "meshes" / "pellet_cladding.msh")
    # the rows' order is that of the first surface's nodes
    by_height = np.argsort(mesh.coordinates[mesh.nodes_of["fuel_surface"], 1])
    worst = 0.0
    for u, multipliers, point in zip(
        snapshots["displacement"], snapshots["multipliers"], points, strict=True
    ):
        forces = np.array(point["multipliers"])
        difference = np.abs(multipliers[by_height] - forces).max()
        # without contact there is no force at all
        worst = max(worst, difference / forces.max() if forces.any() else difference)
        worst = max(worst, abs(np.linalg.norm(u) / point["displacement_norm"] - 1))
        assert (multipliers > 0).sum() == point["n_active"]
    name = f"lambda and norm of u at {len(points)} points, {solver}"
    figures.at_most(PROBLEM, name, worst, SAME_SOLUTION, "independent NumPy code")


def test_modes_of_the_paper(signorom, tmp_path, figures):
    """500 snapshots with whole_edges: 36 modes leave less than 1e-6 of the energy, (20); 12 contact rows, +- 6."""
    deck = copy_deck(ROOT / "input" / "pellet_cladding_whole_edges.yaml", tmp_path, **{ENRICHED: ""})
    signorom("sample", deck, folder=tmp_path)
    results = tmp_path / "results" / "pellet_cladding_whole_edges"
    displacement = read_snapshots(results / "snapshots.h5")["displacement"]
    assert len(displacement) == 500
    # squared singular values; the tail of 1e-6 is far above their rounding
    squares = np.linalg.eigvalsh(displacement @ displacement.T)
    tails = np.append(np.cumsum(squares)[::-1], 0.0) / np.sum(squares)
    n_modes = np.flatnonzero(tails < 1e-6)[0]
    assert n_modes == EXPECTED["n_modes"]["whole_edges"]
    figures.compare(
        PROBLEM, "modes of 500 snapshots at 1e-6", n_modes, 36, 0, "the paper, 5.2", kind="absolute"
    )
    signorom("train", deck, folder=tmp_path)
    with h5py.File(results / "model.h5") as file:
        assert len(file["clusters/1/basis"]) == 36
        n_rows = len(file["clusters/1/contact_rows"])
    figures.compare(PROBLEM, "contact pairs in the RID", n_rows, 12, 6, "the paper, 5.2", kind="absolute")


def test_random_points_converge(signorom, tmp_path, figures):
    """1000 seeded points by the condensed solver, and some of them by the active set: small residuals, same answers."""
    draw = np.random.default_rng(SEED)
    points = np.stack([draw.uniform(5.0, 200.0, 1000), draw.uniform(0.6, 6.0, 1000)], axis=1).tolist()
    print("seed", SEED)
    condensed = sample(signorom, tmp_path / "condensed", "condensed", points)
    assert condensed["multipliers"].min() >= 0
    worst = np.abs(condensed["residuals"]).max()
    figures.at_most(PROBLEM, "residuals of 1000 random points", worst, SMALL_RESIDUAL, "the equations (3)")
    other = sample(signorom, tmp_path / "active_set", "active_set", points[:5])
    for name in ("displacement", "multipliers"):
        for values, expected in zip(other[name], condensed[name], strict=False):
            np.testing.assert_allclose(values, expected, rtol=0, atol=SAME_SOLUTION * np.abs(expected).max())
