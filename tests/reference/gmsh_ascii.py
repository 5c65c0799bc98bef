# SPDX-License-Identifier: BSD-3-Clause
"""Small reader of plane gmsh 4.1 ASCII meshes of one kind of cell, independent of the program's reader."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

TRIANGLE = 2
QUADRANGLE = 3
TETRAHEDRON = 4
CELLS = (TRIANGLE, QUADRANGLE)
LINE = 1
POINT = 15
N_NODES = {POINT: 1, LINE: 2, TRIANGLE: 3, QUADRANGLE: 4, TETRAHEDRON: 4}


@dataclass
class Mesh:
    """Nodes and cells in the file's order, 0-based; nodes that no cell uses are dropped."""

    coordinates: np.ndarray
    cells: np.ndarray
    node_tags: np.ndarray
    nodes_of: dict = field(default_factory=dict)
    cells_of: dict = field(default_factory=dict)


def sections_of(path):
    """Lines of each `$Section` of the file."""
    sections, name = {}, None
    for line in Path(path).read_text().splitlines():
        if line.startswith("$End"):
            name = None
        elif line.startswith("$"):
            name = line[1:].strip()
            sections[name] = []
        elif name:
            sections[name].append(line)
    return sections


def physical_tags(entities):
    """Physical tags of each (dimension, entity); gmsh manual, MSH file format 4.1, $Entities."""
    n_of_dimension = [int(word) for word in entities[0].split()]
    tags, i_line = {}, 1
    for dimension, n_entities in enumerate(n_of_dimension):
        n_bounds = 3 if dimension == 0 else 6
        for _ in range(n_entities):
            words = entities[i_line].split()
            n_tags = int(words[1 + n_bounds])
            first = 2 + n_bounds
            tags[dimension, int(words[0])] = [abs(int(w)) for w in words[first : first + n_tags]]
            i_line += 1
    return tags


def read_nodes(lines):
    """Tags and plane coordinates in the order of the file."""
    tags, coordinates, i_line = [], [], 1
    for _ in range(int(lines[0].split()[0])):
        n_block = int(lines[i_line].split()[3])
        tags += [int(line) for line in lines[i_line + 1 : i_line + 1 + n_block]]
        i_line += 1 + n_block
        coordinates += [[float(w) for w in line.split()[:2]] for line in lines[i_line : i_line + n_block]]
        i_line += n_block
    return np.array(tags), np.array(coordinates)


def read_mesh(path):
    """Read a version 4.1 ASCII file; cells are reoriented counterclockwise."""
    sections = sections_of(path)
    version, file_type = sections["MeshFormat"][0].split()[:2]
    if version != "4.1" or file_type != "0":
        raise ValueError(f"{path}: expected gmsh 4.1 ASCII")
    names = {}
    for line in sections.get("PhysicalNames", ["0"])[1:]:
        dimension, tag, name = line.split(maxsplit=2)
        names[int(dimension), int(tag)] = name.strip().strip('"')
    physical_of = physical_tags(sections["Entities"])
    tags, coordinates = read_nodes(sections["Nodes"])
    elements = read_elements(sections["Elements"])
    return build_mesh(tags, coordinates, elements, physical_of, names)


def read_elements(lines):
    """(dimension, entity, element type, node tags) of each element."""
    elements, i_line = [], 1
    for _ in range(int(lines[0].split()[0])):
        dimension, entity, element_type, n_block = (int(word) for word in lines[i_line].split())
        for line in lines[i_line + 1 : i_line + 1 + n_block]:
            nodes = [int(word) for word in line.split()[1 : 1 + N_NODES[element_type]]]
            elements.append((dimension, entity, element_type, nodes))
        i_line += 1 + n_block
    return elements


def build_mesh(tags, coordinates, elements, physical_of, names):
    """Number what cells use, in the file's order, and collect the named groups."""
    used = {node for _, _, kind, nodes in elements if kind in CELLS for node in nodes}
    kept = np.array([tag in used for tag in tags])
    tags, coordinates = tags[kept], coordinates[kept]
    number_of = {tag: i for i, tag in enumerate(tags.tolist())}
    cells, nodes_of, cells_of = [], {}, {}
    for dimension, entity, kind, nodes in elements:
        numbers = [number_of[node] for node in nodes if node in number_of]
        groups = [names[dimension, tag] for tag in physical_of.get((dimension, entity), [])]
        for name in groups:
            nodes_of.setdefault(name, set()).update(numbers)
        if kind in CELLS:
            for name in groups:
                cells_of.setdefault(name, []).append(len(cells))
            cells.append(numbers)
    cells = np.array(cells)
    a, b, c = (coordinates[cells[:, i]] for i in range(3))
    area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (c[:, 0] - a[:, 0]) * (b[:, 1] - a[:, 1])
    cells[area < 0, 1:] = cells[area < 0, :0:-1]
    nodes_of = {name: np.array(sorted(nodes)) for name, nodes in nodes_of.items()}
    cells_of = {name: np.array(numbers) for name, numbers in cells_of.items()}
    return Mesh(coordinates, cells, tags, nodes_of, cells_of)
