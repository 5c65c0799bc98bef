# SPDX-License-Identifier: BSD-3-Clause
"""Model.query_many of Python beside a loop in C over the same points, in one run.

build/venv/bin/python tests/benchmark/query_many.py [PROGRAM] [N]   (default: build/release/signorom, 20000 points)
"""

import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from timing import load_text

ROOT = Path(__file__).resolve().parents[2]
#: name of the model: deck, its section reduction
MODELS = {
    "half disks, hhr": ("half_disks", "reduction: {method: hhr}"),
    "half disks, condensed": ("half_disks", "reduction: {method: condensed}"),
    "case b, hhr": ("pellet_cladding", None),
    "case b, condensed": ("pellet_cladding", "reduction: {method: condensed}"),
}


def train(program, folder, name, reduction):
    """Model of a deck of input/ with another section reduction."""
    text = (ROOT / "input" / f"{name}.yaml").read_text().replace("../meshes/", f"{ROOT}/meshes/")
    if reduction:
        text = re.sub(r"(?ms)^(reduction|clusters):.*?(?=^\S|\Z)", "", text) + f"{reduction}\n"
    (folder / "deck.yaml").write_text(text)
    for command in ("sample", "train"):
        subprocess.run(
            [program, command, "deck.yaml", "--quiet"], cwd=folder, check=True, stderr=subprocess.DEVNULL
        )
    return folder / "results" / "deck" / "model.h5"


def loop_in_c(library, folder, model, points):
    """[s] of signorom_query and signorom_get_multipliers, mean per point; each point was asked once before."""
    np.savetxt(folder / "points.txt", points, "%.17g")
    source = Path(__file__).with_name("query_times.c")
    build = ["cc", "-O2", source, f"-I{ROOT}/include", f"-L{library}", "-lsignorom_online"]
    subprocess.run([*build, f"-Wl,-rpath,{library}", "-o", folder / "query_times"], check=True)
    command = [folder / "query_times", model, str(len(points)), "points.txt"]
    said = subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True).stdout
    return np.mean(np.array(said.split(), dtype=float))


def call_in_python(path, points):
    """[s] of one call for all points, mean per point; the best of three."""
    from signorom_post import Model

    with Model(path) as model:
        times = []
        for _ in range(3):
            start = time.perf_counter()
            model.query_many(points)
            times.append(time.perf_counter() - start)
    return min(times) / len(points)


def main():
    """Print a line per model."""
    program = Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "build" / "release" / "signorom").resolve()
    n_points = int(sys.argv[2]) if len(sys.argv) > 2 else 20000
    library = program.parent / "src" / "online"
    os.environ["SIGNOROM_LIBRARY"] = str(library / "libsignorom_online.so")
    from signorom_post import Model

    for label, (name, reduction) in MODELS.items():
        with tempfile.TemporaryDirectory() as temporary:
            folder = Path(temporary)
            path = train(program, folder, name, reduction)
            with Model(path) as model:
                lowest, highest = np.array([(p.minimum, p.maximum) for p in model.parameters]).T
            points = lowest + np.random.default_rng(1).random((n_points, len(lowest))) * (highest - lowest)
            in_c, in_python = loop_in_c(library, folder, path, points), call_in_python(path, points)
            print(
                f"{label}: C {1e6 * in_c:.1f} us, Python {1e6 * in_python:.1f} us a point: {in_python / in_c:.2f}"
            )
    print(load_text())


if __name__ == "__main__":
    main()
