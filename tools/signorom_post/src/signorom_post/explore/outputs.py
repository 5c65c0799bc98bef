# SPDX-License-Identifier: BSD-3-Clause
"""The numbers of an answer that people read and draw over a parameter: contact forces, areas, moments, pressures."""

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import yaml

from signorom_post.answer import Answer, Gradient, NoAnswerError
from signorom_post.answers import Answers
from signorom_post.arrays import BoolArray, FloatArray, pressure_unit
from signorom_post.explore.exploration import DISPLACEMENTS, FORCES, STRESSES, Exploration, Look
from signorom_post.online import Model
from signorom_post.points import ExtrapolationWarning


@dataclass(frozen=True)
class Output:
    """A number of an answer. Those of contacts have the names of the columns of `signorom predict`."""

    name: str
    label: str
    unit: str
    #: what must be right for it: FORCES, DISPLACEMENTS or STRESSES
    needs: str
    #: the number of an answer, or an array of those of many answers
    of: Callable[[Answer | Answers], FloatArray]
    #: the derivative over parameter k; None if the model gives none, as of areas, which jump
    slope_of: Callable[[Gradient, int], float] | None = None


@dataclass(frozen=True)
class Curve:
    """An output over one parameter, or over the time of a history, with all other parameters held."""

    #: name and unit of what varies
    name: str
    unit: str
    output: Output
    #: values of what varies, and of the output there, NaN without an answer; shape (n)
    at: FloatArray
    values: FloatArray
    #: which of the points lie inside the trained box, shape (n)
    is_inside: BoolArray
    #: where the exploration stands: value of what varies, of the output, and the derivative; None: there is none
    here: tuple[float, float] | None
    slope: float | None


def outputs_of(model: Model) -> list[Output]:
    """Returns all outputs of a model, those of all contacts together first."""
    found = [
        Output(
            "contact_force",
            "sum of normal contact forces",
            model.force_unit,
            FORCES,
            lambda answer: np.asarray(answer.contact_force),
            _sum_slope(model),
        )
    ]
    pressure = model.stress_unit or pressure_unit(model.force_unit, model.length_unit)
    found.append(
        Output("force_over_area", "largest contact force over its area", pressure, FORCES, _largest_pressure)
    )
    axes = axis_names(model)
    area = model.area_unit or (
        model.length_unit if len(axes) == 2 and "r" not in axes else f"{model.length_unit}2"
    )
    moments = axes if len(axes) == 3 else ("z",)
    for i, name in enumerate(model.contact_names):
        start = f"contact_{i + 1}"
        found.append(Output(f"{start}_area", f"{name}: area", area, FORCES, _resultant("areas", i)))
        for kind, unit, components in (
            ("force", model.force_unit, axes),
            ("moment", moment_unit(model), moments),
        ):
            found += [
                Output(
                    f"{start}_{kind}_{axis}",
                    f"{name}: {kind} {axis}",
                    unit,
                    FORCES,
                    _resultant(f"{kind}s", i, k),
                    _resultant_slope(f"{kind}s", i, k),
                )
                for k, axis in enumerate(components)
            ]
    return found


def _resultant(kind: str, *place: int) -> Callable[[Answer | Answers], FloatArray]:
    return lambda answer: np.asarray(getattr(answer.resultants, kind)[(..., *place)])


def _resultant_slope(kind: str, *place: int) -> Callable[[Gradient, int], float]:
    return lambda gradient, k: float(getattr(gradient, kind)[(k, *place)])


def _sum_slope(model: Model) -> Callable[[Gradient, int], float]:
    contacts = model.force_contacts
    is_normal = contacts == np.arange(len(contacts)) if len(contacts) else slice(None)
    return lambda gradient, k: float(gradient.multipliers[k][is_normal].sum())


def _largest_pressure(answer: Answer | Answers) -> FloatArray:
    """Returns the largest pressure of any contact; NaN without an answer."""
    pressure = np.where(np.isnan(answer.multipliers), np.nan, np.nan_to_num(answer.pressure, nan=-np.inf))
    return np.asarray(pressure.max(axis=-1))


def axis_names(model: Model) -> tuple[str, ...]:
    """Returns the names of the axes of forces: x, y, z in space, x, y in the plane, r, z in axisymmetry."""
    deck = yaml.safe_load(model.deck)
    if isinstance(deck, dict) and deck.get("mesh", {}).get("model") == "axisymmetric":
        return ("r", "z")
    return ("x", "y", "z")[: model.nodes[1].shape[1]]


def moment_unit(model: Model) -> str:
    """Returns the unit of moments: N mm, or N of a plane model with forces in N/mm."""
    force, length = model.force_unit, model.length_unit
    return force.removesuffix(f"/{length}") if force.endswith(f"/{length}") else f"{force} {length}".strip()


@dataclass(frozen=True)
class Number:
    """A number of a look, for a table."""

    name: str
    label: str
    unit: str
    #: None: there is no answer
    value: float | None
    #: whether nothing speaks against it
    is_vouched_for: bool


def numbers_of(exploration: Exploration, outputs: Sequence[Output], look: Look) -> list[Number]:
    """Returns all outputs at a look, then the largest values of its fields; without an answer their values are None."""
    numbers = [
        Number(
            output.name,
            output.label,
            output.unit,
            None if look.answer is None else float(output.of(look.answer)),
            not look.speaks_against(output.needs),
        )
        for output in outputs
    ]
    if exploration.cells is None:
        return numbers
    found: Mapping[str, float] = {}
    if look.fields is not None:
        found = {
            "contact_pressure": float(np.nanmax(look.fields.contact_pressure)),
            "von_mises": float(np.nanmax(look.fields.von_mises_smoothed)),
            "displacement": _largest_length(look.fields.displacement),
        }
    model = exploration.model
    for name, label, unit, needs in (
        ("contact_pressure", "largest contact pressure", model.stress_unit, FORCES),
        ("von_mises", "largest von Mises stress", model.stress_unit, STRESSES),
        ("displacement", "largest displacement", model.length_unit, DISPLACEMENTS),
    ):
        numbers.append(
            Number(f"largest_{name}", label, unit, found.get(name), not look.speaks_against(needs))
        )
    return numbers


def _largest_length(vectors: FloatArray) -> float:
    lengths = np.linalg.norm(vectors, axis=1)
    return float(np.nanmax(lengths)) if np.isfinite(lengths).any() else float("nan")


def curve_of(exploration: Exploration, output: Output, over: str, look: Look, n_points: int = 61) -> Curve:
    """Returns an output over the parameter named `over`, or over the `time` of a history, around a look.

    The curve spans the trained range, and the point of the look if this lies outside. The derivative is that of the
    model at the look. Points without an answer are NaN; ValueError if a table is not valid at a point.
    """
    place, unit, at, here = _varied(exploration, over, look, n_points)
    with warnings.catch_warnings():  # the curve shows where it extrapolates
        warnings.simplefilter("ignore", ExtrapolationWarning)
        values, is_inside = _values_along(exploration.model, output, look, place, at)
    value = None if look.answer is None else float(output.of(look.answer))
    standing = None if value is None or here is None else (here, value)
    return Curve(over, unit, output, at, values, is_inside, standing, slope_at(output, look, place))


def _varied(
    exploration: Exploration, over: str, look: Look, n_points: int
) -> tuple[int, str, FloatArray, float | None]:
    """Returns number (from 0) and unit of the parameter `over`, its values along a curve, and that of the look."""
    names = [parameter.name for parameter in exploration.parameters]
    if over == "time":
        return len(names), exploration.model.parameters[len(names)].unit, exploration.model.times, look.time
    place = names.index(over)
    parameter, here = exploration.parameters[place], look.point[over]
    ends = min(parameter.minimum, here), max(parameter.maximum, here)
    return place, parameter.unit, np.linspace(*ends, n_points), here


def _values_along(
    model: Model, output: Output, look: Look, place: int, at: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Returns the output, and whether the points lie in the box, at values `at` of parameter `place`; shapes (n)."""
    point = list(look.point.values())
    if place == len(point):  # the time
        answers = model.query_history(np.array([point]))
        return output.of(answers)[0], answers.is_inside_box[0]
    points = np.tile(point, (len(at), 1))
    points[:, place] = at
    if look.step is None:
        answers = model.query_many(points)
        return output.of(answers), answers.is_inside_box
    answers = model.query_history(points)
    return output.of(answers)[:, look.step], answers.is_inside_box[:, look.step]


def slope_at(output: Output, look: Look, place: int) -> float | None:
    """Returns the derivative of an output over the parameter `place`, from 0; None if the model gives none here."""
    if look.answer is None or output.slope_of is None:
        return None
    try:
        slope = output.slope_of(look.answer.gradient, place)
    except (NoAnswerError, ValueError):
        return None
    return slope if np.isfinite(slope) else None
