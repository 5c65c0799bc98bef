# SPDX-License-Identifier: BSD-3-Clause
"""Decks of this folder, and what runs of them write."""

from pathlib import Path

import yaml

from decks import copy_deck
from program import ROOT
from results import read_fields, read_snapshots, read_table

__all__ = ["HERE", "INPUT", "MESHES", "ROOT", "read_fields", "read_report", "read_snapshots", "read_table"]
__all__ += ["solve_deck", "solve_input", "write_deck", "write_deck_with", "write_input"]

HERE = Path(__file__).resolve().parent
INPUT = ROOT / "input"
MESHES = ROOT / "meshes"


def write_deck(name, folder, **replacements):
    """Copy decks/<name>.yaml into a folder with `old` -> `new` texts replaced."""
    return copy_deck(HERE / "decks" / f"{name}.yaml", folder, **replacements)


def write_input(name, folder, replacements=None):
    """As write_deck_with, of a deck that users have."""
    return copy_deck(INPUT / f"{name}.yaml", folder, **(replacements or {}))


def solve_input(signorom, name, folder, replacements=None, n_ranks=1):
    """Fields at each output point of a deck that users have, and the report."""
    return solve_deck(signorom, write_input(name, folder, replacements), n_ranks)


def solve_deck(signorom, deck, n_ranks=1):
    """Fields at each output point of a deck, and the report; results go beside the deck."""
    signorom("solve", deck, folder=deck.parent, n_ranks=n_ranks)
    report = read_report(deck.parent, deck.stem)
    path = deck.parent / "results" / deck.stem / "fields.h5"
    fields = [read_fields(path, i_point) for i_point in range(1, len(report["points"]) + 1)]
    assert all(point["status"] == "converged" for point in report["points"].values())
    return fields, report


def read_report(folder, name):
    """report.yaml of a run in a folder."""
    return yaml.safe_load((Path(folder) / "results" / name / "report.yaml").read_text())


def write_deck_with(name, folder, replacements):
    """As write_deck, for texts that are no Python names."""
    return write_deck(name, folder, **replacements)
