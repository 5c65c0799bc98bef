#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Models of large contacts in space: how time, memory, file and queries grow with contact rows and dofs.

    build/venv/bin/python tests/benchmark/large_growth.py                        # four sizes, minutes
    build/venv/bin/python tests/benchmark/large_growth.py 99,16 --test 50        # 10 000 rows, a million dofs: hours

The boxes of boxes.py with `condensed` and multigrid, whose contact matrix is made by elimination. Each size is
CELLS,HIGH: cells along a side of the contact face, and along the height of a box. Times are user time of one thread.
`full` is one point by active_set with multigrid, the whole command; `offline` is what the model takes besides the
solutions at training points, in units of `full`. With four sizes or more, exponents a and b of rows^a dofs^b.
"""

import csv
import shutil
import sys
import tempfile
from pathlib import Path

import numpy as np
import yaml
from boxes import deck_text, write_boxes
from large_contact import time_queries
from timing import build, command_line, load_text, measure, tell_target, write_points

ASPECT = 0.33
SEED = 1495
REST = """\
training: {{latin_hypercube: {training}, seed: 3}}
test: {{latin_hypercube: {test}, seed: 7}}
{keys}
output: {{points: [{{P: 1.1e6, tilt: 0.3}}]}}"""
LARGEST_ERROR = 1e-6
FIGURES = "rows dofs elimination training validation gigabytes file query".split()


def write_deck(folder, options, solver):
    """`boxes.yaml`: a pressure that leans to one side."""
    keys = f"reduction: {{{options.set}}}" if options.set else ""
    rest = REST.format(training=options.training, test=options.test, keys=keys)
    text = deck_text(
        "H8", aspect=ASPECT, solver=solver, parameters=", tilt: {min: -1, max: 1}", rest=rest
    ).replace("pressure: P}", 'pressure: "P * (1 + 0.2 * tilt * (x - 0.5))"}')
    (folder / "boxes.yaml").write_text(text)


def run_stage(program, folder, command, *words):
    """User time [s] and largest memory [bytes] of a command; what it says is in a file beside the deck."""
    done = measure([program, command, "boxes.yaml", *words], folder, log=folder / f"{command}.log")
    return done.user, done.megabytes * 1e6


def read_errors(results):
    """Errors of the contact forces at all test points, nan where there is no answer; their bounds."""
    with (results / "validation.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    return [np.array([float(row[name] or "nan") for row in rows]) for name in ("e_lambda_all", "error_bound")]


def measure_size(program, library, folder, size, options):
    """Figures of one size, by name."""
    n_side, n_high = map(int, size.split(","))
    shutil.rmtree(folder / "results", ignore_errors=True)
    n_nodes = write_boxes(folder / "boxes.msh", "H8", [n_side, n_side, n_high], ASPECT)
    write_deck(folder, options, "type: active_set, linear: gamg")
    full = run_stage(program, folder, "solve")
    write_deck(folder, options, "type: condensed, linear: gamg")
    sampling, training, validation = (
        run_stage(program, folder, name) for name in ("sample", "train", "validate")
    )
    results = folder / "results" / "boxes"
    report = yaml.safe_load((results / "report.yaml").read_text())
    errors, bounds = read_errors(results)
    points = np.random.default_rng(SEED).uniform([0.5e6, -1], [2.0e6, 1], (options.queries, 2))
    write_points(folder / "points.csv", ["P", "tilt"], points)
    times = time_queries(folder, library, results / "model.h5", points)[1]
    return {
        "rows": report["sizes"]["n_multipliers"],
        "dofs": 3 * n_nodes,
        "full": full[0],
        "elimination": sampling[0],
        "training": training[0],
        "validation": validation[0] / options.test,
        "gigabytes": max(sampling[1], training[1], validation[1]) / 1e9,
        "full_gigabytes": full[1] / 1e9,
        "file": (results / "model.h5").stat().st_size / 1e9,
        "query": np.median(times),
        "worst": times.max(),
        "error": np.where(np.isfinite(errors), errors, np.inf).max(),
        "bound": np.where(np.isfinite(bounds), bounds, np.inf).max(),
    }


def tell(found, n_training):
    """A line of the table."""
    offline = (found["elimination"] + found["training"]) / found["full"] - n_training
    print(
        f"{found['dofs']:8d} {found['rows']:6d} {found['full']:8.1f} {found['elimination']:8.1f} "
        f"{found['training']:8.1f} {offline:8.1f} {found['validation']:10.1f} {found['full_gigabytes']:8.2f} "
        f"{found['gigabytes']:6.2f} {found['file']:6.3f} {1e3 * found['query']:8.2f} {1e3 * found['worst']:7.2f} "
        f"{found['error']:.1e} {found['bound']:.1e}",
        flush=True,
    )
    return offline


def tell_growth(table):
    """Exponents of each figure over all sizes."""
    logs = {name: np.log([found[name] for found in table]) for name in FIGURES}
    system = np.stack([np.ones(len(table)), logs["rows"], logs["dofs"]], axis=1)
    for name in FIGURES[2:]:
        (_, a, b), *_ = np.linalg.lstsq(system, logs[name], rcond=None)
        print(f"{name}: rows^{a:.2f} dofs^{b:.2f}")


def main():
    """A line per size."""
    parser = command_line(__doc__)
    parser.add_argument("sizes", nargs="*", default=["18,5", "31,8", "31,24", "49,12"], metavar="CELLS,HIGH")
    parser.add_argument("--training", type=int, default=6, help="training points")
    parser.add_argument(
        "--test", type=int, default=10, help="test points, each solved by the full order, too"
    )
    parser.add_argument("--queries", type=int, default=200)
    parser.add_argument("--set", default="", help="keys of `reduction`, as in YAML")
    parser.add_argument("--keep", type=Path, help="folder that keeps deck, mesh and results of the last size")
    options = parser.parse_args()
    program, library = build("signorom", "signorom_online")
    print(load_text())
    print(
        "    dofs   rows     full   sample    train  offline validation  full GB     GB   file query ms  "
        "worst   error   bound"
    )
    table, offline = [], []
    for size in options.sizes:
        with tempfile.TemporaryDirectory() as place:
            folder = options.keep or Path(place)
            folder.mkdir(exist_ok=True)
            table.append(measure_size(program, library, folder, size, options))
            offline.append(tell(table[-1], options.training))
    if len(table) > 3:
        tell_growth(table)
    tell_target("offline in at most 40 solutions of the full order", max(offline) <= 40)
    tell_target("a model of at most 4 GB", max(found["file"] for found in table) <= 4)
    is_fast = all(found["query"] <= 0.05 and found["worst"] <= 0.5 for found in table)
    tell_target("queries in 50 ms in the median, 500 ms at most", is_fast)
    worst = max(found["error"] for found in table)
    sys.exit(None if worst <= LARGEST_ERROR else f"the largest error of contact forces is {worst:.1e}")


if __name__ == "__main__":
    main()
