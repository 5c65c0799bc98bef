# SPDX-License-Identifier: BSD-3-Clause
"""Reads the parts of model.h5, the reduced model, that the figures need."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from signorom_post.arrays import FloatArray, IntArray, as_number
from signorom_post.readers.hdf5_input import Hdf5Input


@dataclass(frozen=True)
class Cluster:
    """One local hyper-reduced model; all indices count from 0."""

    #: its number as text, from 1
    name: str
    #: singular values of its snapshots, descending, shape (m)
    singular_values: FloatArray
    #: number of columns of the basis: POD modes and hats
    n_modes: int
    #: nodes that DEIM and the zones of interest chose
    seed_nodes: IntArray
    #: nodes on the other contact surface that face seed nodes
    facing_nodes: IntArray
    #: cells of the reduced integration domain
    cells: IntArray
    #: contact rows in the domain, whose forces the model solves for
    contact_rows: IntArray
    #: kappa (11), nan if the file does not have it
    condition_number: float
    #: condition number of the reduced stiffness, nan if the file does not have it
    stiffness_condition: float
    #: its snapshots, as indices of the model's training points
    training_points: IntArray


@dataclass(frozen=True)
class Model:
    """The parts of a model file that the figures need."""

    path: Path
    title: str
    length_unit: str
    force_unit: str
    parameter_names: list[str]
    parameter_units: list[str]
    #: limits of the trained box [unit of each parameter], shape (n_parameters)
    minimum: FloatArray
    maximum: FloatArray
    #: shape (n_training_points, n_parameters)
    training_points: FloatArray
    #: hyper-reduced local models; a condensed model has none
    clusters: list[Cluster]
    #: tolerance of the POD: the basis may lose less than this share of the energy (20)
    pod_tolerance: float
    #: the effective deck; empty if its text is not YAML
    deck: dict[str, Any]

    @property
    def _mechanical_model(self) -> str:
        mesh = self.deck.get("mesh")
        return str(mesh.get("model", "")) if isinstance(mesh, dict) else ""

    @property
    def axis_names(self) -> tuple[str, str]:
        """Names of the first two coordinates: r and z if the model is axisymmetric, else x and y."""
        return ("r", "z") if self._mechanical_model == "axisymmetric" else ("x", "y")

    @property
    def energy_unit(self) -> str:
        """Unit of an elastic energy, in plane models of an energy per thickness.

        Empty if the file lacks the unit of lengths or of forces, or its deck lacks the mechanical model.
        """
        kind = self._mechanical_model
        if not (self.force_unit and self.length_unit and kind):
            return ""
        unit = f"{self.force_unit} {self.length_unit}"
        return f"{unit}/{self.length_unit}" if kind.startswith("plane") else unit

    def unit_of(self, parameter: str) -> str:
        """Returns the unit of a parameter as the deck gives it; empty if the parameter is unknown or has no unit."""
        units = dict(zip(self.parameter_names, self.parameter_units, strict=True))
        return units.get(parameter, "")


def read_model(path: Path) -> Model:
    """Returns the contents of model.h5; InputError if the file is missing, damaged or inconsistent."""
    with Hdf5Input(path) as file:
        file.check_format("signorom model", 7, oldest=6)
        names = file.texts("/parameters/names")
        units = file.texts("/parameters/units")
        points = file.reals("/parameters/training_points", 2)
        if len(units) != len(names) or points.shape[1] != len(names):
            raise file.fail("'/parameters' holds names, units and training points of different lengths")
        parts = sorted(file.names("/clusters"), key=lambda n: (len(n), n))
        if not parts:
            raise file.fail("the model has no clusters ('/clusters/1')")
        clusters = [
            _read_cluster(file, name)
            for name in parts
            if file.attribute(f"/clusters/{name}", "kind") == "hhr"
        ]
        return Model(
            path=path,
            title=file.text("/title"),
            length_unit=file.text("/units/length"),
            force_unit=file.text("/units/force"),
            parameter_names=names,
            parameter_units=units,
            minimum=file.reals("/parameters/minimum", 1),
            maximum=file.reals("/parameters/maximum", 1),
            training_points=points,
            clusters=clusters,
            pod_tolerance=float(file.reals("/reduction/pod_tolerance", 0)),
            deck=_parse_deck(file.text("/deck")),
        )


def _read_cluster(file: Hdf5Input, name: str) -> Cluster:
    group = f"/clusters/{name}"
    unlimited = np.iinfo(np.int64).max
    condition_number = as_number(file.attribute(group, "condition_number"))
    stiffness_condition = as_number(file.attribute(group, "stiffness_condition"))
    return Cluster(
        name=name,
        singular_values=file.reals(f"{group}/singular_values", 1),
        n_modes=len(file.reals(f"{group}/basis", 2)),
        seed_nodes=file.indices(f"{group}/seed_nodes", unlimited),
        facing_nodes=file.indices(f"{group}/facing_nodes", unlimited),
        cells=file.indices(f"{group}/cells", unlimited),
        contact_rows=file.indices(f"{group}/contact_rows", unlimited),
        condition_number=np.nan if condition_number is None else condition_number,
        stiffness_condition=np.nan if stiffness_condition is None else stiffness_condition,
        training_points=file.indices(f"{group}/training_points", unlimited),
    )


def _parse_deck(text: str) -> dict[str, Any]:
    try:
        deck = yaml.safe_load(text)
    except yaml.YAMLError:
        return {}
    return deck if isinstance(deck, dict) else {}
