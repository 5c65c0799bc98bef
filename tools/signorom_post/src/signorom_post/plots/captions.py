# SPDX-License-Identifier: BSD-3-Clause
"""The factor by which displacements are magnified in a figure, and the title that names it."""

import math

import numpy as np

from signorom_post.arrays import NO_UNITS, FloatArray, format_number
from signorom_post.readers.fields import FieldPoint
from signorom_post.readers.model import Model

#: displacements are magnified if the largest component is below this share of the size of the mesh
VISIBLE_SHARE = 0.02
#: [characters] a label of a point that is longer is broken into one line per parameter
LONGEST_TITLE = 24
#: [characters] a longer name of a contact is broken between its surfaces
LONGEST_NAME = 36


def wrapped(label: str, n_characters: int) -> str:
    """Returns the label of a point in lines of up to `n_characters`, each of which ends behind a parameter."""
    lines = [""]
    for part in label.split(", "):
        if lines[-1] and len(lines[-1]) + len(part) + 2 > n_characters:
            lines[-1] += ","
            lines.append(part)
        else:
            lines[-1] += f", {part}" if lines[-1] else part
    return "\n".join(lines)


def point_texts(points: list[FieldPoint], model: Model | None, n_characters: int) -> list[str]:
    """Returns a text for each point: the parameters in which the points differ, with units, all of a single point.

    Lines have up to `n_characters`. Units that the points do not have come from `model`.
    """
    values = np.array([point.parameters for point in points])
    differs = np.flatnonzero((values != values[0]).any(axis=0))
    which = differs if differs.size else np.arange(values.shape[1])
    return [
        wrapped(", ".join(_parameter_text(point, i, model) for i in which), n_characters) for point in points
    ]


def _parameter_text(point: FieldPoint, i: int, model: Model | None) -> str:
    name = point.parameter_names[i]
    unit = point.parameter_units[i] if point.parameter_units else model.unit_of(name) if model else ""
    text = f"{name} = {format_number(point.parameters[i])}"
    return text if unit in NO_UNITS else f"{text} {unit}"


def surface_title(name: str, longest: int = LONGEST_NAME) -> str:
    """Returns the name of a contact as a title: in two lines if it has more than `longest` characters."""
    return name.replace(" - ", " -\n", 1) if len(name) > longest else name


def deformed_title(point: FieldPoint, scale: float) -> str:
    """Returns a title: the label of the point, and the factor `scale` of its displacement unless `scale` is 1.

    A label of more than 24 characters is broken into one line per parameter.
    """
    lines = [*point.label.split(", ")] if len(point.label) > LONGEST_TITLE else [point.label]
    lines[-1] += f"  (displacement x {format_number(scale)})" if scale != 1 else ""
    return "\n".join(lines)


def magnification(displacement: FloatArray, size: float) -> float:
    """Returns the factor by which a figure multiplies `displacement`, shape (n_nodes, 3).

    `size` is that of the mesh, in the same unit. The factor is 1 if the displacement is zero, or if the largest
    absolute value of its components is at least 2 % of the size. Else it is the largest 1, 2 or 5 times a power of ten
    with which this value comes to at most 4 % of the size.
    """
    largest = float(np.abs(displacement).max(initial=0.0))
    if largest == 0.0 or largest >= VISIBLE_SHARE * size:
        return 1.0
    wanted = 2.0 * VISIBLE_SHARE * size / largest
    power = 10.0 ** math.floor(math.log10(wanted))
    return max(step * power for step in (1.0, 2.0, 5.0) if step * power <= wanted * (1 + 1e-12))
