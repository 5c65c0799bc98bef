# SPDX-License-Identifier: BSD-3-Clause
"""Writes a comparison as a Markdown table and as CSV."""

import csv
import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

from signorom_post.compare.entries import ERROR, Entry, Study
from signorom_post.summary import ABSENT, duration

#: a column: heading, attribute of Entry, and the function that returns the text of a value
Column = tuple[str, str, Callable[[Any], str]]


def _megabytes(value: int) -> str:
    return f"{value / 1e6:.2g}" if value < 1e7 else f"{value / 1e6:.0f}"


def _error(value: float) -> str:
    return f"{value:.1e}" if math.isfinite(value) else str(value)


SIZES: list[Column] = [
    ("model", "name", str),
    ("kind", "kind", str),
    ("unknowns", "unknowns", str),
    ("contacts in the RID", "domain_contacts", str),
    ("contacts", "n_contacts", str),
    ("MB", "file_size", _megabytes),
]
TIMES: list[Column] = [("offline", "offline", duration), ("query", "query", duration)]
ERRORS: list[Column] = [
    ("e_λ median", "median", _error),
    ("95 %", "p95", _error),
    ("largest", "largest", _error),
    ("by fallback", "n_fallbacks", str),
    ("no answer", "n_unanswered", str),
]


def format_markdown(study: Study, has_times: bool) -> str:
    """Returns a Markdown table with aligned columns, one line per full-order solver and then one per model.

    `has_times`: whether it has the columns `offline` and `query`. A number that an entry does not have is shown as `-`.
    """
    columns = [*SIZES, *(TIMES if has_times else []), *ERRORS]
    rows = [[heading for heading, _, _ in columns]]
    for entry in [*study.full_order, *study.models]:
        values = [(getattr(entry, attribute), show) for _, attribute, show in columns]
        rows.append([ABSENT if value is None else show(value) for value, show in values])
    widths = [max(len(row[i]) for row in rows) for i in range(len(columns))]
    rows.insert(1, ["-" * width for width in widths])
    lines = [" | ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)) for row in rows]
    return "\n".join(f"| {line} |" for line in lines)


def explanation(study: Study, has_times: bool, n_query_points: int, seed: int) -> str:
    """Returns a text that explains the columns and says where their numbers are from.

    `n_query_points` is the number of the random points at which queries were timed, and `seed` is their seed. The text
    names them, and what the times are, only if `has_times`.
    """
    infinite = any(entry.largest == math.inf for entry in study.models)
    sentences = [
        f"Errors {ERROR} at {study.n_points} test points with a full-order solution, against this solution.",
        "The error at a point without an answer counts as infinite"
        + (", and so does that of forces where the full-order model has none." if infinite else "."),
        "Unknowns: modes and hats of a reduced basis; contacts if only their forces are solved for; dofs.",
    ]
    if has_times:
        sentences += [
            "Offline: set-up, snapshots and training, wall time of the reports; of a full-order solver its set-up.",
            "Query of a full-order solver: wall time per point, the least of the reports;",
            f"of a model: processor time with the forces of all contacts, mean of {n_query_points} random points of "
            f"its box (seed {seed}) in one call, median of the calls.",
        ]
    return " ".join(sentences)


def write_csv(path: Path, entries: Sequence[Entry]) -> None:
    """Writes the entries to the file `path` as CSV: a header with the names of the members, then a row for each entry.

    Numbers are not rounded, times are in seconds, sizes of files in bytes; a member that is None is empty. OSError if
    the file cannot be written.
    """
    with path.open("w", newline="", encoding="utf-8") as file:
        names = [field.name for field in fields(Entry)]
        writer = csv.DictWriter(file, fieldnames=names, lineterminator="\n")
        writer.writeheader()
        writer.writerows(asdict(entry) for entry in entries)
