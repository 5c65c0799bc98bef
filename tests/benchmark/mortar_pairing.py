#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Two blocks of H8 whose facets do not match: time of pairing and integration beside that of one assembly and solve.

    build/venv/bin/python tests/benchmark/mortar_pairing.py            # 10 000 facing 15 129 facets
    build/venv/bin/python tests/benchmark/mortar_pairing.py 200        # 40 000 facing 60 025: 1.2 million dofs

The blocks of blocks_3d.py, four nodes high; a number is the edges along each side of the first surface. Prints a
table; ends with 1 where pairing takes more than a tenth of assembly, set-up and solution.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import yaml
from blocks_3d import DECK, ENVIRONMENT, ROOT, launcher, write_mesh

N_HIGH = 4
RATIO = 1.225
ALLOWED = 0.1


def main():
    """A line per size."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("edges", nargs="*", type=int, default=[100])
    parser.add_argument("--ranks", type=int, default=1)
    arguments = parser.parse_args()
    program = Path(os.environ.get("SIGNOROM_EXECUTABLE", ROOT / "build" / "release" / "signorom")).resolve()
    deck = DECK.format(solver="active_set", linear="gamg").replace(", direction: [0, 0, 1]", "")
    print("   first  second     dofs  pairing  us per facet  assembly  set-up   solve  share")
    is_fine = True
    for n in arguments.edges:
        other = round(RATIO * n)
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            write_mesh(folder / "blocks.msh", n + 1, N_HIGH, other + 1)
            (folder / "blocks.yaml").write_text(deck)
            command = [*launcher(arguments.ranks), str(program), "solve", "blocks.yaml", "--quiet"]
            subprocess.run(command, cwd=folder, env=os.environ | ENVIRONMENT, check=True)
            report = yaml.safe_load((folder / "results" / "blocks" / "report.yaml").read_text())
        times, solve = report["times"], report["points"]["1"]["seconds"]
        share = times["pairing"] / (times["assembly"] + times["setup"] + solve)
        is_fine = is_fine and share <= ALLOWED
        print(
            f"{n * n:8d} {other * other:7d} {report['sizes']['n_dofs']:8d} {times['pairing']:8.2f} "
            f"{1e6 * times['pairing'] / (n * n + other * other):13.1f} {times['assembly']:9.2f} {times['setup']:7.2f} "
            f"{solve:7.1f} {share:6.1%}",
            flush=True,
        )
    return 0 if is_fine else 1


if __name__ == "__main__":
    sys.exit(main())
