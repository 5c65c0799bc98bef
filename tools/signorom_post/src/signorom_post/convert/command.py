# SPDX-License-Identifier: BSD-3-Clause
"""The command `signorom-post convert`: writes the mesh of another program as a .msh with its names."""

import argparse
from collections.abc import Callable
from pathlib import Path

import numpy as np

from signorom_post.convert.abaqus import read_abaqus
from signorom_post.convert.by_meshio import SUFFIXES, read_by_meshio
from signorom_post.convert.gmsh_file import write_gmsh
from signorom_post.convert.groups import Converted, convert, count
from signorom_post.convert.med import read_med
from signorom_post.convert.nastran import read_nastran
from signorom_post.convert.source import Source
from signorom_post.convert.universal import read_universal
from signorom_post.errors import InputError

#: suffix -> reader
READERS: dict[str, Callable[[Path], Source]] = {
    ".inp": read_abaqus,
    ".unv": read_universal,
    ".med": read_med,
    ".mmed": read_med,
    ".rmed": read_med,
    ".bdf": read_nastran,
    ".nas": read_nastran,
    ".fem": read_nastran,
    ".dat": read_nastran,
} | dict.fromkeys(SUFFIXES, read_by_meshio)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments of `signorom-post convert` to its parser."""
    parser.add_argument("part", metavar="PART", type=Path, help=f"mesh of another program: {_allowed()}")
    parser.add_argument(
        "-o", "--output", metavar="FILE.msh", type=Path, help="mesh to be written; default: beside PART"
    )
    parser.add_argument(
        "--split",
        metavar=("A", "B"),
        nargs=2,
        action="append",
        default=[],
        help="give two regions that share nodes nodes of their own, and name the new boundaries A_to_B and B_to_A",
    )


def run(options: argparse.Namespace) -> int:
    """Converts PART, and prints what became of its sets and what was left out. Returns 0.

    InputError: a suffix that is not known, a file that cannot be read or converted, regions that cannot be split, an
    output that is PART itself, has another suffix than .msh, or cannot be written.
    """
    reader = READERS.get(options.part.suffix.lower())
    if reader is None:
        raise InputError(
            options.part, f"the suffix '{options.part.suffix}' is not known; allowed are: {_allowed()}"
        )
    output = options.output or options.part.with_suffix(".msh")
    if output.suffix.lower() != ".msh":
        raise InputError(output, "the mesh to be written must end with .msh")
    if output.exists() and options.part.exists() and output.samefile(options.part):
        raise InputError(output, "the output is the input; give another name with -o")
    mesh = convert(reader(options.part), [tuple(pair) for pair in options.split])
    write_gmsh(mesh, output)
    options.log.result(_table(mesh, output))
    return 0


def _allowed() -> str:
    return " ".join(READERS)


def _table(mesh: Converted, output: Path) -> str:
    """Returns the text that says what became of the sets, and what was left out."""
    lines = [f"{output}: {_content(mesh)}"]
    if mesh.cells.n_mirrored:
        lines.append(f"{count(mesh.cells.n_mirrored, 'cell')} had a negative volume: turned")
    if mesh.cells.n_collapsed:
        lines.append(
            f"{count(mesh.cells.n_collapsed, 'cell')} had a node twice: written as the simpler cells they are"
        )
    lines += ["", *_columns("what the file has", "what it became", mesh.rows)]
    if mesh.left_out:
        lines += ["", *_columns("left out", "why", mesh.left_out)]
    return "\n".join(lines)


def _content(mesh: Converted) -> str:
    used = mesh.cells.used_nodes()
    cells = ", ".join(f"{len(which)} {kind.name}" for kind, which in mesh.cells.blocks())
    n_bodies = int(mesh.cells.bodies().max()) + 1
    places = mesh.cells.coordinates[used]
    low, high = places.min(axis=0), places.max(axis=0)
    box = ", ".join(
        f"{axis} {low[i]:.6g} to {high[i]:.6g}" for i, axis in enumerate("xyz"[: mesh.cells.n_dim])
    )
    bodies = f"{n_bodies} separate {'body' if n_bodies == 1 else 'bodies'}"
    return f"{count(int(np.sum(used)), 'node')}, cells: {cells}; {bodies}; {box} (units as in the file)"


def _columns(first: str, second: str, rows: list[tuple[str, str]]) -> list[str]:
    """Returns a table of two columns with a head."""
    width = min(60, max(len(row[0]) for row in [(first, ""), *rows]))
    head = [f"{first:<{width}}  {second}", f"{'-' * width}  {'-' * len(second)}"]
    return head + [f"{what:<{width}}  {became}" for what, became in rows]
