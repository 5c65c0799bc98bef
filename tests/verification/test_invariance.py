# SPDX-License-Identifier: BSD-3-Clause
"""The same body described otherwise: other units, mesh elsewhere, everything larger. The answers are the same."""

from dataclasses import dataclass

import numpy as np
import pytest

from gmsh_mesh import write_moved_mesh
from runs import MESHES, solve_input

SAME = 1e-9


@dataclass
class Description:
    """What changes in the deck, how displacements and nodal forces scale, where the mesh goes."""

    changes: dict
    displacement: float = 1.0
    force: float = 1.0
    shift: tuple = ()


# a load driven body in the plane, on triangles
CYLINDER = {
    "metres and newtons": Description(
        {
            "length: mm": "length: m",
            "model: plane_strain": "model: plane_strain, length_unit: mm",
            "{min: 1.0e3, max: 35.0e3, unit: N/mm}": "{min: 1.0e6, max: 35.0e6, unit: N/m}",
            "pressure: load / 100": "pressure: load / 0.1",
            "210.0e3": "210.0e9",
            "70.0e3": "70.0e9",
            "{load: 5.0e3}, {load: 15.0e3}, {load: 25.0e3}, {load: 35.0e3}": "{load: 5.0e6}, {load: 15.0e6}, "
            "{load: 25.0e6}, {load: 35.0e6}",
        },
        1e-3,
        1e3,
    ),
    "kilonewtons": Description(
        {
            "force: N": "force: kN",
            "pressure: load / 100": "pressure: 1e-3 * load / 100",
            "210.0e3": "210.0",
            "70.0e3": "70.0",
        },
        1.0,
        1e-3,
    ),
    "ten times larger": Description(
        {"model: plane_strain": "model: plane_strain, length_unit: cm"}, 10.0, 10.0
    ),
    "elsewhere": Description({}, shift=(123.4, -56.7, 0.0)),
}
# a window that cuts cells in space, a body that tilts
BLOCKS = {
    "metres and newtons": Description(
        {
            "length: mm": "length: m",
            "model: solid": "model: solid, length_unit: mm",
            "{min: 10.0, max: 100.0, unit: MPa}": "{min: 10.0e6, max: 100.0e6, unit: Pa}",
            "{min: -10.0, max: 6.0, unit: mm}": "{min: -10.0e-3, max: 6.0e-3, unit: m}",
            "210.0e3": "210.0e9",
            "70.0e3": "70.0e9",
            "{P: 50, edge: -10}, {P: 50, edge: 4.5}": "{P: 50e6, edge: -10e-3}, {P: 50e6, edge: 4.5e-3}",
        },
        1e-3,
        1.0,
    ),
    "ten times larger": Description(
        {"model: solid": "model: solid, length_unit: cm", "min: edge": "min: 10 * edge"}, 10.0, 100.0
    ),
    "elsewhere": Description({"min: edge": "min: edge + 123.4"}, shift=(123.4, -56.7, 8.9)),
}
# a pressure around an axis up to a height; the meters of this one are in test_pellet_cladding
CLADDING = {
    "farther up": Description({"min: 0, max: h1": "min: 56.7, max: h1 + 56.7"}, shift=(0.0, 56.7, 0.0))
}
DECKS = {"hertz_cylinder": CYLINDER, "blocks": BLOCKS, "pellet_cladding": CLADDING}


@pytest.fixture(scope="module", params=DECKS)
def reference(request, signorom, tmp_path_factory):
    """Name of a deck and its answers as it stands."""
    return request.param, solve_input(signorom, request.param, tmp_path_factory.mktemp("invariance"))[0]


def test_same_answer(signorom, tmp_path, reference, figures):
    """Displacements and contact forces at each output point, after their factors."""
    deck, expected = reference
    for name, description in DECKS[deck].items():
        folder = tmp_path / name.replace(" ", "_")
        folder.mkdir()
        changes = dict(description.changes)
        if description.shift:
            write_moved_mesh(MESHES / f"{deck}.msh", folder / "shifted.msh", shift=description.shift)
            changes[str(MESHES / f"{deck}.msh")] = "shifted.msh"
        found, _ = solve_input(signorom, deck, folder, changes)
        worst = 0.0
        for a, b in zip(found, expected, strict=True):
            assert (a["multipliers_full_order"] > 0).sum() == (b["multipliers_full_order"] > 0).sum()
            for field, factor in (
                ("displacement", description.displacement),
                ("multipliers_full_order", description.force),
            ):
                worst = max(worst, np.abs(a[field] / factor - b[field]).max() / np.abs(b[field]).max())
        figures.at_most(f"deck {deck}", f"{name}: difference, relative", worst, SAME, "the deck as it stands")
