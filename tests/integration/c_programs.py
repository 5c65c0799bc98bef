# SPDX-License-Identifier: BSD-3-Clause
"""Programs in C that ask the online library."""

import os
import subprocess

from runs import HERE

SOURCES = HERE / "online"
INCLUDE = HERE.parents[1] / "include"


def compile_c(name, library, folder):
    """Compile a C program against nothing but the header and the library."""
    program = folder / name
    command = ["cc", "-std=gnu11", "-Wall", "-Wextra", "-Werror", SOURCES / f"{name}.c", f"-I{INCLUDE}"]
    command += [
        f"-L{library.parent}",
        "-lsignorom_online",
        "-lpthread",
        "-lm",
        f"-Wl,-rpath,{library.parent}",
    ]
    subprocess.run([*command, "-o", program], check=True)
    return program


def run_c(program, *arguments, time_limit=120):
    """Run a compiled program, whatever its exit code."""
    return subprocess.run(
        [program, *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=time_limit,
        env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},
    )
