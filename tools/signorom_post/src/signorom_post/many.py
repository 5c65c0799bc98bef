# SPDX-License-Identifier: BSD-3-Clause
"""Asks the online library at many points in one call."""

import ctypes
from ctypes import byref, c_void_p

import numpy as np

from signorom_post.answer import Resultants
from signorom_post.answers import Answers
from signorom_post.arrays import BoolArray, FloatArray, IntArray
from signorom_post.library import METHODS, OK, CAnswer, CArrays, CSizes, doubles, ints


def answers_at(
    library: ctypes.CDLL,
    context: c_void_p,
    sizes: CSizes,
    n_entries: tuple[int, int],
    points: FloatArray,
    nodes: IntArray,
    areas: FloatArray,
    n_normal: int,
) -> Answers:
    """Returns the answers at `points`, shape (n_points, n_parameters).

    `context` and `sizes` are those of the model. `n_entries` is a pair: the numbers of entries of the deck's
    section contact and of components of a moment. `nodes` are the positions, from 0, of the nodes whose displacement is
    wanted, as C ints. `areas`: the area of each contact force, shape (sizes.n_contacts). `n_normal`: the number of
    normal forces. A point without an answer is no error.
    """
    n, n_dimensions = len(points), sizes.n_dimensions
    told = np.zeros(n, dtype=np.dtype(CAnswer))
    told["size"] = ctypes.sizeof(CAnswer)
    multipliers = np.empty((n, sizes.n_contacts))
    resultants = Resultants(
        np.empty((n, n_entries[0])),
        np.empty((n, n_entries[0], n_dimensions)),
        np.empty((n, *n_entries)),
    )
    displacement = np.empty((n, len(nodes), n_dimensions))
    arrays = CArrays(
        size=ctypes.sizeof(CArrays),
        answers=told.ctypes.data,
        multipliers=doubles(multipliers),
        areas=doubles(resultants.areas),
        forces=doubles(resultants.forces),
        moments=doubles(resultants.moments),
        n_nodes=len(nodes),
        nodes=ints(nodes),
        displacement=doubles(displacement) if len(nodes) else None,
    )
    library.signorom_query_arrays(context, n, doubles(points), byref(arrays))
    has_answer = told["code"] == OK
    return Answers(
        points=points,
        has_answer=has_answer,
        multipliers=multipliers,
        resultants=resultants,
        displacement=displacement,
        method=np.array(METHODS)[told["method"]],
        cluster=told["cluster"].astype(np.int64),
        is_inside_box=told["is_inside_box"] != 0,
        distance=told["distance"].copy(),
        residual=np.where(has_answer, told["residual"], np.nan),
        n_solutions=told["n_solutions"].astype(np.int64),
        bound=_known(told["bound"], has_answer),
        relative_bound=_known(told["relative_bound"], has_answer),
        displacement_bound=_known(told["displacement_bound"], has_answer),
        relative_displacement_bound=_known(told["relative_displacement_bound"], has_answer),
        n_free_motions=told["n_free_motions"].astype(np.int64),
        error_estimate=_known(told["error_estimate"], has_answer),
        _areas=areas,
        _n_normal=n_normal,
    )


def _known(bounds: FloatArray, has_answer: BoolArray) -> FloatArray:
    """Returns bounds or estimates, NaN at points without an answer or without a bound or an estimate."""
    return np.where(has_answer & (bounds >= 0), bounds, np.nan)
