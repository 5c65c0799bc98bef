#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Condensed models beside Gaussian processes of scikit-learn, from the same training points, at new points.

    build/venv/bin/python tests/benchmark/surrogate_peers.py bracket dovetail

The surrogate has the coefficients of the POD modes of the training forces (all but 1e-6 of their energy), each by a
Gaussian process with a squared exponential kernel of a length per parameter and a nugget, fitted to the parameters in
[0, 1]. Forces that pull are set to 0. Errors are those of all contact forces of a point, in the Euclidean norm over
that of the full order, which solves the new points, too. `within 2 sigma` is the share of single forces, of contacts
that close at some training point, whose error is at most twice the standard deviation that the surrogate tells.
Our certificate is one of the energy norm; forces are exact where it is at most 1e-12. One thread.
"""

import os
import sys
import tempfile
import time
import warnings
from pathlib import Path

import h5py
import numpy as np
from large_contact import sample
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel
from timing import INPUT, build, command_line, copy_deck, load_text, python_model, train, write_points

SEED = 1495
LEFT_OUT = 1e-6
LARGEST_ERROR = 1e-9
# a certificate of at most this says that forces are exact
EXACT = 1e-12


class Surrogate:
    """POD and a Gaussian process per mode."""

    def __init__(self, points, forces, box, most_modes):
        """`points`: shape (n, n_parameters), `forces`: (n, n_contacts), `box`: lowest and highest values."""
        self.box = box
        self.mean = forces.mean(axis=0)
        left, sizes, self.modes = np.linalg.svd(forces - self.mean, full_matrices=False)
        energy = np.cumsum(sizes**2) / np.sum(sizes**2)
        n_modes = min(int(np.searchsorted(energy, 1 - LEFT_OUT)) + 1, most_modes)
        self.modes = self.modes[:n_modes]
        lengths = np.ones(len(box[0]))
        kernel = ConstantKernel() * RBF(lengths, (1e-2, 1e2)) + WhiteKernel(1e-6, (1e-10, 1e-1))
        self.processes = [
            GaussianProcessRegressor(kernel, normalize_y=True).fit(self.scaled(points), left[:, k] * sizes[k])
            for k in range(n_modes)
        ]

    def scaled(self, points):
        """In [0, 1]."""
        return (points - self.box[0]) / (self.box[1] - self.box[0])

    def predict(self, points):
        """Forces and their standard deviations, shape (n, n_contacts)."""
        told = [process.predict(self.scaled(points), return_std=True) for process in self.processes]
        values, deviations = (np.array([pair[i] for pair in told]).T for i in range(2))
        return np.maximum(self.mean + values @ self.modes, 0), np.sqrt(deviations**2 @ self.modes**2)


def timed(procedure, *arguments):
    """What it returns, and its wall time [s]."""
    start = time.perf_counter()
    found = procedure(*arguments)
    return found, time.perf_counter() - start


def errors_of(forces, expected):
    """Of each point."""
    return np.linalg.norm(forces - expected, axis=1) / np.linalg.norm(expected, axis=1)


def tell(name, offline, online, errors, rest):
    """A line."""
    quantiles = " ".join(f"{value:.1e}" for value in np.quantile(errors, [0.5, 0.95, 1]))
    print(
        f"{name}: offline {offline:.1f} s, {1e6 * online:.1f} us a point; error {quantiles}; {rest}",
        flush=True,
    )


def compare(deck, options, programs, folder):
    """Lines of a deck; the largest error of our model."""
    program, library = programs
    copy_deck(INPUT / f"{deck}.yaml", folder)
    (sampling, training), path = train(program, folder, deck)
    with h5py.File(path.with_name("snapshots.h5")) as file:
        points, forces = file["parameters"][()], file["multipliers"][()]
    with python_model(library)(path) as model:
        names = [parameter.name for parameter in model.parameters]
        box = np.array([(parameter.minimum, parameter.maximum) for parameter in model.parameters]).T
        new = np.random.default_rng(SEED).uniform(*box, (options.points, len(names)))
        model.query_many(new)
        answers, asking = timed(model.query_many, new)
    write_points(folder / "points.csv", names, new)
    expected, full = sample(program, folder, deck, new, "condensed")
    print(
        f"{deck}: {len(points)} training points {sampling:.1f} s, {forces.shape[1]} contacts, "
        f"full order {1e6 * full:.0f} us"
    )
    errors = errors_of(answers.multipliers, expected)
    exact = 100 * np.mean(answers.relative_bound <= EXACT)
    bound = np.quantile(answers.relative_bound, 0.5)
    tell(
        "signorom", training, asking / options.points, errors, f"told {bound:.1e}, exact by it {exact:.1f} %"
    )
    with warnings.catch_warnings():
        # a length at the end of its range
        warnings.simplefilter("ignore")
        surrogate, fitting = timed(Surrogate, points, forces, box, options.modes)
    (found, deviations), asking = timed(surrogate.predict, new)
    closes = forces.max(axis=0) > 0
    within = 100 * np.mean((np.abs(found - expected) <= 2 * deviations)[:, closes])
    told = np.quantile(np.linalg.norm(deviations, axis=1) / np.linalg.norm(found, axis=1), 0.5)
    rest = f"told {told:.1e} (sigma), within 2 sigma {within:.1f} %; {len(surrogate.processes)} modes"
    tell("POD and Gaussian processes", fitting, asking / options.points, errors_of(found, expected), rest)
    return errors.max()


def main():
    """Three lines per deck."""
    parser = command_line(__doc__)
    parser.add_argument("decks", nargs="+", help="of input/, with a condensed model without friction")
    parser.add_argument("--points", type=int, default=1000)
    parser.add_argument("--modes", type=int, default=1000, help="most of the surrogate")
    options = parser.parse_args()
    programs = build("signorom", "signorom_online")
    print(load_text())
    worst = 0.0
    for deck in options.decks:
        with tempfile.TemporaryDirectory() as folder:
            worst = max(worst, compare(deck, options, programs, Path(folder)))
    sys.exit(None if worst <= LARGEST_ERROR else f"the largest error of our forces is {worst:.1e}")


if __name__ == "__main__":
    # before the libraries of linear algebra are loaded, in this process started anew
    if os.environ.get("OMP_NUM_THREADS") != "1":
        os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"
        os.execv(sys.executable, [sys.executable, *sys.argv])
    main()
