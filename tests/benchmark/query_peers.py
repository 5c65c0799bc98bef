#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Single queries of condensed models at random points, beside a warm dense solver and solvers of quadratic programs.

    build/venv/bin/python tests/benchmark/query_peers.py bracket saddle angle_bracket
    build/venv/bin/python tests/benchmark/query_peers.py flange --points 500 --dense-points 40 --peer-points 5

A query has the certificate; the dense solver starts at the closed contacts of the nearest training point and factors
W of the closed ones by LAPACK in each pass (benchmark_query). The peers get W and q, and minimize z'W z / 2 + q'z over
z >= 0: OSQP keeps its factors and starts warm, with an error of 1e-9; the others are exact but for rounding, or
interior point methods with their usual error; Lemke's method of Siconos (python3-siconos) gets the same. Those that are
not installed are left out (requirements.txt). Times are of one thread; `error` is the largest difference of a force
over the largest force.
"""

import importlib
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import h5py
import numpy as np
import scipy.sparse
from query_many import write_deck
from timing import build, command_line, load_text, measure, train

SAME = 1e-9
INFINITE = 1e30
# Siconos is a package of Debian (python3-siconos), made for this Python
DEBIAN_PYTHON = "/usr/bin/python3"


def start_osqp(osqp, matrix):
    """One problem whose q changes."""
    n = len(matrix)
    solver = osqp.OSQP()
    upper = scipy.sparse.csc_matrix(np.triu(matrix))
    options = {"eps_abs": 1e-9, "eps_rel": 1e-9, "max_iter": 100_000, "polishing": True, "verbose": False}
    zeros, none = np.zeros(n), np.full(n, np.inf)
    solver.setup(upper, zeros, scipy.sparse.identity(n, format="csc"), zeros, none, **options)

    def solve(q):
        solver.update(q=q)
        return solver.solve().x

    return solve


def start_daqp(daqp, matrix):
    """A dual active set, which factors W for each q."""
    n = len(matrix)
    low, high, sense = np.zeros(n), np.full(n, INFINITE), np.zeros(n, dtype=np.int32)
    identity = np.zeros((0, n))
    return lambda q: daqp.solve(matrix, q.copy(), identity, high, low, sense)[0]


def start_quadprog(quadprog, matrix):
    """Goldfarb and Idnani's method, which factors W for each q."""
    identity = np.eye(len(matrix))
    return lambda q: quadprog.solve_qp(matrix, -q, identity, np.zeros(len(q)))[0]


def start_piqp(piqp, matrix):
    """An interior point method that keeps its memory."""
    n = len(matrix)
    solver = piqp.DenseSolver()
    solver.settings.eps_abs = solver.settings.eps_rel = 1e-10
    solver.setup(matrix, np.zeros(n), None, None, None, None, None, np.zeros(n), np.full(n, np.inf))

    def solve(q):
        solver.update(c=q)
        solver.solve()
        return np.array(solver.result.x)

    return solve


PEERS = {"osqp": start_osqp, "daqp": start_daqp, "quadprog": start_quadprog, "piqp": start_piqp}


def time_peer(name, matrix, openings, expected):
    """Seconds of each point and the largest error; nothing where the peer is not installed.

    W and q are scaled, so that forces have the size 1.
    """
    try:
        library = importlib.import_module(name)
    except ImportError:
        return None
    force = np.abs(expected).max()
    scale = np.diag(matrix).max()
    solve = PEERS[name](library, np.ascontiguousarray(matrix / scale))
    seconds, errors = [], []
    for q, forces in zip(openings, expected, strict=True):
        scaled = q / (scale * force)
        start = time.perf_counter()
        found = solve(scaled)
        seconds.append(time.perf_counter() - start)
        errors.append(np.abs(np.asarray(found) - forces / force).max())
    return np.array(seconds), max(errors)


def time_siconos(folder, matrix, openings, expected):
    """The same of Lemke's method of Siconos, in a process of Debian's Python; nothing where it is not installed."""
    force, scale = np.abs(expected).max(), np.diag(matrix).max()
    np.savez(folder / "problem.npz", matrix=matrix / scale, openings=openings / (scale * force))
    script = Path(__file__).with_name("siconos_lemke.py")
    command = [DEBIAN_PYTHON, script, folder / "problem.npz", folder / "answer.npz"]
    if subprocess.run([DEBIAN_PYTHON, "-c", "import siconos.numerics"], capture_output=True).returncode:
        return None
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    answer = np.load(folder / "answer.npz")
    return answer["seconds"], np.abs(answer["forces"] - expected / force).max()


def ask(program, benchmark, folder, deck, options):
    """What benchmark_query tells, its largest difference, W or None, q and unknowns of some points."""
    write_deck(folder, deck, "reduction: {method: condensed}" if options.condensed else None)
    _, model = train(program, folder, deck)
    n_dense = min(options.dense_points or options.points, options.points)
    command = [benchmark, model, str(options.points), str(n_dense), folder / "pairs.bin"]
    text = measure(command, folder).output
    difference = float(text.split("largest unknown:")[1])
    with h5py.File(model) as file:
        part = file["clusters/1"]
        matrix, is_symmetric = part["compliance"][()], not part["anchors"].size
    numbers = np.fromfile(folder / "pairs.bin").reshape(2, n_dense, len(matrix))
    return text, difference, matrix if is_symmetric else None, *numbers[:, : options.peer_points]


def tell(name, found):
    """A line of a peer."""
    if found is None:
        print(f"{name}: not installed")
        return
    median, worst = (1e6 * measure_of(found[0]) for measure_of in (np.median, np.max))
    print(f"{name}, us: median, worst {median:.0f} {worst:.0f}; error {found[1]:.1e}", flush=True)


def main():
    """Lines of benchmark_query, and a line per peer."""
    parser = command_line(__doc__)
    parser.add_argument("decks", nargs="+", help="of input/, with a condensed model without friction")
    parser.add_argument("--condensed", action="store_true", help="whatever model the deck asks for")
    parser.add_argument("--points", type=int, default=10_000)
    parser.add_argument(
        "--dense-points", type=int, help="of these the first ones by the dense solver; default: all"
    )
    parser.add_argument("--peer-points", type=int, default=50)
    options = parser.parse_args()
    program, benchmark = build("signorom", "benchmark_query")
    os.environ["OPENBLAS_NUM_THREADS"] = os.environ["OMP_NUM_THREADS"] = "1"
    print(load_text())
    is_same = True
    for deck in options.decks:
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place)
            text, difference, matrix, openings, expected = ask(program, benchmark, folder, deck, options)
            print(f"{deck} {len(expected[0])} rows\n{text}", end="")
            is_same = is_same and difference <= SAME
            if matrix is None:
                print("only contact holds a body: W is not symmetric, so no peer solves this")
                continue
            tell("siconos", time_siconos(folder, matrix, openings, expected))
            for name in PEERS:
                tell(name, time_peer(name, matrix, openings, expected))
    sys.exit(None if is_same else "the answers differ")


if __name__ == "__main__":
    main()
