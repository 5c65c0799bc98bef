# SPDX-License-Identifier: BSD-3-Clause
"""What a query of case b costs, beside the condensed and the refactored full-order model, in one run.

build/venv/bin/python tests/benchmark/query.py [N] [--grid 10 50]   (default: 100000 points)
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import yaml
from timing import INPUT, build, build_query_times, command_line, copy_deck, load_text, measure

NAME = "pellet_cladding_whole_edges"


def main():
    """Train, validate at a few points (for the times of the full-order model), and ask many points of the box."""
    parser = command_line(__doc__)
    parser.add_argument("n_points", nargs="?", default=100_000)
    parser.add_argument("--grid", nargs=2, default=[10, 50], help="snapshots along each parameter")
    options = parser.parse_args()
    program, library = build("signorom", "signorom_online")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        changes = {"P1: 80, h1: 80": "P1: 5, h1: 5", "P1: 10, h1: 50": "P1: {}, h1: {}".format(*options.grid)}
        deck = copy_deck(INPUT / f"{NAME}.yaml", folder, **changes)
        results = folder / "results" / NAME
        times = {}
        for command in ("sample", "train", "validate"):
            words = ["--quiet", "--benchmark"] if command == "validate" else ["--quiet"]
            done = measure([program, command, deck.name, *words], folder)
            print(f"{command}: {done.cpu:.2f} s of CPU time, {done.wall:.2f} s")
            if command != "sample":
                times |= yaml.safe_load((results / "report.yaml").read_text())["times"]
        print(f"of that, training after the snapshots were read: {times['train']:.2f} s; {load_text()}")
        print(f"refactored full-order model: {1e3 * times['refactored_per_point']:.2f} ms per point")
        print(f"condensed full-order model:  {1e3 * times['full_order_per_point']:.2f} ms per point")
        sys.stdout.flush()
        subprocess.run(
            [build_query_times(library, folder), results / "model.h5", str(options.n_points)], check=True
        )


if __name__ == "__main__":
    main()
