# SPDX-License-Identifier: BSD-3-Clause
"""Elastic sphere on an elastic block, in the round (Q4) and as a quarter in space (H8), against Hertz."""

from dataclasses import dataclass

import numpy as np
import pytest

import hertz
from block_meshes import consistent_areas
from runs import read_snapshots, write_deck
from sphere_mesh import RADIUS, sphere_on_block

SOLID = {
    "model: axisymmetric": "model: solid",
    "displacement: {r: 0.0}}": "displacement: {x: 0.0}}\n  - {boundary: front, displacement: {y: 0.0}}",
    "direction: [0, 1]": "direction: [0, 0, 1]",
}
MATERIALS = hertz.NAFEMS_MATERIALS


@dataclass
class Case:
    """Grid near the contact (step in mm, number of equal steps, growth after them) and the allowed difference."""

    n_dim: int
    step: float
    n_fine: int
    growth: float
    tolerance: float
    # parts of the whole contact: a quarter, or all of it
    n_parts: int


# in the round a / 16 to a / 28; in space a / 4 to a / 7.5
CASES = {
    "axisymmetric": Case(2, 0.2, 40, 1.15, 0.01, 1),
    "solid": Case(3, 0.75, 10, 1.6, 0.03, 4),
}


@pytest.mark.parametrize("model", CASES)
def test_half_width_and_peak(signorom, tmp_path, model):
    """Fitted half-width and peak, and the largest pressure, for the load found at each approach."""
    case = CASES[model]
    mesh = sphere_on_block(case.n_dim, case.step, case.n_fine, case.growth)
    deck = write_deck("sphere", tmp_path, **(SOLID if model == "solid" else {}))
    mesh.write(tmp_path / "sphere.msh")
    signorom("sample", deck, folder=tmp_path)
    snapshots = read_snapshots(tmp_path / "results" / "sphere" / "snapshots.h5")
    assert (snapshots["reasons"] > 0).all()
    nodes = mesh.nodes_of("block_face")
    distance = np.linalg.norm(mesh.coordinates[nodes, : case.n_dim - 1], axis=1)
    areas = consistent_areas(mesh, "block_face", is_round=model == "axisymmetric")[nodes]
    for multipliers in snapshots["multipliers"]:
        pressure = multipliers / areas
        half_width, peak = hertz.fit(distance, pressure)
        load = case.n_parts * multipliers.sum()
        exact = hertz.Point(hertz.contact_modulus(*MATERIALS), RADIUS, load)
        print(f"F = {load:.0f} N: a {half_width:.4f} mm ({half_width / exact.half_width - 1:+.2%}), ", end="")
        print(
            f"p0 {peak:.1f} MPa ({peak / exact.peak - 1:+.2%}), max p ({pressure.max() / exact.peak - 1:+.2%})"
        )
        assert half_width == pytest.approx(exact.half_width, rel=case.tolerance)
        assert peak == pytest.approx(exact.peak, rel=case.tolerance)
        assert pressure.max() == pytest.approx(exact.peak, rel=case.tolerance)
        # nothing is closed beyond one cell outside the contact
        assert distance[pressure > 0].max() <= exact.half_width + case.step
