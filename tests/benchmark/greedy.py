#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Case b from irregular snapshots: greedy selections beside points of Sobol's sequence, models as in the paper's 5.2.2.

    PATH=build/venv/bin:$PATH build/venv/bin/python tests/benchmark/greedy.py            # an 80 x 80 map per model
    PATH=build/venv/bin:$PATH build/venv/bin/python tests/benchmark/greedy.py --map 40

Prints, in Markdown, sizes and errors of the models and the CPU time of each selection; then how far the bound is above
the errors.
"""

import argparse
import csv
import io
import tempfile
from pathlib import Path

import numpy as np
import yaml
from timing import ROOT, build, cpu_of, load_text

DECK = (ROOT / "input" / "pellet_cladding_greedy.yaml").read_text()
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


def read_csv(path):
    """Columns of numbers; lines that start with # are for people."""
    lines = [line for line in path.read_text().splitlines(keepends=True) if not line.startswith("#")]
    rows = list(csv.DictReader(io.StringIO("".join(lines))))
    return {name: [row[name] for row in rows] for name in rows[0]}


def numbers(column):
    """A column as numbers."""
    return np.array([float(value) for value in column])


def select(signorom, folder, training):
    """Seconds of CPU, and the columns of selection.csv or none; points.csv in the folder has the points."""
    text = DECK.replace("../meshes", str(ROOT / "meshes"))
    assert GREEDY in text
    (folder / "selection.yaml").write_text(text.replace(GREEDY, training))
    seconds, _, _ = cpu_of([signorom, "sample", "selection.yaml"], folder)
    path = folder / "results" / "selection" / "selection.csv"
    if not path.exists():
        return seconds, None
    table = read_csv(path)
    rows = [f"{first},{second}\n" for first, second in zip(table["P1"], table["h1"], strict=True)]
    (folder / "points.csv").write_text("".join(["P1,h1\n", *rows]))
    return seconds, table


def measure(signorom, folder, training, model, n_map):
    """A row of the table: points, l, N, l-bar, errors."""
    reduction, clusters = MODELS[model]
    text = DECK.replace("../meshes", str(ROOT / "meshes")).replace(GREEDY, training)
    text = text.replace(LOCAL, reduction).replace(CLUSTERS, clusters)
    (folder / "model.yaml").write_text(text.replace("{P1: 80, h1: 80}", f"{{P1: {n_map}, h1: {n_map}}}"))
    cpu_of([signorom, "run", "model.yaml"], folder)
    results = folder / "results" / "model"
    report = yaml.safe_load((results / "report.yaml").read_text())
    found = report["reduction"]
    found = found["clusters"].values() if "clusters" in found else [found]
    sizes = [(one["n_modes"], one["n_contact_rows"], one["n_reduced_unknowns"]) for one in found]
    table = read_csv(results / "validation.csv")
    errors = numbers(table["e_lambda_rid"])
    errors = errors[~np.isnan(errors)]
    columns = [", ".join(map(str, column)) for column in zip(*sizes, strict=True)]
    dual = f"{np.median(errors):.1%}; {np.percentile(errors, 95):.0%}; {np.mean(errors > 0.1):.0%}"
    return [str(report["sampling"]["n_points"]), *columns, dual, f"{np.median(numbers(table['e_u'])):.2%}"]


def main():
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--map", type=int, default=80, help="points per parameter of the test grid")
    n_map = parser.parse_args().map
    (signorom,) = build("signorom")
    print(f"{load_text()}; test grid {n_map} x {n_map}\n")
    print("| points by | CPU | models | points | l | N | l̄ | e_λ: median; 95 %; above 10 % | e_u: median |")
    print("|---|---|---|---|---|---|---|---|---|", flush=True)
    bounds = None
    for name, training in SELECTIONS.items():
        with tempfile.TemporaryDirectory() as path:
            seconds, table = select(signorom, Path(path), training)
            if name == "defect":
                bounds = {key: numbers(table[key]) for key in ("indicator", "error_u", "error_lambda")}
            points = training if table is None else "training: {file: points.csv}"
            for model in MODELS:
                row = measure(signorom, Path(path), points, model, n_map)
                print("| " + " | ".join([name, f"{seconds:.0f} s", model, *row]) + " |", flush=True)
    for name in ("error_u", "error_lambda"):
        ratio = bounds["indicator"] / bounds[name]
        ratio = ratio[np.isfinite(ratio)]
        print(
            f"\nbound / {name} at {len(ratio)} points: {ratio.min():.1f} to {ratio.max():.1f}, "
            f"median {np.median(ratio):.1f}"
        )


if __name__ == "__main__":
    main()
