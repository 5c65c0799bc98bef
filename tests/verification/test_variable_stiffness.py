# SPDX-License-Identifier: BSD-3-Clause
"""Elastic constants that are expressions of the parameters: bars of known stiffness, tubes of known Poisson's ratio."""

import numpy as np
import pytest
import yaml

import bar_with_gap
import patch_test
import thick_cylinder
from gmsh_ascii import read_mesh
from runs import HERE, read_fields, read_snapshots, write_deck
from test_thick_cylinder import LEVELS, tubes

# Uniaxial fields are in the span of linear elements: what is left is rounding.
TOLERANCE = 1e-10
STRENGTHS = (0.5, 1.25, 2.0)
BARS = {
    "parameters: {": "parameters: {strength: {min: 0.5, max: 2.0}, ",
    "young_modulus: 200.0": "young_modulus: 200 * strength",
    "young_modulus: 50.0": 'young_modulus: "max(50, 40 * strength^2)"',
    "training: {grid: {stroke: 21}}": "training: {grid: {strength: 3, stroke: 5}}",
    "test: {grid: {stroke: 3}}": "output: {points: [{strength: 0.5, stroke: 0.02}, {strength: 2, stroke: 0.02}]}",
}


@pytest.fixture(scope="module")
def mesh():
    """The bars by the reference's reader."""
    return read_mesh(HERE / "meshes" / "bar_with_gap.msh")


def set_moduli(monkeypatch, strength):
    """The reference's bars as the deck's expressions make them."""
    monkeypatch.setattr(bar_with_gap, "LOWER_MODULUS", 200 * strength)
    monkeypatch.setattr(bar_with_gap, "UPPER_MODULUS", max(50, 40 * strength**2))


@pytest.mark.parametrize(
    ("solver", "n_ranks", "groups"),
    [
        ("condensed", 1, "auto"),
        ("condensed", 4, "2"),
        ("active_set", 3, "1"),
        ("active_set", 2, "2"),
        ("snesvi", 2, "1"),
    ],
)
def test_sweep_of_bars(signorom, tmp_path, monkeypatch, mesh, solver, n_ranks, groups):
    """Springs in series at every point; groups share the values of the moduli and so their stiffnesses."""
    deck = write_deck(
        "bar_with_gap",
        tmp_path,
        **BARS,
        **{"type: condensed": f"type: {solver}", "stroke: 5}}": f"stroke: 5}}, groups: {groups}}}"},
    )
    printed = signorom("sample", deck, folder=tmp_path, n_ranks=n_ranks)
    assert "the stiffness depends on the parameters" in printed
    assert f"{len(STRENGTHS)} stiffnesses" in printed
    snapshots = read_snapshots(tmp_path / "results" / "bar_with_gap" / "snapshots.h5")
    lengths = patch_test.tributary_lengths(mesh.coordinates[mesh.nodes_of["lower_face"], 0])
    y = mesh.coordinates[:, 1]
    np.testing.assert_allclose(np.unique(snapshots["parameters"][:, 0]), STRENGTHS)
    largest = snapshots["multipliers"].max()
    for point, force, values in zip(
        snapshots["parameters"], snapshots["multipliers"], snapshots["displacement"], strict=True
    ):
        set_moduli(monkeypatch, point[0])
        expected = bar_with_gap.pressure(point[1]) * lengths
        np.testing.assert_allclose(force, expected, rtol=0, atol=TOLERANCE * largest)
        expected = bar_with_gap.vertical_displacement(y, y < bar_with_gap.GAP / 2, point[1])
        np.testing.assert_allclose(values[1::2], expected, rtol=0, atol=TOLERANCE * point[1])


def test_stress_is_of_the_point(signorom, tmp_path, monkeypatch, mesh):
    """sigma_yy = -p in both bars at two moduli; so is the reaction."""
    deck = write_deck("bar_with_gap", tmp_path, **BARS)
    signorom("solve", deck, folder=tmp_path)
    results = tmp_path / "results" / "bar_with_gap"
    report = yaml.safe_load((results / "report.yaml").read_text())
    assert report["stiffness"]["depends_on_parameters"] is True
    for number, strength in ((1, 0.5), (2, 2.0)):
        set_moduli(monkeypatch, strength)
        p = bar_with_gap.pressure(0.02)
        stress = read_fields(results / "fields.h5", number)["stress"]
        np.testing.assert_allclose(stress[:, 1], -p, rtol=TOLERANCE)
        reactions = report["points"][str(number)]["reactions"].values()
        forces = {entry["boundary"]: entry["y"] for entry in reactions}
        width = np.ptp(mesh.coordinates[:, 0])
        assert forces["lower_base"] == pytest.approx(p * width, rel=TOLERANCE)


@pytest.mark.parametrize("ratio", [0.0, 0.45])
def test_tubes_of_a_poisson_ratio(signorom, tmp_path, monkeypatch, ratio):
    """u_r of the inner tube's ratio, within the error of 32 cells across (0.1 %, as for fixed constants)."""
    n = LEVELS[-1]
    mesh = tubes("Q4", n)
    mesh.write(tmp_path / "tubes.msh")
    changes = {
        "parameters: {": "parameters: {ratio: {min: 0, max: 0.45}, ",
        "poisson_ratio: 0.3": "poisson_ratio: ratio",
        "points: [{": f"points: [{{ratio: {ratio}, ",
    }
    signorom("solve", write_deck("thick_cylinder", tmp_path, **changes), folder=tmp_path)
    fields = read_fields(tmp_path / "results" / "thick_cylinder" / "fields.h5")
    monkeypatch.setattr(thick_cylinder, "POISSON_RATIOS", (ratio, thick_cylinder.POISSON_RATIOS[1]))
    is_inner = np.arange(len(mesh.coordinates)) < mesh.nodes_of("outer").min()
    exact = thick_cylinder.radial_displacement(mesh.coordinates[:, 0], is_inner)
    assert np.abs(fields["displacement"][:, 0] - exact).max() < 1e-3 * thick_cylinder.PUSH
    assert (
        np.abs(
            fields["contact_pressure"][mesh.nodes_of("inner_face")] / thick_cylinder.contact_pressure() - 1
        ).max()
        < 1e-2
    )
