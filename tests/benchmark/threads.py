# SPDX-License-Identifier: BSD-3-Clause
"""A million answers of case b and its clusters on eight threads, compared bit by bit with one thread.

build/venv/bin/python tests/benchmark/threads.py [ANSWERS]   (default: 1000000 for each model, two minutes)

Ends with 1 where an answer differs. The tests do the same with fewer answers (tests/integration/test_threads.py).
"""

import subprocess
import sys
import tempfile
from pathlib import Path

from timing import ROOT, build, cpu_of, load_text

sys.path += [str(ROOT / "tests" / folder) for folder in ("integration", "support")]
from c_programs import compile_c
from decks import copy_deck

N_THREADS = 8


def main():
    """Train the models, then ask them."""
    n_answers = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    program = build("signorom")[0]
    build("signorom_online")
    library = program.parent / "src" / "online" / "libsignorom_online.so"
    has_failed = False
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        compare = compile_c("compare_threads", library, folder)
        for deck in ("pellet_cladding", "pellet_cladding_clusters"):
            copy_deck(ROOT / "input" / f"{deck}.yaml", folder)
            for command in ("sample", "train"):
                cpu_of([program, command, f"{deck}.yaml", "--quiet"], folder)
            model = folder / "results" / deck / "model.h5"
            done = subprocess.run([compare, model, str(N_THREADS), str(n_answers // N_THREADS)], check=False)
            has_failed |= done.returncode != 0
    print(load_text())
    sys.exit(int(has_failed))


if __name__ == "__main__":
    main()
