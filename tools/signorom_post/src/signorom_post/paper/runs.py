# SPDX-License-Identifier: BSD-3-Clause
"""Runs of the program, kept in a folder. A finished run with the same program, mesh and deck is not repeated."""

import hashlib
import os
import shutil
import subprocess
import time
from collections.abc import Iterable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from pathlib import Path
from threading import Lock
from typing import Any

import yaml

from signorom_post.errors import InputError
from signorom_post.log import LOOK_INTERVAL, Log, Progress, last_line
from signorom_post.paper.variants import GRID, IRREGULAR, POINTS, Variant, with_load, with_training
from signorom_post.program import USABLE, program_environment
from signorom_post.readers.hdf5_input import Hdf5Input
from signorom_post.results import Results

#: files in the folder of a run: a checksum of its inputs, written first, and an empty file, written at the end
FINGERPRINT, FINISHED = "fingerprint", "finished"
#: file with the scattered training points, in the folder of their snapshots
IRREGULAR_FILE = "points.csv"
#: GRID or IRREGULAR -> folder of the snapshots
SNAPSHOTS = {GRID: "snapshots", IRREGULAR: "irregular_snapshots"}


@dataclass(frozen=True)
class Job:
    """One run of the program."""

    #: folder of the deck and of the results
    folder: Path
    #: the program's command, such as `run`
    command: str
    deck: dict[str, Any]
    #: file of another run; a link to it is made in `folder`, so that the run finds it
    link: Path | None = None
    #: names of large result files that are not needed and are deleted
    dropped: tuple[str, ...] = ()


class Runs:
    """Starts the program for the variants that a figure needs, up to `n_jobs` runs at a time."""

    def __init__(self, folder: Path, program: Path, base_deck: Path, n_jobs: int, log: Log) -> None:
        """Keeps the runs of `program` below `folder`; `base_deck` is the deck of case b."""
        self.folder = folder
        self._program = program
        self._base = yaml.safe_load(base_deck.read_text(encoding="utf-8"))
        self._base["mesh"]["file"] = str((base_deck.parent / self._base["mesh"]["file"]).resolve())
        self._n_jobs = n_jobs
        self._log = log
        self._inputs = _digest(program.read_bytes(), Path(self._base["mesh"]["file"]).read_bytes())
        self._processes: list[subprocess.Popen[bytes]] = []
        self._lock = Lock()
        self._is_stopped = False

    def results(self, variants: Sequence[Variant]) -> list[Results]:
        """Returns the results of these variants in the same order.

        Runs that have not finished with the same program, mesh and deck are done first, and so are those that make
        their snapshots. A run in which some points did not converge counts as finished. InputError if a run fails in
        another way, OSError if a file cannot be written.
        """
        self.folder.mkdir(parents=True, exist_ok=True)
        lines = ["P1,h1", *(f"{pressure},{height}" for pressure, height in POINTS)]
        (self.folder / "points.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
        samples = dict.fromkeys((v.load, v.training) for v in variants)
        self._run_all(self._sampling(load, training) for load, training in samples)
        for load, training in samples:
            if training == IRREGULAR:
                self._write_points(self.folder / load / SNAPSHOTS[training])
        self._run_all(self._validation(variant) for variant in dict.fromkeys(variants))
        return [Results(self.folder / variant.name) for variant in variants]

    def _sampling(self, load: str, training: str) -> Job:
        deck = with_training(with_load(self._base, load), training)
        return Job(self.folder / load / SNAPSHOTS[training], "sample", deck)

    def _write_points(self, folder: Path) -> None:
        """Writes the training points of the snapshots in `folder` as CSV, from which the models' decks read them."""
        path = folder / IRREGULAR_FILE
        with Hdf5Input(folder / "snapshots.h5") as file:
            names, points = file.texts("/parameter_names"), file.reals("/parameters", 2)
        lines = [",".join(names), *(",".join(repr(float(value)) for value in point) for point in points)]
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")

    def _validation(self, variant: Variant) -> Job:
        snapshots = SNAPSHOTS[variant.training]
        deck = variant.deck(self._base, "../../points.csv", f"../{snapshots}/{IRREGULAR_FILE}")
        dropped = () if variant.has_fields else ("model.h5", "fields.h5", "fields.xdmf")
        link = self.folder / variant.load / snapshots / "snapshots.h5"
        return Job(self.folder / variant.name, "run", deck, link, dropped)

    def _run_all(self, jobs: Iterable[Job]) -> None:
        waiting = [job for job in jobs if not self._is_finished(job)]
        if not waiting:
            return
        with ThreadPoolExecutor(self._n_jobs) as pool, Progress(self._log, "runs", len(waiting)) as progress:
            futures = {pool.submit(self._run, job): job for job in waiting}
            try:
                self._follow(futures, progress)
            except BaseException:
                self._stop(pool)
                raise

    def _follow(self, jobs: dict[Future[float], Job], progress: Progress) -> None:
        """Reports each run that has ended, and the last line of one that is still at work, until all have ended.

        InputError if a run failed.
        """
        left = set(jobs)
        while left:
            ended, left = wait(left, LOOK_INTERVAL, return_when=FIRST_COMPLETED)
            for i, future in enumerate(ended, start=len(jobs) - len(left) - len(ended) + 1):
                name = jobs[future].folder.relative_to(self.folder)
                self._log.note(f"run {i} of {len(jobs)}: {name}, {future.result():.1f} s")
            logs = (jobs[future].folder / "log.txt" for future in jobs if future.running())
            said = next((f"{path.parent.name}: {line}" for path in logs if (line := last_line(path))), "")
            progress.advance(len(jobs) - len(left), said)

    def _run(self, job: Job) -> float:
        """Runs the program in the job's folder and returns the seconds that it took; InputError if the run failed.

        It returns 0 if the runs were stopped; the job then does not count as finished.
        """
        start = time.monotonic()
        self._prepare(job)
        log = job.folder / "log.txt"
        with log.open("wb") as output:
            with self._lock:
                if self._is_stopped:
                    return 0.0
                process = subprocess.Popen(
                    [self._program, job.command, "deck.yaml"],
                    cwd=job.folder,
                    env=program_environment(),
                    stdin=subprocess.DEVNULL,
                    stdout=output,
                    stderr=subprocess.STDOUT,
                )
                self._processes.append(process)
            code = process.wait()
        if self._is_stopped:
            return 0.0
        if code not in USABLE:
            said = log.read_text(encoding="utf-8", errors="replace").strip() or "it said nothing"
            raise InputError(log, f"{self._program.name} {job.command} ended with exit code {code}:\n{said}")
        for name in job.dropped:
            (job.folder / name).unlink(missing_ok=True)
        (job.folder / FINISHED).touch()
        return time.monotonic() - start

    def _prepare(self, job: Job) -> None:
        """Makes the job's folder with deck, link and checksum.

        A folder with other inputs is deleted first. An interrupted run with the same inputs will continue.
        """
        if not self._is_same(job):
            shutil.rmtree(job.folder, ignore_errors=True)
        job.folder.mkdir(parents=True, exist_ok=True)
        (job.folder / "deck.yaml").write_text(_deck_text(job), encoding="utf-8")
        if job.link is not None:
            link = job.folder / job.link.name
            link.unlink(missing_ok=True)
            link.symlink_to(os.path.relpath(job.link, job.folder))
        (job.folder / FINGERPRINT).write_text(self._fingerprint(job), encoding="utf-8")

    def _is_same(self, job: Job) -> bool:
        path = job.folder / FINGERPRINT
        return path.is_file() and path.read_text(encoding="utf-8") == self._fingerprint(job)

    def _is_finished(self, job: Job) -> bool:
        return self._is_same(job) and (job.folder / FINISHED).is_file()

    def _fingerprint(self, job: Job) -> str:
        snapshots = (job.link.parent / FINGERPRINT).read_bytes() if job.link is not None else b""
        return _digest(self._inputs.encode(), job.command.encode(), _deck_text(job).encode(), snapshots)

    def _stop(self, pool: ThreadPoolExecutor) -> None:
        """Cancels the runs that wait, and asks the others to end; the program ends after its current point."""
        with self._lock:
            self._is_stopped = True
            for process in self._processes:
                if process.poll() is None:
                    process.terminate()
        pool.shutdown(wait=True, cancel_futures=True)


def _deck_text(job: Job) -> str:
    return yaml.safe_dump(job.deck, sort_keys=False)


def _digest(*parts: bytes) -> str:
    digest = hashlib.sha256()
    for part in parts:
        digest.update(hashlib.sha256(part).digest())
    return digest.hexdigest()
