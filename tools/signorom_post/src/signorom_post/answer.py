# SPDX-License-Identifier: BSD-3-Clause
"""What a trained model says, as data."""

from dataclasses import dataclass

from signorom_post.arrays import FloatArray, IntArray
from signorom_post.errors import InputError


class ModelError(InputError):
    """A model that cannot be read or cannot answer."""


class NoAnswerError(Exception):
    """A point at which the model has no answer."""


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

    @property
    def contact_force(self) -> float:
        """Sum of the contact forces."""
        return float(self.multipliers.sum())
