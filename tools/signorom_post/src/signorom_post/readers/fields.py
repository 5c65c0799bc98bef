# SPDX-License-Identifier: BSD-3-Clause
"""Reads fields.h5: the mesh, and the fields of some parameter points."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from signorom_post.arrays import FloatArray, IntArray, Quantity, format_number, without_unit_one
from signorom_post.contact import Contact, ContactSide
from signorom_post.errors import InputError
from signorom_post.mesh import Faces, Mesh
from signorom_post.readers.hdf5_input import Hdf5Input
from signorom_post.readers.topology import XDMF_CELLS, cells_of_mixed, drawn_nodes

#: largest number of points whose fields are all read at once; with more points, a field is read at its first use
MOST_IN_MEMORY = 100


class StoredFields(Mapping[str, Quantity]):
    """The fields of one point of a large file; each field is read and checked at its first use."""

    def __init__(self, path: Path, group: str, names: list[str], lengths: dict[str, int]) -> None:
        self._path = path
        self._group = group
        self._names = names
        self._lengths = lengths
        self._read: dict[str, Quantity] = {}

    def __getitem__(self, name: str) -> Quantity:
        if name not in self._names:
            raise KeyError(name)
        if name not in self._read:
            with Hdf5Input(self._path) as file:
                self._read[name] = _read_field(file, self._group, name, self._lengths)
        return self._read[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)


@dataclass(frozen=True)
class FieldPoint:
    """The fields at one parameter point."""

    label: str
    parameter_names: list[str]
    #: values of the parameters, shape (n_parameters)
    parameters: FloatArray
    #: dataset name -> field. Shapes: of nodes (n_nodes) or (n_nodes, 3), of cells (n_cells) or (n_cells, n), of contact
    #: rows (n_contacts)
    fields: Mapping[str, Quantity]
    #: unit of each parameter; empty if the file does not tell them
    parameter_units: list[str] = field(default_factory=list)

    @property
    def reduced_rows(self) -> IntArray:
        """Contact rows in the domain of the chosen cluster, from 0, also where the fallback answers or nothing does.

        All rows if the model is not hyper-reduced; empty if the file does not have them, as without a model.
        """
        if "rows_in_reduced_domain" not in self.fields:
            return np.empty(0, dtype=np.int64)
        return np.flatnonzero(self.fields["rows_in_reduced_domain"].values)


@dataclass(frozen=True)
class FieldFile:
    """The contents of fields.h5; all indices count from 0."""

    path: Path
    mesh: Mesh
    points: list[FieldPoint]
    contact: Contact

    def field(self, point: FieldPoint, name: str) -> Quantity:
        """Returns a field of a point; InputError if the point does not have it."""
        if name not in point.fields:
            raise InputError(self.path, f"the point '{point.label}' has no field '{name}'")
        return point.fields[name]

    @property
    def contact_faces(self) -> Faces:
        """Outer faces of solid cells whose corners all carry the force of a contact row."""
        faces = self.mesh.outer_faces
        return faces.take(np.flatnonzero(np.isin(faces.nodes, self.contact.owners).all(axis=1)))


def read_fields(path: Path) -> FieldFile:
    """Returns the contents of fields.h5; InputError if the file is missing, damaged or inconsistent.

    With more than 100 points, a field is read and checked only at its first use, which may raise InputError, too.
    """
    with Hdf5Input(path) as file:
        file.check_format("signorom fields", 3)
        mesh = _read_mesh(file)
        contact = _read_contact(file, mesh.n_nodes)
        # sorted by number: 10000 comes after 9999
        names = sorted(file.names("/points"), key=lambda name: (len(name), name))
        lengths = _field_lengths(mesh, contact.n_rows)
        in_memory = len(names) <= MOST_IN_MEMORY
        points = [_read_point(file, f"/points/{name}", lengths, in_memory) for name in names]
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


def _read_point(file: Hdf5Input, group: str, lengths: dict[str, int], in_memory: bool) -> FieldPoint:
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
    fields: Mapping[str, Quantity]
    if in_memory:
        datasets = [name for name in file.names(group) if file.is_dataset(f"{group}/{name}")]
        fields = {name: _read_field(file, group, name, lengths) for name in datasets}
    else:
        fields = StoredFields(file.path, group, file.names(group), lengths)
    units = file.attribute(group, "parameter_units")
    known = units if isinstance(units, list) and len(units) == len(names) else []
    return FieldPoint(without_unit_one(str(label)), names, values, fields, known)


def _field_lengths(mesh: Mesh, n_contacts: int) -> dict[str, int]:
    return {
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


def _read_field(file: Hdf5Input, group: str, name: str, lengths: dict[str, int]) -> Quantity:
    quantity = file.quantity(f"{group}/{name}")
    found = len(np.atleast_1d(quantity.values))
    if name in lengths and found != lengths[name]:
        raise file.fail(f"'{group}/{name}' has {found} entries; {lengths[name]} are needed")
    return quantity
