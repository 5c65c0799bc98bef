#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The whole command `solve` beside CalculiX on the same mesh: user time and memory, one core each.

    build/venv/bin/python tests/benchmark/calculix.py H8 55          # element, thousand dofs; needs ccx (calculix-ccx)
    build/venv/bin/python tests/benchmark/calculix.py H8 195
    build/venv/bin/python tests/benchmark/calculix.py T10 65

Two boxes, the gap between them grows with the square of the distance to the middle, and the top is moved down. CalculiX
has frictionless surface-to-surface contact with a penalty of 50 E; its solvers SPOOLES and iterative Cholesky are tried,
the faster one counts. Displacements of both differ by the penalty: the largest difference is printed. Targets: a quarter
of the time, and no more memory.
"""

import os
import re
import tempfile
from pathlib import Path

import numpy as np
from boxes import deck_text, grid_counts, make_boxes, write_gmsh
from timing import build, command_line, load_text, measure

ASPECT, PRESS, MODULUS = 0.5, 4e-5, 210.0e9
CURVATURE = 12e-5 * ASPECT
TYPES = {"H8": "C3D8", "T10": "C3D10", "T4": "C3D4"}
# corners of the faces in CalculiX's order
FACES = {
    "H8": [(0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 4, 5), (1, 2, 5, 6), (2, 3, 6, 7), (0, 3, 4, 7)],
    "T4": [(0, 1, 2), (0, 1, 3), (1, 2, 3), (0, 2, 3)],
}
FACES["T10"] = FACES["T4"]
# the last two nodes of T10 in gmsh's order are swapped
ORDER = {"T10": [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]}
N_CORNERS = {"H8": 4, "T4": 3, "T10": 3}


def lines_of(table):
    """Integer rows as text."""
    return "\n".join(", ".join(map(str, row)) for row in table.tolist())


def face_set(element, cells, facets, first):
    """`element, S2` of each facet of a body whose first element has the number `first`."""
    number = {}
    for k, corners in enumerate(FACES[element]):
        for i, key in enumerate(map(tuple, np.sort(cells[:, corners], axis=1).tolist())):
            number[key] = (first + i, k + 1)
    found = [number[key] for key in map(tuple, np.sort(facets[:, : N_CORNERS[element]], axis=1).tolist())]
    return "\n".join(f"{i}, S{k}" for i, k in found)


def write_calculix(path, element, nodes, groups, linear):
    """The same problem as the deck; the gap is in the places of the nodes."""
    part = {name: members for _, name, members in groups}
    moved = nodes.copy()
    upper = np.unique(part["upper_face"])
    moved[upper, 2] += CURVATURE * (nodes[upper, 0] ** 2 + nodes[upper, 1] ** 2)
    text = ["*NODE, NSET=NALL"]
    text += [f"{i}, {x:.12g}, {y:.12g}, {z:.12g}" for i, (x, y, z) in enumerate(moved.tolist(), 1)]
    first = 1
    for name in ("lower", "upper"):
        cells = part[name][:, ORDER.get(element, slice(None))] + 1
        text += [f"*ELEMENT, TYPE={TYPES[element]}, ELSET={name}"]
        text += [lines_of(np.hstack([np.arange(first, first + len(cells))[:, None], cells]))]
        face = f"{name}_face"
        text += [f"*SURFACE, NAME={face}, TYPE=ELEMENT", face_set(element, part[name], part[face], first)]
        first += len(cells)
    for name in ("bottom", "left", "front", "top"):
        text += [f"*NSET, NSET={name}", lines_of(np.unique(part[name])[:, None] + 1)]
    text += ["*MATERIAL, NAME=steel", "*ELASTIC", f"{MODULUS!r}, 0.3"]
    text += [f"*SOLID SECTION, ELSET={name}, MATERIAL=steel" for name in ("lower", "upper")]
    text += ["*SURFACE INTERACTION, NAME=hard", "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR"]
    text += [f"{50 * MODULUS!r}"]
    text += ["*CONTACT PAIR, INTERACTION=hard, TYPE=SURFACE TO SURFACE", "lower_face, upper_face"]
    text += ["*BOUNDARY", "bottom, 1, 3", "left, 1, 1", "front, 2, 2", "*STEP", f"*STATIC, SOLVER={linear}"]
    text += ["1., 1.", "*BOUNDARY", f"top, 3, 3, {-PRESS!r}", "*NODE PRINT, NSET=NALL", "U", "*END STEP", ""]
    path.write_text("\n".join(text))


def write_ours(folder, element):
    """The deck, with the top moved down in place of the pressure."""
    text = deck_text(element, aspect=ASPECT)
    text = text.replace("{P: {min: 0.5e6, max: 2.0e6, unit: Pa}}", "{P: {min: 1e-5, max: 1e-4, unit: m}}")
    text = text.replace(
        "loads:\n  - {boundary: top, pressure: P}\n", '  - {boundary: top, displacement: {z: "-P"}}\n'
    )
    (folder / "boxes.yaml").write_text(text.replace("P: 1.0e6", f"P: {PRESS!r}"))


def displacements(folder, n_nodes):
    """Of CalculiX's last print."""
    rows = [line.split() for line in (folder / "part.dat").read_text().splitlines()]
    values = np.array([row for row in rows if len(row) == 4 and row[0].isdigit()], dtype=float)
    return values[-n_nodes:, 1:]


def main():
    """One part."""
    parser = command_line(__doc__)
    parser.add_argument("element", choices=list(TYPES))
    parser.add_argument("size", type=float, help="thousand dofs")
    parser.add_argument("--solvers", nargs="*", default=["SPOOLES", "ITERATIVE CHOLESKY"])
    arguments = parser.parse_args()
    os.environ |= {"CCX_NPROC_EQUATION_SOLVER": "1", "CCX_NPROC_RESULTS": "1"}
    (program,) = build("signorom")
    counts = grid_counts(arguments.element, 1e3 * arguments.size, ASPECT)
    nodes, groups = make_boxes(arguments.element, counts, ASPECT)
    print(f"{arguments.element}, {3 * len(nodes)} dofs; {load_text()}")
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        write_gmsh(folder / "boxes.msh", nodes, groups)
        write_ours(folder, arguments.element)
        ours = measure([program, "solve", "boxes.yaml"], folder)
        print(
            f"signorom: {ours.user:.1f} s, {ours.megabytes:.0f} MB; {re.search('solver: .*', ours.output).group(0)}",
            flush=True,
        )
        theirs = []
        for linear in arguments.solvers:
            write_calculix(folder / "part.inp", arguments.element, nodes, groups, linear)
            theirs.append(measure(["ccx", "part"], folder))
            top = displacements(folder, len(nodes))
            print(
                f"CalculiX, {linear}: {theirs[-1].user:.1f} s, {theirs[-1].megabytes:.0f} MB; "
                f"largest displacement {np.abs(top).max():.3e}",
                flush=True,
            )
        best = min(theirs, key=lambda run: run.user)
        print(
            f"time: {best.user / ours.user:.1f} times ours; "
            f"memory: {ours.megabytes / best.megabytes:.1f} times theirs"
        )


if __name__ == "__main__":
    main()
