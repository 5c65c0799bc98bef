# SPDX-License-Identifier: BSD-3-Clause
"""Numbers as texts."""

import pytest

from signorom_post.arrays import (
    as_number,
    format_number,
    power_of_ten,
    pressure_unit,
    with_unit,
    without_unit_one,
)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (1e-8, "$10^{-8}$"),
        (1.0, "$10^{0}$"),
        (2.5e-8, r"$2.5\times10^{-8}$"),
        (1.1e3, r"$1.1\times10^{3}$"),
        (0.96e-4, r"$9.6\times10^{-5}$"),
        # rounds up to the next power
        (999.0, "$10^{3}$"),
    ],
)
def test_powers_of_ten_have_no_factor_of_one(value: float, text: str) -> None:
    assert power_of_ten(value) == text


@pytest.mark.parametrize(
    ("value", "number"),
    [
        (2, 2.0),
        (0.5, 0.5),
        ("1e8", 1e8),
        ("1.0e-8", 1e-8),
        (True, None),
        ("none", None),
        (None, None),
        ([1], None),
    ],
)
def test_numbers_of_yaml_may_be_texts(value: object, number: float | None) -> None:
    assert as_number(value) == number


@pytest.mark.parametrize(("value", "text"), [(0.2, "0.2"), (3.21688, "3.217"), (1.08e-5, "1.08e-05")])
def test_numbers_have_four_digits(value: float, text: str) -> None:
    assert format_number(value) == text


def test_labels_have_their_unit() -> None:
    assert with_unit("x", "mm") == "x [mm]"
    assert with_unit("ratio", "-") == with_unit("ratio", "1") == with_unit("ratio", "") == "ratio"


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("nu = 0.3 1", "nu = 0.3"),
        ("P = 1 MPa, nu = 1e-05 1, n = 1", "P = 1 MPa, nu = 1e-05, n = 1"),
        ("nu = 0.33 1: 1.9E-08, 4 active pairs", "nu = 0.33: 1.9E-08, 4 active pairs"),
        ("P = 3 1/m, q = 2 10", "P = 3 1/m, q = 2 10"),
    ],
)
def test_the_unit_one_is_not_shown(text: str, shown: str) -> None:
    assert without_unit_one(text) == shown


@pytest.mark.parametrize(
    ("force", "length", "unit"),
    [
        ("N", "mm", "MPa"),
        ("N", "m", "Pa"),
        ("N/mm", "mm", "MPa"),
        ("N/m", "m", "Pa"),
        ("kN", "m", "kN/m²"),
        ("kN/m", "m", "kN/m²"),
        ("", "mm", ""),
    ],
)
def test_unit_of_a_pressure(force: str, length: str, unit: str) -> None:
    """1 N/mm² is 1 MPa; a force per length over a length is a pressure, too."""
    assert pressure_unit(force, length) == unit
