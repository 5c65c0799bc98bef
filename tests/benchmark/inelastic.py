#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Reduced models of materials that flow: errors of whole histories, worth of the estimate, time of a query.

    build/venv/bin/python tests/benchmark/inelastic.py pcmi punch
    build/venv/bin/python tests/benchmark/inelastic.py fragment --cells 12 3 6

pcmi: pcmi.yaml on a fine mesh (gmsh). punch: a stiff, round punch whose place is a parameter, on a block that yields
(gmsh). fragment: a quarter of a pellet, cracked, in its cladding, in space; cells along the sides, and over the
thickness of cladding and fragment.

Training and test histories come from Sobol's sequence. Times are user time: of the full order, from what 'sample' takes
for all training histories and for one; of queries without fields, with and without the correction of forces.
"""

import re
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import yaml
from boxes import FACETS, LINEAR, Box, with_middles, write_gmsh
from timing import INPUT, ROOT, build, command_line, copy_deck, load_text, measure, read_table, tell_target

#: training and test histories
HISTORIES = {"pcmi": (12, 30), "punch": (48, 20), "fragment": (6, 6)}
SMALL_HISTORIES = (3, 3)
#: numbers of meshes/*.geo
FINE = {
    "pcmi": {"n_cladding": 12, "n_axial_cladding": 210, "n_fuel": 20, "n_axial_fuel": 50},
    "punch": {"n_face": 24},
}
#: cells along each side, over the thickness of the cladding, and over that of the fragment
CELLS, SMALL_CELLS = (12, 3, 6), (3, 1, 2)
WAYS = ("strains at all points", "corrected", "raw")
ERRORS = (
    "forces_not_corrected",
    "error_estimate",
    "forces",
    "displacement",
    "von_mises",
    "plastic_strain",
    "creep_strain",
)
#: targets: speed-up with and without correction, errors, share of near estimates, rank correlation
SPEED = {"pcmi": (100, 300), "punch": (100, 300), "fragment": (1000, 1000)}
MOST = {"forces": 0.005, "von_mises": 0.01}
NEAR, CORRELATION = 0.9, 0.9

PUNCH = """\
title: A stiff round punch on a block that yields, its place a parameter
units: {length: m, force: N, time: s}
mesh: {file: punch.msh, model: plane_strain}
parameters:
  place: {min: 0.3, max: 0.7, unit: m}
  depth: {min: 0.01, max: 0.02, unit: m}
  sy: {min: 200.0e6, max: 300.0e6, unit: Pa}
history:
  tables: {press: {time: [0, 1, 2], value: [0, depth, "0.6 * depth"]}}
  steps: [{until: 1, increments: 8}, {until: 2, increments: 4}]
materials:
  punch: {regions: [punch], young_modulus: 210.0e9, poisson_ratio: 0.3}
  block:
    regions: [block]
    young_modulus: 210.0e9
    poisson_ratio: 0.3
    plasticity: {yield_stress: sy, isotropic_hardening: 2.0e9}
boundary_conditions:
  - {boundary: punch_nodes, displacement: {x: 0, y: -press}}
  - {boundary: block_middle, displacement: {x: 0}}
  - {boundary: block_base, displacement: {y: 0}}
contact:
  - {first: block_face, second: punch_face, direction: [0, 1], initial_gap: "(x - place)^2 / 2"}
"""

# [mm]
HEIGHT, HOLE, RADIUS, THICKNESS = 3.0, 0.5, 4.1, 0.57
FRAGMENT = """\
title: A quarter of a pellet, cracked, in its cladding
units: {length: mm, force: N, time: h}
mesh: {file: fragment.msh, model: solid}
parameters:
  q: {min: 28.0, max: 40.0, unit: W/mm} # power per length
  gap: {min: 0.010, max: 0.025, unit: mm}
  sy: {min: 240.0, max: 320.0, unit: MPa}
history:
  tables: {power: {time: [0, 2, 26], value: [0, q, q]}}
  steps: [{until: 2, increments: 5}, {until: 26, increments: 5, growth: 8}]
materials:
  fuel: {regions: [fuel], young_modulus: 190.0e3, poisson_ratio: 0.31, thermal_expansion: 1.0e-5}
  cladding:
    regions: [cladding]
    young_modulus: 78.0e3
    poisson_ratio: 0.34
    plasticity: {yield_stress: sy, isotropic_hardening: 2000}
    creep: {norton: {coefficient: 5.0e-14, exponent: 4}}
boundary_conditions:
  - {boundary: fuel_hole, displacement: {x: 0, y: 0}}
  - {boundary: ends, displacement: {z: 0}}
  - {boundary: cladding_at_y, displacement: {y: 0}}
  - {boundary: cladding_at_x, displacement: {x: 0}}
loads:
  - {boundary: cladding_outside, pressure: 15}
imposed_strains:
  - {region: fuel, temperature: "600 + 12 * power + 26.5 * power * (1 - (x^2 + y^2) / 4.1^2)", reference: 600}
contact:
  - {first: fuel_surface, second: cladding_inside, initial_gap: gap}
"""


def write_fragment(path, cells):
    """A mesh of H20: boxes along angle, axis and radius, bent round the axis."""
    n, n_cladding, n_fuel = cells
    groups, nodes, sides = [], [], {}
    first = 0
    for kind, thickness, n_cells, inner in (
        ("fuel", RADIUS - HOLE, n_fuel, HOLE),
        ("cladding", THICKNESS, n_cladding, RADIUS),
    ):
        box = Box("H20", [np.pi / 2, HEIGHT, thickness], [n, n, n_cells], [0, 0, inner])
        groups.append((LINEAR["H20"], kind, box.cells + first))
        sides |= {(kind, *side): facets + first for side, facets in box.sides.items()}
        nodes.append(box.nodes)
        first += len(box.nodes)
    # where the angle is 0 and 90 degrees the fragment is cracked: its sides there are free
    named = {
        "ends": np.vstack([sides["fuel", 1, 0], sides["cladding", 1, 0]]),
        "fuel_hole": sides["fuel", 2, 0],
        "fuel_surface": sides["fuel", 2, 1],
        "cladding_inside": sides["cladding", 2, 0],
        "cladding_outside": sides["cladding", 2, 1],
        "cladding_at_y": sides["cladding", 0, 0],
        "cladding_at_x": sides["cladding", 0, 1],
    }
    groups += [(FACETS[LINEAR["H20"]], name, facets) for name, facets in named.items()]
    nodes, groups = with_middles(np.vstack(nodes), groups, "H20")
    angle, axial, radius = nodes.T
    write_gmsh(path, np.stack([radius * np.cos(angle), radius * np.sin(angle), axial], axis=1), groups)


def write_case(name, folder, options):
    """Mesh and deck of a case, without sections of training and test."""
    if name == "fragment":
        write_fragment(folder / "fragment.msh", SMALL_CELLS if options.small else options.cells)
        return FRAGMENT
    mesh = ROOT / "meshes" / f"{name}.msh"
    if name == "punch" or not options.small:
        mesh = folder / f"{name}.msh"
        numbers = {"n_face": 16} if options.small else FINE[name]
        given = [text for key, value in numbers.items() for text in ("-setnumber", key, str(value))]
        order = ["-order", "2"] if name == "punch" else []
        command = ["gmsh", "-2", "-v", "1", *order, "-format", "msh41", *given, "-o", str(mesh)]
        subprocess.run([*command, str(ROOT / "meshes" / f"{name}.geo")], check=True)
    if name == "punch":
        return PUNCH
    text = copy_deck(INPUT / "pcmi.yaml", folder).read_text()
    text = re.sub(r"file: \S+\.msh", f"file: {mesh}", text)
    return re.sub(r"^(training|test|reduction|output):.*\n", "", text, flags=re.M)


def study(programs, name, folder, options):
    """Samples, trains and validates; prints sizes, errors, times and targets."""
    signorom, benchmark = programs
    counts = SMALL_HISTORIES if options.small else HISTORIES[name]
    n_training, n_test = options.training or counts[0], options.test or counts[1]
    text = write_case(name, folder, options)
    deck, results = folder / f"{name}.yaml", folder / "results" / name

    def run(command, n):
        deck.write_text(
            f"{text}training: {{sobol: {n}}}\ntest: {{sobol: {n_test}, seed: 1}}\nreduction: {{fields: true}}\n"
        )
        return measure([signorom, command, deck.name], folder)

    print(f"{name}, {load_text()}", flush=True)
    one, sampled, trained = run("sample", 1), run("sample", n_training), run("train", n_training)
    validated = run("validate", n_training)
    report, table = (
        yaml.safe_load((results / "report.yaml").read_text()),
        read_table(results / "validation.csv"),
    )
    n_times = len(table["time"]) // n_test
    of_full_order = (sampled.user - one.user) / (n_training - 1) / n_times
    points = np.array([table[key][::n_times] for key in list(table)[: list(table).index("time")]]).T
    asked = measure([benchmark, results / "model.h5", *map(repr, points.ravel().tolist())], folder).output
    numbers = [[float(word) for word in line.split(":")[-1].split()] for line in asked.splitlines()[-4:]]
    n_rows, n_modes, n_points, n_chosen, n_check = map(int, numbers[0][:5])
    print(
        f"  {report['sizes']['n_dofs']} dofs, {n_rows} contact rows, largest strain {numbers[1][3]:.2g}\n"
        f"  {n_training} training and {n_test} test histories of {n_times} times\n"
        f"  {n_modes} modes, {n_chosen} of {n_points} points, {n_check} for the correction\n"
        f"  user time: sample {sampled.user:.0f} s, train {trained.user:.0f} s, validate {validated.user:.0f} s; "
        f"memory {max(sampled.megabytes, trained.megabytes):.0f} MB"
    )
    p95 = tell_errors(report["histories"])
    print(f"  full order ({report['solver']['type']}): {1e3 * of_full_order:.3g} ms per time")
    speed = {}
    for way, (seconds, n_iterations, n_refused, _, median) in zip(WAYS, numbers[1:], strict=True):
        speed[way] = of_full_order / seconds
        print(
            f"  query, {way}: {1e3 * seconds:.3g} ms on average, {1e3 * median:.3g} ms in the median, "
            f"{n_iterations:.1f} iterations, {n_refused:.0f} without answer: {speed[way]:.0f} times faster"
        )
    for way, least in zip(WAYS[1:], SPEED[name], strict=True):
        tell_target(f"{least} times faster, {way}", speed[way] >= least)
    for key, most in MOST.items():
        tell_target(f"{key} to {most:.1%} at 95 % of the histories", p95[key] <= most)
    quality = report["histories"]["estimate_over_error"]
    near, correlation = quality["share_from_0.5_to_1.2"], quality["rank_correlation"]
    print(
        f"  estimate over error: median {quality['median']:.2f}, from 0.5 to 1.2 at {near:.0%}, rank {correlation:.2f}"
    )
    tell_target(f"estimate from 0.5 to 1.2 times the error at {NEAR:.0%} of the histories", near >= NEAR)
    tell_target(f"rank correlation {CORRELATION}", correlation >= CORRELATION)


def tell_errors(histories):
    """Prints errors of whole histories, and returns their 95 % quantiles."""
    for key in ERRORS:
        if key in histories:
            found = histories[key]
            print(
                f"  {key}: median {found['median']:.2e}, p95 {found['p95']:.2e}, largest {found['max']:.2e}"
            )
    return {key: histories[key]["p95"] for key in MOST}


def main():
    """A paragraph per case."""
    parser = command_line(__doc__)
    parser.add_argument("cases", nargs="+", choices=HISTORIES)
    parser.add_argument("--training", type=int, help="number of training histories")
    parser.add_argument("--test", type=int, help="number of test histories")
    parser.add_argument("--cells", type=int, nargs=3, default=CELLS, help="of the fragment")
    parser.add_argument("--small", action="store_true", help="small meshes, few histories")
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="where meshes, decks and results stay")
    options = parser.parse_args()
    programs = build("signorom", "benchmark_inelastic")
    for name in options.cases:
        if options.keep:
            options.keep.mkdir(parents=True, exist_ok=True)
            study(programs, name, options.keep.resolve(), options)
            continue
        with tempfile.TemporaryDirectory() as folder:
            study(programs, name, Path(folder), options)


if __name__ == "__main__":
    main()
