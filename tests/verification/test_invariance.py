# SPDX-License-Identifier: BSD-3-Clause
"""The same body described otherwise: other units, mesh elsewhere, everything larger. The answers are the same."""

import numpy as np
import pytest

from runs import HERE, read_snapshots, write_deck

SAME = 1e-9
MESH = "hertz_cylinder.msh"
BOX = "{min: 0.2, max: 1.33515, unit: mm}"
UNITS = "units: {length: mm, force: N}"
MODEL = "model: plane_strain}"
# name: texts of the deck that change, factor of displacements, factor of forces per length
DESCRIPTIONS = {
    "metres_and_newtons": (
        {
            UNITS: "units: {length: m, force: N}",
            MODEL: "model: plane_strain, length_unit: mm}",
            BOX: "{min: 0.2e-3, max: 1.33515e-3, unit: m}",
            "210.0e3": "210.0e9",
            "70.0e3": "70.0e9",
        },
        1e-3,
        1e3,
    ),
    "kilonewtons": (
        {UNITS: "units: {length: mm, force: kN}", "210.0e3": "210.0", "70.0e3": "70.0"},
        1.0,
        1e-3,
    ),
    "ten_times_larger": (
        {MODEL: "model: plane_strain, length_unit: cm}", BOX: "{min: 2.0, max: 13.3515, unit: mm}"},
        10.0,
        10.0,
    ),
    "elsewhere": ({}, 1.0, 1.0),
}
SHIFT = np.array([123.4, -56.7, 0.0])


def sample(signorom, folder, changes):
    """Snapshots of a few approaches."""
    folder.mkdir()
    changes = changes | {"training: {grid: {approach: 11}}": "training: {grid: {approach: 4}}"}
    signorom("sample", write_deck("hertz_cylinder", folder, **changes), folder=folder)
    return read_snapshots(folder / "results" / "hertz_cylinder" / "snapshots.h5")


def write_shifted(source, path):
    """Copy of a gmsh 4.1 ASCII mesh with every node moved; the boxes of $Entities are not read by anybody."""
    lines = source.read_text().splitlines()
    i_line = lines.index("$Nodes") + 2
    while lines[i_line] != "$EndNodes":
        n_nodes = int(lines[i_line].split()[3])
        first = i_line + 1 + n_nodes
        for i in range(first, first + n_nodes):
            moved = np.array([float(word) for word in lines[i].split()]) + SHIFT
            lines[i] = " ".join(repr(value) for value in moved.tolist())
        i_line = first + n_nodes
    path.write_text("\n".join([*lines, ""]))


@pytest.fixture(scope="module")
def reference(signorom, tmp_path_factory):
    """As the deck has it."""
    return sample(signorom, tmp_path_factory.mktemp("invariance") / "plain", {})


@pytest.mark.parametrize("name", DESCRIPTIONS)
def test_same_answer(signorom, tmp_path, reference, name):
    """Displacements and contact forces, after their factors."""
    changes, displacement_factor, force_factor = DESCRIPTIONS[name]
    if name == "elsewhere":
        write_shifted(HERE / "meshes" / MESH, tmp_path / "shifted.msh")
        changes = {str(HERE / "meshes" / MESH): str(tmp_path / "shifted.msh")}
    other = sample(signorom, tmp_path / "run", changes)
    assert (other["multipliers"] > 0).sum() == (reference["multipliers"] > 0).sum()
    for field, factor in (("displacement", displacement_factor), ("multipliers", force_factor)):
        limit = SAME * np.abs(reference[field]).max()
        np.testing.assert_allclose(other[field] / factor, reference[field], rtol=0, atol=limit)
