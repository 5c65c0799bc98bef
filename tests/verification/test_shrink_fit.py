# SPDX-License-Identifier: BSD-3-Clause
"""Two rings shrunk onto each other, free and held ends, against Lamé."""

import numpy as np
import pytest

import shrink_fit
from gmsh_ascii import read_mesh
from gmsh_mesh import make_mesh
from lame import ThickCylinder
from runs import MESHES, read_snapshots, write_input

PROBLEM = "shrink fit of two rings"
# Includes 0.0125 %: the formula takes both rings to meet at 20 mm, the inner one is 20.0025 mm.
LAME = 1e-3
SAME_SOLUTION = 1e-8
SOLVERS = ("condensed", "active_set", "snesvi")
HELD = "  - {boundary: top, displacement: {z: 0}}\n"
SOURCE = "Lamé"


def sample(signorom, folder, ends, solver="condensed", changes=None):
    """Snapshots without a pressure in the bore and with three."""
    changes = (changes or {}) | ({HELD: ""} if ends == "free" else {})
    deck = write_input("shrink_fit", folder, changes)
    # hyper-reduction keeps displacements in the snapshots
    deck.write_text(f"{deck.read_text()}solver: {{type: {solver}}}\nreduction: {{method: hhr}}\n")
    signorom("sample", deck, folder=folder)
    return read_snapshots(folder / "results" / "shrink_fit" / "snapshots.h5")


@pytest.fixture(scope="module", params=["free", "held"])
def shrunk(request, signorom, tmp_path_factory):
    """Kind of ends and the snapshots."""
    return request.param, sample(signorom, tmp_path_factory.mktemp(request.param), request.param)


@pytest.fixture(scope="module")
def mesh():
    """The mesh by the reference's reader."""
    return read_mesh(MESHES / "shrink_fit.msh")


def test_pressure_is_lame(shrunk, mesh, figures):
    """5.74 and 6.31 MPa: force of each node over 2 pi r times its length; the mean, and the worst node."""
    ends, snapshots = shrunk
    z = mesh.coordinates[mesh.nodes_of["inner_face"], 1]
    edge = 2 / 3
    lengths = np.where((z < edge / 2) | (z > 2 - edge / 2), edge / 2, edge)
    areas = 2 * np.pi * (shrink_fit.MIDDLE / 2) * lengths
    forces, expected = snapshots["multipliers"][0], shrink_fit.pressure(ends)
    found = forces.sum() / areas.sum()
    figures.compare(PROBLEM, f"contact pressure, ends {ends}", found, expected, LAME, SOURCE, "MPa")
    np.testing.assert_allclose(forces / areas, expected, rtol=LAME)


def test_rings_are_thick_cylinders(shrunk, mesh):
    """Radial displacement of both rings everywhere, by Lamé's thick cylinder under the contact pressure."""
    ends, snapshots = shrunk
    material = (shrink_fit.YOUNG_MODULUS, shrink_fit.POISSON_RATIO)
    pressure = shrink_fit.pressure(ends)
    inner = ThickCylinder(*material, 10.0, 20.0, outer_pressure=pressure, ends=ends)
    outer = ThickCylinder(*material, 20.0, 30.0, inner_pressure=pressure, ends=ends)
    u = snapshots["displacement"][0].reshape(-1, 2)[:, 0]
    for region, ring in (("inner_ring", inner), ("outer_ring", outer)):
        nodes = mesh.nodes_of[region]
        expected = ring.displacement(mesh.coordinates[nodes, 0])
        np.testing.assert_allclose(u[nodes], expected, rtol=0, atol=LAME * np.abs(expected).max())


def test_pressure_in_the_bore(shrunk, mesh, figures):
    """Closed rings are one thick cylinder: its radial stress adds to the contact pressure."""
    ends, snapshots = shrunk
    material = (shrink_fit.YOUNG_MODULUS, shrink_fit.POISSON_RATIO)
    rim = mesh.nodes_of["rim"]
    first = snapshots["displacement"][0].reshape(-1, 2)[rim, 0]
    for (pressure,), u, multipliers in zip(
        snapshots["parameters"], snapshots["displacement"], snapshots["multipliers"], strict=True
    ):
        both = ThickCylinder(*material, 10.0, 30.0, inner_pressure=pressure, ends=ends)
        expected = shrink_fit.pressure(ends) - both.stress(20.0)[0]
        found = multipliers.sum() / (2 * np.pi * 20.0 * 2.0)
        assert found == pytest.approx(expected, rel=LAME)
        moved = u.reshape(-1, 2)[rim, 0] - first
        np.testing.assert_allclose(moved, both.displacement(30.0), rtol=LAME, atol=LAME * first.max())
    problem = "thick cylinder of shrunk rings"
    figures.compare(problem, f"contact pressure at 60 MPa, {ends}", found, expected, LAME, SOURCE, "MPa")
    figures.compare(
        problem, f"rim moved by 60 MPa, {ends}", moved.mean(), both.displacement(30.0), LAME, SOURCE, "mm"
    )


def test_force_converges_with_order_two(signorom, tmp_path, figures):
    """Linear elements: half the cell size, a quarter of the error of the contact force (held ends)."""
    exact, errors = 2 * shrink_fit.force_of_meshes("held"), []
    for n_radial in (5, 10, 20):
        folder = tmp_path / str(n_radial)
        folder.mkdir()
        make_mesh(MESHES / "shrink_fit.geo", folder / "rings.msh", n_radial=n_radial)
        meshed = str(MESHES / "shrink_fit.msh")
        snapshots = sample(signorom, folder, "held", changes={meshed: "rings.msh"})
        errors.append(abs(snapshots["multipliers"][0].sum() / exact - 1))
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    source = "linear elements"
    for order, cells in zip(orders, ("5 to 10", "10 to 20"), strict=True):
        figures.compare(PROBLEM, f"order, {cells} cells", order, 2, 0.1, source, kind="absolute")


@pytest.mark.parametrize("solver", SOLVERS[1:])
def test_solvers_agree(signorom, tmp_path, shrunk, solver):
    """The same forces and displacements by each solver."""
    ends, first = shrunk
    other_folder = tmp_path / solver
    other_folder.mkdir()
    other = sample(signorom, other_folder, ends, solver)
    assert (other["reasons"] > 0).all()
    for name in ("multipliers", "displacement"):
        limit = SAME_SOLUTION * np.abs(first[name]).max()
        np.testing.assert_allclose(other[name], first[name], rtol=0, atol=limit)
