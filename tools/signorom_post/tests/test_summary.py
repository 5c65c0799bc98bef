# SPDX-License-Identifier: BSD-3-Clause
"""The table of a run: aligned, and tolerant of what a report lacks."""

import pytest
import yaml
from half_disk_results import REPORT

from signorom_post.summary import format_summary

EXPECTED = """Two half disks pressed together  |  signorom 0.1.0

Sizes
  nodes          678
  dofs           1356
  contact pairs  53
  inert pairs    2
  their nodes    1 - 56; 55 - 110

Reduction
  modes l                     9
  contact pairs of the model  8
  cells of the RID            50
  kappa                       3.217
  cond(K_r)                   1.5e+08
  rank of the contact rows    8

Errors at 101 points      min   median      p95      max
  e_u                 1.0e-05  8.1e-05  2.1e-04  3.4e-04
  e_lambda_rid        1.0e-04  2.7e-04  1.2e-03      inf
  e_lambda_rid, infinite: 1
  e_lambda_rid, largest at:
    squeeze = 0.156 m: 1.6E-02
    squeeze = 0.2 m: 9.1E-03

Times
  sample, per point  211 us (max 1.98 ms)
  train              61.5 s
  query              21.3 us

Speed-up of a query
  over refactored  1520 x
  over condensed   31.2 x"""


def test_whole_report() -> None:
    assert format_summary(yaml.safe_load(REPORT)) == EXPECTED


@pytest.mark.parametrize("section", ["version", "deck", "sizes", "reduction", "errors", "times", "speed_up"])
def test_any_section_may_be_absent_or_empty(section: str) -> None:
    report = yaml.safe_load(REPORT)
    heading = {"sizes": "Sizes", "reduction": "Reduction", "errors": "Errors", "times": "Times"}.get(section)
    for value in ({}, None):
        text = format_summary(report | {section: value})
        assert heading is None or heading not in text
    del report[section]
    assert heading is None or heading not in format_summary(report)


def test_absent_statistics_are_dashes() -> None:
    text = format_summary({"errors": {"e_u": {"median": 1e-4}, "e_energy": None}})
    assert text.splitlines()[1].split() == ["e_u", "-", "1.0e-04", "-", "-"]
    assert text.splitlines()[2].split() == ["e_energy", "-", "-", "-", "-"]


def test_report_without_any_known_section() -> None:
    assert "none of the sections sizes, reduction" in format_summary({"deck": {"title": "T"}})
    assert "none of the sections" in format_summary({})


def test_scalar_speed_up_and_nested_times() -> None:
    text = format_summary({"speed_up": 12.34, "times": {"train": {"pod": 0.5, "deim": 4e-9}}})
    assert "\n  12.3 x" in text
    assert "  train, pod   500 ms" in text
    assert "  train, deim  4.00 ns" in text


@pytest.mark.parametrize(
    ("seconds", "text"),
    [
        (0, "0 s"),
        (119.6, "120 s"),
        (125, "2 min 5 s"),
        (1.0, "1.00 s"),
        ("1e-3", "1.00 ms"),
        ("soon", "soon"),
    ],
)
def test_times_have_a_legible_unit(seconds: object, text: str) -> None:
    assert format_summary({"times": {"query": seconds}}).splitlines()[1] == f"  query  {text}"


def test_numbers_that_yaml_takes_for_text() -> None:
    """YAML 1.1 wants a sign in the exponent, so `1.5e8` comes as text."""
    report = yaml.safe_load("reduction: {stiffness_condition: 1.5e8}")
    assert isinstance(report["reduction"]["stiffness_condition"], str)
    assert format_summary(report).splitlines()[1] == "  cond(K_r)  1.5e+08"


def test_each_cluster_has_a_column() -> None:
    """What none of them has to say is left out."""
    clusters = {
        "1": {"n_snapshots": 240, "condition_number": 8.84321, "warnings": []},
        "2": {"n_snapshots": 1290, "condition_number": 12345678.0, "warnings": []},
    }
    text = format_summary({"reduction": {"n_clusters": 2, "clusters": clusters}})
    assert text.splitlines()[1:] == [
        "  n clusters  2",
        "",
        "Cluster            1          2",
        "  snapshots      240       1290",
        "  kappa        8.843  1.235e+07",
    ]


def test_each_contact_has_a_table() -> None:
    """Points without an answer, and reports that say something else, do no harm."""
    answered = {"surfaces": "foot - floor", "area": 0.75, "force": [0.0, -12.5], "moment": [-6.25]}
    answered["moment_imbalance"] = [0.5]
    refused = answered | {"area": float("nan"), "force": [float("nan")] * 2, "moment": [float("nan")]}
    del refused["moment_imbalance"]  # as in reports of earlier programs
    report = {
        "units": {"contact_area": "m", "force": "N/m", "moment": "N*m/m"},
        "points": {
            "1": {"point": "p = 2 Pa", "contacts": {"1": answered}},
            "2": {"point": "p = 13 Pa", "contacts": {"1": refused}},
            "3": "nothing",
        },
    }
    assert format_summary(report).strip().splitlines() == [
        "Contact 1: foot - floor  area [m]  force [N/m]  moment [N*m/m]  of both sides [N*m/m]",
        "  p = 2 Pa               0.75      0; -12.5     -6.25           0.5",
        "  p = 13 Pa              nan       nan; nan     nan             -",
    ]


def test_values_of_other_types() -> None:
    text = format_summary({"sizes": {"is_tied": True, "ranks": [1, 2], "inert": None}})
    assert text.splitlines()[1:] == ["  is tied  yes", "  ranks    1; 2", "  inert    -"]


def test_errors_that_are_nowhere_defined_have_no_row() -> None:
    """The error of the energy where materials flow; one that is defined at some point keeps its row."""
    undefined = dict.fromkeys(("min", "median", "p95", "max"), float("nan"))
    told = format_summary({"errors": {"n_points": 2, "e_energy": undefined, "e_u": undefined | {"max": 0.1}}})
    assert "e_energy" not in told
    assert "e_u" in told
