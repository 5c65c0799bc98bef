# SPDX-License-Identifier: BSD-3-Clause
"""Feeds mutated files to the sanitized readers (`fuzz_readers`) and keeps each one that does harm.

A file must be accepted, or refused with a sentence. Harm is: the reader ends, a sanitizer speaks, it computes for
more than 5 s, it wants more than 1 GB, or the sentence is empty.
"""

import argparse
import contextlib
import os
import random
import select
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from binary_kinds import Hdf5, mutate_shard
from text_kinds import CORPUS, ROOT, Deck, mutate_expression, mutate_mesh, mutate_table

KINDS = ["deck", "mesh", "expression", "points", "selection", "shard", "snapshots", "model"]
FOLDERS = {
    "deck": ["input/*.yaml", "tests/integration/decks/*.yaml", "tests/integration/decks/invalid/*.yaml"],
    "mesh": ["tests/integration/meshes/*.msh"],
    "points": ["input/half_disks_points.csv"],
}
WRITTEN = {"shard": "*.shard", "snapshots": "snapshots*.h5", "model": "model*.h5"}
CPU_LIMIT = 5.0  # s that a reader may compute for one file
WALL_LIMIT = 120.0  # s, for a reader that only waits
MEMORY_LIMIT = 1024  # MB
SANITIZERS = {
    "ASAN_OPTIONS": f"hard_rss_limit_mb={MEMORY_LIMIT}:max_allocation_size_mb={MEMORY_LIMIT}:detect_leaks=1:"
    "fast_unwind_on_malloc=1:handle_abort=1",
    "UBSAN_OPTIONS": "print_stacktrace=1:halt_on_error=1",
    "LSAN_OPTIONS": f"suppressions={ROOT}/tools/lsan.supp:print_suppressions=0",
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
}
READ_BY_ONE = 2000  # files that one process reads before it ends and tells what it leaked


class Reader:
    """A process that reads one file after the other."""

    def __init__(self, program: Path, kind: str, folder: Path) -> None:
        self.command = [program, kind]
        self.report = folder / "report.txt"
        self.environment = os.environ | SANITIZERS
        self.start()

    def start(self) -> None:
        self.n_read = 0
        with self.report.open("wb") as report:
            self.process = subprocess.Popen(
                self.command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=report,
                env=self.environment,
            )

    def cpu_seconds(self) -> float:
        fields = Path(f"/proc/{self.process.pid}/stat").read_text().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def wait(self) -> bool:
        """Whether an answer or the end came in time."""
        start_cpu, start = self.cpu_seconds(), time.monotonic()
        while not select.select([self.process.stdout], [], [], 1.0)[0]:
            if self.cpu_seconds() - start_cpu > CPU_LIMIT or time.monotonic() - start > WALL_LIMIT:
                return False
        return True

    def read(self, path: Path) -> tuple[str, str]:
        """The answer to one file, and what is wrong about it (empty where nothing is)."""
        self.n_read += 1
        try:
            self.process.stdin.write(f"{path}\n".encode())
            self.process.stdin.flush()
        except BrokenPipeError:
            return "", self.end("the reader had ended")
        if not self.wait():
            self.process.kill()
            return "", self.end(f"no answer after {CPU_LIMIT:g} s of computing, or after {WALL_LIMIT:g} s")
        words = self.process.stdout.readline().split()
        if words == [b"accepted"]:
            return "accepted", ""
        if len(words) != 2 or words[0] != b"refused":
            return "", self.end("the reader ended")
        sentence = self.process.stdout.read(int(words[1]) + 1)
        return "refused", "" if len(sentence.split()) > 2 else f"a refusal without a sentence: {sentence}"

    def end(self, reason: str) -> str:
        """Ends the process and starts the next one; the reason with what a sanitizer said."""
        if self.process.poll() is None:
            with contextlib.suppress(BrokenPipeError):
                self.process.stdin.close()
        try:
            status = self.process.wait(60)
        except subprocess.TimeoutExpired:
            self.process.kill()
            status = self.process.wait()
        self.process.stdout.close()
        told = self.report.read_text(errors="replace")
        self.start()
        return f"{reason}\nexit code {status}\n{told}" if reason or status != 0 else ""


def seeds_of(kind: str, written: Path) -> list[tuple[str, bytes]]:
    """Names and contents of what the mutations begin with; regressions among them."""
    paths = sorted((CORPUS / kind).glob("*"))
    for pattern in FOLDERS.get(kind, []):
        paths += sorted(ROOT.glob(pattern))
    if kind in WRITTEN:
        paths += sorted(written.glob(WRITTEN[kind]))
    return [(path.name, path.read_bytes()) for path in paths if path.is_file()]


def mutation_of(kind: str, folder: Path) -> Callable[[bytes, random.Random], bytes]:
    if kind == "deck":
        return Deck().mutate
    if kind in ("snapshots", "model"):
        return Hdf5(folder).mutate
    return {
        "mesh": mutate_mesh,
        "expression": mutate_expression,
        "points": mutate_table,
        "selection": mutate_table,
        "shard": mutate_shard,
    }[kind]


def inputs(seeds: list[tuple[str, bytes]], mutate: Callable, seed: int) -> Iterator[tuple[str, bytes]]:
    """First the seeds as they are, then their mutations without an end; input i depends on the seed and on i alone."""
    yield from seeds
    i = 0
    while True:
        rng = random.Random(f"{seed}/{i}")
        yield f"seed {seed}, input {i}", mutate(rng.choice(seeds)[1], rng)
        i += 1


def fuzz_kind(kind: str, program: Path, options: argparse.Namespace, seconds: float, folder: Path) -> int:
    """Reads until the inputs or the seconds are used up; the number of harmful inputs."""
    reader = Reader(program, kind, folder)
    path = folder / f"input.{kind}"
    seeds = seeds_of(kind, folder)
    counts = {"accepted": 0, "refused": 0, "harmful": 0}
    start = time.monotonic()
    for n_read, (name, data) in enumerate(inputs(seeds, mutation_of(kind, folder), options.seed)):
        if (
            n_read >= options.inputs + len(seeds)
            or time.monotonic() - start > seconds
            or counts["harmful"] >= options.most
        ):
            break
        path.write_bytes(data)
        answer, fault = reader.read(path)
        if not fault and reader.n_read >= READ_BY_ONE:
            fault = reader.end("")
        counts["harmful" if fault else answer] += 1
        if fault:
            keep(kind, name, data, fault, counts["harmful"], options.keep)
    fault = reader.end("")
    reader.process.kill()
    if fault:
        counts["harmful"] += 1
        keep(kind, "end of the run", b"", fault, counts["harmful"], options.keep)
    n_inputs = sum(counts.values())
    print(
        f"{kind}: {n_inputs} inputs in {time.monotonic() - start:.0f} s, "
        + ", ".join(f"{counts[k]} {k}" for k in counts),
        flush=True,
    )
    return counts["harmful"]


def keep(kind: str, name: str, data: bytes, fault: str, number: int, folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{kind}-{number}").write_bytes(data)
    (folder / f"{kind}-{number}.txt").write_text(f"{name}\n{fault}")
    print(f"{kind}, {name}: kept as {folder}/{kind}-{number}\n{fault[:3000]}", flush=True)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("program", type=Path, help="fuzz_readers of a build")
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=KINDS)
    parser.add_argument(
        "--inputs", type=int, default=100_000, help="mutated files per kind (default: %(default)s)"
    )
    parser.add_argument(
        "--seconds", type=float, default=float("inf"), help="for all kinds together (default: no limit)"
    )
    parser.add_argument("--seed", type=int, default=1, help="of the random numbers (default: %(default)s)")
    parser.add_argument(
        "--most",
        type=int,
        default=5,
        help="harmful files of a kind after which it ends (default: %(default)s)",
    )
    parser.add_argument(
        "--keep",
        type=Path,
        default=Path("fuzz_found"),
        help="folder for harmful files (default: %(default)s)",
    )
    options = parser.parse_args()
    folder = Path(tempfile.mkdtemp(prefix="fuzz"))
    try:
        program = options.program.resolve()
        # gfortran leaks the constructors by which the seeds are made
        subprocess.run(
            [program, "seeds", folder], check=True, env=os.environ | {"ASAN_OPTIONS": "detect_leaks=0"}
        )
        share = options.seconds / len(options.kinds)
        n_harmful = sum(fuzz_kind(kind, program, options, share, folder) for kind in options.kinds)
    finally:
        shutil.rmtree(folder)
    return 1 if n_harmful else 0


if __name__ == "__main__":
    sys.exit(main())
