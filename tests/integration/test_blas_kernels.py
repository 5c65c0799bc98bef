# SPDX-License-Identifier: BSD-3-Clause
"""The program does not stay with OpenBLAS' kernels of 2004 on a processor that has AVX2."""

import os
import re
import subprocess
from pathlib import Path

import pytest

FLAGS = Path("/proc/cpuinfo").read_text() if Path("/proc/cpuinfo").exists() else ""


def kernels(signorom, **variables):
    """What OpenBLAS says of itself when the program loads it, each time."""
    environment = {name: value for name, value in os.environ.items() if name != "OPENBLAS_CORETYPE"}
    done = subprocess.run(
        [signorom.executable, "check", "no such.yaml"],
        env=environment | {"OPENBLAS_VERBOSE": "2"} | variables,
        capture_output=True,
        text=True,
        check=False,
    )
    # the arguments have come through
    assert done.returncode == 2
    assert "no such.yaml" in done.stderr
    return re.findall(r"(?m)^Core: (\w+)$", done.stderr)


@pytest.mark.skipif(not re.search(r"\bavx2\b", FLAGS), reason="the processor has no AVX2")
def test_kernels_of_2004_are_left(signorom):
    """Where OpenBLAS takes them by itself; elsewhere the program starts once, with what OpenBLAS takes."""
    found = kernels(signorom)
    if not found:
        pytest.skip("another BLAS, or one that does not say what it takes")
    assert found == (["Prescott", "Haswell"] if found[0] == "Prescott" else found[:1])


def test_a_choice_of_the_user_stays(signorom):
    """Whatever it is."""
    assert kernels(signorom, OPENBLAS_CORETYPE="Prescott")[1:] == []
