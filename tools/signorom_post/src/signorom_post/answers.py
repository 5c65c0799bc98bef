# SPDX-License-Identifier: BSD-3-Clause
"""What a trained model says at many points, as arrays."""

from dataclasses import dataclass, field
from functools import cached_property

from signorom_post.answer import Resultants, pressure_of
from signorom_post.arrays import BoolArray, FloatArray, IntArray, TextArray


@dataclass(frozen=True, eq=False)
class Answers:
    """Answers at many points, a row per point; arrays are the caller's own.

    Numbers are NaN where there is no answer.
    """

    #: values of the parameters, shape (n_points, n_parameters)
    points: FloatArray
    #: the model has an answer, shape (n_points)
    has_answer: BoolArray
    #: force of each contact [force unit of the model], shape (n_points, n_contacts)
    multipliers: FloatArray
    #: contact area, resultant force and moment of each contact of the deck, with a row per point
    resultants: Resultants
    #: displacement of the nodes that were asked for [length unit of the model], NaN where a node has none; shape
    #: (n_points, n_nodes, n_dimensions)
    displacement: FloatArray
    #: active_set, block_pivoting, lemke, condensed, or none without an answer; shape (n_points), like all that follow
    method: TextArray
    #: which local model was asked, counted from 0
    cluster: IntArray
    #: the point lies in the trained box; outside, the answer is an extrapolation
    is_inside_box: BoolArray
    #: to the nearest training point, the sides of the box taken as 1
    distance: FloatArray
    #: largest violation of the contact conditions of the dense problem, relative: rounding, not the error of the model
    residual: FloatArray
    #: solutions of the reduced problem that two starts found; 0 without an answer
    n_solutions: IntArray
    #: certificates as in Answer, NaN where the model cannot give one
    bound: FloatArray
    relative_bound: FloatArray
    displacement_bound: FloatArray
    relative_displacement_bound: FloatArray
    _areas: FloatArray = field(repr=False)

    @cached_property
    def pressure(self) -> FloatArray:
        """Contact pressures [force unit / area], NaN where a contact has no area; shape (n_points, n_contacts)."""
        return pressure_of(self.multipliers, self._areas)

    @property
    def contact_force(self) -> FloatArray:
        """Sum of the contact forces at each point, shape (n_points)."""
        return self.multipliers.sum(axis=1)

    def __len__(self) -> int:
        return len(self.points)
