# SPDX-License-Identifier: BSD-3-Clause
"""Writes a mesh in each of gmsh's formats, by the description in gmsh's manual."""

import struct

from block_meshes import DIMENSIONS, GMSH_TYPES

#: (version, binary)
FORMATS = [(version, binary) for version in ("2.0", "2.1", "2.2", "4.0", "4.1") for binary in (False, True)]


class Stream:
    """Collects numbers as text or as bytes."""

    def __init__(self, is_binary, order="<", size="Q"):
        """Begins without content; byte order and kind of a size as `struct` names them."""
        self.is_binary, self.content = is_binary, b""
        self.order, self.size = order, size

    def line(self, text):
        """Adds a line that is text in both kinds of files."""
        self.content += f"{text}\n".encode()

    def put(self, kinds, *values):
        """Adds numbers; `kinds` has a letter for each: i int, n size_t, d double."""
        if self.is_binary:
            self.content += struct.pack(self.order + kinds.replace("n", self.size), *values)
        else:
            self.line(" ".join(repr(value) for value in values))

    def end(self, name):
        """Ends a section."""
        self.line(f"{chr(10) if self.is_binary else ''}$End{name}")


def groups_of(mesh):
    """Returns the sorted groups (dimension, name) of a mesh; the place of a group, from 1, is its number."""
    return sorted({(DIMENSIONS[kind], name) for kind, name, _ in mesh.elements})


def write_as(mesh, path, version, is_binary=False, grouping="named", order="<", size="Q"):
    """Writes a mesh of block_meshes as gmsh's format `version`.

    `grouping`: `named`; `numbered`, physical groups without names; `none`, without physical groups. An entity has the
    number of its group plus 100. Node i (from 0) has the number 3 i + 2, so that there are holes. Binary files have the
    byte order `order` and sizes of the kind `size`: "Q", or "I" as 32-bit machines write format 4.1.
    """
    out = Stream(is_binary, order, size)
    out.line("$MeshFormat")
    out.line(f"{version} {int(is_binary)} {struct.calcsize(size)}")
    if is_binary:
        out.put("i", 1)
    out.end("MeshFormat")
    groups = groups_of(mesh)
    if grouping == "named":
        out.line("$PhysicalNames")
        out.line(len(groups))
        for i, (n_dim, name) in enumerate(groups, 1):
            # format 2.0 has no dimension
            out.line(f'{i} "{name}"' if version == "2.0" else f'{n_dim} {i} "{name}"')
        out.line("$EndPhysicalNames")
    if version < "4":
        write_2(mesh, groups, out, grouping, version)
    else:
        write_4(mesh, groups, out, grouping, version)
    path.write_bytes(out.content)


def write_2(mesh, groups, out, grouping, version):
    """Writes nodes and elements of formats 2.0 to 2.2."""
    out.line("$Nodes")
    out.line(len(mesh.coordinates))
    for i, place in enumerate(mesh.coordinates.tolist()):
        out.put("iddd", 3 * i + 2, *place)
    out.end("Nodes")
    out.line("$Elements")
    out.line(len(mesh.elements))
    for i, (kind, name, nodes) in enumerate(mesh.elements, 1):
        group = groups.index((DIMENSIONS[kind], name)) + 1
        # a third tag, the partition, is usual before 2.2
        tags = [0 if grouping == "none" else group, group + 100, *([0] if version < "2.2" else [])]
        numbers = [3 * node + 2 for node in nodes]
        head = [GMSH_TYPES[kind], 1, len(tags), i] if out.is_binary else [i, GMSH_TYPES[kind], len(tags)]
        out.put("i" * (len(head) + len(tags) + len(numbers)), *head, *tags, *numbers)
    out.end("Elements")


def write_4(mesh, groups, out, grouping, version):
    """Writes entities, nodes and elements of formats 4.0 and 4.1."""
    is_old = version == "4.0"
    out.line("$Entities")
    out.put("nnnn", *(sum(n_dim == i for n_dim, _ in groups) for i in range(4)))
    for i, (n_dim, _) in enumerate(groups, 1):
        n_box = 6 if n_dim > 0 or is_old else 3
        physical = [] if grouping == "none" else [i]
        kinds = "i" + "d" * n_box + "n" + "i" * len(physical) + ("n" if n_dim > 0 else "")
        out.put(kinds, i + 100, *[0.0] * n_box, len(physical), *physical, *([0] if n_dim > 0 else []))
    out.end("Entities")
    write_nodes_4(mesh, groups, out, is_old)
    out.line("$Elements")
    n_blocks, n = len(mesh.elements), len(mesh.elements)
    out.put("nn", n_blocks, n) if is_old else out.put("nnnn", n_blocks, n, 1, n)
    for i, (kind, name, nodes) in enumerate(mesh.elements, 1):
        key = (DIMENSIONS[kind], groups.index((DIMENSIONS[kind], name)) + 101)
        out.put("iiin", *(reversed(key) if is_old else key), GMSH_TYPES[kind], 1)
        numbers = [3 * node + 2 for node in nodes]
        out.put(("i" if is_old else "n") * (1 + len(nodes)), i, *numbers)
    out.end("Elements")


def write_nodes_4(mesh, groups, out, is_old):
    """Writes all nodes in one block, which belongs to the entity of the last group."""
    n = len(mesh.coordinates)
    key = (groups[-1][0], len(groups) + 100)
    out.line("$Nodes")
    out.put("nn", 1, n) if is_old else out.put("nnnn", 1, n, 2, 3 * n - 1)
    out.put("iiin", *(reversed(key) if is_old else key), 0, n)
    if is_old:
        for i, place in enumerate(mesh.coordinates.tolist()):
            out.put("iddd", 3 * i + 2, *place)
    else:
        for i in range(n):
            out.put("n", 3 * i + 2)
        for place in mesh.coordinates.tolist():
            out.put("ddd", *place)
    out.end("Nodes")
