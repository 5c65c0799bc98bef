# SPDX-License-Identifier: BSD-3-Clause
"""Data of the answers of a trained model: forces, resultants, fields, derivatives, certificates."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from signorom_post.arrays import BoolArray, FloatArray, IntArray
from signorom_post.errors import InputError


class ModelError(InputError):
    """A model that cannot be read or cannot answer."""


class NotAcceptedWarning(UserWarning):
    """The validation of a model did not accept it; the text is its verdict."""


class FreeMotionWarning(UserWarning):
    """No contact force holds a body at the point: its displacement and its gaps are one of many possible."""


class InaccurateFieldsWarning(UserWarning):
    """The displacement of an answer has an error of more than 1 %, in the norm of the stiffness; so have stresses."""


class NoAnswerError(Exception):
    """The model has no answer at a point, or cannot give what was asked for."""


def pressure_of(multipliers: FloatArray, areas: FloatArray) -> FloatArray:
    """Returns the contact pressures: `multipliers`, shape (..., n_contacts), over `areas`, shape (n_contacts).

    The pressure of a contact without an area is NaN.
    """
    return multipliers / np.where(areas > 0, areas, np.nan)


@dataclass(frozen=True)
class Parameter:
    """A parameter and the range in which the model was trained, in the unit of the deck (empty if it has none)."""

    name: str
    unit: str
    minimum: float
    maximum: float


@dataclass(frozen=True)
class ContactNodes:
    """The nodes of one side of all contacts.

    Those of contact i, from 0, are the entries starts[i] to starts[i + 1] - 1 of the other three arrays.
    """

    #: first entry of each contact, from 0, and the number of all entries at the end; shape (n_contacts + 1)
    starts: IntArray
    #: numbers of the nodes in the mesh file. On the first side, the node that carries the contact's force comes first.
    #: A contact with a rigid obstacle has no nodes on the second side
    tags: IntArray
    #: share of the contact's force on each node, same shape as `tags`. The shares of a contact on one side sum up to 1
    #: and may be negative
    weights: FloatArray
    #: coordinates of the nodes [length unit of the model], shape (len(tags), n_dimensions)
    coordinates: FloatArray


@dataclass(frozen=True)
class Resultants:
    """Contact area, resultant force and moment of each entry of the deck's section `contact`.

    The arrays are empty if an earlier version wrote the model file. The arrays of many answers have one more dimension
    in front, for the points. Units are those of the model. An area has the unit of a length in plane models, and else
    of a length squared.
    """

    #: area of the contacts that carry a force, shape (n_entries)
    areas: FloatArray
    #: resultant force on the first surface of the entry, shape (n_entries, n_dimensions); in axisymmetry the sums of
    #: F_r and F_z
    forces: FloatArray
    #: moment of the forces about the origin on the undeformed mesh. Shape (n_entries, 3) in space. In plane and
    #: axisymmetric models (n_entries, 1), which is x F_y - y F_x or r F_z - z F_r
    moments: FloatArray


@dataclass(frozen=True)
class Cells:
    """The mesh that a model keeps for fields. Nodes count from 0.

    The number of nodes gives the type of an element: T3, Q4, T6, Q8, Q9 in the plane; T4, P5, W6, H8, T10, P13, P14,
    W15, W18, H20, H27 in space. The nodes of an element are in gmsh's order.
    """

    #: the nodes of cell i are nodes[starts[i]:starts[i + 1]]; shape (n_cells + 1)
    starts: IntArray
    nodes: IntArray
    #: region of each cell as an index of `region_names`, -1 if it has none; shape (n_cells)
    regions: IntArray
    region_names: list[str]
    #: facets of the surfaces that carry the contact forces: the nodes of facet i are
    #: facet_nodes[facet_starts[i]:facet_starts[i + 1]]
    facet_starts: IntArray
    facet_nodes: IntArray
    #: number of the contact of the deck to which each facet belongs, from 0; shape (n_facets)
    facet_contacts: IntArray


@dataclass(frozen=True)
class Fields:
    """The fields of an answer at one point on the whole mesh; they have the same names as in fields.h5.

    The six components of a tensor are xx, yy, zz, xy, yz, xz. In axisymmetry x is r, y is z, and zz is the hoop
    direction.
    """

    #: values of the parameters
    point: dict[str, float]
    #: displacement, NaN at nodes without one; shape (n_nodes, n_dimensions)
    displacement: FloatArray
    #: stress and von Mises stress, means of the cells, shapes (n_cells, 6) and (n_cells)
    stress: FloatArray
    von_mises: FloatArray
    #: strain that temperature and swelling impose, means of the cells, components of the tensor, shape (n_cells, 6)
    imposed_strain: FloatArray
    #: stress and von Mises stress at the nodes, smoothed, shapes (n_nodes, 6) and (n_nodes)
    stress_smoothed: FloatArray
    von_mises_smoothed: FloatArray
    #: force of the other body on each node, shape (n_nodes, n_dimensions)
    contact_force: FloatArray
    #: contact pressure at each node, 0 at nodes without a contact, shape (n_nodes)
    contact_pressure: FloatArray
    #: gap that is left after the displacement, NaN at nodes without a contact, shape (n_nodes)
    gap: FloatArray
    #: status of each node: 0 no contact, 1 open, 2 closed, 4 tied; shape (n_nodes)
    status: IntArray
    #: status of each cell: 0 no contact at its nodes, 1 open, 2 closed, 3 open at some nodes, 4 tied; shape (n_cells)
    contact_status: IntArray
    #: Resultants.areas of this answer, shape (n_entries)
    contact_area: FloatArray
    #: name of a field -> its unit
    units: dict[str, str]
    #: as in Answer: the error of the displacement; that of the stresses is of this size on the average over the part
    displacement_bound: float | None
    relative_displacement_bound: float | None
    #: with friction, else None: friction over area, and slip since the last time, both of the node's own surface, shape
    #: (n_nodes, n_dimensions)
    tangential_traction: FloatArray | None = None
    slip: FloatArray | None = None
    #: status of each node: 0 no contact, 1 open, 2 sticks, 3 slips (also closed without friction), 4 tied
    friction_status: IntArray | None = None
    #: where some material has plasticity, else None: accumulated equivalent plastic strain, plastic strain (a tensor),
    #: means of the cells, shapes (n_cells) and (n_cells, 6), and the equivalent strain at the nodes,
    #: smoothed, shape (n_nodes)
    plastic_strain: FloatArray | None = None
    plastic_strain_tensor: FloatArray | None = None
    plastic_strain_smoothed: FloatArray | None = None
    #: where some material creeps, else None: the same of creep
    creep_strain: FloatArray | None = None
    creep_strain_tensor: FloatArray | None = None
    creep_strain_smoothed: FloatArray | None = None


@dataclass(frozen=True)
class Gradient:
    """Derivatives of an answer with respect to each parameter.

    They hold as long as contacts with a force stay closed and open contacts stay open. Those of a hyper-reduced model
    are the derivatives of the full-order solution at the point, by its full-order operator, and not of its own answer.
    The unit of a derivative is the unit of the answer over that of the parameter. The first dimension of each array
    counts the parameters.
    """

    #: names of the parameters, in the model's order
    parameters: list[str]
    #: derivatives of the contact forces, shape (n_parameters, n_contacts)
    multipliers: FloatArray
    #: derivatives of the resultant forces, shape (n_parameters, n_entries, n_dimensions)
    forces: FloatArray
    #: derivatives of the resultant moments, shape (n_parameters, n_entries, n_moments)
    moments: FloatArray
    #: derivatives of the displacement of the nodes that the query asked for (default: all), NaN at nodes without a
    #: displacement, and at nodes of bodies that no contact force holds beside the point (Answer.n_free_motions). If
    #: the model cannot differentiate the displacement of one of the nodes, all are NaN. Shape (n_parameters, n_nodes,
    #: n_dimensions)
    displacement: FloatArray
    #: relative error of the derivative of the displacement in the norm of the stiffness: a bound, over the size of the
    #: derivative or, if that is larger, a thousandth of the largest displacement in training over the range of the
    #: parameter; -1: not known, as wherever the displacement itself has no bound. Shape (n_parameters)
    displacement_errors: FloatArray
    #: whether the derivatives towards larger and smaller values of a parameter differ. This happens where a contact
    #: touches without a force, or where an expression of the deck has a kink; shape (n_parameters)
    is_one_sided: BoolArray
    #: number of contacts that touch without a force (grazing contacts) at the point
    n_grazing: int


@dataclass(frozen=True)
class Answer:
    """The answer of a model at one point. The arrays are copies: a later query does not change them."""

    #: values of the parameters
    point: dict[str, float]
    #: force of each contact [force unit of the model], shape (n_contacts)
    multipliers: FloatArray
    #: contact area, resultant force and moment of each contact of the deck
    resultants: Resultants
    #: force of each contact in the reduced integration domain of the local model `cluster`, shape (n_domain_contacts);
    #: of each contact if the model is not hyper-reduced
    domain_multipliers: FloatArray
    #: numbers of these contacts, from 0, shape (n_domain_contacts)
    domain_contacts: IntArray
    #: displacement of the nodes that the query asked for, in their order, or of all, in the order of Model.nodes
    #: [length unit of the model], NaN at nodes without a displacement; shape (n_nodes, n_dimensions)
    displacement: FloatArray
    #: reduced coordinates of the local model `cluster` [length unit of the model], shape (n_modes), which may be (0);
    #: NaN if the full-order operator answered and they do not exist
    coordinates: FloatArray
    #: solver that answered: active_set, block_pivoting or lemke on the reduced integration domain, or condensed on all
    #: contacts. `condensed` is the full-order operator of a hyper-reduced model, and the usual solver of other models
    method: str
    #: number of the local model that was chosen, from 0. If `method` is condensed, a hyper-reduced model has answered
    #: by its full-order operator in place of this local model
    cluster: int
    #: number of the local model that is second in the choice, from 0; None if there is only one
    next_cluster: int | None
    #: number of linear solves and pivots
    n_iterations: int
    #: whether the point lies in the trained box; outside of it, the answer is an extrapolation
    is_inside_box: bool
    #: distance to the nearest training point, with all parameters scaled so that the box has sides of length 1
    distance: float
    #: largest relative violation of the contact conditions of the problem that was solved. It shows rounding errors of
    #: the solver, not the error of the model
    residual: float
    #: number of different solutions of the reduced problem that two starts of the solver found. 2 means that the
    #: solution is not unique, so that the forces are less reliable
    n_solutions: int
    #: certificate: upper bound of the error of the contact forces in the energy norm [sqrt(force * length)]; None if
    #: the model cannot give one for this answer, 1.8e308 (the largest number) if the error may be of any size
    bound: float | None
    #: `bound` over the size of the forces, which counts as at least a thousandth of the largest size in training. If it
    #: is at most 1e-12, the forces are exact. None as for `bound`, or if all forces are 0, here and in training
    relative_bound: float | None
    #: certificate: upper bound of the error of the displacement in the norm of the stiffness [sqrt(force * length)],
    #: without rigid motions of bodies that only contact holds; None if the model cannot give one for this answer,
    #: 1.8e308 as in `bound`
    displacement_bound: float | None
    #: `displacement_bound` over the size of the displacement, which counts as at least a thousandth of the largest size
    #: in training. None as for `displacement_bound`, or if all displacements are 0, here and in training
    relative_displacement_bound: float | None
    #: number of independent rigid motions of bodies that only contact holds which no contact force holds at this point.
    #: If it is not 0, the displacement and the gaps of these bodies are one of many possible; forces and stresses are
    #: not affected
    n_free_motions: int
    #: estimate of the error of the contact forces, relative to their size, where materials yield or creep: how far the
    #: forces moved when the laws of the materials were asked at all points, over the size of the forces after that. It
    #: is an estimate and no bound; None if the model gives none
    error_estimate: float | None
    #: returns the derivatives towards larger (1) or smaller (-1) values of the parameters
    _differentiate: Callable[[int], Gradient] = field(repr=False, compare=False)
    _areas: FloatArray = field(repr=False, compare=False)
    _n_normal: int = field(repr=False, compare=False)

    @cached_property
    def gradient(self) -> Gradient:
        """Derivatives with respect to the parameters; if they are one-sided, those towards larger values.

        A hyper-reduced model gives the derivatives of its full-order operator. NoAnswerError if it has no such operator
        or if this has no answer at the point, if a load or an expression of the deck jumps at the point, has no finite
        slope there or no value beside it, if the contact forces are not unique, if contacts that touch without a force
        leave no solution beside the point, or if beside it the loads move a body that no contact force holds here. The
        first access computes the derivatives; ValueError if the model is closed then.
        """
        return self._differentiate(1)

    @cached_property
    def backward_gradient(self) -> Gradient:
        """As `gradient`, with the same types of exceptions. One-sided derivatives are those towards smaller values."""
        return self._differentiate(-1)

    @cached_property
    def pressure(self) -> FloatArray:
        """Contact pressures [force unit / area unit], NaN without an area, as at tangential forces; (n_contacts)."""
        return pressure_of(self.multipliers, self._areas)

    @property
    def contact_force(self) -> float:
        """Sum of the sizes of all normal contact forces, whatever their directions [force unit of the model].

        `resultants` has the forces as vectors, with friction.
        """
        return float(self.multipliers[: self._n_normal].sum())
