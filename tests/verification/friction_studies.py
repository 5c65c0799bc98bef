# SPDX-License-Identifier: BSD-3-Clause
"""Partial slip under refinement, cylinders (D21) and spheres (D23); many random histories against another code.

    build/venv/bin/python tests/verification/friction_studies.py cylinders [EDGES ...]      default: 8 16 32
    build/venv/bin/python tests/verification/friction_studies.py spheres [EDGES ...]        default: 4 6 8
    build/venv/bin/python tests/verification/friction_studies.py random [SEED ...]          default: 1 to 20
    build/venv/bin/python tests/verification/friction_studies.py models [HISTORIES ...]     default: 67

EDGES: per half-width of the contact. The program is that of SIGNOROM_EXECUTABLE, or build/ci/signorom; a release build
is much faster here. Spheres of 8 edges have 100 000 dofs and 300 contacts. random: two blocks under random histories
against the sweeps of friction_blocks.py, a line per seed and kind of blocks: the largest difference of all forces at
all times for f = 0.1, 0.3, 0.6, 1 and 1.5. Sweeps need not converge where f is large: then there is none. models: of
press_fit_pull (axisymmetric), bolted_joint (3D, three contacts) and two plane blocks, models that are trained on the
deck's history answer so many random ones, with random parameters: the largest difference of all forces to solve.
"""

import re
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import yaml

sys.path[:0] = [
    str(Path(__file__).resolve().parents[1] / name) for name in ("support", "reference", "verification")
]

import hertz  # noqa: E402
from decks import copy_deck  # noqa: E402
from friction_blocks import Blocks  # noqa: E402
from friction_bodies import (  # noqa: E402
    CYLINDER_FRICTION,
    LOADED,
    POISSON,
    RADIUS,
    YOUNG,
    fit_half_width,
    solve_cylinders,
    solve_spheres,
)
from friction_decks import PLANE, SOLID, write_random_deck  # noqa: E402
from friction_formulas import LineSlip  # noqa: E402
from friction_results import largest_difference, read_forces, results_of  # noqa: E402
from program import ROOT, find_program  # noqa: E402
from results import read_table  # noqa: E402


def study_cylinders(signorom, folder, n_fine):
    """One line: half-widths against Hertz and Cattaneo."""
    _, forces, x, areas = solve_cylinders(signorom, folder, "Q4", n_fine)
    modulus = hertz.contact_modulus((YOUNG, POISSON), (YOUNG, POISSON))
    exact = LineSlip(hertz.Line(modulus, RADIUS / 2, forces.resultant[0][0]), CYLINDER_FRICTION)
    tau = forces.tangential[LOADED, :, 0]
    c = exact.stick_half_width(tau.sum())
    found = fit_half_width(x, (CYLINDER_FRICTION * forces.normal[LOADED] - tau) / areas)
    a, _ = hertz.fit(x, forces.normal[0] / areas)
    print(
        f"{n_fine:3d} edges: a {a:.4f} mm ({a / exact.normal.half_width - 1:+.2%}), "
        f"c {found:.4f} mm ({found / c - 1:+.2%} of {c:.4f}), c / a {found / a:.4f} "
        f"({found / a - c / exact.normal.half_width:+.4f})"
    )


def study_spheres(signorom, folder, n_fine):
    """One line per load: radii and displacement against Mindlin."""
    found = solve_spheres(signorom, folder, n_fine)
    exact, load = found.exact, 2 * found.forces.resultant[0]
    a = exact.normal.half_width
    print(
        f"{n_fine:3d} edges, {found.n_nodes} nodes, {len(found.forces.numbers)} contacts: F {load[0]:.1f} to "
        f"{load[-1]:.1f} N, a {found.half_width:.4f} mm ({found.half_width / a - 1:+.2%})"
    )
    for shear, c, moved in zip(found.shear, found.stick_radius, found.displacement, strict=True):
        print(
            f"    Q / (f F) {shear / exact.limit:.3f}: c / a {c / a:.4f} ({(c - exact.stick_radius(shear)) / a:+.4f}), "
            f"displacement {moved:.5f} mm ({moved / exact.approach(shear) - 1:+.2%})"
        )


def study_random(signorom, folder, seed):
    """One line per kind of blocks: largest difference for each f."""
    for name, kind in (PLANE | SOLID).items():
        found = []
        for friction in (0.1, 0.3, 0.6, 1.0, 1.5):
            deck = write_random_deck(folder, kind, friction, seed)
            signorom("solve", deck, folder=folder)
            try:
                found.append(f"{largest_difference(read_forces(deck), Blocks(deck).history()):.1e}")
            except ArithmeticError:
                found.append("none")
        print(f"seed {seed}, {name}:", *found, flush=True)


def random_history(random, tables):
    """Times and values of tables that turn round again and again between their ends; what presses does so always."""
    times = np.arange(1, 13) / 2
    values = {}
    for name, table in tables.items():
        low, high = min(table["value"]), max(table["value"])
        # what presses begins at 0 and does not pull
        at = random.uniform(0.3 if low >= 0 else 0.0, 1.0, 6)
        values[name] = np.interp(times, np.arange(7), np.append(max(low, 0.0), low + at * (high - low)))
    return times, values


def with_history(text, times, values, point):
    """The deck with this history and one point."""
    rows = [f"    {k}: {{time: [0, {', '.join(map(repr, times.tolist()))}], " for k in values]
    rows = [
        f"{row}value: [0, {', '.join(map(repr, v.tolist()))}]}}"
        for row, v in zip(rows, values.values(), strict=True)
    ]
    history = "\n".join(
        ["history:", "  tables:", *rows, f"  steps: [{{until: {times[-1]}, increments: {len(times)}}}]", ""]
    )
    text = re.sub(r"(?m)^history:\n(?:  .*\n)+", history, text)
    text = re.sub(r"(?m)^(training|test|reduction):.*\n", "", text)
    return re.sub(r"(?m)^output:.*$", f"output: {{points: [{point}], fields: [contact]}}", text)


def difference_to_solve(signorom, deck, text, random):
    """Of the model of a deck, which was trained before; a random point and a random history."""
    folder, settings = deck.parent, yaml.safe_load(text)
    point = {
        name: random.uniform(float(box["min"]), min(float(box["max"]), 1.0))
        for name, box in settings["parameters"].items()
    }
    times, values = random_history(random, settings["history"]["tables"])
    lines = [",".join(["time", *values])]
    lines += [",".join(map(repr, row)) for row in np.array([times, *values.values()]).T.tolist()]
    (folder / "random.csv").write_text("\n".join([*lines, ""]))
    at = ",".join(f"{name}={value!r}" for name, value in point.items())
    model = folder / "results" / deck.stem / "model.h5"
    signorom(
        "predict", model, "--at", at, "--history", "random.csv", "--output", "answers.csv", folder=folder
    )
    full = folder / "random.yaml"
    full.write_text(with_history(text, times, values, point))
    signorom("solve", full, folder=folder)
    answers, states = read_table(folder / "answers.csv"), read_table(results_of(full) / "history.csv")
    assert set(answers["status"]) == {"answered"}
    assert set(states["status"]) == {"converged"}
    names = [name for name in states if name.startswith(("lambda_", "tau_"))]
    found, wanted = (np.array([table[name] for name in names]) for table in (answers, states))
    return np.abs(found - wanted).max() / np.abs(wanted).max()


def study_models(signorom, folder, n_histories):
    """One line per part."""
    decks = [
        copy_deck(ROOT / "input" / f"{name}.yaml", folder) for name in ("press_fit_pull", "bolted_joint")
    ]
    blocks = write_random_deck(folder, PLANE["plane_stress, curved"], 0.3, 1)
    blocks.write_text(blocks.read_text() + "training: {sobol: 2}\n")
    for deck in [*decks, blocks]:
        text = deck.read_text()
        for command in ("sample", "train"):
            signorom(command, deck, folder=folder)
        random = np.random.default_rng(1)
        worst = max(difference_to_solve(signorom, deck, text, random) for _ in range(n_histories))
        print(f"{deck.stem}, {n_histories} histories of 12 times: {worst:.1e}", flush=True)


STUDIES = {"cylinders": (study_cylinders, (8, 16, 32)), "spheres": (study_spheres, (4, 6, 8))}
STUDIES["random"] = (study_random, range(1, 21))
STUDIES["models"] = (study_models, (67,))


def main(arguments):
    """A study with its numbers of edges."""
    if not arguments or arguments[0] not in STUDIES:
        sys.exit(__doc__)
    study, default = STUDIES[arguments[0]]
    signorom = find_program()
    for n_fine in [int(word) for word in arguments[1:]] or default:
        start = time.perf_counter()
        with tempfile.TemporaryDirectory() as folder:
            study(signorom, Path(folder), n_fine)
        print(f"    {time.perf_counter() - start:.1f} s")


if __name__ == "__main__":
    main(sys.argv[1:])
