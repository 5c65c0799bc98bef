# SPDX-License-Identifier: BSD-3-Clause
"""Two bars with a gap: where it closes, the force after that, and the displacement on both sides."""

import numpy as np
import pytest

import bar_with_gap
import patch_test
from gmsh_ascii import read_mesh
from runs import HERE, read_snapshots, write_deck

# Uniaxial fields are in the span of linear elements: what is left is rounding.
TOLERANCE = 1e-10
PROBLEM, SOURCE = "two bars with a gap", "springs in series"


@pytest.fixture(scope="module", params=["condensed", "active_set", "snesvi"])
def snapshots(request, signorom, tmp_path_factory):
    """Snapshots of 21 strokes around the gap, by each solver."""
    folder = tmp_path_factory.mktemp("bar")
    deck = write_deck("bar_with_gap", folder, **{"type: condensed": f"type: {request.param}"})
    signorom("sample", deck, folder=folder)
    return read_snapshots(folder / "results" / "bar_with_gap" / "snapshots.h5") | {"solver": request.param}


@pytest.fixture(scope="module")
def mesh():
    """The mesh by the reference's reader."""
    return read_mesh(HERE / "meshes" / "bar_with_gap.msh")


def test_no_force_before_the_gap_closes(snapshots):
    """Lambda = 0 up to stroke = gap, the last point with contact but without force."""
    strokes = snapshots["parameters"][:, 0]
    is_open = strokes <= bar_with_gap.GAP * (1 + 1e-12)
    assert is_open.sum() == 6
    limit = TOLERANCE * snapshots["multipliers"].max()
    assert np.abs(snapshots["multipliers"][is_open]).max() <= limit
    assert (snapshots["multipliers"][~is_open] > limit).all()


def test_gap_closes_at_the_gap(snapshots, figures):
    """The force line of the closed points meets zero at stroke = gap."""
    strokes, force = snapshots["parameters"][:, 0], snapshots["multipliers"].sum(axis=1)
    slope = (force[-1] - force[6]) / (strokes[-1] - strokes[6])
    closing = strokes[6] - force[6] / slope
    name = f"stroke that closes the gap, {snapshots['solver']}"
    figures.compare(PROBLEM, name, closing, bar_with_gap.GAP, 1e-9, SOURCE, "m")


def test_forces_are_those_of_springs_in_series(snapshots, mesh, figures):
    """Lambda = p times tributary length at every stroke."""
    lengths = patch_test.tributary_lengths(mesh.coordinates[mesh.nodes_of["lower_face"], 0])
    pressures = np.array([bar_with_gap.pressure(stroke) for stroke in snapshots["parameters"][:, 0]])
    expected = np.outer(pressures, lengths)
    worst = np.abs(snapshots["multipliers"] - expected).max() / expected.max()
    name = f"contact forces, 21 strokes, {snapshots['solver']}"
    figures.at_most(PROBLEM, name, worst, TOLERANCE, SOURCE)


def test_displacement_is_linear_in_each_bar(snapshots, mesh):
    """Rigid part plus strain p / E of each bar; nothing sideways."""
    y = mesh.coordinates[:, 1]
    is_lower = y < bar_with_gap.GAP / 2
    for stroke, values in zip(snapshots["parameters"][:, 0], snapshots["displacement"], strict=True):
        u = values.reshape(-1, 2)
        expected = bar_with_gap.vertical_displacement(y, is_lower, stroke)
        np.testing.assert_allclose(u[:, 1], expected, rtol=0, atol=TOLERANCE * stroke)
        np.testing.assert_allclose(u[:, 0], 0, rtol=0, atol=TOLERANCE * stroke)


def test_terms_are_the_moving_ends(snapshots):
    """The prescribed values that depend on the parameter, behind the constant term."""
    assert snapshots["term_texts"][0] == "1"
    assert len(snapshots["term_texts"]) == 3
