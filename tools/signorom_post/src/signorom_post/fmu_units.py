# SPDX-License-Identifier: BSD-3-Clause
"""Units of measure as FMI describes them: exponents of the base units of SI, a factor, an offset."""

import xml.etree.ElementTree as ET
from collections.abc import Iterable

#: name of a unit -> its factor to the SI unit
_LENGTHS = {"m": 1.0, "dm": 0.1, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "nm": 1e-9}
_FORCES = {"N": 1.0, "mN": 1e-3, "kN": 1e3, "MN": 1e6}
_PRESSURES = {"Pa": 1.0, "hPa": 1e2, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "bar": 1e5, "N/mm^2": 1e6}
_NO_UNIT = {"", "-", "1"}


def base_unit(unit: str) -> dict[str, str] | None:
    """Returns the attributes of FMI's element BaseUnit for a unit of measure, such as `mm^2`, or None.

    They are the exponents of the SI base units, the factor if it is not 1, and for Celsius the offset. None if the unit
    is not known here.
    """
    if unit.removesuffix("^2") in _LENGTHS:
        power = 2 if unit.endswith("^2") else 1
        return _attributes({"m": power}, _LENGTHS[unit.removesuffix("^2")] ** power)
    if unit in _FORCES:
        return _attributes({"kg": 1, "m": 1, "s": -2}, _FORCES[unit])
    if unit in _PRESSURES:
        return _attributes({"kg": 1, "m": -1, "s": -2}, _PRESSURES[unit])
    if unit == "K":
        return _attributes({"K": 1}, 1.0)
    if unit in ("degC", "°C"):
        return _attributes({"K": 1}, 1.0) | {"offset": "273.15"}
    force, _, length = unit.partition("*")
    if force in _FORCES and length in _LENGTHS:
        return _attributes({"kg": 1, "m": 2, "s": -2}, _FORCES[force] * _LENGTHS[length])
    force, _, length = unit.partition("/")
    if force in _FORCES and length in _LENGTHS:
        return _attributes({"kg": 1, "s": -2}, _FORCES[force] / _LENGTHS[length])
    return None


def moment_unit(force: str, length: str) -> str:
    """Returns the unit of a moment from the units of force and length.

    It is such as `N*mm`. In plane models the unit of force is per length, such as N/mm, and the moment per thickness
    has the unit N.
    """
    per_length = f"/{length}"
    return force.removesuffix(per_length) if force.endswith(per_length) else f"{force}*{length}"


def _attributes(exponents: dict[str, int], factor: float) -> dict[str, str]:
    attributes = {name: str(exponent) for name, exponent in exponents.items()}
    return attributes if factor == 1 else attributes | {"factor": repr(factor)}


def unit_definitions(units: Iterable[str]) -> ET.Element:
    """Returns FMI's element UnitDefinitions, which contains each unit of measure once.

    Empty ones, `-` and `1` are left out. A unit that `base_unit` does not know has only its name.
    """
    definitions = ET.Element("UnitDefinitions")
    for unit in dict.fromkeys(unit for unit in units if unit not in _NO_UNIT):
        element = ET.SubElement(definitions, "Unit", name=unit)
        base = base_unit(unit)
        if base is not None:
            ET.SubElement(element, "BaseUnit", base)
    return definitions
