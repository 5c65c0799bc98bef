# SPDX-License-Identifier: BSD-3-Clause
"""Meshes that are made when a test needs them."""

import subprocess


def make_mesh(source, path, dimension=2, **constants):
    """Mesh a .geo file by gmsh, with values for the constants that it lets one choose."""
    numbers = [word for name, value in constants.items() for word in ("-setnumber", name, str(value))]
    command = ["gmsh", f"-{dimension}", "-format", "msh41", *numbers, str(source), "-o", str(path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{' '.join(command)}\n{done.stdout}\n{done.stderr}"
    return path
