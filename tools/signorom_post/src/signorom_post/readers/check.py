# SPDX-License-Identifier: BSD-3-Clause
"""Reads check.h5: the set-up of a deck before any solution."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from signorom_post.arrays import FloatArray, IntArray, Quantity, without_unit_one
from signorom_post.errors import InputError
from signorom_post.mesh import Mesh
from signorom_post.readers.hdf5_input import Hdf5Input
from signorom_post.readers.topology import XDMF_CELLS, XDMF_EDGES, cells_of_mixed, drawn_nodes

#: values of the field `kind`: a cell of a body, a facet of a named boundary, a facet of a contact surface, and a line
#: between two nodes of a contact that face each other
BODY, BOUNDARY, SURFACE, LINK = 1, 2, 3, 4
CELL_FIELDS = ("kind", "material", "region", "boundary", "contact", "side", "share")
NODE_VECTORS = ("prescribed", "prescribed_displacement", "load", "contact_normal")
NODE_NUMBERS = ("contact_side", "contact_entry", "contact_row", "gap", "contact_area", "n_partners")
NAMES = ("materials", "regions", "boundaries", "contacts", "model")


@dataclass(frozen=True)
class CheckFile:
    """The contents of check.h5. Indices of nodes and cells count from 0, numbers of contacts and boundaries from 1."""

    path: Path
    #: the cells of the bodies only
    mesh: Mesh
    #: text of the parameter point
    label: str
    #: nodes of each cell of any kind, in the order in which a picture joins them by lines
    cells: list[IntArray]
    #: name -> field, of `cells` with shape (n_cells), or of nodes with shape (n_nodes) or (n_nodes, 3)
    fields: dict[str, Quantity]
    #: key of NAMES -> names of the materials, regions and so on
    names: dict[str, list[str]]

    def __getitem__(self, name: str) -> FloatArray:
        """Returns the values of the field `name`, shaped as in `fields`."""
        return self.fields[name].values

    def of(self, kind: int, **labels: int) -> list[IntArray]:
        """Returns the nodes (from 0) of each cell whose kind is `kind` and whose fields have the values in `labels`.

        `kind` is BODY, BOUNDARY, SURFACE or LINK; `labels` are values by the names of cell fields, such as `contact=1,
        side=2`. The nodes of a cell are in the order in which a picture joins them by lines.
        """
        return [self.cells[i] for i in self.indices(kind, **labels)]

    def indices(self, kind: int, **labels: int) -> IntArray:
        """Returns the indices, from 0 in `cells`, of the cells that `of` chooses by these arguments."""
        is_chosen = self["kind"] == kind
        for name, value in labels.items():
            is_chosen = is_chosen & (self[name] == value)
        return np.flatnonzero(is_chosen)

    @cached_property
    def axis_names(self) -> tuple[str, str, str]:
        """Names of the three coordinates: r, z and an empty text if the model is axisymmetric, else x, y, z."""
        return ("r", "z", "") if self.names["model"] == ["axisymmetric"] else ("x", "y", "z")


def find_check_file(path: Path) -> Path:
    """Returns the path of the file to read, which may be missing.

    It is check.h5 in the folder `path`, for an XDMF file the .h5 file of the same name, and otherwise `path` itself.
    """
    if path.is_dir():
        return path / "check.h5"
    return path.with_suffix(".h5") if path.suffix == ".xdmf" else path


def read_check(path: Path) -> CheckFile:
    """Returns the contents of check.h5, the file `path`.

    InputError if it is missing, damaged or inconsistent, has another format, or has no set-up or no bodies.
    """
    try:
        with Hdf5Input(path) as file:
            file.check_format("signorom fields", 3)
            if not file.has("/check"):
                raise file.fail("the file has no set-up of a deck; `signorom check DECK --fields` writes one")
            return _read(file)
    except InputError as error:
        if path.exists():
            raise
        sentence = f"{error.sentence}; `signorom check DECK --fields` writes one"
        raise InputError(path, sentence) from error


def _read(file: Hdf5Input) -> CheckFile:
    coordinates = file.reals("/mesh/coordinates", 2)
    flat = file.integers("/mesh/topology")
    cells, dimensions = cells_of_mixed(file, flat, XDMF_CELLS | XDMF_EDGES)
    nodes = np.concatenate([*cells, np.empty(0, dtype=np.int64)])
    if coordinates.shape[1] != 3 or (nodes.size and (nodes.min() < 0 or nodes.max() >= len(coordinates))):
        raise file.fail("'/mesh/topology' and '/mesh/coordinates' do not fit each other")
    fields = {
        name: file.quantity(f"/points/0001/{name}") for name in (*CELL_FIELDS, *NODE_VECTORS, *NODE_NUMBERS)
    }
    _check_shapes(file, fields, len(cells), len(coordinates))
    names = {name: file.texts(f"/check/{name}") for name in NAMES}
    drawn = [drawn_nodes(cell, n_dim) for cell, n_dim in zip(cells, dimensions, strict=True)]
    bodies = np.flatnonzero(fields["kind"].values == BODY)
    n_dim = max((dimensions[i] for i in bodies), default=0)
    if n_dim < 2:
        raise file.fail("there are no bodies")
    mesh = Mesh(coordinates, [drawn[i] for i in bodies], n_dim, file.unit("/mesh/coordinates"))
    for entry in range(1, len(names["contacts"]) + 1):
        if not np.any((fields["contact"].values == entry) & (fields["side"].values == 1)):
            raise file.fail(f"contact {entry} has no first surface")
    label = without_unit_one(str(file.attribute("/points/0001", "label") or ""))
    return CheckFile(file.path, mesh, label, drawn, fields, names)


def _check_shapes(file: Hdf5Input, fields: dict[str, Quantity], n_cells: int, n_nodes: int) -> None:
    expected = dict.fromkeys(CELL_FIELDS, (n_cells,)) | dict.fromkeys(NODE_NUMBERS, (n_nodes,))
    expected |= dict.fromkeys(NODE_VECTORS, (n_nodes, 3))
    for name, shape in expected.items():
        if fields[name].values.shape != shape:
            raise file.fail(
                f"'/points/0001/{name}' has the shape {fields[name].values.shape}; {shape} is needed"
            )
