# SPDX-License-Identifier: BSD-3-Clause
"""The first surface of each contact, with the contact pressure: from contact.h5, else from what fields.h5 has."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from signorom_post.arrays import FloatArray, IntArray, Quantity, pressure_unit
from signorom_post.readers.fields import FieldFile
from signorom_post.readers.hdf5_input import Hdf5Input
from signorom_post.readers.topology import XDMF_CELLS, XDMF_EDGES, cells_of_mixed, drawn_nodes

#: number of nodes of the largest linear line and the largest linear face
LINEAR = {1: 2, 2: 4}
#: forces of contact rows in fields.h5 -> their pressure in contact.h5
PRESSURES = {
    "multipliers_full_order": "contact_pressure",
    "multipliers_reduced": "contact_pressure_reduced",
}


@dataclass(frozen=True)
class ContactSurface:
    """The surface of one contact that carries its forces."""

    #: both surfaces of the entry, `first - second`; empty if the file does not tell it
    name: str
    #: nodes of the mesh (from 0) along each line or around each face
    facets: list[IntArray]

    @property
    def nodes(self) -> IntArray:
        """Nodes of the surface, from 0, each once."""
        return np.unique(np.concatenate(self.facets))


@dataclass(frozen=True)
class ContactSurfaces:
    """All surfaces that carry contact forces, and their forces and pressures at nodes."""

    fields: FieldFile
    surfaces: list[ContactSurface]
    #: whether a facet has nodes that are not corners, so that nodal forces cannot be compared with each other
    is_quadratic: bool
    #: contact.h5 and the nodes of its mesh, from 0; None: pressures are forces over areas
    file: tuple[Path, IntArray] | None = None

    def forces(self, i_point: int, name: str) -> Quantity:
        """Returns the forces `name`, a key of PRESSURES, of the point `i_point` (from 0); nan at nodes without a row.

        InputError if the point does not have them.
        """
        found = self.fields.field(self.fields.points[i_point], name)
        return Quantity(self._at_owners(found.values), found.unit)

    def pressures(self, i_point: int, name: str) -> Quantity:
        """Returns the pressure of the forces `name` as `forces` does; InputError if the file cannot be used."""
        forces = self.forces(i_point, name)
        unit = pressure_unit(forces.unit, self.fields.mesh.unit)
        if self.file is not None:
            path, nodes = self.file
            with Hdf5Input(path) as file:
                place = f"/points/{_groups(file)[i_point]}/{PRESSURES[name]}"
                if file.has(place):
                    values = np.full(len(forces.values), np.nan)
                    values[nodes] = file.reals(place, 1)
                    return Quantity(np.where(np.isnan(forces.values), np.nan, values), unit)
        return Quantity(forces.values / self._at_owners(self.fields.contact.areas), unit)

    def _at_owners(self, of_rows: FloatArray) -> FloatArray:
        values = np.full(self.fields.mesh.n_nodes, np.nan)
        values[self.fields.contact.owners] = of_rows
        return values


def read_surfaces(path: Path, fields: FieldFile) -> ContactSurfaces:
    """Returns the surfaces of contact.h5, the file `path`, or those of `fields` if the file belongs to other points.

    InputError if the file is missing, damaged or inconsistent.
    """
    with Hdf5Input(path) as file:
        file.check_format("signorom fields", 3)
        labels = [file.attribute(f"/points/{group}", "parameters") for group in _groups(file)]
        mesh_nodes = file.indices("/mesh/nodes", np.iinfo(np.int64).max)
        is_same = len(labels) == len(fields.points) and all(
            np.array_equal(np.atleast_1d(label), point.parameters)
            for label, point in zip(labels, fields.points, strict=True)
        )
        if not labels or not is_same or mesh_nodes.max(initial=0) >= fields.mesh.n_nodes:
            return surfaces_of_fields(fields)
        cells, dimensions = _read_cells(file, len(mesh_nodes))
        entries = file.integers(f"/points/{_groups(file)[0]}/contact")
        names = file.texts("/contact/names")
        if len(entries) != len(cells) or entries.max(initial=0) > len(names):
            raise file.fail(
                "'/contact/names', '/mesh/topology' and the field 'contact' do not fit each other"
            )
    drawn = [mesh_nodes[drawn_nodes(cell, n)] for cell, n in zip(cells, dimensions, strict=True)]
    surfaces = [
        ContactSurface(name, [drawn[i] for i in np.flatnonzero(entries == number)])
        for number, name in enumerate(names, start=1)
        if np.any(entries == number)
    ]
    is_quadratic = any(len(cell) > LINEAR.get(n, 1) for cell, n in zip(cells, dimensions, strict=True))
    return ContactSurfaces(fields, surfaces, is_quadratic, (path, mesh_nodes))


def surfaces_of_fields(fields: FieldFile) -> ContactSurfaces:
    """Returns the surfaces that carry contact forces without their names: facets that hang together are one surface."""
    if fields.mesh.n_dim == 3:
        faces = fields.contact_faces
        facets = [nodes[:n] for nodes, n in zip(faces.nodes, faces.n_corners, strict=True)]
    else:
        edges = fields.mesh.boundary_edges
        facets = list(edges[np.isin(edges, fields.contact.owners).all(axis=1)])
    largest = max(len(cell) for cell in fields.mesh.cells)
    labels = joined(facets, fields.mesh.n_nodes)
    surfaces = [
        ContactSurface("", [facets[i] for i in np.flatnonzero(labels == label)])
        for label in np.unique(labels)
    ]
    return ContactSurfaces(fields, surfaces, fields.mesh.n_dim == 2 and largest > LINEAR[2])


def joined(facets: list[IntArray], n_nodes: int) -> IntArray:
    """Returns a number for each facet: facets that share a node, also through others, have the same one."""
    labels = np.arange(n_nodes)
    is_done = False
    while not is_done:
        before = labels.copy()
        for facet in facets:
            labels[facet] = labels[facet].min()
        labels = labels[labels]
        is_done = np.array_equal(before, labels)
    return np.array([labels[facet[0]] for facet in facets], dtype=np.int64)


def _groups(file: Hdf5Input) -> list[str]:
    return sorted(file.names("/points"), key=lambda name: (len(name), name))


def _read_cells(file: Hdf5Input, n_nodes: int) -> tuple[list[IntArray], list[int]]:
    """Returns the nodes of each facet, numbers in the file's own mesh, and the dimension of each facet."""
    if file.quantity("/mesh/topology").values.ndim == 2:
        topology = file.integers("/mesh/topology", 2)
        kinds = file.integers("/mesh/cell_types")
        known = {kind: n_dim for kind, (_, n_dim) in (XDMF_CELLS | XDMF_EDGES).items()}
        cells, dimensions = list(topology), [known.get(int(kind), 0) for kind in kinds]
    else:
        cells, dimensions = cells_of_mixed(file, file.integers("/mesh/topology"), XDMF_CELLS | XDMF_EDGES)
    nodes = np.concatenate([*cells, np.empty(0, dtype=np.int64)])
    if len(cells) != len(dimensions) or (nodes.size and (nodes.min() < 0 or nodes.max() >= n_nodes)):
        raise file.fail("'/mesh/topology' and '/mesh/nodes' do not fit each other")
    return cells, dimensions
