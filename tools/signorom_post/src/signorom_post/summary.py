# SPDX-License-Identifier: BSD-3-Clause
"""Makes short tables of the numbers in report.yaml."""

import math
from collections.abc import Callable, Iterator
from typing import Any

from signorom_post.arrays import as_number, format_number, without_unit_one

#: key of the report, or section/key -> name in the table; other keys are shown with blanks in place of underscores
NAMES = {
    "n_nodes": "nodes",
    "n_cells": "cells",
    "n_dofs": "dofs",
    "n_multipliers": "contact pairs",
    "n_inert_pairs": "inert pairs",
    "inert_pairs": "their nodes",
    "n_snapshots": "snapshots",
    "n_modes": "modes l",
    "n_reduced_unknowns": "reduced unknowns",
    "n_contact_rows": "contact pairs of the model",
    "condition_number": "kappa",
    "stiffness_condition": "cond(K_r)",
    "reduction/n_cells": "cells of the RID",
    "reduction/rank": "rank of the contact rows",
    "full_order_per_point": "full order, per point",
    "refactored_per_point": "full order refactored, per point",
    "sample_per_point": "sample, per point",
    "forces_not_corrected": "contact forces before their correction",
    "histories/error_estimate": "estimate of the error before the correction",
    "histories/forces": "contact forces",
    "histories/displacement": "displacement in the norm of the stiffness",
    "histories/von_mises": "von Mises stress",
    "histories/estimate_over_error": "estimate over error",
    "share_from_0.5_to_1.2": "share from 0.5 to 1.2",
}
STATISTICS = ("min", "median", "p95", "max")
SECTIONS = {
    "sizes": "Sizes",
    "reduction": "Reduction",
    "errors": "Errors",
    "histories": "Errors of whole histories: largest one over the largest value",
    "times": "Times",
    "speed_up": "Speed-up of a query",
}
ABSENT = "-"


def format_summary(report: dict[str, Any]) -> str:
    """Returns the tables of sizes, reduction, errors, times, speed-up and contacts as text.

    `report` is the contents of report.yaml. The title of the deck and the version come first. Sections that the report
    does not have are left out; if it has none of them, a sentence says so.
    """
    blocks = [_heading(report)]
    for key, heading in SECTIONS.items():
        section = report.get(key)
        if section is None or section == {}:
            continue
        if key == "errors" and isinstance(section, dict):
            blocks.append(_error_table(heading, section))
        elif key == "reduction" and isinstance(section, dict) and section.get("clusters"):
            rest = {name: value for name, value in section.items() if name != "clusters"}
            blocks.append(_table(heading, list(entries(rest, key, value_text))))
            blocks.append(_cluster_table(section["clusters"]))
        else:
            show = {"times": duration, "speed_up": _factor}.get(key, value_text)
            blocks.append(_table(heading, list(entries(section, key, show))))
    blocks += _contact_tables(report)
    if len(blocks) == 1:
        blocks.append("The report has none of the sections " + ", ".join(SECTIONS) + ".")
    return "\n\n".join(block for block in blocks if block)


def _heading(report: dict[str, Any]) -> str:
    deck = report.get("deck")
    title = deck.get("title") if isinstance(deck, dict) else None
    version = report.get("version")
    if isinstance(version, dict):
        version = version.get("signorom")
    parts = [str(title) if title else "", f"signorom {version}" if version else ""]
    return "  |  ".join(part for part in parts if part)


def entries(section: Any, path: str, show: Callable[[Any], str]) -> Iterator[tuple[str, str]]:
    """Yields the name and the text of each value in nested mappings; empty lists and empty mappings give nothing.

    `path` is the section's key, by which NAMES are found; `show` returns the text of a value. A name has the names of
    the mappings around it in front, with commas. A mapping that has only keys of STATISTICS gives one text, with its
    median and maximum. A section that is no mapping is one value with an empty name.
    """
    if not isinstance(section, dict):
        yield "", show(section)
        return
    for key, value in section.items():
        name = NAMES.get(f"{path}/{key}") or NAMES.get(str(key)) or str(key).replace("_", " ")
        if isinstance(value, dict) and value and set(value) <= set(STATISTICS):
            yield name, _spread(value, show)
        elif isinstance(value, dict):
            yield from ((f"{name}, {below}", text) for below, text in entries(value, f"{path}/{key}", show))
        elif value != []:
            yield name, show(value)


def _spread(statistics: dict[str, Any], show: Callable[[Any], str]) -> str:
    """Returns the statistics of one quantity as text: the median and, in parentheses, the maximum."""
    return f"{show(statistics.get('median'))} (max {show(statistics.get('max'))})"


def _table(heading: str, entries: list[tuple[str, str]]) -> str:
    width = max((len(name) for name, _ in entries), default=0)
    return "\n".join(
        [heading, *(f"  {name:<{width}}  {text}".rstrip() if name else f"  {text}" for name, text in entries)]
    )


def _cluster_table(clusters: dict[str, dict[str, Any]]) -> str:
    """Returns a table with one row per quantity and one column per cluster; `clusters`: number -> its section."""
    keys = dict.fromkeys(key for cluster in clusters.values() for key in cluster)
    rows = [["Cluster", *map(str, clusters)]]
    for key in keys:
        values = [cluster.get(key) for cluster in clusters.values()]
        if any(value != [] for value in values):
            name = NAMES.get(f"reduction/{key}") or NAMES.get(key) or key.replace("_", " ")
            rows.append([f"  {name}", *(value_text(value) for value in values)])
    width = max(len(row[0]) for row in rows)
    widths = [max(7, *(len(row[i]) for row in rows)) for i in range(1, len(rows[0]))]
    return "\n".join(
        "  ".join([f"{row[0]:<{width}}", *(f"{text:>{w}}" for text, w in zip(row[1:], widths, strict=True))])
        for row in rows
    )


def _contact_tables(report: dict[str, Any]) -> Iterator[str]:
    """Yields a table for each contact, with one row per full-order point.

    Its columns are the area of closed contacts, the force, the moment, and the sum of the moments of both sides.
    """
    points = mapping(report.get("points")).values()
    units = mapping(report.get("units"))
    tables: dict[str, list[list[str]]] = {}
    for point in map(mapping, points):
        for number, contact in mapping(point.get("contacts")).items():
            contact = mapping(contact)
            heading = f"Contact {number}: {value_text(contact.get('surfaces'))}"
            values = [value_text(contact.get(key)) for key in ("area", "force", "moment", "moment_imbalance")]
            tables.setdefault(heading, []).append([f"  {value_text(point.get('point'))}", *values])
    titles = [
        f"{name} [{units.get(key, ABSENT)}]"
        for name, key in (
            ("area", "contact_area"),
            ("force", "force"),
            ("moment", "moment"),
            ("of both sides", "moment"),
        )
    ]
    for heading, rows in tables.items():
        cells = [[heading, *titles], *rows]
        widths = [max(len(row[i]) for row in cells) for i in range(len(cells[0]))]
        yield "\n".join(
            "  ".join(f"{text:<{width}}" for text, width in zip(row, widths, strict=True)).rstrip()
            for row in cells
        )


def mapping(value: Any) -> dict[Any, Any]:
    """Returns `value` if it is a mapping, else an empty mapping."""
    return value if isinstance(value, dict) else {}


def is_undefined(statistics: dict[str, Any]) -> bool:
    """Returns whether an error is not defined at any point, such as that of the energy where materials flow."""
    values = [statistics.get(key) for key in STATISTICS]
    return all(isinstance(value, float) and math.isnan(value) for value in values)


def _error_table(heading: str, section: dict[str, Any]) -> str:
    """Returns a table with one row per error, and below it what else the report says about an error, but for 0.

    An error that is not defined at any point has no row.
    """
    rows, remarks = [], []
    for name, statistics in section.items():
        if statistics is None:
            statistics = {}
        if not isinstance(statistics, dict) or is_undefined(statistics):
            continue
        rows.append([str(name), *(error_text(statistics.get(key)) for key in STATISTICS)])
        for key, value in statistics.items():
            if key in STATISTICS or value in (None, 0, []):
                continue
            remarks.append(f"  {name}, {str(key).replace('_', ' ')}:")
            if isinstance(value, list):
                remarks += [f"    {value_text(item)}" for item in value]
            else:
                remarks[-1] += f" {value_text(value)}"
    n_points = section.get("n_points")
    heading += f" at {n_points} points" if n_points is not None else ""
    name_width = max([len(heading) - 2, *(len(row[0]) for row in rows)])
    widths = [max(7, *(len(row[i]) for row in rows)) if rows else 7 for i in range(1, 1 + len(STATISTICS))]
    titles = "  ".join(f"{title:>{width}}" for title, width in zip(STATISTICS, widths, strict=True))
    lines = [f"{heading:<{name_width + 2}}  {titles}"]
    for name, *cells in rows:
        texts = "  ".join(f"{cell:>{width}}" for cell, width in zip(cells, widths, strict=True))
        lines.append(f"  {name:<{name_width}}  {texts}")
    return "\n".join([*lines, *remarks])


def value_text(value: Any) -> str:
    """Returns the text of a value of the report.

    That is `-` for none, yes or no, a whole number with all digits, another number (also a text that is a number) with
    four significant digits, the values of a list with semicolons, and else the text itself, without the unit 1.
    """
    if value is None:
        return ABSENT
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list | tuple):
        return "; ".join(value_text(item) for item in value)
    number = as_number(value)
    if number is None or isinstance(value, int):
        return without_unit_one(str(value))
    return format_number(number)


def error_text(value: Any) -> str:
    """Returns the text of an error with two digits, such as 1.2e-03, or inf or nan; `-` if `value` is no number."""
    number = as_number(value)
    return ABSENT if number is None else f"{number:.1e}" if math.isfinite(number) else str(number)


def duration(value: Any) -> str:
    """Returns the text of a time in seconds with a suitable unit: 800 ns, 21.3 us, 1.50 ms, 119 s, 2 min 5 s.

    A value that is no time (no number, negative, not finite) has the text of `value_text`.
    """
    seconds = as_number(value)
    if seconds is None or not math.isfinite(seconds) or seconds < 0:
        return value_text(value)
    if seconds == 0:
        return "0 s"
    if seconds >= 120:
        return f"{int(seconds) // 60} min {int(seconds) % 60} s"
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6)):
        if seconds >= size:
            return f"{_three_digits(seconds / size)} {unit}"
    return f"{_three_digits(seconds / 1e-9)} ns"


def _three_digits(value: float) -> str:
    decimals = 2 if value < 10 else 1 if value < 100 else 0
    return f"{value:.{decimals}f}"


def _factor(value: Any) -> str:
    number = as_number(value)
    return value_text(value) if number is None or not math.isfinite(number) else f"{_three_digits(number)} x"
