# SPDX-License-Identifier: BSD-3-Clause
"""fields.h5: the mesh, and the fields of a few parameter points."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from signorom_post.arrays import FloatArray, IntArray, Quantity, format_number
from signorom_post.contact import Contact, ContactSide
from signorom_post.errors import InputError
from signorom_post.mesh import Faces, Mesh
from signorom_post.readers.hdf5_input import Hdf5Input
from signorom_post.readers.topology import XDMF_CELLS, cells_of_mixed, drawn_nodes


@dataclass(frozen=True)
class FieldPoint:
    """The fields at one parameter point."""

    label: str
    parameter_names: list[str]
    #: shape (n_parameters)
    parameters: FloatArray
    #: by dataset name; of nodes (n_nodes) or (n_nodes, 3), cells (n_cells[, n]), pairs (n_contacts)
    fields: dict[str, Quantity]

    @property
    def reduced_rows(self) -> IntArray:
        """Pairs whose multiplier the reduced model that answers computes, 0-based; none where there is no model."""
        if "rows_in_reduced_domain" not in self.fields:
            return np.empty(0, dtype=np.int64)
        return np.flatnonzero(self.fields["rows_in_reduced_domain"].values)


@dataclass(frozen=True)
class FieldFile:
    """Everything in fields.h5; indices are 0-based."""

    path: Path
    mesh: Mesh
    points: list[FieldPoint]
    contact: Contact

    def field(self, point: FieldPoint, name: str) -> Quantity:
        """A field of a point, or an error that names the file."""
        if name not in point.fields:
            raise InputError(self.path, f"the point '{point.label}' has no field '{name}'")
        return point.fields[name]

    @property
    def contact_faces(self) -> Faces:
        """Outer faces of solid cells whose nodes all carry a contact force."""
        faces = self.mesh.outer_faces
        return faces.take(np.flatnonzero(np.isin(faces.nodes, self.contact.owners).all(axis=1)))


def read_fields(path: Path) -> FieldFile:
    """Read and check fields.h5."""
    with Hdf5Input(path) as file:
        file.check_format("signorom fields", 3)
        mesh = _read_mesh(file)
        contact = _read_contact(file, mesh.n_nodes)
        points = [
            _read_point(file, f"/points/{name}", mesh, contact.n_rows) for name in file.names("/points")
        ]
    return FieldFile(path, mesh, points, contact)


def _read_contact(file: Hdf5Input, n_nodes: int) -> Contact:
    if not file.has("/contact"):
        side = ContactSide(np.zeros(1, dtype=np.int64), np.empty(0, dtype=np.int64), np.empty(0))
        return Contact(side, side, np.empty(0))
    areas = file.reals("/contact/areas", 1)
    return Contact(
        _read_side(file, "/contact/first", n_nodes, areas.size, n_least=1),
        _read_side(file, "/contact/second", n_nodes, areas.size, n_least=0),
        areas,
    )


def _read_side(file: Hdf5Input, group: str, n_nodes: int, n_rows: int, n_least: int) -> ContactSide:
    starts = file.integers(f"{group}/starts")
    nodes = file.indices(f"{group}/nodes", n_nodes)
    weights = file.reals(f"{group}/weights", 1)
    if starts.size != n_rows + 1 or starts[0] != 0 or starts[-1] != nodes.size or nodes.size != weights.size:
        raise file.fail(f"the datasets of '{group}' and '/contact/areas' do not fit each other")
    if np.any(np.diff(starts) < n_least):
        raise file.fail(f"'{group}/starts' does not ascend")
    return ContactSide(starts, nodes, weights)


def _read_mesh(file: Hdf5Input) -> Mesh:
    coordinates = file.reals("/mesh/coordinates", 2)
    if coordinates.shape[1] != 3:
        raise file.fail(f"'/mesh/coordinates' has {coordinates.shape[1]} columns; 3 are needed")
    is_plane = bool(np.ptp(coordinates[:, 2]) == 0.0) if len(coordinates) else False
    if file.quantity("/mesh/topology").values.ndim == 2:
        topology = file.integers("/mesh/topology", 2)
        n_dim = 2 if is_plane or topology.shape[1] == 3 else 3
        cells = [drawn_nodes(cell, n_dim) for cell in topology]
    else:
        mixed, dimensions = cells_of_mixed(file, file.integers("/mesh/topology"), XDMF_CELLS)
        cells = [drawn_nodes(cell, n_dim) for cell, n_dim in zip(mixed, dimensions, strict=True)]
        n_dim = max(dimensions, default=2)
    if not cells:
        raise file.fail("the mesh has no cells")
    nodes = np.concatenate(cells)
    if nodes.min() < 0 or nodes.max() >= len(coordinates):
        raise file.fail(f"'/mesh/topology' has a node outside 0..{len(coordinates) - 1}")
    return Mesh(coordinates, cells, n_dim, file.unit("/mesh/coordinates"))


def _read_point(file: Hdf5Input, group: str, mesh: Mesh, n_contacts: int) -> FieldPoint:
    parameters = file.attribute(group, "parameters")
    names = file.attribute(group, "parameter_names")
    if parameters is None or names is None:
        raise file.fail(f"'{group}' lacks the attribute 'parameters' or 'parameter_names'")
    values = np.atleast_1d(np.asarray(parameters, dtype=np.float64))
    names = names.replace(",", " ").split() if isinstance(names, str) else list(names)
    if len(names) != len(values):
        raise file.fail(f"'{group}' has {len(values)} parameters and {len(names)} parameter names")
    label = file.attribute(group, "label") or ", ".join(
        f"{name} = {format_number(value)}" for name, value in zip(names, values, strict=True)
    )
    fields = {
        name: file.quantity(f"{group}/{name}")
        for name in file.names(group)
        if file.is_dataset(f"{group}/{name}")
    }
    _check_lengths(file, group, fields, mesh, n_contacts)
    return FieldPoint(str(label), names, values, fields)


def _check_lengths(
    file: Hdf5Input, group: str, fields: dict[str, Quantity], mesh: Mesh, n_contacts: int
) -> None:
    expected = {
        "displacement": mesh.n_nodes,
        "displacement_reduced": mesh.n_nodes,
        "contact_force": mesh.n_nodes,
        "contact_pressure": mesh.n_nodes,
        "gap": mesh.n_nodes,
        "reduced_domain": mesh.n_cells,
        "multipliers_full_order": n_contacts,
        "multipliers_reduced": n_contacts,
        "rows_in_reduced_domain": n_contacts,
    }
    for name, length in expected.items():
        if name in fields and len(np.atleast_1d(fields[name].values)) != length:
            found = len(np.atleast_1d(fields[name].values))
            raise file.fail(f"'{group}/{name}' has {found} entries; {length} are needed")
