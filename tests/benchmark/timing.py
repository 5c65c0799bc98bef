# SPDX-License-Identifier: BSD-3-Clause
"""What the benchmarks share: a release build, CPU and wall time of a command, the load of the machine."""

import os
import resource
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "tests" / "support"))
from program import ENVIRONMENT  # noqa: E402

BUILD = ROOT / "build" / "release"


def build(*targets):
    """Paths of the programs of a release build, brought up to date."""
    if not (BUILD / "build.ninja").exists():
        subprocess.run(["cmake", "--preset", "release"], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["ninja", "-C", str(BUILD), *targets], check=True, stdout=subprocess.DEVNULL)
    return [BUILD / (name if name == "signorom" else f"tests/benchmark/{name}") for name in targets]


def cpu_of(command, folder):
    """User and system time, wall time [s] and output of a command that must succeed."""
    before, start = children_cpu(), time.perf_counter()
    done = subprocess.run(
        list(map(str, command)),
        cwd=folder,
        env=os.environ | ENVIRONMENT,
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        sys.exit(f"{command} ended with {done.returncode}: {done.stderr}")
    wall = time.perf_counter() - start
    return children_cpu() - before, wall, done.stdout


def children_cpu():
    """User and system time [s] of all commands that have ended."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def load_text():
    """`load 0.3 on 2 cores`."""
    return f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores"
