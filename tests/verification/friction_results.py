# SPDX-License-Identifier: BSD-3-Clause
"""What runs of decks with friction write: forces of all contacts over time, slips, work."""

import re
from dataclasses import dataclass

import h5py
import numpy as np

from friction_blocks import tangents_of
from results import read_table


@dataclass
class Forces:
    """Forces over time; contacts by the number (from 1) of their nodes, ascending."""

    times: np.ndarray
    numbers: np.ndarray
    #: (n_times, n_contacts) and (n_times, n_contacts, n_dim - 1)
    normal: np.ndarray
    tangential: np.ndarray

    @property
    def resultant(self):
        """Sums over the contacts: normal (n_times) and tangential (n_times, n_dim - 1)."""
        return self.normal.sum(axis=1), self.tangential.sum(axis=1)


def results_of(deck):
    """Folder of a deck's results."""
    return deck.parent / "results" / deck.stem


def read_forces(deck):
    """Columns lambda_k and tau_k, or tau_k_1 and tau_k_2, of history.csv; 0 where prescribed dofs leave no tangent."""
    table = read_table(results_of(deck) / "history.csv")
    assert set(table["status"]) == {"converged"}
    numbers = sorted(
        int(found[1]) for found in (re.fullmatch(r"lambda_(\d+)", name) for name in table) if found
    )
    is_plane = any(re.fullmatch(r"tau_\d+", name) for name in table)
    endings = [""] if is_plane else ["_1", "_2"]
    nothing = np.zeros(len(table["time"]))
    tangential = [[table.get(f"tau_{k}{ending}", nothing) for ending in endings] for k in numbers]
    assert is_plane or any(name.startswith("tau_") for name in table)
    normal = np.array([table[f"lambda_{k}"] for k in numbers]).T
    return Forces(table["time"], np.array(numbers), normal, np.moveaxis(np.array(tangential), 2, 0))


def read_displacements(deck, n_dim):
    """Displacements (n_times, n_nodes, n_dim)."""
    with h5py.File(results_of(deck) / "fields.h5") as file:
        points = [file["points"][name] for name in sorted(file["points"])]
        return np.array([point["displacement"][:, :n_dim] for point in points])


def read_slips(deck, normals):
    """Slips of node pairs or of nodes on rigid bodies that rest, (n_times, n_contacts, n_dim - 1).

    `normals`: one for all contacts or one for each (n_contacts, n_dim). Changes of the position: also while open.
    """
    normals = np.atleast_2d(normals)
    n_dim = normals.shape[1]
    moved = read_displacements(deck, n_dim)
    with h5py.File(results_of(deck) / "fields.h5") as file:
        first = file["contact/first/nodes"][()] - 1
        second = file["contact/second/nodes"][()] - 1 if "contact/second/nodes" in file else []
    order = np.argsort(first)
    relative = moved[:, first[order]]
    if len(second):
        relative = relative - moved[:, second[order]]
    tangents = np.array([tangents_of(normal) for normal in normals])
    position = np.einsum("tki,kji->tkj", relative, np.broadcast_to(tangents, (len(first), n_dim - 1, n_dim)))
    return np.diff(position, axis=0, prepend=0.0)


def largest_difference(found, expected):
    """Of all forces at each time, relative to the largest one then; where there is none, to the largest at any time."""
    sizes = np.abs(expected.normal).max(axis=1)
    sizes = np.where(sizes > 0, sizes, sizes.max())
    difference = np.abs(found.normal - expected.normal).max(axis=1)
    across = np.abs(found.tangential - expected.tangential).max(axis=(1, 2))
    return (np.maximum(difference, across) / sizes).max()
