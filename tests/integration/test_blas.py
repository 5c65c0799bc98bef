# SPDX-License-Identifier: BSD-3-Clause
"""The program takes kernels of OpenBLAS that suit the processor, also where OpenBLAS does not know it."""

import re
import subprocess
from pathlib import Path

import pytest

from program import ENVIRONMENT

FAST = {"SkylakeX", "Haswell"}


def kernels(signorom, folder, **variables):
    """The kernels that OpenBLAS says it takes, each time that it is loaded."""
    environment = {key: value for key, value in ENVIRONMENT.items() if key != "OPENBLAS_CORETYPE"}
    environment |= {"OPENBLAS_VERBOSE": "2", **variables}
    run = subprocess.run(
        [signorom.executable, "--version"],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    assert run.stdout.startswith("signorom ")
    found = re.findall(r"^Core: (\w+)$", run.stderr, re.MULTILINE)
    if not found:
        pytest.skip("another BLAS")
    return found


def test_an_unknown_processor_gets_fast_kernels(signorom, tmp_path):
    has_avx2 = " avx2 " in Path("/proc/cpuinfo").read_text(encoding="utf-8")
    found = kernels(signorom, tmp_path)
    if found[0] == "Prescott" and has_avx2:
        assert len(found) == 2
        assert found[1] in FAST
    else:
        assert len(found) == 1, "OpenBLAS knows the processor: the program starts once"


def test_the_choice_of_the_user_counts(signorom, tmp_path):
    assert kernels(signorom, tmp_path, OPENBLAS_CORETYPE="Prescott") == ["Prescott"]
