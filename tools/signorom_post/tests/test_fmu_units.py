# SPDX-License-Identifier: BSD-3-Clause
"""Units of measurement in the words of FMI: value in SI = factor * value + offset."""

import pytest

from signorom_post.fmu_units import base_unit, moment_unit, unit_definitions


@pytest.mark.parametrize(
    ("unit", "expected"),
    [
        ("m", {"m": "1"}),
        ("mm", {"m": "1", "factor": "0.001"}),
        ("N", {"kg": "1", "m": "1", "s": "-2"}),
        ("MPa", {"kg": "1", "m": "-1", "s": "-2", "factor": "1000000.0"}),
        ("N/m", {"kg": "1", "s": "-2"}),
        ("degC", {"K": "1", "offset": "273.15"}),
        ("W/mm", None),
    ],
)
def test_base_units(unit: str, expected: dict[str, str] | None) -> None:
    assert base_unit(unit) == expected


def test_products_and_powers() -> None:
    area, moment, line = base_unit("mm^2"), base_unit("kN*mm"), base_unit("N/mm")
    assert area is not None
    assert moment is not None
    assert line is not None
    assert (area["m"], float(area["factor"])) == ("2", pytest.approx(1e-6))
    assert moment == {"kg": "1", "m": "2", "s": "-2"}
    assert float(line["factor"]) == pytest.approx(1e3)
    assert moment_unit("N", "mm") == "N*mm"
    assert moment_unit("N/mm", "mm") == "N"


def test_each_unit_is_defined_once() -> None:
    found = unit_definitions(["mm", "", "N", "mm", "1", "W/mm"])
    assert [unit.get("name") for unit in found] == ["mm", "N", "W/mm"]
