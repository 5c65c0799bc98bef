# SPDX-License-Identifier: BSD-3-Clause
"""The named groups of a converted mesh: regions of cells, boundaries of outer faces, lines and points."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from signorom_post.arrays import BoolArray, IntArray
from signorom_post.convert.cells import Cells, Faces, corner_key, find_cells, outer_faces, smooth_pieces
from signorom_post.convert.elements import BY_NAME, KINDS, Kind
from signorom_post.convert.source import Source, Unique, element_numbers
from signorom_post.convert.split import Seam, split


@dataclass
class Group:
    """A named group. Members are cells (of the dimension of the mesh) or outer faces (one less)."""

    name: str
    n_dim: int
    members: IntArray
    #: of lower dimensions: kind and nodes of its elements
    kind: Kind | None = None
    nodes: IntArray | None = None


@dataclass
class Converted:
    """The mesh to be written, and what the table says of it."""

    cells: Cells
    faces: Faces
    groups: list[Group] = field(default_factory=list)
    #: (what, became) of each set of the source
    rows: list[tuple[str, str]] = field(default_factory=list)
    #: (what, why)
    left_out: list[tuple[str, str]] = field(default_factory=list)

    def regions(self) -> list[Group]:
        """Returns the groups of cells."""
        return [group for group in self.groups if group.n_dim == self.cells.n_dim]


def convert(source: Source, pairs: Sequence[tuple[str, str]] = ()) -> Converted:
    """Returns the mesh of a source with its names. Both regions of each pair get nodes of their own.

    InputError: those of find_cells and of split.
    """
    cells = find_cells(source)
    made = _Making(source, cells)
    made.add_regions()
    regions = {group.name: group.members for group in made.groups}
    seams = [split(cells, regions, *pair, source.path) for pair in pairs]
    made.find_faces()
    for seam in seams:
        made.add_seam(seam)
    made.add_boundaries()
    made.add_sides()
    made.note_rest()
    return Converted(cells, made.faces, made.groups, made.rows, made.left_out)


class _Making:
    """Makes the groups one after the other."""

    faces: Faces

    def __init__(self, source: Source, cells: Cells) -> None:
        self._source, self._cells = source, cells
        self.groups: list[Group] = []
        self.rows: list[tuple[str, str]] = []
        self.left_out: list[tuple[str, str]] = []
        self._region_names, self._boundary_names = Unique(), Unique()
        self._cell_of_element = np.full(source.n_elements, -1)
        self._cell_of_element[cells.element] = np.arange(cells.n_cells)
        self._is_told = np.zeros(source.n_elements, dtype=bool)
        self._is_told[cells.element] = True
        self._starts = np.cumsum([0] + [len(elements.nodes) for elements in source.elements])

    # -- regions

    def add_regions(self) -> None:
        """Adds a region for each element set with cells, and others for the cells in none."""
        is_named = np.zeros(self._cells.n_cells, dtype=bool)
        for name, elements in self._source.element_sets.items():
            cells = self._cells_of(elements)
            if len(cells):
                self._add_region(f"element set {name}", name, cells)
                is_named[cells] = True
        for name, elements in self._source.bodies.items():
            cells = self._cells_of(elements)
            cells = cells[~is_named[cells]]
            if len(cells):
                self._add_region(f"elements of {name}", name, cells)
                is_named[cells] = True
        self._add_bodies(np.flatnonzero(~is_named))

    def _add_bodies(self, cells: IntArray) -> None:
        """Adds a region for the cells of each body that no set names."""
        body = self._cells.bodies()[cells]
        for i, which in enumerate(np.unique(body), 1):
            self._add_region("cells in no element set", f"body_{i}", cells[body == which])

    def _add_region(self, what: str, name: str, cells: IntArray) -> None:
        name = self._region_names.take(name)
        self.groups.append(Group(name, self._cells.n_dim, cells))
        self.rows.append((what, f"region {name}: {count(len(cells), 'cell')}"))

    def _cells_of(self, elements: IntArray) -> IntArray:
        cells = self._cell_of_element[elements]
        return cells[cells >= 0]

    # -- boundaries

    def find_faces(self) -> None:
        """Finds the outer faces; the cells must have their final nodes."""
        self.faces = outer_faces(self._cells)
        self._faces_at: dict[tuple[int, ...], list[int]] = {}
        origin = np.append(self._cells.origin, -1)
        for n_corners in (2, 3, 4):
            which = np.flatnonzero(_corner_counts(self.faces) == n_corners)
            keys = corner_key(origin[self.faces.nodes[which]], n_corners)
            for i, key in zip(which.tolist(), keys.tolist(), strict=True):
                self._faces_at.setdefault(tuple(key), []).append(i)

    def add_seam(self, seam: Seam) -> None:
        """Adds the new boundary of each of two regions that were split."""
        is_split = np.isin(self._cells.origin, seam.nodes)
        self.rows.append(
            (f"split of {seam.regions}", f"{count(len(seam.nodes), 'node')} doubled{seam.remark}")
        )
        for name, cells in seam.sides:
            is_of_side = np.zeros(self._cells.n_cells, dtype=bool)
            is_of_side[cells] = True
            own = is_of_side[self.faces.cell]
            faces = self.faces.all_nodes_in(is_split)
            faces = faces[own[faces]]
            if len(faces) == 0:  # they shared a line or a point: the whole sides around it
                piece = smooth_pieces(self.faces, self._cells.coordinates)
                touching = self.faces.any_node_in(is_split)
                pieces = np.unique(piece[touching[own[touching]]])
                faces = np.flatnonzero(np.isin(piece, pieces) & own)
            self._add_faces(f"split of {seam.regions}", name, faces, "")

    def add_boundaries(self) -> None:
        """Adds a boundary for each surface, each element set of sides, lines or points, and each node set."""
        for name, faces in self._source.face_sets.items():
            found, n_inner = self._match(faces)
            self._add_faces(f"surface {name}", name, found, _inner(n_inner))
        for name, elements in self._source.element_sets.items():
            self._add_lower(name, elements)
        for name, nodes in self._source.node_sets.items():
            self._add_node_set(name, nodes)

    def _match(self, faces: IntArray) -> tuple[IntArray, int]:
        """Returns the outer faces that are those of a face set, shape (n, 2), and how many others there are."""
        found, n_inner = [], 0
        for i_block, elements in enumerate(self._source.elements):
            start, end = self._starts[i_block], self._starts[i_block + 1]
            for row in faces[(faces[:, 0] >= start) & (faces[:, 0] < end)]:
                nodes, cell = elements.nodes[row[0] - start], self._cell_of_element[row[0]]
                if row[1] < 0 and cell >= 0:
                    found += self._faces_of_cell(int(cell))
                    continue
                if row[1] < 0:
                    key, self._is_told[row[0]] = corner_key(nodes[None], elements.kind.n_corners), True
                else:
                    side, places = elements.kind.sides[row[1]]
                    key = corner_key(nodes[places][None], side.n_corners)
                here = self._faces_at.get(tuple(key[0].tolist()), [])
                here = [i for i in here if cell < 0 or self.faces.cell[i] == cell]
                found += here
                n_inner += not here
        return element_numbers([found]), n_inner

    def _faces_of_cell(self, cell: int) -> list[int]:
        first, last = np.searchsorted(self.faces.cell, [cell, cell + 1])
        return list(range(first, last))

    def _add_lower(self, name: str, elements: IntArray) -> None:
        """Adds the sides, lines and points of an element set: sides as outer faces, the others as they are."""
        for i_block, block in enumerate(self._source.elements):
            start, end = self._starts[i_block], self._starts[i_block + 1]
            inside = elements[(elements >= start) & (elements < end)]
            if len(inside) == 0 or block.kind.n_dim == self._cells.n_dim:
                continue
            if block.kind.n_dim == self._cells.n_dim - 1:
                whole = np.column_stack([inside, np.full_like(inside, -1)])
                found, n_inner = self._match(whole)
                if len(found):
                    self._add_faces(f"element set {name}", name, found, _inner(n_inner))
                else:
                    self._is_told[inside] = False
            else:
                self._add_elements(
                    f"element set {name}", name, block.kind, block.nodes[inside - start], inside
                )

    def _add_elements(
        self, what: str, name: str, kind: Kind, nodes: IntArray, elements: IntArray | None = None
    ) -> None:
        """Adds lines or points as a group of their own, if all their nodes belong to cells."""
        used = self._cells.used_nodes()
        is_on = used[nodes].all(axis=1)
        if not is_on.any():
            if elements is None:
                self.left_out.append((what, "none of its nodes belongs to a cell"))
            return
        if elements is not None:
            self._is_told[elements[is_on]] = True
        name = self._boundary_names.take(name)
        self.groups.append(Group(name, kind.n_dim, np.empty(0, dtype=np.int64), kind, nodes[is_on]))
        noun = "line" if kind.n_dim == 1 else "point"
        self.rows.append((what, f"boundary {name}: {count(int(is_on.sum()), noun)}"))

    def _add_node_set(self, name: str, nodes: IntArray) -> None:
        """Adds the outer faces all of whose nodes are in a node set; without such a face, its nodes as points."""
        inside = np.zeros(len(self._source.coordinates), dtype=bool)
        inside[nodes] = True
        inside = inside[self._cells.origin]
        used = self._cells.used_nodes()
        if inside[used].all():
            self.left_out.append((f"node set {name}", "it holds all nodes of the mesh"))
            return
        faces = self.faces.all_nodes_in(inside)
        if len(faces) == 0:
            points = np.flatnonzero(inside & used)[:, None]
            self._add_elements(f"node set {name}", name, BY_NAME["point"], points)
            return
        self._add_faces(f"node set {name}", name, faces, self._strays(inside & used, faces), "_nodes")

    def _strays(self, inside: BoolArray, faces: IntArray) -> str:
        """Returns a remark about nodes of a set that are on none of its faces."""
        nodes = self.faces.nodes[faces]
        inside = inside.copy()
        inside[nodes[nodes >= 0]] = False
        n = int(inside.sum())
        return f"; {count(n, 'node')} on none of them left out" if n else ""

    def _add_faces(self, what: str, name: str, faces: IntArray, remark: str, ending: str = "") -> None:
        """Adds a boundary of outer faces. If its name is taken, it gets the ending, or is left out as the same faces."""
        if len(faces) == 0:
            self.left_out.append((what, f"none of its faces is an outer face of a cell{remark}"))
            return
        same = [group for group in self._boundaries() if group.name == name]
        if same and np.array_equal(same[0].members, faces):
            self.rows.append((what, f"the same faces as boundary {name}"))
            return
        name = self._boundary_names.take(f"{name}{ending}" if same else name)
        self.groups.append(Group(name, self._cells.n_dim - 1, faces))
        noun = "face" if self._cells.n_dim == 3 else "edge"
        self.rows.append((what, f"boundary {name}: {count(len(faces), noun)}{remark}"))

    def _boundaries(self) -> Iterator[Group]:
        return (group for group in self.groups if group.n_dim == self._cells.n_dim - 1)

    def add_sides(self) -> None:
        """Gives the sides of bodies that no set names, not even a part of them, boundaries that end at sharp edges."""
        bodies = self._cells.bodies()
        piece = smooth_pieces(self.faces, self._cells.coordinates)
        named = element_numbers(group.members for group in self._boundaries())
        is_bare = ~np.isin(piece, piece[named])
        body_of_face = bodies[self.faces.cell]
        for body in np.unique(body_of_face[is_bare]).tolist():
            name = self._name_of_body(np.flatnonzero(bodies == body), body)
            for i, which in enumerate(np.unique(piece[is_bare & (body_of_face == body)]), 1):
                faces = np.flatnonzero(piece == which)
                self._add_faces(f"side of {name}, in no set", f"{name}_side_{i}", faces, "")

    def _name_of_body(self, cells: IntArray, body: int) -> str:
        """Returns the name of the region that has exactly these cells, else `body_1`, ..."""
        for group in self.groups:
            if group.n_dim == self._cells.n_dim and np.array_equal(group.members, cells):
                return group.name
        return f"body_{body + 1}"

    # -- the rest

    def note_rest(self) -> None:
        """Notes which elements are in no group, and what the reader left out."""
        used = self._cells.used_nodes()
        counts: dict[str, tuple[int, int]] = {}
        for i, elements in enumerate(self._source.elements):
            left = ~self._is_told[self._starts[i] : self._starts[i + 1]]
            on_cells = int(used[elements.nodes[left]].any(axis=1).sum()) if left.any() else 0
            n, n_on_cells = counts.get(elements.label, (0, 0))
            counts[elements.label] = (n + int(left.sum()), n_on_cells + on_cells)
        for label, (n, n_on_cells) in counts.items():
            if n:
                shared = f"; {n_on_cells} of them share nodes with cells" if n_on_cells else ""
                self.left_out.append(
                    (
                        f"{label}: {count(n, 'element')}",
                        f"not cells of dimension {self._cells.n_dim}, and not named sides of such{shared}",
                    )
                )
        n_unused = int((~used[: len(self._source.coordinates)]).sum())
        if n_unused:
            self.left_out.append((count(n_unused, "node"), "they belong to no cell"))
        self.left_out += self._source.left_out.items()


def _corner_counts(faces: Faces) -> IntArray:
    """Returns the number of corners of each face."""
    return np.array([kind.n_corners for kind in KINDS])[faces.kinds]


def _inner(n: int) -> str:
    """Returns a remark about faces that are not outer ones."""
    return f"; {n} not at the outside left out" if n else ""


def count(n: int, noun: str) -> str:
    """Returns such as `1 face` or `12 faces`."""
    return f"{n} {noun}{'' if n == 1 else 's'}"
