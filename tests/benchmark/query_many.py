# SPDX-License-Identifier: BSD-3-Clause
"""Model.query_many of Python beside a loop in C over the same points, in one run.

build/venv/bin/python tests/benchmark/query_many.py [N] [--models NAME ...]   (default: 20000 points)
"""

import re
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
from timing import (
    INPUT,
    build,
    build_query_times,
    command_line,
    copy_deck,
    load_text,
    python_model,
    tell_target,
    train,
)

MOST_RATIO = 1.5
#: name of the model: deck, its section reduction
MODELS = {
    "half disks, hhr": ("half_disks", "reduction: {method: hhr}"),
    "half disks, condensed": ("half_disks", "reduction: {method: condensed}"),
    "case b, hhr": ("pellet_cladding", None),
    "case b, condensed": ("pellet_cladding", "reduction: {method: condensed}"),
}


def write_deck(folder, name, reduction):
    """A deck of input/ with another section reduction."""
    deck = copy_deck(INPUT / f"{name}.yaml", folder)
    if reduction:
        text = re.sub(r"(?ms)^(reduction|clusters):.*?(?=^\S|\Z)", "", deck.read_text())
        deck.write_text(f"{text}{reduction}\n")


def loop_in_c(library, folder, path, points):
    """[s] of signorom_query and signorom_get_multipliers, mean per point; each point was asked once before."""
    np.savetxt(folder / "points.txt", points, "%.17g")
    command = [build_query_times(library, folder), path, str(len(points)), "points.txt"]
    said = subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True).stdout
    return np.mean(np.array(said.split(), dtype=float))


def call_in_python(model, points):
    """[s] of one call for all points, mean per point; the best of three."""
    times = []
    for _ in range(3):
        start = time.perf_counter()
        model.query_many(points)
        times.append(time.perf_counter() - start)
    return min(times) / len(points)


def main():
    """Print a line per model."""
    parser = command_line(__doc__)
    parser.add_argument("n_points", nargs="?", type=int, default=20_000)
    parser.add_argument("--models", nargs="+", choices=[*MODELS], default=[*MODELS])
    options = parser.parse_args()
    program, library = build("signorom", "signorom_online")
    open_model = python_model(library)
    ratios = []
    for label in options.models:
        name, reduction = MODELS[label]
        with tempfile.TemporaryDirectory() as temporary:
            folder = Path(temporary)
            write_deck(folder, name, reduction)
            _, path = train(program, folder, name)
            with open_model(path) as model:
                lowest, highest = np.array([(p.minimum, p.maximum) for p in model.parameters]).T
                points = np.random.default_rng(1).uniform(lowest, highest, (options.n_points, len(lowest)))
                in_c, in_python = loop_in_c(library, folder, path, points), call_in_python(model, points)
            ratios.append(in_python / in_c)
            print(
                f"{label}: C {1e6 * in_c:.1f} us, Python {1e6 * in_python:.1f} us a point: {ratios[-1]:.2f}",
                flush=True,
            )
    print(load_text())
    tell_target(f"at most {MOST_RATIO} times the loop in C", max(ratios) <= MOST_RATIO)


if __name__ == "__main__":
    main()
