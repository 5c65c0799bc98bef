# SPDX-License-Identifier: BSD-3-Clause
"""What a query of case b costs, beside the condensed and the refactored full-order model, in one run.

build/venv/bin/python tests/benchmark/query.py [PROGRAM] [N]   (default: build/release/signorom, 100000 points)
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

import yaml
from timing import cpu_of, load_text

ROOT = Path(__file__).resolve().parents[2]
DECK = ROOT / "input" / "pellet_cladding_whole_edges.yaml"


def main():
    """Train, validate at a few points (for the times of the full-order model), and ask many points of the box."""
    program = Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "build" / "release" / "signorom").resolve()
    n_points = sys.argv[2] if len(sys.argv) > 2 else "100000"
    library = program.parent / "src" / "online"
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        deck = re.sub(r"test: .*", "test: {grid: {P1: 5, h1: 5}}", DECK.read_text())
        deck = deck.replace("../meshes/", f"{ROOT}/meshes/")
        (folder / "case_b.yaml").write_text(deck)
        results = folder / "results" / "case_b"
        times = {}
        for command in ("sample", "train", "validate"):
            options = ["--quiet", "--benchmark"] if command == "validate" else ["--quiet"]
            cpu, wall, _ = cpu_of([program, command, "case_b.yaml", *options], folder)
            print(f"{command}: {cpu:.2f} s of CPU time, {wall:.2f} s")
            if command != "sample":
                times |= yaml.safe_load((results / "report.yaml").read_text())["times"]
        print(f"of that, training after the snapshots were read: {times['train']:.2f} s; {load_text()}")
        print(f"refactored full-order model: {1e3 * times['refactored_per_point']:.2f} ms per point")
        print(f"condensed full-order model:  {1e3 * times['full_order_per_point']:.2f} ms per point")
        source = Path(__file__).with_name("query_times.c")
        build = ["cc", "-O2", source, f"-I{ROOT}/include", f"-L{library}", "-lsignorom_online"]
        subprocess.run([*build, f"-Wl,-rpath,{library}", "-o", folder / "query_times"], check=True)
        subprocess.run([folder / "query_times", results / "model.h5", n_points], check=True)


if __name__ == "__main__":
    main()
