# SPDX-License-Identifier: BSD-3-Clause
"""The program under test (SIGNOROM_EXECUTABLE, or build/ci/signorom), bare or under mpirun, with a time limit."""

import atexit
import contextlib
import functools
import os
import re
import shutil
import signal
import subprocess
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# [s] long enough for a busy machine; a hanging program is a failure
TIME_LIMIT = 600
# so many times longer a program with sanitizers may take
SANITIZED = 10

# One BLAS thread per rank; Open MPI refuses root unless told twice; ranks on
# one machine talk through memory, and Open MPI need not look for networks.
ENVIRONMENT = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "OMPI_MCA_btl_vader_single_copy_mechanism": "none",
    "OMPI_MCA_pml": "ob1",
    "OMPI_MCA_btl": "self,vader",
    "PMIX_MCA_gds": "hash",
    # All ranks end by themselves: mpirun need not wait a second between its two signals to them.
    "OMPI_MCA_odls_base_sigkill_timeout": "0",
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
}

# mpirun that starts at the same moment in two test processes must not make the same session folder.
SESSIONS = tempfile.mkdtemp(prefix="ompi")
atexit.register(shutil.rmtree, SESSIONS, ignore_errors=True)
ENVIRONMENT["OMPI_MCA_orte_tmpdir_base"] = SESSIONS


def find_program():
    """Returns the Program to test; FileNotFoundError if it is missing, so that tests fail and are not skipped."""
    path = Path(os.environ.get("SIGNOROM_EXECUTABLE", ROOT / "build" / "ci" / "signorom")).resolve()
    if not path.is_file():
        raise FileNotFoundError(f"{path} is missing: build it or set SIGNOROM_EXECUTABLE")
    return Program(path)


class Program:
    """Callable: `signorom("check", deck, folder=...)` insists on exit code 0 and returns what was printed."""

    def __init__(self, executable):
        """Takes the absolute path of the executable."""
        self.executable = executable

    def __call__(self, *arguments, folder, n_ranks=1, **limits):
        """Runs a command in a folder and returns its standard output; AssertionError unless the exit code is 0."""
        done = self.run(*arguments, folder=folder, n_ranks=n_ranks, **limits)
        shown = " ".join(map(str, done.args))
        assert done.returncode == 0, f"{shown}\nexit code {done.returncode}\n{done.stdout}\n{done.stderr}"
        return done.stdout

    def run(self, *arguments, folder, n_ranks=1, time_limit=TIME_LIMIT):
        """Runs a command in a folder, and returns a CompletedProcess with exit code, standard output and error as text.

        `time_limit` [s] is multiplied by patience(); subprocess.TimeoutExpired after it.
        """
        process = self.start(*arguments, folder=folder, n_ranks=n_ranks)
        return finish(process, time_limit)

    def start(self, *arguments, folder, n_ranks=1, **streams):
        """Starts a command in a folder, in a session of its own, and returns the Popen.

        `streams` replace stdin (empty), stdout and stderr (pipes).
        """
        piped = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
        return subprocess.Popen(
            [*launcher(n_ranks), str(self.executable), *map(str, arguments)],
            cwd=folder,
            env=os.environ | ENVIRONMENT | waiting(n_ranks),
            encoding="utf-8",
            errors="replace",
            start_new_session=True,
            **(piped | streams),
        )


def waiting(n_ranks):
    """Returns the environment variable by which waiting ranks give their core away; not with one rank.

    One rank waits for nobody, and would come after all other work.
    """
    return {"OMPI_MCA_mpi_yield_when_idle": str(int(n_ranks > 1))}


def launcher(n_ranks):
    """Returns the words of the command before the program's name: none for one rank, else those of mpirun."""
    if n_ranks == 1:
        return []
    return ["mpirun", "--oversubscribe", "--bind-to", "none", "-n", str(n_ranks)]


def finish(process, time_limit=TIME_LIMIT):
    """Waits for a started command, and returns a CompletedProcess.

    If it has not ended after patience() * time_limit seconds, it is killed with all its ranks, and
    subprocess.TimeoutExpired is raised.
    """
    try:
        stdout, stderr = process.communicate(timeout=patience() * time_limit)
    except BaseException:
        kill(process)
        raise
    return subprocess.CompletedProcess(process.args, process.returncode, stdout, stderr)


def kill(process):
    """Sends SIGKILL to a process and all its descendants (mpirun and every rank), and waits for its end."""
    for pid in [process.pid, *descendants(process.pid)]:
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
    process.communicate()


def descendants(pid):
    """Returns the process ids of the children of a process, their children and so on."""
    children = {}
    for status in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            # pid (name) state parent ...: the name may hold blanks and parentheses
            parent = int(status.read_text().rpartition(")")[2].split()[1])
            children.setdefault(parent, []).append(int(status.parent.name))
    found = [pid]
    for known in found:
        found += children.get(known, [])
    return found[1:]


def mpi_needs_large_files():
    """Returns whether MPI cannot start under a limit of the file size: Open MPI 5 maps some megabytes of memory."""
    version = subprocess.run(["mpirun", "--version"], capture_output=True, text=True, check=True).stdout
    found = re.search(r"Open MPI\) (\d+)", version)
    return found is not None and int(found.group(1)) >= 5


def needs_library(executable, name):
    """Returns whether a program is linked with a shared library whose name or path contains `name`."""
    return name in subprocess.run(["ldd", executable], capture_output=True, text=True, check=True).stdout


@functools.cache
def is_sanitized(executable):
    """Returns whether a program was built with the address sanitizer."""
    return needs_library(executable, "libasan")


def patience():
    """Returns the factor of time limits: SANITIZED if the program under test has sanitizers, else 1."""
    return SANITIZED if is_sanitized(find_program().executable) else 1


def wait_until(condition, process, time_limit=60, pause=0.002):
    """Waits until condition() is true, and looks every `pause` seconds.

    AssertionError if the process ends before, or after patience() * time_limit seconds.
    """
    start = time.monotonic()
    while not condition():
        if process.poll() is not None:
            done = finish(process)
            raise AssertionError(f"ended too early, exit code {done.returncode}\n{done.stdout}{done.stderr}")
        assert time.monotonic() - start < patience() * time_limit, "nothing happened in time"
        time.sleep(pause)
