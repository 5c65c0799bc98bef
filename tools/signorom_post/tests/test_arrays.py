# SPDX-License-Identifier: BSD-3-Clause
"""Numbers as texts."""

import pytest

from signorom_post.arrays import as_number, format_number, power_of_ten, with_unit


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
