# SPDX-License-Identifier: BSD-3-Clause
"""Contact patch test: uniform pressure E U / H, linear displacement."""

import re

import numpy as np
import pytest

import patch_test
from gmsh_ascii import read_mesh
from runs import HERE, read_snapshots, solve_deck, write_deck
from spread import spread

# Node-to-node contact with matching nodes reproduces the linear solution up to rounding.
TOLERANCE = 1e-10
SOLVERS = ("condensed", "active_set", "snesvi")


@pytest.mark.parametrize(("solver", "n_ranks"), spread(SOLVERS, [1, 2, 3, 4]))
def test_uniform_pressure(signorom, tmp_path, figures, solver, n_ranks):
    """All pairs closed, lambda = p times tributary length, u_y linear, u_x = 0."""
    deck = write_deck("patch", tmp_path, **{"type: condensed": f"type: {solver}"})
    signorom("sample", deck, folder=tmp_path, n_ranks=n_ranks)
    snapshots = read_snapshots(tmp_path / "results" / "patch" / "snapshots.h5")
    mesh = read_mesh(HERE / "meshes" / "patch_blocks.msh")
    x = np.sort(mesh.coordinates[mesh.nodes_of["lower_face"], 0])
    np.testing.assert_allclose(snapshots["parameters"][:, 0], np.linspace(0.02, 0.1, 5), rtol=1e-14)
    assert (snapshots["reasons"] > 0).all()
    worst = 0.0
    for i_point, stroke in enumerate(snapshots["parameters"][:, 0]):
        forces = patch_test.nodal_forces(x, stroke)
        order = np.argsort(mesh.coordinates[mesh.nodes_of["lower_face"], 0])
        found = snapshots["multipliers"][i_point][order]
        worst = max(worst, np.abs(found - forces).max() / forces.max())
        u = snapshots["displacement"][i_point].reshape(-1, 2)
        expected = patch_test.vertical_displacement(mesh.coordinates[:, 1], stroke)
        worst = max(worst, np.abs(u[:, 1] - expected).max() / stroke, np.abs(u[:, 0]).max() / stroke)
    ranks = "rank" if n_ranks == 1 else "ranks"
    name = f"forces and displacements, {solver}, {n_ranks} {ranks}"
    figures.at_most("patch test, T3, plane strain", name, worst, TOLERANCE, "uniform pressure")


@pytest.mark.parametrize("first_listed", ["region", "surface"])
def test_region_and_surface_of_one_name(signorom, tmp_path, figures, first_listed):
    """Physical groups of different dimensions may share a name; the contact's area is that of the surface."""
    text = (HERE / "meshes" / "patch_blocks.msh").read_text().replace('"lower_face"', '"lower"')
    head, names, rest = re.split(r"(?s)(?<=\$PhysicalNames\n)\d+\n(.*?)(?=\$EndPhysicalNames)", text)
    lines = sorted(names.splitlines(), reverse=first_listed == "region")
    (tmp_path / "blocks.msh").write_text(head + "\n".join([str(len(lines)), *lines, ""]) + rest)
    changes = {"first: lower_face": "first: lower", "solver:": "output: {points: [{stroke: 0.06}]}\nsolver:"}
    deck = write_deck("patch", tmp_path, **changes)
    deck.write_text(re.sub(r"file: [^,}]+patch_blocks.msh", "file: blocks.msh", deck.read_text()))
    (fields,), _ = solve_deck(signorom, deck)
    pressure = fields["contact_pressure"][read_mesh(tmp_path / "blocks.msh").nodes_of["upper_face"]]
    expected = patch_test.pressure(0.06)
    worst = np.abs(pressure / expected - 1).max()
    name = f"pressure, {first_listed} of the same name listed first"
    figures.at_most("patch test, T3, plane strain", name, worst, TOLERANCE, "uniform pressure")


def test_pressure_of_the_handbook():
    """The formula gives D1's 1.0e5 Pa and -0.05 m for U = 0.1 m."""
    assert patch_test.pressure(0.1) == pytest.approx(1.0e5, rel=1e-14)
    assert patch_test.vertical_displacement(0.0, 0.1) == pytest.approx(-0.05, rel=1e-14)
