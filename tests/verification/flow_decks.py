# SPDX-License-Identifier: BSD-3-Clause
"""Decks of materials that flow, written for a test, and what their runs found."""

import numpy as np

from block_meshes import LINEAR, QUADRATIC, Mesh
from runs import read_fields, read_report

AXES = {"plane_strain": "xy", "axisymmetric": "rz", "solid": "xyz"}
# Cells of the models, by how they are integrated: reduced, or with the mean dilatation.
PLANE = ("Q8", "T6", "Q4")
SOLID = ("H20", "T10", "W15", "H8", "W6")
SIDES = ("left", "right", "bottom", "top", "front", "back")


def block(element, n_dim, lines=None, moved=0.2, shift=0.0, region="body"):
    """A mesh of one box; sides left, right (x), bottom, top (y) and front, back (z)."""
    mesh = Mesh()
    lines = lines or [np.linspace(0, 1, 3)] * n_dim
    faces = {(axis, side): SIDES[2 * axis + side] for axis in range(n_dim) for side in range(2)}
    mesh.add_block(region, lines, LINEAR.get(element, element), faces, moved, seed=3)
    mesh.coordinates[:, 0] += shift
    if element in QUADRATIC:
        mesh.make_quadratic(element)
    return mesh


def held(**displacements):
    """Section boundary_conditions: held(left={"x": 0}, top={"y": "load"})."""
    entries = [
        f"  - {{boundary: {name}, displacement: {{{', '.join(f'{axis}: {value}' for axis, value in moved.items())}}}}}\n"
        for name, moved in displacements.items()
    ]
    return "boundary_conditions:\n" + "".join(entries)


def write_deck(folder, mesh, model, sections, units="{length: mm, force: N, time: h}", further=None):
    """A deck deck.yaml on body.msh with the parameter `load`, at 1; `sections` is the rest of it.

    `further` has the ranges of further parameters, in the middle of which the output point is.
    """
    folder.mkdir(exist_ok=True)
    ranges = {"load": (0, 2), **(further or {})}
    parameters = ", ".join(f"{name}: {{min: {low}, max: {high}}}" for name, (low, high) in ranges.items())
    point = ", ".join(f"{name}: {(low + high) / 2}" for name, (low, high) in ranges.items())
    mesh.write(folder / "body.msh")
    (folder / "deck.yaml").write_text(
        f"units: {units}\n"
        f"mesh: {{file: body.msh, model: {model}}}\n"
        f"parameters: {{{parameters}}}\n"
        f"{sections}"
        f"output: {{points: [{{{point}}}]}}\n"
    )
    return folder / "deck.yaml"


def read_run(folder):
    """Fields of each time that has an answer, and the points of the report by number."""
    points = read_report(folder, "deck")["points"]
    points = [points[str(i + 1)] for i in range(len(points))]
    n_solved = sum(point["status"] == "converged" for point in points)
    path = folder / "results" / "deck" / "fields.h5"
    return [read_fields(path, i + 1) for i in range(n_solved)], points


def solve(signorom, folder, mesh, model, sections, n_ranks=1, **units):
    """Fields of each time and the points of the report, all of them converged."""
    deck = write_deck(folder, mesh, model, sections, **units)
    signorom("solve", deck, folder=folder, n_ranks=n_ranks)
    fields, points = read_run(folder)
    assert len(fields) == len(points)
    return fields, points
