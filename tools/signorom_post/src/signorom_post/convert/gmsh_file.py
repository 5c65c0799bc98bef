# SPDX-License-Identifier: BSD-3-Clause
"""Writes a converted mesh as a .msh of gmsh, format 4.1 ASCII."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from signorom_post.arrays import IntArray
from signorom_post.convert.elements import KINDS, Kind
from signorom_post.convert.groups import Converted
from signorom_post.errors import writing

#: an entity: dimension, numbers of its physical groups, and for each kind the nodes of its elements
Entity = tuple[int, list[int], list[tuple[Kind, IntArray]]]


def write_gmsh(mesh: Converted, path: Path) -> None:
    """Writes nodes of cells, numbered from 1 in the order of the source, all cells, and the elements of named groups.

    Elements in the same groups form one entity. InputError if the file cannot be written.
    """
    with writing("the mesh", path):
        path.write_text("\n".join(_lines(mesh)) + "\n", encoding="utf-8")


def _lines(mesh: Converted) -> Iterator[str]:
    entities = _entities(mesh)
    yield from ("$MeshFormat", "4.1 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(mesh.groups)))
    for i, group in enumerate(mesh.groups, 1):
        yield f'{group.n_dim} {i} "{group.name}"'
    yield "$EndPhysicalNames"
    yield from _entity_lines(mesh, entities)
    used = mesh.cells.used_nodes()
    number = np.cumsum(used)
    n_nodes = int(number[-1])
    yield from ("$Nodes", f"1 {n_nodes} 1 {n_nodes}", f"{mesh.cells.n_dim} 1 0 {n_nodes}")
    yield from map(str, range(1, n_nodes + 1))
    for x, y, z in mesh.cells.coordinates[used].tolist():
        yield f"{x!r} {y!r} {z!r}"
    yield "$EndNodes"
    yield from _element_lines(entities, number)


def _entities(mesh: Converted) -> list[Entity]:
    """Returns the entities, the numbers of whose groups count from 1; the first one is of cells."""
    n_dim = mesh.cells.n_dim
    found: list[Entity] = []
    for dimension, kinds, nodes in (
        (n_dim, mesh.cells.kinds, mesh.cells.nodes),
        (n_dim - 1, mesh.faces.kinds, mesh.faces.nodes),
    ):
        membership = _memberships(mesh, dimension, len(kinds))
        patterns, of_pattern = np.unique(membership, axis=0, return_inverse=True)
        for i, pattern in enumerate(patterns):
            which = np.flatnonzero(of_pattern.reshape(-1) == i)
            blocks = []
            for i_kind in np.unique(kinds[which]):
                of_kind = which[kinds[which] == i_kind]
                blocks.append((KINDS[i_kind], nodes[of_kind, : KINDS[i_kind].n_nodes]))
            if pattern.any():
                found.append((dimension, (np.flatnonzero(pattern) + 1).tolist(), blocks))
    for i, group in enumerate(mesh.groups, 1):
        if group.kind is not None and group.nodes is not None:
            found.append((group.n_dim, [i], [(group.kind, group.nodes)]))
    return found


def _memberships(mesh: Converted, n_dim: int, n: int) -> IntArray:
    """Returns whether each of n cells or faces is in each group; shape (n, n_groups)."""
    membership = np.zeros((n, len(mesh.groups)), dtype=bool)
    for i, group in enumerate(mesh.groups):
        if group.n_dim == n_dim and group.kind is None:
            membership[group.members, i] = True
    return membership


def _entity_lines(mesh: Converted, entities: list[Entity]) -> Iterator[str]:
    yield "$Entities"
    yield " ".join(str(sum(entity[0] == n_dim for entity in entities)) for n_dim in range(4))
    for n_dim in range(4):
        of_dimension = [entity for entity in entities if entity[0] == n_dim]
        for tag, (_, groups, blocks) in enumerate(of_dimension, 1):
            nodes = np.concatenate([nodes.ravel() for _, nodes in blocks])
            places = mesh.cells.coordinates[nodes]
            low, high = places.min(axis=0).tolist(), places.max(axis=0).tolist()
            box = low if n_dim == 0 else low + high
            words = [tag, *box, len(groups), *groups] + ([0] if n_dim else [])
            yield " ".join(map(repr, words))
    yield "$EndEntities"


def _element_lines(entities: list[Entity], number: IntArray) -> Iterator[str]:
    n_blocks = sum(len(blocks) for _, _, blocks in entities)
    n_elements = sum(len(nodes) for _, _, blocks in entities for _, nodes in blocks)
    yield from ("$Elements", f"{n_blocks} {n_elements} 1 {n_elements}")
    tags, element = [0] * 4, 0
    for n_dim, _, blocks in entities:
        tags[n_dim] += 1
        for kind, nodes in blocks:
            yield f"{n_dim} {tags[n_dim]} {kind.gmsh} {len(nodes)}"
            for row in number[nodes].tolist():
                element += 1
                yield f"{element} {' '.join(map(str, row))}"
    yield "$EndElements"
