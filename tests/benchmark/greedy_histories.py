#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""pcmi.yaml trained by histories that the model's own estimates choose, and by points of Sobol's sequence.

    build/venv/bin/python tests/benchmark/greedy_histories.py
    build/venv/bin/python tests/benchmark/greedy_histories.py --histories 4 --test 6 --tolerance 0.01

Prints, in Markdown, the errors of whole test histories (median and 95 % quantile of the largest error of all times,
over the largest value of the history), and how well the estimate tells the error before the correction.
"""

import tempfile
from pathlib import Path

import yaml
from timing import INPUT, build, command_line, copy_deck, cpu_of, load_text

GREEDY = "training: {greedy: {candidates: {sobol: 100}, max_points: 12}}"
TEST = "test: {sobol: 4, seed: 1}"
FIELDS = "reduction: {fields: true}"
# states of a history of the deck
N_TIMES = 46
COLUMNS = ("forces_not_corrected", "error_estimate", "forces", "von_mises", "plastic_strain", "creep_strain")


def measure(signorom, folder, training, n_test, tolerance):
    """A row of the table: histories, modes, errors, quality of the estimate, seconds of CPU."""
    folder.mkdir()
    changes = {
        GREEDY: f"training: {training}",
        TEST: f"test: {{sobol: {n_test}, seed: 1}}",
        FIELDS: f"reduction: {{fields: true, inelastic_tolerance: {tolerance}}}",
    }
    seconds = cpu_of([signorom, "run", copy_deck(INPUT / "pcmi.yaml", folder, **changes)], folder)
    report = yaml.safe_load((folder / "results" / "pcmi" / "report.yaml").read_text())
    histories, n_points = report["histories"], report["sampling"]["n_points"]
    errors = [f"{histories[name]['median']:.1e} / {histories[name]['p95']:.1e}" for name in COLUMNS]
    quality = histories["estimate_over_error"]
    near = (
        f"{quality['median']:.2f}; {quality['share_from_0.5_to_1.2']:.0%}; {quality['rank_correlation']:.2f}"
    )
    return [str(n_points // N_TIMES), *errors, near, f"{seconds:.0f}"]


def main():
    """Prints the table."""
    parser = command_line(__doc__)
    parser.add_argument(
        "--histories", type=int, default=8, help="of the greedy selection and of the smaller Sobol set"
    )
    parser.add_argument("--test", type=int, default=30, help="number of test histories")
    parser.add_argument("--tolerance", type=float, default=1e-4, help="reduction.inelastic_tolerance")
    options = parser.parse_args()
    (signorom,) = build("signorom")
    print(f"{load_text()}; {options.test} test histories, inelastic_tolerance {options.tolerance}\n")
    n = options.histories
    candidates = "candidates: {sobol: 100, seed: 5}"
    trainings = {
        f"greedy, at most {n}": f"{{greedy: {{{candidates}, initial: {min(n, 5)}, max_points: {n}}}}}",
        f"Sobol, {n}": f"{{sobol: {n}}}",
        f"Sobol, {2 * n}": f"{{sobol: {2 * n}}}",
    }
    titles = ["training", "histories", *(name.replace("_", " ") for name in COLUMNS)]
    print("| " + " | ".join([*titles, "estimate over error; 0.5 to 1.2; rank correlation", "CPU s"]) + " |")
    print("|---" * (len(titles) + 2) + "|")
    with tempfile.TemporaryDirectory() as folder:
        for i, (name, training) in enumerate(trainings.items()):
            row = measure(signorom, Path(folder) / str(i), training, options.test, options.tolerance)
            print("| " + " | ".join([name, *row]) + " |", flush=True)


if __name__ == "__main__":
    main()
