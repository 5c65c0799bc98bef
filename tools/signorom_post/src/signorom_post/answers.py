# SPDX-License-Identifier: BSD-3-Clause
"""Data of the answers of a trained model at many points, as arrays."""

from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any

import numpy as np

from signorom_post.answer import Resultants, pressure_of
from signorom_post.arrays import BoolArray, FloatArray, IntArray, TextArray


@dataclass(frozen=True, eq=False)
class Answers:
    """The answers of a model at many points, one row per point.

    Those of Model.query_history have the time as second axis behind the point.

    The arrays are copies: a later query does not change them. At points without an answer, real numbers are NaN,
    except for points, distance, and the resultants of a contact of the deck that has only inert pairs, which are 0.
    """

    #: values of the parameters, shape (n_points, n_parameters)
    points: FloatArray
    #: whether the model has an answer, shape (n_points)
    has_answer: BoolArray
    #: force of each contact [force unit of the model], shape (n_points, n_contacts)
    multipliers: FloatArray
    #: contact area, resultant force and moment of each contact of the deck; the first dimension of the arrays is
    #: n_points
    resultants: Resultants
    #: displacement of the nodes that the query asked for (default: none) [length unit of the model], NaN at nodes
    #: without a displacement; shape (n_points, n_nodes, n_dimensions)
    displacement: FloatArray
    #: solver that answered: active_set, block_pivoting, lemke, condensed, or none if there is no answer. This array and
    #: all that follow have the shape (n_points)
    method: TextArray
    #: number of the local model that was chosen, from 0, as in Answer
    cluster: IntArray
    #: whether the point lies in the trained box; outside of it, the answer is an extrapolation
    is_inside_box: BoolArray
    #: distance to the nearest training point, with all parameters scaled so that the box has sides of length 1
    distance: FloatArray
    #: largest relative violation of the contact conditions of the problem that was solved. It shows rounding errors of
    #: the solver, not the error of the model
    residual: FloatArray
    #: number of different solutions of the reduced problem that two starts of the solver found; 0 without an answer
    n_solutions: IntArray
    #: certificates as in Answer, but NaN where Answer has None, and at points without an answer
    bound: FloatArray
    relative_bound: FloatArray
    displacement_bound: FloatArray
    relative_displacement_bound: FloatArray
    #: as in Answer; 0 without an answer
    n_free_motions: IntArray
    #: estimate of the error as in Answer, but NaN where Answer has None, and at points without an answer
    error_estimate: FloatArray
    _areas: FloatArray = field(repr=False)
    _n_normal: int = field(repr=False)

    @cached_property
    def pressure(self) -> FloatArray:
        """Contact pressures [force unit / area unit], shape (n_points, n_contacts).

        NaN at points without an answer, at contacts without an area, and at tangential forces.
        """
        return pressure_of(self.multipliers, self._areas)

    @property
    def contact_force(self) -> FloatArray:
        """Sum of the sizes of all normal contact forces at each point, whatever their directions; shape (n_points).

        The unit is the force unit of the model. NaN at points without an answer.
        """
        return self.multipliers[..., : self._n_normal].sum(axis=-1)

    def __len__(self) -> int:
        return len(self.points)


def with_time_axis(answers: Answers, shape: tuple[int, int]) -> Answers:
    """Returns answers of states, point by point and time by time, with the first axis divided into `shape`.

    `shape` is (n_points, n_times).
    """
    parts: dict[str, Any] = {
        part.name: np.reshape(getattr(answers, part.name), shape + getattr(answers, part.name).shape[1:])
        for part in fields(answers)
        if part.name not in ("resultants", "_areas", "_n_normal")
    }
    sums = (answers.resultants.areas, answers.resultants.forces, answers.resultants.moments)
    parts["resultants"] = Resultants(*(np.reshape(values, shape + values.shape[1:]) for values in sums))
    return replace(answers, **parts)
