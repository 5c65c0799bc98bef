# SPDX-License-Identifier: BSD-3-Clause
"""Checks of the parameter points of a query: whether they are valid, and whether they lie in the trained box."""

import warnings
from collections.abc import Mapping, Sequence

import numpy as np

from signorom_post.answer import FreeMotionWarning, InaccurateFieldsWarning, Parameter
from signorom_post.arrays import BoolArray, FloatArray


class ExtrapolationWarning(UserWarning):
    """A query lies outside of the box in which the model was trained."""


#: error of a displacement in the norm of the stiffness above which fields cause a warning, as in predict
LARGE_ERROR = 0.01


def point_of(parameters: Sequence[Parameter], values: Mapping[str, float]) -> FloatArray:
    """Returns the values of the parameters in the model's order, shape (n_parameters).

    `values` has them by name. TypeError if a parameter is missing or unknown, ValueError if a value is not finite.
    """
    names = [parameter.name for parameter in parameters]
    for name in values:
        if name not in names:
            raise TypeError(f"unknown parameter '{name}'; the parameters are {', '.join(names)}")
    for name in names:
        if name not in values:
            raise TypeError(f"no value for the parameter '{name}'")
    point = np.array([float(values[name]) for name in names])
    for name, value in zip(names, point, strict=True):
        if not np.isfinite(value):
            raise ValueError(f"the parameter '{name}' must be a finite number, not {value}")
    return point


def points_of(parameters: Sequence[Parameter], points: FloatArray) -> FloatArray:
    """Returns the points as a contiguous array of real numbers, shape (n_points, n_parameters).

    ValueError if they have another shape, or if a value is not finite.
    """
    given = np.array(points, dtype=float, order="C")
    if given.ndim != 2 or given.shape[1] != len(parameters):
        raise ValueError(f"points must have shape (n_points, {len(parameters)}), not {given.shape}")
    is_finite = np.isfinite(given)
    if not is_finite.all():
        row, column = np.argwhere(~is_finite)[0]
        name = parameters[column].name
        raise ValueError(
            f"the parameter '{name}' must be a finite number; at points[{row}] it is {given[row, column]}"
        )
    return given


def warn_outside(
    parameters: Sequence[Parameter], points: FloatArray, is_inside: BoolArray, stack_level: int = 3
) -> None:
    """Issues one ExtrapolationWarning if a point lies outside of the trained box.

    The warning names each parameter that leaves its range at these points, with its lowest and highest value outside
    of the range. `points` has the shape (n_points, n_parameters). `is_inside`, shape (n_points): whether a point lies in
    the box. `stack_level` is that of `warnings.warn`, so that the warning names the line of the caller.
    """
    if is_inside.all():
        return
    outside = points[~is_inside]
    lowest = np.array([parameter.minimum for parameter in parameters])
    highest = np.array([parameter.maximum for parameter in parameters])
    is_beyond = (outside < lowest) | (outside > highest)
    named = [
        f"{parameter.name} ({_range_of(outside[is_beyond[:, k], k], parameter)}) lies outside of {range_of(parameter)}"
        for k, parameter in enumerate(parameters)
        if is_beyond[:, k].any()
    ]
    where = f" at {len(outside)} of {len(points)} points" if len(points) > 1 else ""
    warnings.warn(
        f"the model extrapolates{where}: {', '.join(named)}",
        ExtrapolationWarning,
        stacklevel=stack_level,
    )


def warn_unheld(n_free_motions: int, stack_level: int = 3) -> None:
    """Issues a FreeMotionWarning if a motion of a body is free. `stack_level` is as in warn_outside."""
    if n_free_motions:
        warnings.warn(
            "no contact force holds a body at this point: its displacement and its gaps are one of many possible; "
            "forces and stresses are not affected",
            FreeMotionWarning,
            stacklevel=stack_level,
        )


def warn_inaccurate(bound: float | None, stack_level: int = 3) -> None:
    """Issues an InaccurateFieldsWarning if a displacement is inaccurate.

    `bound` is the relative_displacement_bound of an answer; `stack_level` is as in warn_outside.
    """
    if bound is not None and bound > LARGE_ERROR:
        warnings.warn(
            f"the error of the displacement at this point may be {bound:.2g} in the norm of the stiffness: "
            "displacements and stresses are not accurate there",
            InaccurateFieldsWarning,
            stacklevel=stack_level,
        )


def range_of(parameter: Parameter) -> str:
    """Returns the text of a parameter's trained range, such as `5 to 200 MPa`; the units `-` and `1` are left out."""
    unit = "" if parameter.unit in ("", "-", "1") else f" {parameter.unit}"
    return f"{parameter.minimum:.6g} to {parameter.maximum:.6g}{unit}"


def _range_of(values: FloatArray, parameter: Parameter) -> str:
    """Returns the lowest and highest value, with all digits where fewer would show an end of the parameter's range."""
    ends = {f"{end:.6g}" for end in (parameter.minimum, parameter.maximum)}
    texts = [f"{value:.6g}" for value in (values.min(), values.max())]
    if not ends.isdisjoint(texts):
        texts = [repr(float(value)) for value in (values.min(), values.max())]
    return texts[0] if texts[0] == texts[1] else " to ".join(texts)
