# SPDX-License-Identifier: BSD-3-Clause
"""Contact forces of input/bracket.yaml and input/saddle.yaml at any point; the decks' numbers stand here again."""

from pathlib import Path

import numpy as np

from floating_contact import FloatingContact, facing_nodes, read_simplices, surface_load

MESHES = Path(__file__).resolve().parents[2] / "meshes"


class Bracket:
    """Plane strain; a bracket beside a wall, held by contact alone along x, y and in rotation."""

    names = ("bolt", "P", "place")

    def __init__(self):
        """Read and condense."""
        self.mesh = mesh = read_simplices(MESHES / "bracket.msh", 2)
        sides = [("foot_1", "foot_1", 1), ("foot_2", "foot_2", 1), ("wall", "stop", 0)]
        found = [facing_nodes(mesh, f"block_{one}", f"bracket_{other}", axis) for one, other, axis in sides]
        axes = np.concatenate(
            [np.full(len(pairs), side[2]) for (pairs, _), side in zip(found, sides, strict=True)]
        )
        base = mesh.nodes_of["block_base"]
        materials = {"bracket": (207e3, 0.29), "block": (71e3, 0.33)}
        pairs, self.gaps = (np.concatenate(parts) for parts in zip(*found, strict=True))
        self.problem = FloatingContact(
            mesh, materials, "bracket", np.concatenate([2 * base, 2 * base + 1]), pairs, axes
        )
        self.order = np.argsort(pairs[:, 0])
        # one straight edge: outward is away from the foot below it
        ends = mesh.coordinates[mesh.nodes_of["shelf"]]
        left, right = ends[ends[:, 0].argmin()], ends[ends[:, 0].argmax()]
        self.outward = np.array([left[1] - right[1], right[0] - left[0]]) / np.linalg.norm(right - left)

    def load(self, bolt, pressure, place):
        """F: the slanted bolt and the strip of pressure."""
        return surface_load(self.mesh, "bolt_seat", [-0.23 * bolt, -bolt]) + surface_load(
            self.mesh, "shelf", -pressure * self.outward, 0, (place, place + 5.7)
        )

    def forces(self, bolt, pressure, place):
        """Forces of the pairs, ascending in the block's nodes, whatever the contact."""
        return self.problem.forces(self.load(bolt, pressure, place), self.gaps)[self.order]


class Saddle:
    """In space; contact alone holds the saddle along y and against tipping about x and z."""

    names = ("bolt", "place", "shim")

    def __init__(self):
        """Read and condense."""
        self.mesh = mesh = read_simplices(MESHES / "saddle.msh", 3)
        found = [facing_nodes(mesh, f"block_foot_{i}", f"saddle_foot_{i}", 1) for i in (1, 2)]
        pairs = np.concatenate([pairs for pairs, _ in found])
        self.order = np.argsort(pairs[:, 0])
        self.first_gaps = found[0][1]
        self.second_places = mesh.coordinates[found[1][0][:, 0]]
        base, pin, far = (mesh.nodes_of[name] for name in ("base", "pin", "pin_far"))
        fixed = [3 * base, 3 * base + 1, 3 * base + 2, 3 * pin, 3 * pin + 2, 3 * far]
        materials = {"saddle": (1.7e3, 0.37), "block": (205e3, 0.29)}
        self.problem = FloatingContact(
            mesh, materials, "saddle", np.concatenate(fixed), pairs, np.ones(len(pairs), int)
        )

    def load(self, bolt, place):
        """F: the bolt and the strip of pressure along z."""
        return surface_load(self.mesh, "bolt_seat", [0, -bolt, 0]) + surface_load(
            self.mesh, "shelf", [0, -13.7, 0], 2, (place, place + 5.3)
        )

    def forces(self, bolt, place, shim):
        """As Bracket.forces."""
        x, _, z = self.second_places.T
        gaps = shim + (x - 9.1) ** 2 / 540 + 1.3e-4 * (z - 16.2) ** 2
        return self.problem.forces(self.load(bolt, place), np.concatenate([self.first_gaps, gaps]))[
            self.order
        ]
