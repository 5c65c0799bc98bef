#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The way of a user, with all defaults, on parts of real size: time, memory and errors of each stage.

    build/venv/bin/python tests/real_size/run_parts.py                    # all parts, an hour on two cores
    build/venv/bin/python tests/real_size/run_parts.py lug roller --ranks 2 --folder /tmp/parts
    build/venv/bin/python tests/real_size/run_parts.py lug --edge 0.2    # a finer mesh
    build/venv/bin/python tests/real_size/run_parts.py lug --ranks 2 --folder /tmp/two --beside /tmp/parts

Meshes a part, then: check, run, predict --fields, solve at a point that no model has seen, report; derivatives beside
central differences of full-order solutions; forces of contacts and supports beside those of the loads; fields.xdmf read
by VTK. Ends with 1 where a limit is missed, and names it.
"""

import argparse
import csv
import os
import re
import shutil
import sys
import tempfile
import time
import warnings
from pathlib import Path

import h5py
import meshio
import numpy as np
import yaml

ROOT = Path(__file__).resolve().parents[2]
HERE = Path(__file__).resolve().parent
sys.path += [str(ROOT / "tests" / "benchmark"), str(ROOT / "tests" / "support")]
from timing import load_text, measure  # noqa: E402

from program import launcher  # noqa: E402
from signorom_post import Model, NotAcceptedWarning  # noqa: E402
from vtk_fields import read_with_vtk  # noqa: E402

#: part -> a point that is neither of training nor of test
POINTS = {
    "lug": {"pull": 9.3, "angle": 33.7, "fit": 0.0117},
    "press_fit": {"fit": 0.0171, "bend": 5.3, "speed": 1370.0},
    "roller": {"place": 23.7, "depth": 0.213, "hollow": 0.037},
    "flanges": {"bolt": 133.0, "p": 7.7, "warmer": 23.0},
    "stack": {"p": 17.3, "tilt": 0.41, "q": 83.0},
}
DIMENSION = {"lug": 2, "press_fit": 3, "roller": 2, "flanges": 3, "stack": 3}
#: [-] share of a parameter's range between a point and its neighbor for differences
STEP = 1.0e-4
# [-] limits: contact forces of the default model; its fields, as reduction.displacement_tolerance and
# validation.accept_fields; derivatives beside differences, which lose half the digits of the forces; loads on curved
# edges
FORCES, FIELDS, DERIVATIVES, BALANCE = 1.0e-8, 1.0e-2, 1.0e-4, 1.0e-4
# [-] answers of other numbers of ranks
SAME = 1.0e-10


class Stages:
    """Runs commands in a folder, and keeps a line of the table for each."""

    def __init__(self, folder):
        self.folder = folder
        self.rows = []

    def __call__(self, name, command, inside="."):
        """Runs a command in a folder inside of this one, and returns its exit code and all that it printed."""
        log, place = self.folder / f"{name}.log", self.folder / inside
        place.mkdir(exist_ok=True)
        done = measure(command, place, may_fail=True, log=log)
        self.rows.append((name, done.wall, done.cpu, done.megabytes, done.code))
        return done.code, done.output

    def print(self):
        print("| stage | wall s | CPU s | MB | exit code |\n|---|---|---|---|---|")
        for name, seconds, cpu, megabytes, code in self.rows:
            print(f"| {name} | {seconds:.1f} | {cpu:.1f} | {megabytes:.0f} | {code} |")


class Checks:
    """Figures beside their limits."""

    def __init__(self):
        self.missed = []

    def at_most(self, what, found, limit):
        """Prints a figure, and remembers a miss; nan is one."""
        is_good = found <= limit
        print(f"- {what}: {found:.1e}, allowed {limit:.0e}{'' if is_good else ' **missed**'}")
        if not is_good:
            self.missed.append(what)

    def holds(self, what, is_good):
        print(f"- {what}: {'yes' if is_good else '**no**'}")
        if not is_good:
            self.missed.append(what)


def read_point(path):
    """The only point of fields.h5: name -> array."""
    with h5py.File(path) as file:
        return {name: dataset[()] for name, dataset in file["points/0001"].items()}


def off(found, expected):
    """Largest difference over the largest size."""
    return np.nanmax(np.abs(found - expected)) / np.nanmax(np.abs(expected))


def norm_off(found, expected):
    """Difference over the size, in the Euclidean norm."""
    return np.linalg.norm(found - expected) / np.linalg.norm(expected)


def plane_area(mesh, name):
    """Area of a boundary of plane linear facets."""
    area = 0.0
    for block, members in zip(mesh.cells, mesh.cell_sets[name], strict=True):
        if members is None or len(members) == 0:
            continue
        corners = mesh.points[block.data[members]]
        ring = np.roll(corners, -1, axis=1)
        area += np.linalg.norm(np.cross(corners, ring).sum(axis=1) / 2, axis=1).sum()
    return area


def balance(name, point, mesh_file, forces, moments, reactions):
    """Forces that the loads ask for: [(what, found, expected, size)]. `forces`: of each contact on its first surface."""
    if name == "lug":
        angle = np.radians(point["angle"])
        pull = point["pull"] * np.pi * 10**2 * np.array([np.sin(angle), np.cos(angle)])
        held = np.array([reactions["shank_end"][axis] for axis in "xy"])
        size = np.linalg.norm(pull)
        return [
            ("pin on bush", forces[0], pull, size),
            ("eye on bush", forces[1], -pull, size),
            ("supports", held, -pull, size),
        ]
    if name == "press_fit":
        load = point["bend"] * np.pi * 20**2 / 2
        size = np.abs(forces).max()
        return [
            ("contact along x, of none", forces[0][0], 0.0, size),
            ("supports along x", reactions["clamped_end"]["x"], -load, load),
        ]
    if name == "roller":
        size = abs(forces[0][1])
        return [
            ("bed beside roller", forces[1][1], -forces[0][1], size),
            ("their moments", moments[1], -moments[0], abs(moments[0]).max()),
            ("supports along y", reactions["bed_bottom"]["y"], -forces[0][1], size),
        ]
    if name == "stack":
        load = point["p"] * 28 * 24
        return [
            ("base", forces[0][2], -load, load),
            ("middle", forces[1][2], -load, load),
            ("supports along z", reactions["floor"]["z"], load, load),
        ]
    mesh = meshio.read(mesh_file)
    load = point["bolt"] * plane_area(mesh, "upper_seat")
    load -= point["p"] * 40**2 / (50**2 - 40**2) * plane_area(mesh, "upper_end")
    return [
        ("lower flange on gasket", forces[0][2], load, load),
        ("upper flange on gasket", forces[1][2], -load, load),
    ]


def differences(stages, path, command, point):
    """Central differences of full-order solutions: contact forces and displacement, a row per parameter."""
    deck = path.read_text()
    points, steps = [], []
    for name, bounds in yaml.safe_load(deck)["parameters"].items():
        steps.append(STEP * (bounds["max"] - bounds["min"]))
        points += [point | {name: point[name] + steps[-1]}, point | {name: point[name] - steps[-1]}]
    listed = yaml.safe_dump({"points": points}, default_flow_style=True, width=10000)
    (stages.folder / "steps.yaml").write_text(re.sub(r"(?m)^output:.*$", f"output: {listed}", deck))
    code, text = stages("steps", [*command, "solve", "steps.yaml"])
    if code != 0:
        sys.exit(text)
    slopes = {}
    with h5py.File(stages.folder / "results" / "steps" / "fields.h5") as file:
        for name in ("multipliers_full_order", "displacement"):
            values = np.array([file["points"][number][name][()] for number in sorted(file["points"])])
            slopes[name] = [(values[2 * i] - values[2 * i + 1]) / (2 * step) for i, step in enumerate(steps)]
    return slopes


def compare_answer(checks, folder, name):
    """The answer of the model beside the full order, at the unseen point."""
    full = read_point(folder / "solved" / "results" / name / "fields.h5")
    ours = read_point(folder / "answer_fields" / "fields.h5")
    with (folder / "answer.csv").open() as file:
        told = next(csv.DictReader(file))
    checks.at_most("contact forces", norm_off(forces_of(told), full["multipliers_full_order"]), FORCES)
    checks.at_most("displacement", norm_off(ours["displacement"], full["displacement"]), FIELDS)
    checks.at_most(
        "displacement in the norm of the stiffness, told", float(told["displacement_bound"]), FIELDS
    )
    checks.at_most("stress of cells, mean square", norm_off(ours["stress"], full["stress"]), FIELDS)
    for field in ("von_mises", "von_mises_smoothed", "contact_pressure"):
        checks.at_most(f"{field}, anywhere", off(ours[field], full[field]), FIELDS)
    largest = full["von_mises_smoothed"].max()
    checks.at_most("largest von Mises", abs(ours["von_mises_smoothed"].max() / largest - 1), FIELDS)


def compare_runs(checks, folder, other, name):
    """Full order and answer of the model beside those of an earlier run of the same part."""
    place = f"solved/results/{name}/fields.h5"
    ours, theirs = read_point(folder / place), read_point(other / place)
    for field in ("multipliers_full_order", "displacement", "stress"):
        checks.at_most(f"{field} beside the other run", norm_off(ours[field], theirs[field]), SAME)
    tables = []
    for run in (folder, other):
        with (run / "answer.csv").open() as file:
            tables.append(forces_of(next(csv.DictReader(file))))
    checks.at_most("contact forces of the model beside the other run", norm_off(*tables), SAME)


def forces_of(told):
    """Contact forces of a line of the table of predict."""
    return np.array([float(value) for key, value in told.items() if key.startswith("lambda_")])


def compare_derivatives(checks, answer, slopes):
    """Derivatives of the model beside differences of the full order."""
    gradient, n_dim = answer.gradient, answer.displacement.shape[1]
    for i, parameter in enumerate(gradient.parameters):
        forces, displacement = slopes["multipliers_full_order"][i], slopes["displacement"][i][:, :n_dim]
        what = f"derivative over {parameter}"
        checks.at_most(f"{what}, contact forces", norm_off(gradient.multipliers[i], forces), DERIVATIVES)
        checks.at_most(f"{what}, displacement", norm_off(gradient.displacement[i], displacement), FIELDS)


def check_view(checks, folder):
    """What ParaView would show of the predicted fields."""
    shown = read_with_vtk(folder / "answer_fields" / "fields.xdmf")
    expected = read_point(folder / "answer_fields" / "fields.h5")
    step = shown[min(shown)]
    checks.holds("VTK shows one step of fields.xdmf", len(shown) == 1)
    checks.at_most("von Mises in VTK", off(step.cells["von_mises"], expected["von_mises"]), 1e-6)
    checks.at_most("displacement in VTK", off(step.nodes["displacement"], expected["displacement"]), 1e-6)


def make_model(checks, stages, name, command, edge):
    """Mesh, check and run; whether there is a model."""
    deck, results = f"{name}.yaml", stages.folder / "results" / name
    if edge:
        geo = stages.folder / f"{name}.geo"
        geo.write_text(re.sub(r"(?m)^h = DefineNumber\[[^,]*", f"h = DefineNumber[{edge!r}", geo.read_text()))
    stages("mesh", ["gmsh", f"-{DIMENSION[name]}", *f"-v 2 -format msh41 {name}.geo -o {name}.msh".split()])
    _, told = stages("check", [*command, "check", deck])
    code, text = stages("run", [*command, "run", deck])
    print(f"\n## {name}\n")
    for line in told.splitlines():
        if line.startswith(("# sizes", "# predicted")):
            print(f"- {line[2:]}")
    if code != 0 or not (results / "model.h5").exists():
        checks.holds("run ends with a model", False)
        print(text[-2000:])
        return False
    report = yaml.safe_load((results / "report.yaml").read_text())
    for what in ("forces", "fields"):
        print(f"- {what}: {report['validation'][what]}")
        checks.holds(f"the verdict accepts {what}", report["validation"][what].startswith("accepted"))
    times = ("full_order_setup", "train", "validate", "full_order_per_point")
    told = (f"{key} {report['times'][key]:.2g}" for key in times if key in report["times"])
    print(f"- times that run tells [s]: {', '.join(told)}")
    print(f"- model file: {(results / 'model.h5').stat().st_size / 1e6:.0f} MB")
    return True


def use_model(checks, stages, name, command):
    """The model's answer beside the full order, its derivatives beside differences, forces beside loads, the report."""
    folder, point, results = stages.folder, POINTS[name], stages.folder / "results" / name
    model, at = results / "model.h5", ",".join(f"{key}={value!r}" for key, value in POINTS[name].items())
    stages("predict", [command[-1], "predict", model, "--at", at, "--fields", "--output", "answer.csv"])
    stages("solve", [*command, "solve", folder / f"{name}.yaml", "--at", at], "solved")
    compare_answer(checks, folder, name)
    with Model(model) as opened:
        start = time.perf_counter()
        answer = opened.query(**point)
        print(f"- answer with the displacement of all nodes: {1e3 * (time.perf_counter() - start):.1f} ms")
        compare_derivatives(checks, answer, differences(stages, folder / f"{name}.yaml", command, point))
    report = yaml.safe_load((folder / "solved" / "results" / name / "report.yaml").read_text())
    reactions = {entry["boundary"]: entry for entry in report["points"]["1"]["reactions"].values()}
    found = answer.resultants
    for what, value, expected, size in balance(
        name, point, folder / f"{name}.msh", found.forces, found.moments, reactions
    ):
        checks.at_most(what, np.abs(np.asarray(value) - expected).max() / abs(size), BALANCE)
    check_view(checks, folder)
    stages("report", [sys.executable, "-m", "signorom_post", "report", results])
    page = results / "report.html"
    checks.holds("report.html has the verdict", page.exists() and "accepted" in page.read_text())


def go(name, program, arguments, folder):
    """All stages of one part; what was missed."""
    checks, stages = Checks(), Stages(folder)
    for suffix in ("geo", "yaml"):
        shutil.copy(HERE / f"{name}.{suffix}", folder)
    command = [*launcher(arguments.ranks), program]
    if make_model(checks, stages, name, command, arguments.edge):
        use_model(checks, stages, name, command)
        if arguments.beside:
            compare_runs(checks, folder, arguments.beside.resolve() / name, name)
    stages.print()
    return checks.missed


def main():
    """All parts, or some."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("names", nargs="*", default=list(POINTS), help=f"of {', '.join(POINTS)}")
    parser.add_argument("--ranks", type=int, default=1)
    parser.add_argument("--edge", type=float, help="length of edges in place of that of the .geo file [mm]")
    parser.add_argument(
        "--folder",
        type=Path,
        help="where meshes, logs and results stay, in a folder per part that is made anew",
    )
    parser.add_argument(
        "--beside", type=Path, help="folder of an earlier run, as of another number of ranks, for comparison"
    )
    arguments = parser.parse_args()
    program = Path(os.environ.get("SIGNOROM_EXECUTABLE", ROOT / "build" / "release" / "signorom")).resolve()
    # not the latest of all builds, which may be one with sanitizers that Python cannot load
    os.environ["SIGNOROM_LIBRARY"] = str(program.parent / "src/online/libsignorom_online.so")
    warnings.simplefilter("ignore", NotAcceptedWarning)  # the verdict is printed
    print(load_text())
    missed = {}
    for name in arguments.names:
        with tempfile.TemporaryDirectory() as place:
            folder = (arguments.folder or Path(place)).resolve() / name
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir(parents=True)
            missed[name] = go(name, program, arguments, folder)
    for name, misses in missed.items():
        print(f"{name}: {'; '.join(misses) or 'nothing missed'}")
    return 1 if any(missed.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
