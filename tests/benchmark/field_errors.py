# SPDX-License-Identifier: BSD-3-Clause
"""Errors of displacements and stresses of default models, with their size and the times of training and of queries.

build/venv/bin/python tests/benchmark/field_errors.py [NAME ...]   (a deck of input/; default: all of CASES)
"""

import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from boxes import grid_counts, make_boxes, n_axes, write_gmsh
from timing import INPUT, build, copy_deck, load_text, measure, python_model, read_table

SHIPPED = ("indenter", "flange", "bracket", "saddle", "angle_bracket")
#: name: model and mesh width at the contact over that of the disc
DISCS = {"disc": ("plane_strain", 0.1), "disc_in_the_round": ("axisymmetric", 0.1)}
# elastic constants are parameters: element and number of dofs
VARYING = {
    "varying_plane": ("T6", 50e3),
    "varying_solid": ("H8", 50e3),
    "varying_small": ("H8", 6e2),
}
CASES = (*DISCS, *SHIPPED, "varying_plane", "varying_solid")
# A disc, or a sphere, of radius 50 mm between two plates; only the half with x > 0.
GEOMETRY = """\
SetFactory("OpenCASCADE");
Disk(1) = {{0, 0, 0, 50}};
Rectangle(2) = {{0, -70, 0, 60, 20}};
Rectangle(3) = {{0, 50, 0, 60, 20}};
Rectangle(4) = {{-60, -60, 0, 60, 120}};
BooleanDifference{{ Surface{{1}}; Delete; }}{{ Surface{{4}}; Delete; }}
e = 0.01;
Physical Surface("disc") = {{1}};
Physical Surface("lower") = {{2}};
Physical Surface("upper") = {{3}};
axis() = Curve In BoundingBox{{-e, -50 - e, -e, e, 50 + e, e}};
Physical Curve("axis") = axis();
rim() = Abs(Boundary{{ Surface{{1}}; }});
rim() -= axis();
Physical Curve("rim") = rim();
Physical Curve("lower_face") = Curve In BoundingBox{{-e, -50 - e, -e, 60 + e, -50 + e, e}};
Physical Curve("upper_face") = Curve In BoundingBox{{-e, 50 - e, -e, 60 + e, 50 + e, e}};
Physical Curve("bottom") = Curve In BoundingBox{{-e, -70 - e, -e, 60 + e, -70 + e, e}};
Physical Curve("top") = Curve In BoundingBox{{-e, 70 - e, -e, 60 + e, 70 + e, e}};
lower_axis() = Curve In BoundingBox{{-e, -70 - e, -e, e, -50 + e, e}};
upper_axis() = Curve In BoundingBox{{-e, 50 - e, -e, e, 70 + e, e}};
Physical Curve("plate_axes") = {{lower_axis(), upper_axis()}};
Field[1] = MathEval;
Field[1].F = "{width} + 0.018 * sqrt(x^2 + (abs(y) - 50)^2)";
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
"""
DECK = """\
title: A disc between two plates
units: {{length: mm, force: N}}
mesh: {{file: disc.msh, model: {model}}}
parameters: {{d: {{min: 1.0e-5, max: 0.2, unit: mm}}}}
materials:
  disc: {{regions: [disc], young_modulus: 210.0e3, poisson_ratio: 0.3}}
  plates: {{regions: [lower, upper], young_modulus: 70.0e3, poisson_ratio: 0.3}}
boundary_conditions:
  - {{boundary: bottom, displacement: {{{x}: 0, {y}: 0}}}}
  - {{boundary: top, displacement: {{{x}: 0, {y}: -d}}}}
  - {{boundary: axis, displacement: {{{x}: 0}}}}
  - {{boundary: plate_axes, displacement: {{{x}: 0}}}}
contact:
  - {{first: rim, second: lower_face}}
  - {{first: rim, second: upper_face}}
training: {{grid: {{d: 12}}}}
test: {{latin_hypercube: 50}}
reduction: {{fields: true}}
"""

# Two boxes, of which the lower one has a core and a rim: two constants of it vary, and the modulus of the upper one.
BOXES = """\
title: A box of two materials under another one
mesh: {{file: boxes.msh, model: {model}}}
parameters:
  ratio: {{min: 0.3, max: 1.5}}
  nu: {{min: 0.2, max: 0.4}}
  E: {{min: 100.0e9, max: 250.0e9, unit: Pa}}
  P: {{min: 50.0e6, max: 300.0e6, unit: Pa}}
  tilt: {{min: 0.0, max: 0.5}}
materials:
  core: {{regions: [core], young_modulus: 210.0e9 * ratio, poisson_ratio: nu}}
  rim: {{regions: [rim], young_modulus: 210.0e9, poisson_ratio: 0.3}}
  cover: {{regions: [upper], young_modulus: E, poisson_ratio: 0.25}}
boundary_conditions:
  - {{boundary: bottom, displacement: {{{clamped}}}}}
  - {{boundary: left, displacement: {{x: 0}}}}
{front}loads:
  - {{boundary: top, pressure: "P * (1 - tilt * x)"}}
contact:
  - {{first: lower_face, second: upper_face, initial_gap: "1e-3 * ({distance})"}}
training: {{sobol: 20}}
test: {{latin_hypercube: 30}}
reduction: {{fields: true}}
"""


def write_boxes(folder, element, n_dofs):
    """Deck and mesh of two boxes; cells of the lower one left of the middle are its core."""
    nodes, groups = make_boxes(element, grid_counts(element, n_dofs, 0.5))
    kind, _, cells = groups.pop(0)
    is_core = nodes[cells].mean(axis=1)[:, 0] < 0.5
    lower = [(kind, "core", cells[is_core]), (kind, "rim", cells[~is_core])]
    write_gmsh(folder / "boxes.msh", nodes, [*lower, *groups])
    is_plane = n_axes(element) == 2
    return BOXES.format(
        model="plane_strain" if is_plane else "solid",
        clamped="x: 0, y: 0" if is_plane else "x: 0, y: 0, z: 0",
        front="" if is_plane else "  - {boundary: front, displacement: {y: 0}}\n",
        distance="x^2" if is_plane else "x^2 + y^2",
    )


def write_deck(folder, name):
    """The deck of a case, with fields."""
    if name in DISCS:
        model, width = DISCS[name]
        (folder / "disc.geo").write_text(GEOMETRY.format(width=width))
        subprocess.run(["gmsh", "-2", "-v", "1", "-format", "msh41", "disc.geo"], cwd=folder, check=True)
        x, y = ("x", "y") if model == "plane_strain" else ("r", "z")
        text = DECK.format(model=model, x=x, y=y)
    elif name in VARYING:
        text = write_boxes(folder, *VARYING[name])
    else:
        text = copy_deck(INPUT / f"{name}.yaml", folder).read_text()
        text = re.sub(r"(?m)^reduction:.*\n", "", text) + "reduction: {fields: true}\n"
    (folder / "deck.yaml").write_text(text)


def percentile(table, name):
    """95 % of a column of validation.csv; none where it is missing."""
    return np.percentile(table[name], 95) if name in table else np.nan


def query_times(open_model, path):
    """[ms] median time of an answer, and of one with the displacement of all nodes."""
    with open_model(path) as model:
        names = [parameter.name for parameter in model.parameters]
        box = np.array([(parameter.minimum, parameter.maximum) for parameter in model.parameters])
        points = np.random.default_rng(1).uniform(box[:, 0], box[:, 1], (30, len(names)))
        times = []
        for nodes in ((), None):
            own = []
            for point in points:
                start = time.perf_counter()
                model.query(nodes=nodes, **dict(zip(names, point, strict=True)))
                own.append(time.perf_counter() - start)
            times.append(1e3 * np.median(own))
    return times


def main():
    names = sys.argv[1:] or CASES
    program, library = build("signorom", "signorom_online")
    open_model = python_model(library)
    print(load_text())
    columns = [
        "case",
        "rows",
        "displacements",
        "MB",
        "forces p95",
        "energy p95",
        "largest",
        "told p95",
        "von Mises p95",
    ]
    columns += ["ms", "with field", "run"]
    print(f"| {' | '.join(columns)} |\n{'|---' * len(columns)}|")
    for name in names:
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place)
            write_deck(folder, name)
            run = measure([program, "run", "deck.yaml", "--quiet"], folder)
            path = folder / "results/deck/model.h5"
            told = measure([program, "describe", path], folder).output
            rows = re.search(r"(\d+) contact rows?", told)[1]
            form = re.search(r"(?m)^  displacements +(.*)$", told)[1]
            table = read_table(path.with_name("validation.csv"))
            energy = table["e_u_energy_relative"]
            without, with_field = query_times(open_model, path)
            print(
                f"| {name} | {rows} | {form} | {path.stat().st_size / 1e6:.1f} "
                f"| {percentile(table, 'e_lambda_all'):.1e} | {np.percentile(energy, 95):.1e} "
                f"| {energy.max():.1e} | {percentile(table, 'displacement_bound'):.1e} "
                f"| {percentile(table, 'e_von_mises_largest'):.1e} | {without:.3f} | {with_field:.3f} "
                f"| {run.user:.0f} s |",
                flush=True,
            )


if __name__ == "__main__":
    main()
