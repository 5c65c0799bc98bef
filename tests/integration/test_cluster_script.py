# SPDX-License-Identifier: BSD-3-Clause
"""The jobs of input/cluster.slurm: when one goes back to the queue; arrays. Stubs stand for the commands of Slurm."""

import os
import subprocess

import pytest

from program import ENVIRONMENT
from runs import HERE, write_deck

SCRIPT = HERE.parents[1] / "input" / "cluster.slurm"
STUBS = {
    "srun": 'echo "srun $*" >>calls; exit "$CODE"',
    "squeue": 'echo "$STATE"',
    "scontrol": 'echo "scontrol $*" >>calls',
}
# starts the program on one rank, without `--mpi=pmix`
STARTS = {"srun": 'shift; exec "$@"'}


def write_stubs(folder, stubs):
    """Commands of Slurm in folder/bin."""
    (folder / "bin").mkdir()
    for name, text in stubs.items():
        stub = folder / "bin" / name
        stub.write_text(f"#!/bin/sh\n{text}\n")
        stub.chmod(0o755)


def run_job(folder, code, state="RUNNING", restarts=0, words=("part.yaml",), **variables):
    """Exit code of the job, and the calls of srun and scontrol."""
    write_stubs(folder, STUBS)
    environment = variables | {
        "PATH": f"{folder / 'bin'}:{os.environ['PATH']}",
        "CODE": str(code),
        "STATE": state,
        "SLURM_JOB_ID": "17",
        "SLURM_NTASKS": "4",
        "SLURM_RESTART_COUNT": str(restarts),
    }
    done = subprocess.run(
        ["bash", SCRIPT, *words], cwd=folder, env=environment, capture_output=True, timeout=60
    )
    return done.returncode, (folder / "calls").read_text().splitlines()


def test_run_is_started_with_a_log(tmp_path):
    code, calls = run_job(tmp_path, 0)
    assert code == 0
    assert calls == ["srun --mpi=pmix signorom run part.yaml --log part.log"]


def test_job_of_an_array_samples_its_share(tmp_path):
    code, calls = run_job(tmp_path, 0, words=("part.yaml", "4"), SLURM_ARRAY_TASK_ID="3")
    assert code == 0
    assert calls == ["srun --mpi=pmix signorom sample part.yaml --share 3/4 --log part-3.log"]


def test_array_needs_the_number_of_shares(tmp_path):
    """Without it each job would run the whole deck."""
    (tmp_path / "calls").write_text("")
    code, calls = run_job(tmp_path, 0, SLURM_ARRAY_TASK_ID="3")
    assert code != 0
    assert calls == []


def test_two_jobs_of_an_array_and_the_run_behind_them(signorom, tmp_path):
    """Two processes at the same time sample into one folder, and the job behind them solves no training point."""
    write_deck("patch", tmp_path, **{"grid: {push: 5}": "grid: {push: 200}"})
    write_stubs(tmp_path, STUBS | STARTS)
    environment = os.environ | ENVIRONMENT | {"SIGNOROM": str(signorom.executable), "SLURM_JOB_ID": "17"}
    environment["PATH"] = f"{tmp_path / 'bin'}:{os.environ['PATH']}"

    def start(*words, **variables):
        return subprocess.Popen(
            ["bash", SCRIPT, "patch.yaml", *words],
            cwd=tmp_path,
            env=environment | variables,
            stdout=subprocess.PIPE,
            text=True,
        )

    jobs = [start("2", SLURM_ARRAY_TASK_ID=str(k)) for k in (1, 2)]
    for k, job in enumerate(jobs, 1):
        said, _ = job.communicate(timeout=60)
        assert job.returncode == 0
        assert f"sampled 100 points (0 were there): share {k}/2" in said
        assert f"share {k}/2" in (tmp_path / f"patch-{k}.log").read_text()
    run = start()
    said, _ = run.communicate(timeout=60)
    assert run.returncode == 0
    assert "sampled 200 points (200 were there)" in said
    assert (tmp_path / "results" / "patch" / "model.h5").exists()


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
