# SPDX-License-Identifier: BSD-3-Clause
"""What the benchmarks share: the programs, time and memory of a command, decks, points, and what is said of a target."""

import argparse
import contextlib
import os
import subprocess
import sys
import tempfile
import threading
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "tests" / "support"))
from decks import copy_deck  # noqa: E402
from program import ENVIRONMENT, descendants, launcher, waiting  # noqa: E402
from results import read_table  # noqa: E402

__all__ = ["copy_deck", "launcher", "read_table", "waiting"]

INPUT = ROOT / "input"
BUILD = ROOT / "build" / "release"
# where a build has what is not a benchmark
PLACES = {"signorom": "signorom", "signorom_online": "src/online/libsignorom_online.so"}
# [s] between two looks at the memory of a process
PAUSE = 0.05


def command_line(doc):
    """A parser that shows the docstring of a script."""
    return argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)


def build(*targets):
    """Paths of programs and libraries: those of a release build, which is brought up to date.

    SIGNOROM_EXECUTABLE names the program of another build, which stays as it is.
    """
    given = os.environ.get("SIGNOROM_EXECUTABLE")
    folder = Path(given).resolve().parent if given else BUILD
    if not given:
        if not (BUILD / "build.ninja").exists():
            subprocess.run(["cmake", "--preset", "release"], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
        subprocess.run(["ninja", "-C", BUILD, *targets], check=True, stdout=subprocess.DEVNULL)
    return [folder / PLACES.get(name, f"tests/benchmark/{name}") for name in targets]


def python_model(library):
    """The class Model of Python, on this library."""
    os.environ["SIGNOROM_LIBRARY"] = str(library)
    from signorom_post import Model

    return Model


def build_query_times(library, folder):
    """Path of query_times.c, compiled against nothing but the header and the online library."""
    program = folder / "query_times"
    source = Path(__file__).with_name("query_times.c")
    place = library.parent
    command = ["cc", "-O2", source, f"-I{ROOT}/include", f"-L{place}", "-lsignorom_online"]
    subprocess.run([*command, f"-Wl,-rpath,{place}", "-o", program], check=True)
    return program


@dataclass
class Run:
    """What a command took: wall time, user time, user and system time [s], memory of each rank [bytes]; what it said."""

    code: int
    output: str
    wall: float
    user: float
    cpu: float
    peaks: list[float]

    @property
    def megabytes(self):
        """Largest memory of all ranks together."""
        return sum(self.peaks) / 1e6


def measure(command, folder, may_fail=False, log=None):
    """Runs a command, which must succeed unless it may fail. Ranks are in the order in which they started.

    What it says goes to the file `log` while it runs, if there is one.
    """
    command = list(map(str, command))
    start = time.perf_counter()
    with log.open("w+") if log else tempfile.TemporaryFile("w+") as file:
        process = subprocess.Popen(
            command,
            cwd=folder,
            env=os.environ | ENVIRONMENT,
            stdin=subprocess.DEVNULL,
            stdout=file,
            stderr=subprocess.STDOUT,
        )
        usage, peaks = wait(process, is_parallel=command[0] == "mpirun")
        wall = time.perf_counter() - start
        file.seek(0)
        output = file.read()
    if process.returncode != 0 and not may_fail:
        sys.exit(f"{' '.join(command)}\nended with {process.returncode}: {output[-3000:]}")
    of_ranks = [peaks[pid] for pid in sorted(peaks)] or [1024.0 * usage.ru_maxrss]
    return Run(process.returncode, output, wall, usage.ru_utime, usage.ru_utime + usage.ru_stime, of_ranks)


def wait(process, is_parallel):
    """Waits for the end of a process; returns what it used, and the memory of its ranks by process id [bytes]."""
    peaks, has_ended = {}, threading.Event()

    def look():
        while not has_ended.wait(PAUSE):
            note_peaks(descendants(process.pid) if is_parallel else [process.pid], is_parallel, peaks)

    watch = threading.Thread(target=look)
    watch.start()
    _, status, usage = os.wait4(process.pid, 0)
    has_ended.set()
    watch.join()
    process.returncode = os.waitstatus_to_exitcode(status)
    return usage, peaks


def note_peaks(pids, is_parallel, peaks):
    """Keeps the largest resident memory so far of processes; below mpirun only of the program.

    What the system tells at the end, ru_maxrss, is at least the memory of this script, from which the process was made.
    """
    for pid in pids:
        with contextlib.suppress(OSError, KeyError, ValueError):
            lines = Path(f"/proc/{pid}/status").read_text().splitlines()
            fields = dict(line.split(":", 1) for line in lines)
            if not is_parallel or fields["Name"].strip().startswith("signorom"):
                peaks[pid] = 1024.0 * int(fields["VmHWM"].split()[0])


def cpu_of(command, folder):
    """User and system time [s] of a command that must succeed."""
    return measure(command, folder).cpu


def train(program, folder, name):
    """Samples and trains a deck; CPU time of both [s], and the model."""
    times = [cpu_of([program, command, f"{name}.yaml", "--quiet"], folder) for command in ("sample", "train")]
    return times, folder / "results" / name / "model.h5"


def write_points(path, names, points):
    """As a deck and predict read them."""
    path.write_text(
        "\n".join([",".join(names), *(",".join(map(repr, row)) for row in np.asarray(points).tolist()), ""])
    )


def tell_target(text, is_met):
    """Says a target, and whether it was met. A benchmark fails where an answer is wrong, never for its time."""
    print(f"target: {text}: {'met' if is_met else 'MISSED'}")


def load_text():
    """`load 0.3 on 2 cores`."""
    return f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores"
