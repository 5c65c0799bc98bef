# SPDX-License-Identifier: BSD-3-Clause
"""Stresses as VTK shows them, cell by cell and node by node, against known ones. ParaView: tests/paraview."""

import numpy as np
import pytest

from known_stresses import NAMES, write_case
from vtk_fields import read_with_vtk


@pytest.mark.parametrize("name", NAMES)
def test_stresses_are_where_vtk_looks_for_them(signorom, tmp_path, figures, name):
    """Six different components of one strain everywhere; the hoop stress of the thick cylinder."""
    known = write_case(name, tmp_path)
    signorom("solve", known.deck, folder=tmp_path)
    (shown,) = read_with_vtk(tmp_path / "results" / known.deck.stem / "fields.xdmf").values()
    source = {"block": "Hooke's law", "tubes": "Lamé"}[name]
    for place, found, expected, limit in (
        ("cells", shown.cells["stress"], known.cells, known.limits[0]),
        ("nodes", shown.nodes["stress_smoothed"], known.nodes, known.limits[1]),
    ):
        assert found.shape == expected.shape
        worst = np.abs(found - expected).max() / np.abs(expected).max()
        allowed = limit / np.abs(expected).max()
        figures.at_most(
            f"stresses in VTK, {name}", f"xx, yy, zz, xy, yz, xz of the {place}", worst, allowed, source
        )


def test_no_two_components_can_be_taken_for_each_other(tmp_path):
    """The known stresses themselves: six different values, far apart against what is allowed."""
    known = write_case("block", tmp_path)
    stress = np.sort(known.cells[0])
    assert np.diff(stress).min() > 1e6 * known.limits[0]
