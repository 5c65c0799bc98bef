# SPDX-License-Identifier: BSD-3-Clause
"""Meshes that are made when a test needs them."""

import subprocess

import numpy as np


def make_mesh(source, path, dimension=2, **constants):
    """Meshes the .geo file `source` by gmsh into `path` (MSH 4.1), and returns `path`; AssertionError if gmsh fails.

    `dimension` is that of the elements; `constants`: values of constants that the file defines by DefineConstant.
    """
    numbers = [word for name, value in constants.items() for word in ("-setnumber", name, str(value))]
    command = ["gmsh", f"-{dimension}", "-format", "msh41", *numbers, str(source), "-o", str(path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{' '.join(command)}\n{done.stdout}\n{done.stderr}"
    return path


def write_moved_mesh(source, path, factor=1.0, shift=0.0):
    """Copy of a gmsh 4.1 text mesh, all coordinates times `factor` plus `shift`; nobody reads the boxes of $Entities."""
    lines = source.read_text().splitlines()
    i_line = lines.index("$Nodes") + 2
    while lines[i_line] != "$EndNodes":
        n_nodes = int(lines[i_line].split()[3])
        first = i_line + 1 + n_nodes
        for i in range(first, first + n_nodes):
            moved = np.array([float(word) for word in lines[i].split()]) * factor + shift
            lines[i] = " ".join(repr(value) for value in moved.tolist())
        i_line = first + n_nodes
    path.write_text("\n".join([*lines, ""]))
