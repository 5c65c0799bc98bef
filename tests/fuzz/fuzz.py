# SPDX-License-Identifier: BSD-3-Clause
"""Feeds mutated files to the sanitized readers (`fuzz_readers`) and keeps each one that does harm.

A file must be accepted, or refused with a sentence. Harm is: the reader ends, a sanitizer speaks, it computes for
more than 5 s, it wants more than 1 GB, or the sentence is empty.
"""

import argparse
import itertools
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from binary_kinds import Hdf5, mutate_shard
from reader import Reader
from text_kinds import CORPUS, ROOT, Deck, mutate_expression, mutate_mesh, mutate_table

KINDS = ["deck", "mesh", "field", "expression", "points", "selection", "shard", "snapshots", "model"]
FOLDERS = {
    "deck": ["input/*.yaml", "tests/integration/decks/*.yaml", "tests/integration/decks/invalid/*.yaml"],
    "mesh": ["tests/integration/meshes/*.msh"],
    "points": ["input/half_disks_points.csv"],
}
WRITTEN = {"shard": "*.shard", "snapshots": "snapshots*.h5", "model": "model*.h5"}
BATCH = 50  # files that the reader is asked for at a time
BATCHES_OF_ONE = 40  # batches after which a process ends and tells what it leaked


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
        "field": mutate_mesh,
        "expression": mutate_expression,
        "points": mutate_table,
        "selection": mutate_table,
        "shard": mutate_shard,
    }[kind]


def mutated_inputs(
    seeds: list[tuple[str, bytes]], accepted: list[bytes], mutate: Callable, seed: int
) -> Iterator[tuple[str, bytes]]:
    """Without an end; most of them begin with a file that is accepted as it is."""
    i = 0
    while True:
        rng = random.Random(f"{seed}/{i}")
        data = rng.choice(accepted) if accepted and rng.random() < 0.85 else rng.choice(seeds)[1]
        yield f"seed {seed}, input {i}", mutate(data, rng)
        i += 1


class Run:
    """One kind of file, until the inputs or the seconds are used up."""

    def __init__(self, kind: str, program: Path, options: argparse.Namespace, folder: Path) -> None:
        self.kind, self.options, self.folder = kind, options, folder
        self.reader = Reader(program, kind, folder)
        self.n_batches = 0
        self.counts = {"accepted": 0, "refused": 0, "harmful": 0}

    def try_batch(self, batch: list[tuple[str, bytes]]) -> list[str]:
        """accepted, refused or harmful for each."""
        paths = [self.folder / f"input_{i}.{self.kind}" for i in range(len(batch))]
        for path, (_, data) in zip(paths, batch, strict=True):
            path.write_bytes(data)
        self.reader.send(paths)
        outcomes = []
        for i, (name, data) in enumerate(batch):
            process = self.reader.process
            answer, fault = self.reader.answer()
            outcomes.append("harmful" if fault else answer)
            self.count(outcomes[-1], name, data, fault)
            if self.reader.process is not process:
                self.reader.send(paths[i + 1 :])
        self.n_batches += 1
        if self.n_batches % BATCHES_OF_ONE == 0:
            self.end_process()
        return outcomes

    def count(self, outcome: str, name: str, data: bytes, fault: str) -> None:
        self.counts[outcome] += 1
        if fault:
            keep(self.kind, name, data, fault, self.counts["harmful"], self.options.keep)

    def end_process(self) -> None:
        """What a process leaked belongs to one of many inputs."""
        fault = self.reader.end()
        if fault:
            self.count("harmful", "end of a process", b"", fault)


def batches(inputs: Iterator[tuple[str, bytes]]) -> Iterator[list[tuple[str, bytes]]]:
    while batch := list(itertools.islice(inputs, BATCH)):
        yield batch


def fuzz_kind(kind: str, program: Path, options: argparse.Namespace, seconds: float, folder: Path) -> int:
    """First the seeds as they are, then their mutations; the number of harmful inputs."""
    start = time.monotonic()
    run = Run(kind, program, options, folder)
    seeds = seeds_of(kind, folder)
    outcomes = [outcome for batch in batches(iter(seeds)) for outcome in run.try_batch(batch)]
    accepted = [seed[1] for seed, outcome in zip(seeds, outcomes, strict=True) if outcome == "accepted"]
    changed = mutated_inputs(seeds, accepted, mutation_of(kind, folder), options.seed)
    for batch in batches(itertools.islice(changed, options.inputs)):
        run.try_batch(batch)
        if time.monotonic() - start > seconds or run.counts["harmful"] >= options.most:
            break
    run.end_process()
    run.reader.process.kill()
    run.reader.process.wait()
    figures = ", ".join(f"{number} {outcome}" for outcome, number in run.counts.items())
    print(
        f"{kind}: {sum(run.counts.values())} inputs in {time.monotonic() - start:.0f} s, {figures}",
        flush=True,
    )
    return run.counts["harmful"]


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
