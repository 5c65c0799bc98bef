# SPDX-License-Identifier: BSD-3-Clause
"""Every shipped deck with loads: the reactions of the supports add up to minus the resultant of the loads."""

import re

import numpy as np
import pytest
import yaml

from runs import INPUT, solve_input

BALANCE = 1e-9


def blocks(point):
    """Pressure P on the top, 10 mm deep, from x = edge to 10 mm."""
    return {"z": -point["P"] * (10 - point["edge"]) * 10}, 1.0


def hertz_cylinder(point):
    """Half the load of the whole cylinder."""
    return {"y": -point["load"] / 2}, 1.0


def sphere(point):
    """All of the load; radial forces around an axis do not add up to a resultant."""
    return {"z": -point["load"]}, 1.0


def pellet_cladding(point):
    """The pressure acts along the radius: no resultant along the axis, where its own size is the measure."""
    return {"z": 0.0}, point["P1"] * 2 * np.pi * 4.672 * point["h1"]


def two_pressures(point):
    """As in pellet_cladding; P1 up to h1, P2 from there to the top at 7 mm."""
    return {"z": 0.0}, 2 * np.pi * 4.672 * (point["P1"] * point["h1"] + point["P2"] * (7 - point["h1"]))


def shrink_fit(point):
    """As in pellet_cladding; at rest the contact force of the shrink fit is the measure."""
    return {"z": 0.0}, 2 * np.pi * (10 * point["bore_pressure"] + 20 * 6.31) * 2


def bracket(point):
    """The bolt on 9.1 mm, along both axes; the strip 5.7 mm wide on a shelf that falls by 1.3 mm on 24.7 mm."""
    strip = point["P"] * 5.7
    return {"x": -0.23 * point["bolt"] * 9.1 - strip * 1.3 / 24.7, "y": -point["bolt"] * 9.1 - strip}, 1.0


def saddle(point):
    """The bolt on 10.2 x 9.7 mm; the strip up to 5.3 mm wide on a slope of 9.5 and 3.5 mm, from z = 0 to 25.1 mm."""
    strip = min(point["place"] + 5.3, 25.1) - max(point["place"], 0)
    return {"y": -point["bolt"] * 10.2 * 9.7 - 13.7 * strip * np.hypot(9.5, 3.5)}, 1.0


def dovetail(point):
    """Gas on the straight side above the fillet of 2.5 mm; the pull goes through curved faces: test_own_meshes.py."""
    return {"x": point["gas"] * (20 - 2.5 * np.tan(np.pi / 8))}, 1.0


def angle_bracket(point):
    """Nothing along x; what is under the bolt ends in arcs: test_own_meshes.py."""
    return {"x": 0.0}, 88 * point["bolt"]


def fuel_rod(point):
    """Pressure on the outside pushes along r alone; heat has no resultant: as large as the force on the cladding."""
    return {"z": 0.0}, 2 * np.pi * 4.672 * point["h"] * point["P"]


def pcmi(point):
    """The coolant pushes along r alone; its force on the cladding is the measure."""
    return {"z": 0.0}, 2 * np.pi * 4.7 * 6 * point["P"]


# deck -> resultant of its loads at a point [force], and the size of what cancels where it is 0
RESULTANTS = {
    "angle_bracket": angle_bracket,
    "blocks": blocks,
    "bracket": bracket,
    "dovetail": dovetail,
    "fuel_rod": fuel_rod,
    "hertz_cylinder": hertz_cylinder,
    "pcmi": pcmi,
    "pellet_cladding": pellet_cladding,
    "pellet_cladding_clusters": pellet_cladding,
    "pellet_cladding_greedy": pellet_cladding,
    "pellet_cladding_three_parameters": two_pressures,
    "pellet_cladding_whole_edges": pellet_cladding,
    "saddle": saddle,
    "shrink_fit": shrink_fit,
    "sphere": sphere,
}
DECKS = sorted(deck.stem for deck in INPUT.glob("*.yaml") if "loads" in yaml.safe_load(deck.read_text()))


@pytest.mark.parametrize("name", DECKS)
def test_reactions_balance_the_loads(signorom, tmp_path, figures, name):
    """At each output point of the deck, each component."""
    assert name in RESULTANTS, "a new deck with loads: add its resultant"
    _, report = solve_input(signorom, name, tmp_path)
    errors = []
    for point in report["points"].values():
        parameters = {
            key: float(value) for key, value in re.findall(r"(\w+) = (\S+)", point["point"].replace(",", ""))
        }
        resultant, scale = RESULTANTS[name](parameters)
        for axis, load in resultant.items():
            reaction = sum(entry.get(axis, 0.0) for entry in point["reactions"].values())
            errors.append(abs(reaction + load) / (abs(load) or scale))
        assert point["residuals"]["force_balance"] <= BALANCE
    figures.at_most(f"deck {name}", "reactions + loads, relative", max(errors), BALANCE, "equilibrium")
