# SPDX-License-Identifier: BSD-3-Clause
"""Lemke's method of Siconos for query_peers.py, by the Python of Debian, for which its package is made.

    /usr/bin/python3 tests/benchmark/siconos_lemke.py PROBLEM.npz ANSWER.npz

PROBLEM has `matrix`, shape (n, n), and `openings`, (n_points, n). ANSWER gets `seconds` and `forces` of each point.
"""

import sys
import time

import numpy as np
import siconos.numerics as siconos


def main():
    """Solves all points."""
    problem = np.load(sys.argv[1])
    options = siconos.SolverOptions(siconos.SICONOS_LCP_LEMKE)
    options.iparam[siconos.SICONOS_IPARAM_MAX_ITER] = 100_000
    seconds, forces = [], []
    for q in problem["openings"]:
        z, w = np.zeros(len(q)), np.zeros(len(q))
        start = time.perf_counter()
        info = siconos.lcp_lexicolemke(siconos.LCP(problem["matrix"], q), z, w, options)
        seconds.append(time.perf_counter() - start)
        forces.append(np.full(len(q), np.nan) if info else z)
    np.savez(sys.argv[2], seconds=seconds, forces=forces)


main()
