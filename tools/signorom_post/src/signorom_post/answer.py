# SPDX-License-Identifier: BSD-3-Clause
"""What a trained model says, as data."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from signorom_post.arrays import BoolArray, FloatArray, IntArray
from signorom_post.errors import InputError


class ModelError(InputError):
    """A model that cannot be read or cannot answer."""


class NoAnswerError(Exception):
    """A point at which the model has no answer."""


def pressure_of(multipliers: FloatArray, areas: FloatArray) -> FloatArray:
    """Force over area of contacts, their last dimension; NaN where a contact has no area."""
    return multipliers / np.where(areas > 0, areas, np.nan)


@dataclass(frozen=True)
class Parameter:
    """A parameter and the range in which the model was trained."""

    name: str
    unit: str
    minimum: float
    maximum: float


@dataclass(frozen=True)
class ContactNodes:
    """Nodes of one side of the contacts; those of contact i are the entries from starts[i] up to starts[i + 1]."""

    #: shape (n_contacts + 1)
    starts: IntArray
    #: of the mesh file; on the first side the node that carries the contact's force comes first; none: a rigid obstacle
    tags: IntArray
    #: share of the contact's force on each node, shape of `tags`
    weights: FloatArray
    #: [length unit of the model] shape (len(tags), n_dimensions)
    coordinates: FloatArray


@dataclass(frozen=True)
class Resultants:
    """What contact forces come to on each contact of the deck; of many answers with a dimension for these in front.

    Units are those of the model: length (but of plane models: its square), force, force times length.
    """

    #: area that touches, shape (n_entries)
    areas: FloatArray
    #: resultant on the first surface, shape (n_entries, n_dimensions); in axisymmetry the sums of F_r and F_z
    forces: FloatArray
    #: its moment about the origin on the undeformed mesh, shape (n_entries, 3), but of plane and axisymmetric models
    #: (n_entries, 1): x F_y - y F_x, r F_z - z F_r
    moments: FloatArray


@dataclass(frozen=True)
class Cells:
    """Mesh of a model that answers fields; nodes count from 0, those of cell i are nodes[starts[i]:starts[i + 1]].

    The elements are gmsh's by their number of nodes: T3, Q4, T6, Q8, Q9 in the plane, T4, H8, T10, H20, H27 in space.
    """

    #: shape (n_cells + 1)
    starts: IntArray
    nodes: IntArray
    #: region of each cell, an index of region_names, -1 where it has none; shape (n_cells)
    regions: IntArray
    region_names: list[str]
    #: facets of the surfaces that carry the contact forces, and the contact of the deck of each, from 0
    facet_starts: IntArray
    facet_nodes: IntArray
    facet_contacts: IntArray


@dataclass(frozen=True)
class Fields:
    """What a model says at one point on its whole mesh, under the names of fields.h5.

    Six components are xx, yy, zz, xy, yz, xz; in axisymmetry x = r, y = z, and zz is the hoop direction.
    """

    #: values of the parameters
    point: dict[str, float]
    #: shape (n_nodes, n_dimensions)
    displacement: FloatArray
    #: means of the cells, shapes (n_cells, 6) and (n_cells)
    stress: FloatArray
    von_mises: FloatArray
    #: what temperatures and swelling impose: means of the cells, components of the tensor, shape (n_cells, 6)
    imposed_strain: FloatArray
    #: at the nodes, shapes (n_nodes, 6) and (n_nodes)
    stress_smoothed: FloatArray
    von_mises_smoothed: FloatArray
    #: force of the other body on each node, shape (n_nodes, n_dimensions)
    contact_force: FloatArray
    #: 0 off the contacts, shape (n_nodes)
    contact_pressure: FloatArray
    #: NaN off the contacts, shape (n_nodes)
    gap: FloatArray
    #: of the nodes: 0 no contact, 1 open, 2 closed; shape (n_nodes)
    status: IntArray
    #: of the cells: 0 no contact at their nodes, 1 open, 2 closed, 3 closed at some nodes; shape (n_cells)
    contact_status: IntArray
    #: area of each contact of the deck that touches, shape (n_entries)
    contact_area: FloatArray
    #: unit of each of these
    units: dict[str, str]


@dataclass(frozen=True)
class Gradient:
    """How an answer changes with each parameter, while contacts that push stay closed and open ones stay open.

    Units are those of the answer over those of the parameter. The first dimension of each array is that of `parameters`.
    """

    #: names, in the model's order
    parameters: list[str]
    #: of the contact forces, shape (n_parameters, n_contacts)
    multipliers: FloatArray
    #: of the resultants, shapes (n_parameters, n_entries, n_dimensions) and (n_parameters, n_entries, n_moments)
    forces: FloatArray
    moments: FloatArray
    #: of the displacement of the nodes that the query asked for, NaN where there is none; shape (n_parameters, n_nodes,
    #: n_dimensions)
    displacement: FloatArray
    #: the derivative on the other side is another one: a contact grazes, or an expression of the deck has a kink here;
    #: shape (n_parameters)
    is_one_sided: BoolArray
    #: contacts that touch without a force
    n_grazing: int


@dataclass(frozen=True)
class Answer:
    """What the model says at one point; arrays are the caller's own."""

    #: values of the parameters
    point: dict[str, float]
    #: force of each contact [force unit of the model], shape (n_contacts)
    multipliers: FloatArray
    #: contact area, resultant force and moment of each contact of the deck
    resultants: Resultants
    #: the multipliers in the reduced integration domain of this cluster only, shape (n_domain_contacts)
    domain_multipliers: FloatArray
    #: which contacts these are, counted from 0
    domain_contacts: IntArray
    #: displacement of each node, or of the chosen ones [length unit of the model], NaN where there is none; shape
    #: (n_nodes, n_dimensions)
    displacement: FloatArray
    #: reduced coordinates, shape (n_modes)
    coordinates: FloatArray
    #: active_set, block_pivoting, lemke, or condensed: the full-order operator answered
    method: str
    #: which local model answered, counted from 0, and which would be next; None where there is one only
    cluster: int
    next_cluster: int | None
    #: linear solves and pivots
    n_iterations: int
    #: the point lies in the trained box; outside, the answer is an extrapolation
    is_inside_box: bool
    #: to the nearest training point, the sides of the box taken as 1
    distance: float
    #: largest violation of the contact conditions of the dense problem, relative: rounding, not the error of the model
    residual: float
    #: solutions of the reduced problem that two starts found; 2: it has several, and the forces are less reliable
    n_solutions: int
    #: certificate: the contact forces are no farther from the full-order ones, in the norm of the energy
    #: [sqrt(force * length)]; None where the model cannot give one
    bound: float | None
    #: the same over the size of the forces, at least a thousandth of the largest in training; at most 1e-12: exact
    relative_bound: float | None
    #: the same of the displacement in the norm of the stiffness [sqrt(force * length)], rigid motions of bodies that
    #: only contact holds left out; None where the model cannot give one
    displacement_bound: float | None
    #: the same over the size of the displacement, at least a thousandth of the largest in training
    relative_displacement_bound: float | None
    #: asks the model for derivatives in a direction
    _differentiate: Callable[[int], Gradient] = field(repr=False, compare=False)
    _areas: FloatArray = field(repr=False, compare=False)

    @cached_property
    def gradient(self) -> Gradient:
        """Derivatives with respect to the parameters; where they are one-sided, those towards larger values.

        Those of a hyper-reduced model are the derivatives of the full-order operator that it keeps. NoAnswerError where
        there are none: a hyper-reduced model without that operator, a load that jumps at the point. The model is asked
        at the first access, so it must still be open.
        """
        return self._differentiate(1)

    @cached_property
    def backward_gradient(self) -> Gradient:
        """The same; where derivatives are one-sided, those towards smaller values."""
        return self._differentiate(-1)

    @cached_property
    def pressure(self) -> FloatArray:
        """Contact pressures [force unit / area], NaN where a contact has no area; shape (n_contacts)."""
        return pressure_of(self.multipliers, self._areas)

    @property
    def contact_force(self) -> float:
        """Sum of the contact forces."""
        return float(self.multipliers.sum())
