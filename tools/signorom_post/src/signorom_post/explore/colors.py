# SPDX-License-Identifier: BSD-3-Clause
"""The fields that may color the part of an exploration: where their values come from, and what speaks against them."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from signorom_post.answer import Fields
from signorom_post.arrays import FloatArray
from signorom_post.explore.exploration import DISPLACEMENTS, FORCES, STRESSES
from signorom_post.palette import BLUE, GRAY, GREEN, VERMILLION


@dataclass(frozen=True)
class Color:
    """A field of nodes."""

    name: str
    title: str
    #: name of its unit in Fields.units
    unit_of: str
    #: what must be right for it: FORCES, DISPLACEMENTS or STRESSES
    needs: str
    #: its values, NaN where it has none, shape (n_nodes); None: these fields do not have it
    of: Callable[[Fields], FloatArray | None]
    #: whether contact surfaces alone have it
    on_contact: bool = False
    #: value -> name and color, of a field of states; else the field has a scale
    states: dict[int, tuple[str, str]] | None = None


def _length(vectors: FloatArray | None) -> FloatArray | None:
    return None if vectors is None else np.linalg.norm(vectors, axis=1)


def _states(fields: Fields) -> FloatArray:
    """Returns the states of contacts with friction, or those without it as if closed contacts stuck."""
    states = fields.status if fields.friction_status is None else fields.friction_status
    return np.where(states == 0, np.nan, states)


OPEN, TIED = ("open", GRAY), ("tied", GREEN)
FRICTION_STATES = {1: OPEN, 2: ("sticks", BLUE), 3: ("slips", VERMILLION), 4: TIED}
STATES = {1: OPEN, 2: ("closed", BLUE), 4: TIED}
COLORS = [
    Color("von_mises", "von Mises stress", "von_mises", STRESSES, lambda fields: fields.von_mises_smoothed),
    Color(
        "displacement",
        "displacement",
        "displacement",
        DISPLACEMENTS,
        lambda fields: _length(fields.displacement),
    ),
    Color(
        "contact_pressure",
        "contact pressure",
        "contact_pressure",
        FORCES,
        lambda fields: fields.contact_pressure,
        on_contact=True,
    ),
    Color("gap", "gap", "gap", DISPLACEMENTS, lambda fields: fields.gap, on_contact=True),
    Color(
        "slip",
        "slip since the last time",
        "slip",
        FORCES,
        lambda fields: _length(fields.slip),
        on_contact=True,
    ),
    Color(
        "friction",
        "friction over area",
        "tangential_traction",
        FORCES,
        lambda fields: _length(fields.tangential_traction),
        on_contact=True,
    ),
    Color("status", "open or closed", "status", FORCES, _states, on_contact=True, states=STATES),
    Color(
        "plastic_strain",
        "equivalent plastic strain",
        "plastic_strain",
        STRESSES,
        lambda fields: fields.plastic_strain_smoothed,
    ),
    Color(
        "creep_strain",
        "equivalent creep strain",
        "creep_strain",
        STRESSES,
        lambda fields: fields.creep_strain_smoothed,
    ),
]


def colors_of(fields: Fields) -> list[Color]:
    """Returns those of COLORS that these fields have; with friction, the states are stick and slip."""
    found = []
    for color in COLORS:
        if color.of(fields) is None:
            continue
        if color.name == "status" and fields.friction_status is not None:
            color = Color(
                color.name, "stick or slip", "friction_status", FORCES, color.of, True, FRICTION_STATES
            )
        found.append(color)
    return found
