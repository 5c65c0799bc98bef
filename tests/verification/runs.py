# SPDX-License-Identifier: BSD-3-Clause
"""Decks of this folder, and what runs of them write."""

from pathlib import Path

from decks import copy_deck
from program import ROOT
from results import read_fields, read_snapshots, read_table

__all__ = ["HERE", "ROOT", "read_fields", "read_snapshots", "read_table", "write_deck", "write_deck_with"]

HERE = Path(__file__).resolve().parent


def write_deck(name, folder, **replacements):
    """Copy decks/<name>.yaml into a folder with `old` -> `new` texts replaced."""
    return copy_deck(HERE / "decks" / f"{name}.yaml", folder, **replacements)


def write_deck_with(name, folder, replacements):
    """As write_deck, for texts that are no Python names."""
    return write_deck(name, folder, **replacements)
