# SPDX-License-Identifier: BSD-3-Clause
"""Decks of this folder, and what must be true of every run that fails."""

from pathlib import Path

from decks import copy_deck
from results import read_fields, read_table, table_of

HERE = Path(__file__).resolve().parent
# What a program prints that dies instead of saying what is wrong.
CRASH = (
    "PETSC ERROR",
    "MPI_ABORT",
    "Fortran runtime",
    "backtrace",
    "SIGSEGV",
    "Segmentation",
    "terminate called",
)
# [s] an error of the user is found before any work is done
SOON = 60


def on_ranks(cases):
    """Cases with a number of ranks: all on one, the first also on three, where every rank must leave alike."""
    return [(*case, 1) for case in cases] + [(*cases[0], 3)]


def write_deck(name, folder, **replacements):
    """Copy decks/<name>.yaml into a folder with `old` -> `new` texts replaced."""
    return copy_deck(HERE / "decks" / f"{name}.yaml", folder, **replacements)


def results_of(signorom, folder, command, changes, n_ranks=1):
    """Results folder of a command on decks/small_disks.yaml with changes."""
    folder.mkdir(exist_ok=True)
    signorom(command, write_deck("small_disks", folder, **changes), folder=folder, n_ranks=n_ranks)
    return folder / "results" / "small_disks"


def run_shifted_disks(signorom, folder, n_ranks=1, **replacements):
    """Results folder of `run` on decks/shifted_disks.yaml with changes."""
    deck = write_deck("shifted_disks", folder, **replacements)
    signorom("run", deck.name, folder=folder, n_ranks=n_ranks)
    return folder / "results" / "shifted_disks"


def train_shifted_disks(signorom, folder, **replacements):
    """File of a model that decks/shifted_disks.yaml, with changes, trains."""
    deck = write_deck("shifted_disks", folder, **replacements)
    for command in ("sample", "train"):
        signorom(command, deck.name, folder=folder)
    return folder / "results" / "shifted_disks" / "model.h5"


def check_reduced_model(signorom, results, folder):
    """Small errors at the test points, and at the second output point, squeeze = 0.4, the force of the full order."""
    table = read_table(results / "validation.csv")
    assert max(table["e_lambda_rid"]) < 0.05
    assert max(table["e_u"]) < 0.01
    answer = table_of(signorom("predict", results / "model.h5", "--at", "squeeze=0.4", folder=folder))
    full = read_fields(results / "fields.h5", 2)["multipliers_full_order"].sum()
    assert abs(answer["contact_force"][0] - full) <= 0.02 * full


def files_in(folder):
    """All files below a folder with their content; locks are not results."""
    return {
        path: path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and not path.name.startswith(".lock")
    }


def refuse(signorom, *arguments, folder, n_ranks=1):
    """Run a command that must end with exit code 2 soon, crash nowhere and leave every file as it was: its messages."""
    before = files_in(folder)
    done = signorom.run(*arguments, folder=folder, n_ranks=n_ranks, time_limit=SOON)
    assert done.returncode == 2, f"exit code {done.returncode}\n{done.stdout}\n{done.stderr}"
    assert not [word for word in CRASH if word in done.stderr + done.stdout], done.stderr
    assert files_in(folder) == before
    assert done.stderr.count("error: ") >= 1
    return done.stderr
