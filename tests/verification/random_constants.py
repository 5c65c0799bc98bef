#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Models whose elastic constants depend on the parameters, against K factored at each of many random points.

    build/venv/bin/python tests/verification/random_constants.py                           # 500 points of each deck
    build/venv/bin/python tests/verification/random_constants.py fuel_rod --points 10000   # the twin of a fuel rod
    build/venv/bin/python tests/verification/random_constants.py fuel_rod --methods auto hhr
    build/venv/bin/python tests/verification/random_constants.py --by-modes

Prints a line for each deck and each kind of model (`reduction.method`): errors of the forces on all contacts relative to
the larger of their size and a thousandth of the largest in training, those over reduction.stiffness_tolerance; points
without an answer; errors of the displacements; bounds below the true error in the norm of W, and effectivity (median,
largest) where that error is above rounding; with --by-modes the same of displacements in the norm of K, where there is
no room for displacements but by modes; time of a query on one core, of training and of the full order. Ends with 1 where
an error is above the tolerance, a point has no answer, or a bound is below an error.
"""

import argparse
import os
import re
import sys
import tempfile
import time
from pathlib import Path

import h5py
import numpy as np
import yaml

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(HERE), str(HERE.parent / "support"), str(ROOT / "tools" / "signorom_post" / "src")]
from program import Program  # noqa: E402
from results import read_table  # noqa: E402
from runs import write_input  # noqa: E402
from varying_decks import (  # noqa: E402
    HANGING,
    MODULUS,
    NEARLY_INCOMPRESSIBLE,
    RATIOS,
    write_core_and_rim,
    write_one_ratio,
    write_study,
    write_two_materials,
)

DECKS = {
    "modulus": lambda folder: write_study("pellet_cladding", folder, MODULUS),
    "ratios": lambda folder: write_study("pellet_cladding", folder, RATIOS),
    "nearly_incompressible": lambda folder: write_study("pellet_cladding", folder, NEARLY_INCOMPRESSIBLE),
    "hanging": lambda folder: write_study("bracket", folder, HANGING),
    "core_and_rim": write_core_and_rim,
    "one_ratio": write_one_ratio,
    "two_materials": write_two_materials,
    "fuel_rod": lambda folder: write_input("fuel_rod", folder),
}
SEED = 20
# [-] of the size of the answer: smaller true errors are rounding
ROUNDING = 1e-10
SMALLEST_SHARE = 1e-3
WIDTHS = (22, 5, 6, 8, 9, 7, 7, 6, 5, 11, 7, 11, 8, 7, 7, 8)
COLUMNS = "| " + " | ".join(f"{{:<{width}}}" for width in WIDTHS) + " |"
HEADINGS = (
    "deck",
    "model",
    "points",
    "e_lambda",
    "over tol.",
    "without",
    "e_u",
    "bounds",
    "below",
    "effectivity",
)
HEADINGS += ("u below", "u effect.", "query ms", "train s", "full ms", "speed-up")


class Compliance:
    """W of a model at a point, by polynomials of its own: to measure errors with."""

    def __init__(self, path, names):
        """Read what the bodies keep."""
        with h5py.File(path) as file:
            sources = file["terms/sources"]
            self.texts = {
                int(source["terms"][0]): source["text"][()].decode().replace("^", "**")
                for source in sources.values()
                if len(source["terms"]) == 1
            }
            part = file["clusters/1"]
            self.bodies = [{name: body[name][()] for name in BODY_PARTS} for body in part["bodies"].values()]
            self.anchors = part["anchors"][()] - 1
            self.largest_size = part["largest_size"][()]
        self.names = names

    def value(self, term, point):
        """Of a term of the parameters alone."""
        return eval(self.texts[term], {"__builtins__": {}}, dict(zip(self.names, point, strict=True)))

    def __call__(self, point):
        """Sum over the bodies, anchors left out."""
        n = round(len(self.bodies[0]["compliance"][0]) ** 0.5)
        total = np.zeros(n * n)
        for body in self.bodies:
            factor = body["modulus"] / self.value(body["modulus_term"], point)
            total += factor * self.weights(body, point) @ body["compliance"]
        total = total.reshape(n, n)
        total[self.anchors, :] = 0
        total[:, self.anchors] = 0
        return total

    def weights(self, body, point):
        """Lagrange's polynomials of a body at a point, by powers of the constants."""
        place = []
        for top, bottom in zip(body["numerators"], body["denominators"], strict=True):
            value = self.value(top, point) / (self.value(bottom, point) if bottom else 1)
            if body["is_logarithmic"]:
                value = np.log(value) if bottom else -np.log(1 - 2 * value)
            place.append(value)
        nodes = body["nodes"].reshape(len(body["compliance"]), len(place))
        scaled = (2 * np.array(place) - body["lower"] - body["upper"]) / (body["upper"] - body["lower"])
        degrees = degrees_up_to(len(place), len(nodes))
        matrix = np.prod(nodes[:, None, :] ** degrees[None], axis=2)
        return np.linalg.solve(matrix.T, np.prod(scaled**degrees, axis=1))


BODY_PARTS = (
    "modulus_term",
    "modulus",
    "numerators",
    "denominators",
    "is_logarithmic",
    "lower",
    "upper",
    "nodes",
)
BODY_PARTS += ("compliance",)


def degrees_up_to(n_variables, n):
    """Exponents of the first so many monomials, lowest total degree first."""
    found, total = [], 0
    while len(found) < n:
        found += [d for d in np.ndindex(*[total + 1] * n_variables) if sum(d) == total]
        total += 1
    return np.array(found[:n]).reshape(n, n_variables)


def solve_points(program, deck, n_points, n_ranks):
    """The full order at random points of the deck's box: its snapshots, and seconds per point on one core."""
    text = re.sub(r"(?m)^(training|test|solver): .*\n", "", deck.read_text())
    text += f"\ntraining: {{latin_hypercube: {n_points}, seed: {SEED}}}\n"
    folder = deck.parent / "full_order"
    folder.mkdir()
    for mesh in deck.parent.glob("*.msh"):
        (folder / mesh.name).symlink_to(mesh)
    (folder / deck.name).write_text(text)
    start = time.perf_counter()
    program("sample", deck.name, folder=folder, n_ranks=n_ranks, time_limit=24 * 3600)
    seconds = (time.perf_counter() - start) * n_ranks / n_points
    return folder / "results" / deck.stem / "snapshots.h5", seconds


def train(program, deck, method, n_ranks, by_modes):
    """The model of a deck by a method, and the wall time of sampling and training; or why there is none."""
    content = yaml.safe_load(deck.read_text())
    if method != "auto":
        content["reduction"] = content.get("reduction", {}) | {"method": method}
    if by_modes:
        content["reduction"] = content.get("reduction", {}) | {"max_full_order_size": room_of_forces(deck)}
    own = deck.with_name(f"{deck.stem}_{method}.yaml")
    own.write_text(yaml.safe_dump(content, sort_keys=False))
    start = time.perf_counter()
    for command in ("sample", "train"):
        done = program.run(command, own.name, folder=deck.parent, n_ranks=n_ranks, time_limit=24 * 3600)
        if done.returncode:
            raise SystemError(done.stderr.strip().splitlines()[0])
    seconds = time.perf_counter() - start
    folder = deck.parent / "results" / own.stem
    with h5py.File(folder / "snapshots.h5") as file:
        largest = np.linalg.norm(file["multipliers"][()], axis=1).max()
    return folder / "model.h5", seconds, largest, content.get("reduction", {})


def room_of_forces(deck):
    """[MB] W and q, with more terms than decks have, and far less than fields take."""
    with h5py.File(deck.parent / "full_order" / "results" / deck.stem / "snapshots.h5") as file:
        n = file["multipliers"].shape[1]
    return 8e-6 * n * (n + 500)


def displacement_effectivities(program, path, found):
    """Bounds of the displacement over true errors in the norm of K where these are above rounding, from validate."""
    deck = path.parents[2] / f"{path.parent.name}.yaml"
    content = yaml.safe_load(deck.read_text())
    content["test"] = {"latin_hypercube": len(found["displacement_bound"]), "seed": SEED}
    deck.write_text(yaml.safe_dump(content, sort_keys=False))
    program("validate", deck.name, folder=deck.parent, n_ranks=2, time_limit=24 * 3600)
    table = read_table(path.parent / "validation.csv")
    error, size = table["e_u_energy"], table["e_u_energy"] / table["e_u_energy_relative"]
    is_counted = error > ROUNDING * np.maximum(size, SMALLEST_SHARE * size.max())
    return found["displacement_bound"][is_counted] / error[is_counted]


def query_seconds(model, points):
    """Processor time of a query, best of three."""
    found = []
    for _ in range(3):
        start = time.process_time()
        model.query_many(points)
        found.append((time.process_time() - start) / len(points))
    return min(found)


def compare(path, snapshots, largest):
    """Errors and bounds at all points, and the time of a query."""
    from signorom_post.online import Model, NoAnswerError

    found = {
        name: []
        for name in (
            "forces",
            "displacement",
            "bound",
            "error",
            "displacement_bound",
            "failed",
            "effectivity",
        )
    }
    with h5py.File(snapshots) as file, Model(path) as model:
        points = file["parameters"][()]
        reasons = file["reasons"][()]
        names = [parameter.name for parameter in model.parameters]
        compliance = Compliance(path, names)
        for i, point in enumerate(points):
            if reasons[i] <= 0:
                raise SystemError(f"the full order has no solution at {point}")
            exact = file["multipliers"][i]
            try:
                answer = model.query(**dict(zip(names, point, strict=True)))
            except NoAnswerError:
                found["failed"].append(i)
                continue
            wrong = answer.multipliers - exact
            found["forces"].append(
                np.linalg.norm(wrong) / max(np.linalg.norm(exact), SMALLEST_SHARE * largest)
            )
            if not np.isfinite(found["forces"][-1]):
                found["failed"].append(i)
            field = answer.displacement.ravel()
            known = np.isfinite(field)
            if known.any():
                solution = file["displacement"][i][known]
                found["displacement"].append(
                    np.linalg.norm(field[known] - solution) / np.linalg.norm(solution)
                )
            if answer.displacement_bound is not None:
                found["displacement_bound"].append(answer.displacement_bound)
            if answer.relative_bound is not None:
                matrix = compliance(point)
                size = max(np.sqrt(exact @ matrix @ exact), SMALLEST_SHARE * compliance.largest_size)
                found["bound"].append(answer.bound / size)
                found["error"].append(np.sqrt(max(0, wrong @ matrix @ wrong)) / size)
        seconds = query_seconds(model, points[:2000])
    return {name: np.array(values) for name, values in found.items()}, seconds


def line_of(name, method, found, seconds, tolerance, times):
    """A line of the table, and whether all is right."""
    train_seconds, full_seconds = times
    below, effectivity, n_bounds = "none", "none", "none"
    is_right = len(found["failed"]) == 0 and found["forces"].max() <= tolerance
    if len(found["bound"]):
        bound, error = found["bound"], found["error"]
        n_bounds = len(bound)
        n_below = np.count_nonzero(bound < error - 1e-12)
        is_right = is_right and n_below == 0
        below = str(n_below)
        ratios = (bound / np.maximum(error, 1e-300))[error > ROUNDING]
        if len(ratios):
            effectivity = f"{np.median(ratios):.2f}, {ratios.max():.1f}"
    u_below, u_effectivity = "none", "none"
    if len(found["effectivity"]):
        ratios = found["effectivity"]
        u_below = str(np.count_nonzero(ratios < 1))
        u_effectivity = f"{np.median(ratios):.2f}, {ratios.max():.1f}"
        is_right = is_right and ratios.min() >= 1
    displacement = f"{found['displacement'].max():.1e}" if len(found["displacement"]) else "none"
    line = COLUMNS.format(
        name,
        method,
        len(found["forces"]) + len(found["failed"]),
        f"{found['forces'].max():.1e}",
        f"{found['forces'].max() / tolerance:.2f}",
        len(found["failed"]),
        displacement,
        n_bounds,
        below,
        effectivity,
        u_below,
        u_effectivity,
        f"{1e3 * seconds:.3f}",
        f"{train_seconds:.0f}",
        f"{1e3 * full_seconds:.0f}",
        f"{full_seconds / seconds:.0f}",
    )
    return line, is_right


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("decks", nargs="*", help=f"of {', '.join(DECKS)}; default: all")
    parser.add_argument("--build", type=Path, default=ROOT / "build" / "release")
    parser.add_argument("--points", type=int, default=500)
    parser.add_argument("--methods", nargs="+", default=["auto"], help="values of reduction.method")
    parser.add_argument("--ranks", type=int, default=2, help="of the full order and of training")
    parser.add_argument(
        "--by-modes", action="store_true", help="displacements by modes, and bounds of these, by validate"
    )
    arguments = parser.parse_args()
    program = Program((arguments.build / "signorom").resolve())
    os.environ["SIGNOROM_EXECUTABLE"] = str(program.executable)
    os.environ["SIGNOROM_LIBRARY"] = str(program.executable.parent / "src/online/libsignorom_online.so")
    print(COLUMNS.format(*HEADINGS))
    print("|" + "---|" * len(HEADINGS), flush=True)
    is_good = True
    for name in arguments.decks or DECKS:
        with tempfile.TemporaryDirectory() as folder:
            deck = DECKS[name](Path(folder))
            snapshots, full_seconds = solve_points(program, deck, arguments.points, arguments.ranks)
            for method in arguments.methods:
                try:
                    model, seconds, largest, reduction = train(
                        program, deck, method, arguments.ranks, arguments.by_modes
                    )
                    found, query = compare(model, snapshots, largest)
                    if arguments.by_modes:
                        found["effectivity"] = displacement_effectivities(program, model, found)
                except SystemError as reason:
                    print(f"| {name} | {method} | {reason}", flush=True)
                    is_good = False
                    continue
                tolerance = float(reduction.get("stiffness_tolerance", 1e-6))
                line, is_right = line_of(name, method, found, query, tolerance, (seconds, full_seconds))
                print(line, flush=True)
                is_good = is_good and is_right
    return 0 if is_good else 1


if __name__ == "__main__":
    sys.exit(main())
