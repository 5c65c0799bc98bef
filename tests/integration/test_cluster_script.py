# SPDX-License-Identifier: BSD-3-Clause
"""The job of input/cluster.slurm: when it goes back to the queue. Stubs stand for the commands of Slurm."""

import os
import subprocess

import pytest

from runs import HERE

SCRIPT = HERE.parents[1] / "input" / "cluster.slurm"
STUBS = {
    "srun": 'echo "srun $*" >>calls; exit "$CODE"',
    "squeue": 'echo "$STATE"',
    "scontrol": 'echo "scontrol $*" >>calls',
}


def run_job(folder, code, state="RUNNING", restarts=0):
    """Exit code of the job, and the calls of srun and scontrol."""
    (folder / "bin").mkdir()
    for name, text in STUBS.items():
        stub = folder / "bin" / name
        stub.write_text(f"#!/bin/sh\n{text}\n")
        stub.chmod(0o755)
    environment = {
        "PATH": f"{folder / 'bin'}:{os.environ['PATH']}",
        "CODE": str(code),
        "STATE": state,
        "SLURM_JOB_ID": "17",
        "SLURM_NTASKS": "4",
        "SLURM_RESTART_COUNT": str(restarts),
    }
    done = subprocess.run(
        ["bash", SCRIPT, "part.yaml"], cwd=folder, env=environment, capture_output=True, timeout=60
    )
    return done.returncode, (folder / "calls").read_text().splitlines()


def test_run_is_started_with_a_log(tmp_path):
    code, calls = run_job(tmp_path, 0)
    assert code == 0
    assert calls == ["srun --mpi=pmix signorom run part.yaml --log part.log"]


@pytest.mark.parametrize(
    ("code", "state", "restarts", "is_requeued"),
    [
        (130, "RUNNING", 0, True),
        (130, "RUNNING", 19, True),
        (130, "RUNNING", 20, False),
        (130, "CANCELLED", 0, False),
        (2, "RUNNING", 0, False),
        (3, "RUNNING", 0, False),
    ],
)
def test_only_a_stopped_run_goes_back_to_the_queue(tmp_path, code, state, restarts, is_requeued):
    """A user's mistake is not repeated, a cancelled job stays away, and there is an end."""
    found, calls = run_job(tmp_path, code, state, restarts)
    assert found == code
    assert ("scontrol requeue 17" in calls) == is_requeued
