# SPDX-License-Identifier: BSD-3-Clause
"""Histories with friction: condensed models of two blocks, with kept factors and with new ones; and the full order.

build/venv/bin/python tests/benchmark/friction.py
build/venv/bin/python tests/benchmark/friction.py --contacts 12 4 --increments 12
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

from timing import ROOT, build, command_line, measure

sys.path.append(str(ROOT / "tests" / "verification"))
from friction_decks import Kind, write_random_deck

SEED, FRICTION, SIZE = 1, 0.3, 1.0
# [us] per query, and factors that are made anew over kept ones, in operations
TARGETS = {2: 100.0, 3: 30e3}
FEWER = 10.0


def write_deck(folder, n_dim, n_across, increments):
    """A random deck with more contacts, whose model is trained at two points."""
    kind = Kind(n_dim, "plane_strain" if n_dim == 2 else "solid", bulge=0.01)
    deck = write_random_deck(folder, kind, FRICTION, SEED, increments, (n_across,) * (n_dim - 1))
    text = deck.read_text()
    model = re.sub(r"(?m)^output:.*$", "training: {sobol: 2}\nreduction: {method: condensed}", text)
    deck.with_name("model.yaml").write_text(model)
    return deck


def run(options, n_dim, folder):
    """One dimension: prints all figures."""
    n_across = options.contacts[n_dim - 2]
    deck = write_deck(folder, n_dim, n_across, options.increments)
    executable, program = build("signorom", "benchmark_friction")
    print(f"{n_dim}D, {n_across ** (n_dim - 1)} pairs", flush=True)
    for command in ("sample", "train"):
        measure([executable, command, "model.yaml", "--quiet"], folder)
    model = folder / "results" / "model" / "model.h5"
    done = subprocess.run(
        [program, model, str(options.anew), str(FRICTION)], stdout=subprocess.PIPE, text=True, check=True
    )
    print(done.stdout, end="")
    query = float(re.search(r"query: median ([\d.]+)", done.stdout)[1])
    fewer = float(re.search(r"anew over kept: ([\d.]+)", done.stdout)[1])
    difference = float(re.search(r"largest force: +(\S+)", done.stdout)[1])
    for what, is_met in (
        (f"a query takes {query:.1f} us, at most {TARGETS[n_dim]:.0f}", query <= TARGETS[n_dim]),
        (f"{fewer:.1f} times fewer operations, at least {FEWER:.0f}", fewer >= FEWER),
    ):
        print(f"target: {what}: {'met' if is_met else 'NOT met'}")
    if options.full_order:
        taken = measure([executable, "solve", deck.name, "--quiet"], folder)
        print(
            f"full order: {1e3 * taken.cpu / options.increments:.1f} ms of CPU time per time, with all set-up",
            flush=True,
        )
    return difference <= 1e-7


def main():
    """Both dimensions."""
    parser = command_line(__doc__)
    parser.add_argument(
        "--contacts", nargs=2, type=int, default=[100, 32], help="pairs along an edge, in 2D and 3D"
    )
    parser.add_argument("--increments", type=int, default=24, help="times")
    parser.add_argument("--anew", type=int, default=0, help="times with new factors; 0: all")
    parser.add_argument("--dimensions", nargs="+", type=int, default=[2, 3])
    parser.add_argument("--no-full-order", dest="full_order", action="store_false")
    options = parser.parse_args()
    is_right = True
    for n_dim in options.dimensions:
        with tempfile.TemporaryDirectory() as folder:
            is_right = run(options, n_dim, Path(folder)) and is_right
    if not is_right:
        sys.exit("kept factors give other forces")


if __name__ == "__main__":
    main()
