# SPDX-License-Identifier: BSD-3-Clause
"""`signorom-post convert`, then `init` and `solve`: each kind of element, in the order of Abaqus and CalculiX."""

import subprocess
import sys

import numpy as np
import pytest
import yaml

from block_meshes import MIDDLES, stacked_blocks
from results import read_fields

# Corners (0-based) in whose middle the further nodes sit, by the manual of CalculiX.
ABAQUS = {
    "Q8": [(0, 1), (1, 2), (2, 3), (0, 3)],
    "T10": [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)],
    "H20": [(0, 1), (1, 2), (2, 3), (0, 3), (4, 5), (5, 6), (6, 7), (4, 7), (0, 4), (1, 5), (2, 6), (3, 7)],
}
TYPES = {"Q8": "CAX8R", "T10": "C3D10", "H20": "C3D20R"}


def write_deck(mesh, path):
    """Writes the cells of a mesh with an element set per region, and a node set per boundary."""
    lines = ["*NODE"]
    lines += [f"{i}, {x!r}, {y!r}, {z!r}" for i, (x, y, z) in enumerate(mesh.coordinates.tolist(), 1)]
    for i, (kind, name, nodes) in enumerate(mesh.elements, 1):
        if name not in ("lower", "upper"):
            continue
        n_corners = len(nodes) - len(ABAQUS[kind])
        order = [*range(n_corners), *(n_corners + MIDDLES[kind].index(pair) for pair in ABAQUS[kind])]
        words = [str(nodes[j] + 1) for j in order]
        lines += [f"*ELEMENT, TYPE={TYPES[kind]}, ELSET={name}", f"{i}, " + ", ".join(words[:10]) + ","]
        lines += [", ".join(words[10:])] if len(words) > 10 else []
    for name in sorted({name for _, name, _ in mesh.elements} - {"lower", "upper"}):
        lines += [f"*NSET, NSET={name}", *(str(node + 1) for node in mesh.nodes_of(name))]
    path.write_text("\n".join(lines) + "\n")


@pytest.mark.parametrize("element", ["Q8", "T10", "H20"])
def test_elements_of_abaqus(signorom, tmp_path, element):
    """init finds what the node sets name, and the full-order solution is that of the mesh before it was converted."""
    n_dim = 2 if element == "Q8" else 3
    mesh = stacked_blocks(element, n_dim)
    displacements = []
    for folder in (tmp_path / "before", tmp_path / "after"):
        folder.mkdir()
        if folder.name == "before":
            mesh.write(folder / "part.msh")
        else:
            write_deck(mesh, folder / "part.inp")
            convert(folder / "part.inp")
        signorom("init", "part.msh", folder=folder)
        displacements.append(solve(signorom, folder / "part.yaml"))
    before, after = displacements
    np.testing.assert_allclose(after, before, rtol=0, atol=1e-9 * np.abs(before).max())


def convert(part):
    """Runs signorom-post convert, and returns what it prints."""
    command = [sys.executable, "-m", "signorom_post", "convert", str(part)]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def solve(signorom, path):
    """Fills in a deck of init, solves it, and returns its displacements."""
    text = path.read_text().replace("min: FILL_IN, max: FILL_IN", "min: 1, max: 9")
    text = text.replace(
        "young_modulus: FILL_IN, poisson_ratio: FILL_IN", "young_modulus: 1000, poisson_ratio: 0.3"
    )
    for boundary in ("bottom", "left"):
        text = text.replace("boundary: FILL_IN", f"boundary: {boundary}", 1)
    text = text.replace("boundary: FILL_IN, pressure", "boundary: top, pressure")
    path.write_text(text)
    deck = yaml.safe_load(text)
    assert {deck["contact"][0]["first"], deck["contact"][0]["second"]} == {"lower_face", "upper_face"}
    assert set(deck["materials"]) == {"lower", "upper"}
    signorom("solve", path.name, "--at", "P=5", folder=path.parent)
    return read_fields(path.parent / "results" / "part" / "fields.h5")["displacement"]
