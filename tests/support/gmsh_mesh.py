# SPDX-License-Identifier: BSD-3-Clause
"""Meshes that are made when a test needs them."""

import subprocess


def make_mesh(source, path, dimension=2, **constants):
    """Meshes the .geo file `source` by gmsh into `path` (MSH 4.1), and returns `path`; AssertionError if gmsh fails.

    `dimension` is that of the elements; `constants`: values of constants that the file defines by DefineConstant.
    """
    numbers = [word for name, value in constants.items() for word in ("-setnumber", name, str(value))]
    command = ["gmsh", f"-{dimension}", "-format", "msh41", *numbers, str(source), "-o", str(path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{' '.join(command)}\n{done.stdout}\n{done.stderr}"
    return path
