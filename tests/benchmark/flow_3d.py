#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Two boxes in contact, of which the lower one yields and creeps: time of each iteration of Newton's method.

    build/venv/bin/python tests/benchmark/flow_3d.py                   # 100 thousand dofs, 60 times: hours
    build/venv/bin/python tests/benchmark/flow_3d.py 10 --times 12 --solvers cholesky

The boxes of boxes.py, pressed, held and unloaded. Times are user time of the whole command, beside that of one point
of the same boxes where nothing flows. Fails where the solvers disagree, or the balance of work does not hold.
"""

import tempfile
from pathlib import Path

import numpy as np
import yaml
from boxes import AT_ONE_POINT, deck_text, grid_counts, write_boxes
from timing import build, command_line, load_text, measure, read_table

SOLVERS = {
    "condensed": "type: condensed",
    "cholesky": "type: active_set, linear: cholesky",
    "gamg": "type: active_set, linear: gamg",
}
# relative, between solvers: contact forces of conjugate gradients agree with those of a factorization to about 1e-8
AGREEMENT = 1e-6
RESIDUAL_OF_WORK = 1e-8
PRESSURE = 2e8
FLOW = (
    "plasticity: {yield_stress: 250.0e6, isotropic_hardening: 2.0e9}, "
    "creep: {norton: {coefficient: 1.0e-37, exponent: 4}}"
)


def write_deck(folder, element, solver, n_times=0):
    """The deck `boxes.yaml`: with n_times times of materials that flow, or one point where nothing flows."""
    rest = AT_ONE_POINT.replace("}]}", "}], fields: [contact]}").replace("1.0e6", repr(PRESSURE))
    text = deck_text(element, solver=SOLVERS[solver], rest=rest, gap="4e-4 * (x^2 + y^2)").replace(
        "max: 2.0e6", f"max: {PRESSURE!r}"
    )
    if n_times:
        text = (
            text.replace("poisson_ratio: 0.3}", f"poisson_ratio: 0.3, {FLOW}}}", 1)
            .replace("pressure: P", 'pressure: "P*press"')
            .replace(
                "parameters:",
                "units: {length: m, force: N, time: s}\n"
                f"history: {{steps: [{{until: 3, increments: {n_times}}}], "
                "tables: {press: {time: [0, 1, 2, 3], value: [0, 1, 1, 0.2]}}}\nparameters:",
            )
        )
    (folder / "boxes.yaml").write_text(text)


def solve(program, folder):
    """The report, and what the command took."""
    done = measure([program, "solve", "boxes.yaml", "--quiet"], folder)
    results = folder / "results" / "boxes"
    report = yaml.safe_load((results / "report.yaml").read_text())
    return report, done


def run(program, folder, element, solver, n_times):
    """Prints a line, and returns numbers of the answers."""
    write_deck(folder, element, solver)
    elastic = solve(program, folder)[1]
    write_deck(folder, element, solver, n_times)
    report, flowing = solve(program, folder)
    points = list(report["points"].values())
    n_iterations = sum(point["iterations"] for point in points)
    n_linear = sum(point.get("linear_iterations", 0) for point in points)
    worst = max(point["work"]["residual"] for point in points)
    print(
        f"{solver:>10s} {report['sizes']['n_dofs']:8d} {report['sizes']['n_multipliers']:6d} {n_iterations:10d} "
        f"{n_linear / n_iterations:6.1f} {elastic.user:9.1f} {flowing.user:9.1f} {flowing.user / n_iterations:10.2f} "
        f"{flowing.megabytes / 1e3:5.2f} {max(p['flow']['largest_plastic_strain'] for p in points):.2e} {worst:.1e}",
        flush=True,
    )
    assert worst <= RESIDUAL_OF_WORK, worst
    table = read_table(folder / "results" / "boxes" / "history.csv")
    return np.array([values for name, values in sorted(table.items()) if name.startswith("lambda_")])


def main():
    """A line per solver."""
    parser = command_line(__doc__)
    parser.add_argument("size", nargs="?", type=float, default=100, help="thousand dofs")
    parser.add_argument("--element", default="H20")
    parser.add_argument("--times", type=int, default=60)
    parser.add_argument("--solvers", nargs="+", default=["cholesky", "gamg"], choices=SOLVERS)
    options = parser.parse_args()
    (program,) = build("signorom")
    print(load_text())
    print("    solver     dofs  pairs iterations  CG/it  elastic   flowing  iteration    GB  plastic work")
    found = []
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        write_boxes(
            folder / "boxes.msh", options.element, grid_counts(options.element, 1e3 * options.size, 0.5)
        )
        for solver in options.solvers:
            found.append(run(program, folder, options.element, solver, options.times))
    for other in found[1:]:
        difference = np.abs(other - found[0]).max() / np.abs(found[0]).max()
        print(f"agreement of solvers: {difference:.1e}")
        assert difference <= AGREEMENT


if __name__ == "__main__":
    main()
