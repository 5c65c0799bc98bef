#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""What ParaView shows when it runs the script of `signorom-post view`, against the HDF5 files at each point.

    apt-get install --no-install-recommends paraview python3-paraview xvfb
    build/venv/bin/python tests/paraview/check_views.py

CI does not run it: ParaView is about 200 MB of packages. It solves decks of `input`, in the plane, in axisymmetry and
in space, at several points, with the program that SIGNOROM_EXECUTABLE names (default: build/ci/signorom), and starts
pvpython. Exit code 1: a range, the displaced shape or a picture is another one.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "support")]
from decks import copy_deck  # noqa: E402
from program import ROOT, find_program  # noqa: E402

DECKS = ("hertz_cylinder", "shrink_fit", "sphere", "saddle", "blocks")
#: name of a picture -> field in its colors
FIELDS = {
    "displacement": "displacement",
    "von_mises": "von_mises_smoothed",
    "contact_pressure": "contact_pressure",
}
# ParaView keeps places in single precision, of ranges all digits; it widens colors that would show rounding errors only
PLACES, RANGES, COLORS = 1e-6, 1e-12, 1e-3


def main():
    """Solve the decks, draw every point and the default one in ParaView."""
    program = find_program()
    n_failed = 0
    for name in DECKS:
        with tempfile.TemporaryDirectory() as folder:
            deck = copy_deck(ROOT / "input" / f"{name}.yaml", Path(folder))
            program("solve", deck, folder=Path(folder))
            results = Path(folder) / "results" / name
            with h5py.File(results / "fields.h5") as file:
                n_points = len(file["points"])
            for chosen in (None, *range(1, n_points + 1)):
                point = chosen or n_points // 2 + 1
                wrong = faults(results, point, [] if chosen is None else ["--point", str(chosen)])
                print(f"{name}, point {chosen or 'by default'}: {'; '.join(wrong) or 'ok'}", flush=True)
                n_failed += bool(wrong)
    return int(n_failed > 0)


def faults(results, point, options):
    """Sentences about what ParaView shows otherwise than the files have it at a point."""
    shown, pictures = views_in_paraview(results, options)
    with h5py.File(results / "fields.h5") as fields, h5py.File(results / "contact.h5") as contact:
        wrong = []
        for name, field in FIELDS.items():
            file = contact if field == "contact_pressure" else fields
            values = file[f"points/{point:04d}/{field}"][()]
            if not values.any():
                wrong += [f"{name} is zero, but drawn"] * (name in pictures)
                continue
            if name not in pictures or field not in shown:
                wrong.append(f"no picture of {name}")
                continue
            lengths = np.linalg.norm(values, axis=1) if values.ndim == 2 else values
            wrong += faults_of_view(
                name, shown[field], lengths, places(file, point, name, shown[field]["scale"])
            )
    return wrong


def views_in_paraview(results, options):
    """What read_views.py tells of each field, and the names of the pictures that ParaView wrote."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        command = [sys.executable, "-m", "signorom_post", "view", results, "--output", folder, *options]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        command = ["xvfb-run", "-a", "pvpython", "--force-offscreen-rendering", HERE / "read_views.py"]
        subprocess.run([*command, folder / "in_paraview.py", folder / "shown.json"], check=True)
        pictures = {path.stem.removeprefix("paraview_") for path in folder.glob("paraview_*.png")}
        return json.loads((folder / "shown.json").read_text()), pictures


def places(file, point, name, scale):
    """Coordinates of the nodes as they are drawn: contact surfaces at rest, bodies displaced."""
    at_rest = file["mesh/coordinates"][()]
    return (
        at_rest
        if name == "contact_pressure"
        else at_rest + scale * file[f"points/{point:04d}/displacement"][()]
    )


def faults_of_view(name, shown, values, drawn):
    """Sentences about one view; colors of the contact pressure begin at zero."""
    expected = [np.nanmin(values), np.nanmax(values)]
    colors = [min(0.0, expected[0]), expected[1]] if name == "contact_pressure" else expected
    box = np.column_stack([drawn.min(axis=0), drawn.max(axis=0)]).ravel()
    size = np.ptp(drawn, axis=0).max()
    wrong = []
    if not np.allclose(shown["values"], expected, rtol=RANGES, atol=RANGES * expected[1]):
        wrong.append(f"{name} shows {shown['values']}, the file has {expected}")
    if not np.allclose(shown["colors"], colors, rtol=COLORS, atol=COLORS * colors[1]):
        wrong.append(f"{name} has colors for {shown['colors']}, not for {colors}")
    if not np.allclose(shown["box"], box, rtol=0.0, atol=PLACES * size):
        wrong.append(f"{name} fills {shown['box']}, not {box}")
    return wrong


if __name__ == "__main__":
    sys.exit(main())
