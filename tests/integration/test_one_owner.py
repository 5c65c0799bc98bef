# SPDX-License-Identifier: BSD-3-Clause
"""A command reads its mesh once and factors each stiffness once, counted by PETSc itself and by the kernel."""

import ctypes
import os
import re
import struct

import pytest
import yaml

from runs import write_deck

# of <sys/inotify.h>
IN_OPEN, IN_CLOSE = 0x20, 0x18
IN_NONBLOCK = 0x800
EVENT = struct.Struct("iIII")


class OpenCounter:
    """How often a file is opened while the block runs."""

    def __init__(self, path):
        """Watch the file."""
        libc = ctypes.CDLL(None, use_errno=True)
        self.watch = libc.inotify_init1(IN_NONBLOCK)
        # closing is watched, too: the kernel joins equal events that follow each other
        assert libc.inotify_add_watch(self.watch, os.fsencode(path), IN_OPEN | IN_CLOSE) > 0

    def count(self):
        """Opens so far; ends the watch."""
        events = os.read(self.watch, 65536)
        os.close(self.watch)
        masks = [mask for _, mask, _, length in EVENT.iter_unpack(events) if length == 0]
        return sum(bool(mask & IN_OPEN) for mask in masks)


def count_events(path, name):
    """How often PETSc logged an event, 0 where its table lacks it."""
    match = re.search(rf"^{name}\s+(\d+) ", path.read_text(), re.MULTILINE)
    return int(match[1]) if match else 0


@pytest.fixture(scope="module")
def run(signorom, tmp_path_factory):
    """Runs a command on decks/small_disks.yaml with changes: its folder, factorizations, opens of the mesh file."""

    def start(*arguments, n_ranks=1, **changes):
        folder = tmp_path_factory.mktemp("owner")
        deck = write_deck("small_disks", folder, **changes)
        text = deck.read_text()
        mesh = folder / "small_disks.msh"
        named = re.search(r"file: ([^,]+),", text)[1]
        mesh.write_bytes((deck.parent / named).resolve().read_bytes())
        deck.write_text(text.replace(named, mesh.name))
        opens = OpenCounter(mesh)
        signorom(
            arguments[0], deck.name, *arguments[1:], "-log_view", ":log.txt", folder=folder, n_ranks=n_ranks
        )
        return (
            folder / "results" / "small_disks",
            count_events(folder / "log.txt", "MatCholFctrNum"),
            opens.count(),
        )

    return start


def test_run_reads_once_and_factors_once(run):
    """Sampling, lifting, the operator of the model, validation and fields: one K, one factorization."""
    results, n_factorizations, n_opens = run("run")
    assert (n_factorizations, n_opens) == (1, 1)
    report = yaml.safe_load((results / "report.yaml").read_text())
    assert "speed_up" not in report
    assert "query" not in report["times"]


def test_groups_share_the_mesh(run):
    """Two groups of one rank: one reads for both, each factors its own K once (PETSc's table has the largest count)."""
    _, n_factorizations, n_opens = run("run", n_ranks=2)
    assert (n_factorizations, n_opens) == (1, 1)


def test_sample_factors_once(run):
    """Snapshots and the lifting that stands beside them."""
    _, n_factorizations, n_opens = run("sample")
    assert (n_factorizations, n_opens) == (1, 1)


def test_benchmark_is_asked_for(run):
    """Only --benchmark factors anew at each step of its points, and says what that costs."""
    results, n_factorizations, _ = run("run", "--benchmark")
    assert n_factorizations > 5
    report = yaml.safe_load((results / "report.yaml").read_text())
    assert list(report["speed_up"]) == ["over_condensed", "over_refactored"]


def test_benchmark_goes_with_validate_and_run(signorom, tmp_path):
    deck = write_deck("small_disks", tmp_path)
    done = signorom.run("sample", deck.name, "--benchmark", folder=tmp_path)
    assert done.returncode == 2
    assert done.stderr.startswith("error: --benchmark goes with validate and run, not with sample")
