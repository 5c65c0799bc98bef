#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Case b from irregular snapshots: greedy selections beside points of Sobol's sequence, models as in the paper's 5.2.2.

    PATH=build/venv/bin:$PATH build/venv/bin/python tests/benchmark/greedy.py            # an 80 x 80 map per model
    PATH=build/venv/bin:$PATH build/venv/bin/python tests/benchmark/greedy.py --map 40

Prints, in Markdown, sizes and errors of the models and the CPU time of each selection; then how far the bound is above
the errors.
"""

import tempfile
from pathlib import Path

import numpy as np
import yaml
from timing import INPUT, build, command_line, copy_deck, cpu_of, load_text, read_table, write_points

NAME = "pellet_cladding_greedy"
GREEDY = (
    "training: {greedy: {candidates: {sobol: 2000}, indicator: projection, initial: 10, max_points: 200}}"
)
SELECTIONS = {
    "projection": GREEDY,
    "defect": GREEDY.replace("projection", "defect").replace("200}}", "200, batch: 10}}"),
    "Sobol": "training: {sobol: 200}",
}
LOCAL = "  pod_tolerance: 1.0e-8\n  dual_pod_tolerance: 1.0e-6\n"
GLOBAL = "  pod_tolerance: 1.0e-6\n  dual_pod_tolerance: 1.0e-4\n"
CLUSTERS = "clusters: {number: 3, method: irregular}\n"
# reduction and clusters, as in the paper
MODELS = {
    "one, hats": (GLOBAL, ""),
    "one, modes and hats": (GLOBAL + "  extended_pod_tolerance: 3.5e-7\n", ""),
    "three, hats": (LOCAL, CLUSTERS),
}


def select(signorom, folder, training):
    """Seconds of CPU, and the columns of selection.csv or none; points.csv in the folder has the points."""
    deck = copy_deck(INPUT / f"{NAME}.yaml", folder, **{GREEDY: training})
    seconds = cpu_of([signorom, "sample", deck], folder)
    path = folder / "results" / NAME / "selection.csv"
    if not path.exists():
        return seconds, None
    # lines that start with # are for people
    lines = [line for line in path.read_text().splitlines(keepends=True) if not line.startswith("#")]
    (folder / "selection.csv").write_text("".join(lines))
    table = read_table(folder / "selection.csv")
    write_points(folder / "points.csv", ("P1", "h1"), np.stack([table["P1"], table["h1"]], axis=1))
    return seconds, table


def measure_model(signorom, folder, training, model, n_map):
    """A row of the table: points, l, N, l-bar, errors."""
    reduction, clusters = MODELS[model]
    changes = {GREEDY: training, LOCAL: reduction, CLUSTERS: clusters}
    changes["{P1: 80, h1: 80}"] = f"{{P1: {n_map}, h1: {n_map}}}"
    cpu_of([signorom, "run", copy_deck(INPUT / f"{NAME}.yaml", folder, **changes)], folder)
    results = folder / "results" / NAME
    report = yaml.safe_load((results / "report.yaml").read_text())
    found = report["reduction"]
    found = found["clusters"].values() if "clusters" in found else [found]
    sizes = [(one["n_modes"], one["n_contact_rows"], one["n_reduced_unknowns"]) for one in found]
    table = read_table(results / "validation.csv")
    errors = table["e_lambda_rid"][~np.isnan(table["e_lambda_rid"])]
    columns = [", ".join(map(str, column)) for column in zip(*sizes, strict=True)]
    dual = f"{np.median(errors):.1%}; {np.percentile(errors, 95):.0%}; {np.mean(errors > 0.1):.0%}"
    return [str(report["sampling"]["n_points"]), *columns, dual, f"{np.median(table['e_u']):.2%}"]


def main():
    """Prints the table."""
    parser = command_line(__doc__)
    parser.add_argument("--map", type=int, default=80, help="points per parameter of the test grid")
    parser.add_argument(
        "--points", type=int, default=200, help="that a selection chooses, of ten times as many"
    )
    parser.add_argument("--models", nargs="+", choices=[*MODELS], default=[*MODELS])
    parser.add_argument("--selections", nargs="+", choices=[*SELECTIONS], default=[*SELECTIONS])
    options = parser.parse_args()
    (signorom,) = build("signorom")
    print(f"{load_text()}; test grid {options.map} x {options.map}\n")
    print("| points by | CPU | models | points | l | N | l̄ | e_λ: median; 95 %; above 10 % | e_u: median |")
    print("|---|---|---|---|---|---|---|---|---|", flush=True)
    bounds = None
    for name in options.selections:
        training = (
            SELECTIONS[name].replace("2000", str(10 * options.points)).replace("200", str(options.points))
        )
        with tempfile.TemporaryDirectory() as path:
            seconds, table = select(signorom, Path(path), training)
            if name == "defect":
                bounds = {key: table[key] for key in ("indicator", "error_u", "error_lambda")}
            points = training if table is None else "training: {file: points.csv}"
            for model in options.models:
                row = measure_model(signorom, Path(path), points, model, options.map)
                print("| " + " | ".join([name, f"{seconds:.0f} s", model, *row]) + " |", flush=True)
    for name in ("error_u", "error_lambda") if bounds else ():
        ratio = bounds["indicator"] / bounds[name]
        ratio = ratio[np.isfinite(ratio)]
        print(
            f"\nbound / {name} at {len(ratio)} points: {ratio.min():.1f} to {ratio.max():.1f}, "
            f"median {np.median(ratio):.1f}"
        )


if __name__ == "__main__":
    main()
