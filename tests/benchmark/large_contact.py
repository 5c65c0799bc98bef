#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A model of a large contact beside the dense solver that starts warm and factors anew, in one run.

build/venv/bin/python tests/benchmark/large_contact.py flange       # or indenter, where nothing can be gained
build/venv/bin/python tests/benchmark/large_contact.py flange --points 50 --set "method: condensed"

Answers of `predict` against the full-order solver at random points of the box; then medians of single queries by the C
interface, and of a primal-dual active set on W lambda + q from model.h5 that starts at the closed pairs of the nearest
training point and factors W_AA by LAPACK in every pass: time, and operations, |A|^3 / 3 + 2 q |A| per pass. A query that
changes k pairs of a reference takes 2 k^3 / 3 + 2 q k per pass, 2 q n_terms for the transformed q, and 2 q |A| more
for the openings of all pairs. Training keeps transforms only where they pay; without them a query takes the
operations of the dense solver. Ratios are of each point; the worst point has the smallest.
"""

import csv
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import h5py
import numpy as np
import scipy.linalg
import scipy.spatial
import yaml
from boxes import Box, write_gmsh
from timing import (
    INPUT,
    build,
    build_query_times,
    command_line,
    copy_deck,
    cpu_of,
    load_text,
    train,
    write_points,
)

SAME_SOLUTION = 1e-9
SEED = 1495
MAX_PASSES = 50
# names that expressions of decks have and Python has elsewhere
NAMES = {"sqrt": np.sqrt, "exp": np.exp, "cos": np.cos, "sin": np.sin, "abs": np.abs, "_pi": np.pi}
NAMES |= {"max": np.maximum, "min": np.minimum, "where": np.where}
# what a sphere's gap needs (src/contact/obstacle_gap.f90), near the sphere's top
NAMES["_sphere_depth"] = lambda a, b, c, radius: (
    (a**2 + b**2 + c**2) / (radius + np.sqrt(radius**2 - a**2 - b**2 - c**2))
)
# [mm] of meshes/indenter.geo
SIZES = [27.0, 21.0, 7.5]


def python_of(text):
    """An expression of a deck as Python reads it: `a ^ b` is `a ** b`, `a ? b : c` is `where(a, b, c)`."""
    inner = []

    def keep(group):
        inner.append(", ".join(map(chosen, group[1].split(","))))
        return f"@{len(inner) - 1}@"

    n_found = 1
    while n_found:
        text, n_found = re.subn(r"\(([^()]*)\)", keep, text)
    text = chosen(text)
    while "@" in text:
        text = re.sub(r"@(\d+)@", lambda number: f"({inner[int(number[1])]})", text)
    return text.replace("^", "**")


def chosen(text):
    """The same of `? :` alone, in a text without parentheses."""
    condition, mark, rest = text.partition("?")
    if not mark:
        return text
    depth = np.cumsum([(letter == "?") - (letter == ":") for letter in rest])
    i = int(np.argmax(depth < 0))
    return f"where({condition}, {chosen(rest[:i])}, {chosen(rest[i + 1 :])})"


def sample(program, folder, name, points, solver):
    """Multipliers of the full order at points; CPU time of the whole command per point."""
    deck = folder / f"{name}_{solver}.yaml"
    text = re.sub(r"training: .*", "training: {file: points.csv}", (folder / f"{name}.yaml").read_text())
    deck.write_text(f"{text}solver: {{type: {solver}}}\n")
    cpu = cpu_of([program, "sample", deck.name, "--quiet"], folder)
    with h5py.File(folder / "results" / deck.stem / "snapshots.h5") as file:
        if (file["reasons"][()] <= 0).any():
            sys.exit(f"{solver} found no solution at some point")
        return file["multipliers"][()], cpu / len(points)


def predict(program, folder, model, n_contacts):
    """Multipliers of the model at the points; nan where it has no answer."""
    cpu_of([program, "predict", model, "--points", "points.csv", "--output", "answers.csv"], folder)
    with (folder / "answers.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    columns = [column for column in rows[0] if column.startswith("lambda_")]
    if len(columns) != n_contacts:
        sys.exit(f"predict tells {len(columns)} forces, there are {n_contacts} contacts")
    return np.array([[float(row[column] or "nan") for column in columns] for row in rows])


class DenseProblem:
    """0 <= lambda, W lambda + q(mu) >= 0, complementary; W and the terms of q from a model file."""

    def __init__(self, path, names):
        """Read and compile the terms: expressions of the parameters, and of places."""
        with h5py.File(path) as file:
            self.compliance = file["clusters/1/compliance"][()]
            self.openings = file["clusters/1/free_opening"][()]
            self.sources = []
            for source in file["terms/sources"].values():
                text = python_of(source["text"][()].decode())
                if source["dof_terms"].size:
                    sys.exit("windows that move are not for this script")
                self.sources.append(
                    (compile(text, "term", "eval"), source["terms"][()] - 1, source["places"][()])
                )
            self.axes = [axis.decode() for axis in file["terms/coordinate_names"][()]]
        self.names = names

    def opening(self, point):
        """q(mu)."""
        theta = np.ones(len(self.openings))
        for code, terms, places in self.sources:
            known = NAMES | dict(zip(self.names, point, strict=True))
            if places.size:
                known |= dict(zip(self.axes, places.T, strict=True))
            # where() computes both sides: the root that it does not take may be of a negative number
            with np.errstate(invalid="ignore"):
                theta[terms] = eval(code, {"__builtins__": {}}, known)
        return theta @ self.openings

    def solve(self, q, is_closed):
        """Forces, operations, passes."""
        operations = 0.0
        for i_pass in range(1, MAX_PASSES + 1):
            closed = np.flatnonzero(is_closed)
            forces = np.zeros(len(q))
            w = q
            if len(closed):
                columns = self.compliance[closed]
                factor = scipy.linalg.cho_factor(columns[:, closed], lower=True, check_finite=False)
                forces[closed] = scipy.linalg.cho_solve(factor, -q[closed], check_finite=False)
                w = q + forces[closed] @ columns
                operations += len(closed) ** 3 / 3 + 2 * len(q) * len(closed)
            following = np.where(is_closed, forces > 0, w < -1e-13 * np.abs(q).max())
            if (following == is_closed).all():
                return forces, operations, i_pass
            is_closed = following
        sys.exit("the dense solver did not converge")


class TransformedProblem:
    """The same with principal pivot transforms, as a query does it where there are some: counts operations."""

    def __init__(self, path):
        """Read the transforms and the sets."""
        with h5py.File(path) as file:
            group = file["clusters/1"]
            n = len(group["compliance"])
            bits = group["start_sets"][()].astype("<u4").view(np.uint8)
            self.sets = np.unpackbits(bits, axis=1, bitorder="little")[:, :n].astype(bool)
            self.reference_of_point = group["reference_of_point"][()] - 1
            self.references = self.sets[group["reference_points"][()] - 1]
            self.columns = group["transforms"][()].reshape(len(self.references), n, n)

    def count(self, q, n_terms, i_nearest, dense):
        """Operations of a query, pairs that its last set changes, passes; `dense`: both without transforms."""
        if not len(self.references):
            n_closed = self.sets[i_nearest].sum()
            return dense[0] + 2.0 * len(q) * (n_terms + n_closed), n_closed, dense[1]
        i_reference = self.reference_of_point[i_nearest]
        columns, reference = self.columns[i_reference], self.references[i_reference]
        q = np.where(reference, 0.0, q) - q[reference] @ columns[reference]
        is_changed = self.sets[i_nearest] ^ reference
        n, operations = len(q), 2.0 * len(q) * n_terms
        for i_pass in range(1, MAX_PASSES + 1):
            changed = np.flatnonzero(is_changed)
            z = np.zeros(n)
            z[changed] = np.linalg.solve(columns[np.ix_(changed, changed)].T, -q[changed])
            w = q + z[changed] @ columns[changed]
            operations += 2 * len(changed) ** 3 / 3 + 2 * n * len(changed)
            smallest = 1e-12 * (np.abs(z).max(initial=0.0)), 1e-12 * np.abs(w).max()
            following = np.where(is_changed, z >= -smallest[0], w < -smallest[1])
            if (following == is_changed).all():
                n_closed = (is_changed ^ reference).sum()
                return operations + 2.0 * n * n_closed, len(changed), i_pass
            is_changed = following
        sys.exit("the transformed problem did not converge")


def time_dense(results, names, points):
    """Forces, seconds, operations and passes of each point; operations, changes and passes of the query."""
    problem = DenseProblem(results / "model.h5", names)
    transformed = TransformedProblem(results / "model.h5")
    with h5py.File(results / "snapshots.h5") as file:
        known, sets = file["parameters"][()], file["multipliers"][()] > 0
    low, high = known.min(axis=0), known.max(axis=0)
    tree = scipy.spatial.cKDTree((known - low) / (high - low))
    found = []
    for point in points:
        start = time.perf_counter()
        nearest = tree.query((point - low) / (high - low))[1]
        q = problem.opening(point)
        forces, operations, n_passes = problem.solve(q, sets[nearest])
        elapsed = time.perf_counter() - start
        counts = transformed.count(q, len(problem.openings), nearest, (operations, n_passes))
        found.append((forces, elapsed, operations, n_passes, *counts))
    return [np.array(values) for values in zip(*found, strict=True)]


def time_queries(folder, library, model, points):
    """What query_times tells: of random points, and the seconds of each given point."""
    np.savetxt(folder / "points.txt", points, fmt="%.17g")
    command = [build_query_times(library, folder), model, str(len(points))]
    text = subprocess.run(command, check=False, stdout=subprocess.PIPE, text=True).stdout
    done = subprocess.run([*command, folder / "points.txt"], check=True, stdout=subprocess.PIPE, text=True)
    return text, np.array([float(line) for line in done.stdout.split()])


def ratio_text(ours, theirs):
    """Median and worst of the ratios of the points."""
    ratios = theirs / ours
    return f"median {np.median(ratios):.0f}, worst point {ratios.min():.1f}"


def error_text(found, expected):
    """Median and largest error of the points that have an answer, and how many have none; whether it is small."""
    errors = np.linalg.norm(found - expected, axis=1) / np.linalg.norm(expected, axis=1)
    is_answered = np.isfinite(errors)
    largest = errors[is_answered].max(initial=0.0)
    text = f"median {np.median(errors[is_answered]):.1e}, largest {largest:.1e}, no answer at {(~is_answered).sum()}"
    return text, bool(is_answered.any() and largest <= SAME_SOLUTION)


def make_deck(options, folder):
    """The deck with the points and keys of the command line; names and ends of the parameters."""
    deck = copy_deck(INPUT / f"{options.deck}.yaml", folder)
    text = deck.read_text().replace("training: {sobol: 200}", f"training: {{sobol: {options.snapshots}}}")
    if options.cells:
        write_block(folder / "block.msh", options.cells)
        text = re.sub(r"file: \S+\.msh", "file: block.msh", text)
    keys = ", ".join(filter(None, ["max_full_order_size: 400", options.set]))
    deck.write_text(re.sub(r"\nreduction: .*", "", text).rstrip() + f"\nreduction: {{{keys}}}\n")
    ranges = yaml.safe_load(deck.read_text())["parameters"]
    low, high = (np.array([entry[end] for entry in ranges.values()]) for end in ("min", "max"))
    return list(ranges), low, high


def write_block(path, counts):
    """The block of `indenter` with other numbers of cells."""
    block = Box("H8", SIZES, counts, [0.0, 0.0, -SIZES[2]])
    groups = [
        ("H8", "block", block.cells),
        ("Q4", "base", block.sides[2, 0]),
        ("Q4", "face", block.sides[2, 1]),
    ]
    write_gmsh(path, block.nodes, groups)


def compare(options, program, folder, names, points):
    """Train, then the model and active_set against the condensed full order; its forces, and whether all agree."""
    name = options.deck
    times, model = train(program, folder, name)
    print("sample: {:.1f} s, train: {:.1f} s of CPU time".format(*times), flush=True)
    print(f"model.h5: {model.stat().st_size / 1e6:.0f} MB; {load_text()}")
    write_points(folder / "points.csv", names, points)
    expected, cpu = sample(program, folder, name, points, "condensed")
    print(f"full order, condensed: {1e3 * cpu:.1f} ms of CPU time per point, with set-up and displacements")
    text, is_same = error_text(predict(program, folder, model, expected.shape[1]), expected)
    print(f"predict against it at {len(points)} points: {text}: {'same' if is_same else 'NOT the same'}")
    few = points[: options.active_set]
    if len(few):
        write_points(folder / "points.csv", names, few)
        text, is_alike = error_text(sample(program, folder, name, few, "active_set")[0], expected[: len(few)])
        print(f"active_set against condensed at {len(few)}: {text}")
        is_same = is_same and is_alike
    return expected, is_same


def main():
    """One deck."""
    parser = command_line(__doc__)
    parser.add_argument("deck", choices=["flange", "indenter"])
    parser.add_argument("--points", type=int, default=200)
    parser.add_argument("--snapshots", type=int, default=200)
    parser.add_argument("--active-set", type=int, default=2, help="points that active_set solves, too")
    parser.add_argument("--set", default="", help="more keys of `reduction`, as in YAML")
    parser.add_argument(
        "--cells", nargs=3, type=int, help="of indenter along x, y, z, in place of meshes/indenter.msh"
    )
    options = parser.parse_args()
    program, library = build("signorom", "signorom_online")
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        names, low, high = make_deck(options, folder)
        points = np.random.default_rng(SEED).uniform(low, high, (options.points, len(names)))
        expected, is_same = compare(options, program, folder, names, points)
        results = folder / "results" / options.deck
        forces, seconds, operations, passes, fewer, changes, _ = time_dense(results, names, points)
        text, is_alike = error_text(forces, expected)
        print(f"dense solver against condensed: {text}")
        n_closed = (expected > 0).sum(axis=1)
        print(
            f"closed: {n_closed.min()} to {n_closed.max()}, median {np.median(n_closed):.0f} of {len(expected[0])}"
        )
        print(
            f"dense solver, warm, factors anew: median {1e6 * np.median(seconds):.0f} us, "
            f"{np.median(operations):.2e} operations, {np.median(passes):.0f} passes"
        )
        text, own = time_queries(folder, library, results / "model.h5", points)
        print(text, end="")
        print(
            f"query at the points: median {1e6 * np.median(own):.0f} us, largest {1e6 * own.max():.0f} us, "
            f"{np.median(fewer):.2e} operations, {np.median(changes):.0f} pairs differ from the reference"
        )
        print(
            f"dense solver over query: time {ratio_text(own, seconds)}; operations {ratio_text(fewer, operations)}"
        )
    sys.exit(None if is_same and is_alike else "the answers differ")


if __name__ == "__main__":
    main()
