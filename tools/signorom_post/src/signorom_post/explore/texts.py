# SPDX-License-Identifier: BSD-3-Clause
"""What an exploration says in words and tables: numbers, colors, points, and the table to download."""

import csv
import io
from typing import Any

import matplotlib as mpl
import numpy as np

from signorom_post.arrays import NO_UNITS, format_number, with_unit
from signorom_post.explore.colors import Color
from signorom_post.explore.exploration import Exploration, Look, outside_text, sentence_of, unit_of
from signorom_post.explore.outputs import Number, Output, numbers_of
from signorom_post.palette import SEQUENTIAL

#: a component below this share of the largest number of its unit is rounding
ROUNDING = 1e-13


def rows_of(numbers: list[Number], kept: list[Number] | None) -> list[dict[str, Any]]:
    """Returns the rows of the table of numbers; those of one contact stand under its name."""
    rows: list[dict[str, Any]] = []
    group = ""
    for i, number in enumerate(numbers):
        contact, _, label = number.label.rpartition(": ")
        if contact != group:
            group = contact
            title = contact or "Fields"
            rows.append({"is_group": True, "label": title, "name": title, "a_kind": "", "b_kind": ""})
        row = {"is_group": False, "name": number.name, "label": label, "unit": _unit(number.unit)}
        row["a"], row["a_kind"] = number_text(number, numbers)
        row["b"], row["b_kind"] = ("", "") if kept is None else number_text(kept[i], kept)
        rows.append(row)
    return rows


def _unit(unit: str) -> str:
    return "" if unit in NO_UNITS else unit


def number_text(number: Number, others: list[Number]) -> tuple[str, str]:
    """Returns a number as a text and its kind; one that the model does not vouch for has a question mark.

    Beside numbers of the same unit among `others`, what is only rounding is zero.
    """
    if number.value is None or not np.isfinite(number.value):
        return "none", "doubt"
    size = max(abs(other.value or 0.0) for other in others if other.unit == number.unit)
    text = format_number(number.value if abs(number.value) > ROUNDING * size else 0.0)
    return (text, "") if number.is_vouched_for else (f"{text} ?", "doubt")


def legend_of(color: Color | None, limits: tuple[float, float], looks: list[Look]) -> dict[str, Any]:
    """Returns title, and ticks with a gradient of CSS or the names of states, of the colors of a picture."""
    legend: dict[str, Any] = {"title": "", "states": [], "ticks": [], "gradient": ""}
    if color is None:
        return legend
    look = next(look for look in looks if look.fields is not None)
    assert look.fields is not None
    legend["title"] = with_unit(color.title, look.fields.units.get(color.unit_of, ""))
    if any(look.speaks_against(color.needs) for look in looks):
        legend["title"] += " ?"
    if color.states is not None:
        legend["states"] = [{"name": name, "color": value} for name, value in color.states.values()]
        return legend
    legend["ticks"] = [format_number(value) for value in np.linspace(*limits, 6)]
    stops = [mpl.colors.to_hex(value) for value in mpl.colormaps[SEQUENTIAL](np.linspace(0.0, 1.0, 9))]
    legend["gradient"] = f"linear-gradient(to right, {', '.join(stops)})"
    return legend


def picture_text(color: Color | None, limits: tuple[float, float], looks: list[Look], scale: float) -> str:
    """Returns the picture in words."""
    if color is None:
        return "The part at rest, without colors: there are no fields here"
    what = (
        "Contact surfaces at rest"
        if color.on_contact
        else f"The part, displaced {format_number(scale)} times"
    )
    if len(looks) > 1:
        what = f"Two answers side by side. {what}"
    if color.states is not None:
        return f"{what}, colored by {color.title}"
    return f"{what}, colored by {color.title} from {format_number(limits[0])} to {format_number(limits[1])}"


def point_text(exploration: Exploration, look: Look) -> str:
    """Returns the values of the parameters with their units, and the time in a history."""
    parts = [
        f"{parameter.name} = {look.point[parameter.name]:.6g} {unit_of(parameter)}".strip()
        for parameter in exploration.parameters
        if parameter.name in look.point
    ]
    if look.time is not None:
        parts.append(f"time = {look.time:.6g}")
    return ", ".join(parts)


def csv_of(exploration: Exploration, outputs: list[Output], look: Look) -> str:
    """Returns the answer as a table: name, value, unit, and what speaks against the value."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(["name", "value", "unit", "remark"])
    for parameter in exploration.parameters:
        if parameter.name in look.point:
            value = look.point[parameter.name]
            table.writerow([parameter.name, repr(value), unit_of(parameter), outside_text(parameter, value)])
    if look.time is not None:
        unit = exploration.model.parameters[exploration.model.n_given].unit
        table.writerow(["time", repr(look.time), unit, ""])
    for number in numbers_of(exploration, outputs, look):
        remark = "" if number.is_vouched_for else sentence_of(look.remarks) or f"no answer: {look.refusal}"
        value_text = "" if number.value is None else repr(number.value)
        table.writerow([number.name, value_text, number.unit, remark])
    if look.answer is not None:
        for name in ("relative_bound", "relative_displacement_bound", "error_estimate"):
            value = getattr(look.answer, name)
            table.writerow(
                [name, "" if value is None else repr(value), "", "" if value is not None else "not known"]
            )
    return text.getvalue()
