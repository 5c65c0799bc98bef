# SPDX-License-Identifier: BSD-3-Clause
"""Collects the numbers of each model in a comparison from the results folders of one problem."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from signorom_post.arrays import FloatArray, as_number
from signorom_post.errors import InputError, MissingFileError
from signorom_post.readers.validation import Validation
from signorom_post.results import Results

#: column of validation.csv with the error that is compared: that of the contact forces on all contacts
ERROR = "e_lambda_all"
COMMAND = "signorom run DECK --benchmark"


@dataclass(frozen=True)
class Entry:
    """One line of the table: a model or a full-order solver. None stands for a number that it does not have."""

    #: name of the results folder, or its whole path; `full order` or `full order, factored anew` for a solver
    name: str
    #: kind of the model, with the number of its clusters if there are several; or type of the full-order solver
    kind: str
    #: number of unknowns: modes and hats of a reduced basis, dofs, or the contacts if only their forces are solved for.
    #: With clusters it is a range
    unknowns: str | None
    #: number of contacts in the reduced integration domain; with clusters it is a range
    domain_contacts: str | None
    #: number of all contacts
    n_contacts: int | None
    #: size of model.h5 [bytes]
    file_size: int | None = None
    #: [s] time of set-up, snapshots and training; of a full-order solver, time of its set-up
    offline: float | None = None
    #: [s] time of a query with the forces of all contacts, or of a full-order solution
    query: float | None = None
    #: [-] median, 95th percentile and maximum of ERROR over the test points; None for a full-order solver
    median: float | None = None
    p95: float | None = None
    largest: float | None = None
    #: number of test points that the fallback answered
    n_fallbacks: int | None = None
    #: number of test points without an answer
    n_unanswered: int | None = None


@dataclass(frozen=True)
class Study:
    """Validated models of one problem, all tested at the same points."""

    #: the full-order solvers, as _full_order_entries returns them
    full_order: list[Entry]
    #: the models, in the order of their folders
    models: list[Entry]
    #: number of test points with a full-order solution
    n_points: int


def read_study(folders: Sequence[Path], time_of: Callable[[Path], float | None]) -> Study:
    """Returns an entry for the model in each of these results folders, and entries for the full-order solvers.

    `time_of` takes the path of a model file and returns the time [s] of a query of it, or None. InputError if the
    folders have different problems or different test points, or if a file is missing, cannot be used or lacks a section
    that the comparison needs.
    """
    all_results = [Results(folder) for folder in folders]
    for results in all_results:
        _check_same(results, all_results[0])
    return Study(
        full_order=_full_order_entries([results.report for results in all_results]),
        models=[
            _model_entry(name, results, time_of)
            for name, results in zip(_names(folders), all_results, strict=True)
        ],
        n_points=int(_validation(all_results[0]).has_solution.sum()),
    )


def _names(folders: Sequence[Path]) -> list[str]:
    """Returns the names of the folders, or their whole paths if two names are the same."""
    names = [folder.resolve().name for folder in folders]
    return names if len(set(names)) == len(names) else [str(folder) for folder in folders]


def _check_same(results: Results, first: Results) -> None:
    report, expected = _report(results), _report(first)
    provenance, expected_provenance = str(report["provenance"]), str(expected["provenance"])
    if provenance != expected_provenance:
        raise InputError(
            results.folder,
            f"this is another problem than {first.folder} (provenance {provenance}, not {expected_provenance}): "
            "mesh, units, names of parameters, materials, loads, imposed strains, boundary conditions or contact "
            "differ, so the errors cannot be compared",
        )
    here, there = _validation(results), _validation(first)
    is_same = here.parameter_names == there.parameter_names and np.array_equal(
        here.parameters, there.parameters
    )
    if not is_same:
        raise InputError(
            results.folder,
            f"this was validated at other points than {first.folder}: give both decks the same section 'test' and the "
            "same ranges of the parameters, or one file of test points, and run them again",
        )


def _report(results: Results) -> dict[str, Any]:
    """Returns the report of a validated model; InputError if it is missing or lacks a section that is needed."""
    try:
        report = results.report
    except MissingFileError as error:
        raise _not_made(error) from error
    for section in ("provenance", "reduction", "answers"):
        if not report.get(section):
            path = results.folder / "report.yaml"
            raise InputError(
                path,
                f"there is no section '{section}'; this makes all that is compared, if the deck has a test "
                f"section: {COMMAND}",
            )
    return report


def _validation(results: Results) -> Validation:
    try:
        return results.validation
    except MissingFileError as error:
        raise _not_made(error) from error


def _not_made(error: MissingFileError) -> InputError:
    return InputError(error.path, f"{error.sentence}; this makes it: {COMMAND}")


def _model_file(results: Results) -> Path:
    path = results.folder / "model.h5"
    if not path.is_file():
        raise _not_made(MissingFileError(path, "there is no such file"))
    return path


def _model_entry(name: str, results: Results, time_of: Callable[[Path], float | None]) -> Entry:
    report = results.report
    clusters = _clusters(report["reduction"])
    kind = str(clusters[0].get("kind", "hhr"))
    path = _model_file(results)
    return Entry(
        name=name,
        kind=kind if len(clusters) == 1 else f"{kind}, {len(clusters)} clusters",
        unknowns=_range(clusters, "n_reduced_unknowns" if kind == "hhr" else "n_contact_rows"),
        domain_contacts=_range(clusters, "n_contact_rows") if kind == "hhr" else None,
        n_contacts=_whole(report, "sizes", "n_multipliers"),
        file_size=path.stat().st_size,
        offline=_offline(report),
        query=time_of(path),
        **_statistics(_validation(results).counted_errors(ERROR)),
        n_fallbacks=_whole(report, "answers", "by_fallback"),
        n_unanswered=_whole(report, "answers", "none"),
    )


def _clusters(reduction: dict[str, Any]) -> list[dict[str, Any]]:
    """Returns the section of the report about each local model, or about the only model."""
    parts = reduction.get("clusters")
    return list(parts.values()) if isinstance(parts, dict) and parts else [reduction]


def _statistics(errors: FloatArray) -> dict[str, float]:
    """Returns median, 95th percentile and maximum, which are nan if there are no errors.

    Infinite errors may make them infinite, but not nan.
    """
    if len(errors) == 0:
        return {"median": np.nan, "p95": np.nan, "largest": np.nan}
    return {
        "median": _quantile(errors, 0.5),
        "p95": _quantile(errors, 0.95),
        "largest": float(errors.max()),
    }


def _quantile(errors: FloatArray, fraction: float) -> float:
    """Returns the quantile `fraction`, from 0 to 1, of one or more errors, interpolated linearly between neighbors."""
    ascending = np.sort(errors)
    position = fraction * (len(ascending) - 1)
    i = int(position)
    low, high = float(ascending[i]), float(ascending[min(i + 1, len(ascending) - 1)])
    return low if high == low or position == i else low + (position - i) * (high - low)


def _range(clusters: Sequence[dict[str, Any]], key: str) -> str | None:
    """Returns the number `key` that all clusters have, or `smallest to largest`, as text; None if no cluster has it."""
    numbers = sorted({number for cluster in clusters if (number := _whole(cluster, key)) is not None})
    if not numbers:
        return None
    return str(numbers[0]) if len(numbers) == 1 else f"{numbers[0]} to {numbers[-1]}"


def _offline(report: dict[str, Any]) -> float | None:
    """Returns the time [s] of full-order set-up, snapshots (median times number) and training; None if one is absent."""
    parts = [
        _number(report, "times", "full_order_setup"),
        _number(report, "times", "sample_per_point", "median"),
        _number(report, "sampling", "n_points"),
        _number(report, "times", "train"),
    ]
    if any(part is None for part in parts):
        return None
    setup, per_point, n_points, train = (part or 0.0 for part in parts)
    return setup + n_points * per_point + train


def _full_order_entries(reports: Sequence[dict[str, Any]]) -> list[Entry]:
    """Returns the entries of the full-order solvers, each with its shortest time in the reports.

    First comes the solver that factors the stiffness anew at each point, then each solver that a deck uses.
    """
    n_contacts = _whole(reports[0], "sizes", "n_multipliers")
    n_dofs = _whole(reports[0], "sizes", "n_dofs")
    entries = [
        Entry(
            name="full order, factored anew",
            kind="active_set",
            unknowns=_text(n_dofs),
            domain_contacts=None,
            n_contacts=n_contacts,
            query=_least(reports, "times", "refactored_per_point"),
        )
    ]
    for solver in dict.fromkeys(_solver(report) for report in reports):
        chosen = [report for report in reports if _solver(report) == solver]
        entries.append(
            Entry(
                name="full order",
                kind=solver,
                unknowns=_text(n_contacts if solver == "condensed" else n_dofs),
                domain_contacts=None,
                n_contacts=n_contacts,
                offline=_least(chosen, "times", "full_order_setup"),
                query=_least(chosen, "times", "full_order_per_point"),
            )
        )
    return entries


def _solver(report: dict[str, Any]) -> str:
    """Returns the type of the full-order solver at the test points; empty if the report has none."""
    section = report.get("solver")
    return str(section.get("type")) if isinstance(section, dict) else ""


def _text(number: int | None) -> str | None:
    return None if number is None else str(number)


def _least(reports: Sequence[dict[str, Any]], *keys: str) -> float | None:
    numbers = [number for report in reports if (number := _number(report, *keys)) is not None]
    return min(numbers, default=None)


def _whole(report: dict[str, Any], *keys: str) -> int | None:
    number = _number(report, *keys)
    return None if number is None else int(number)


def _number(report: dict[str, Any], *keys: str) -> float | None:
    """Returns the number under these nested keys; None if there is none. A text counts as in `as_number`."""
    value: Any = report
    for key in keys:
        value = value.get(key) if isinstance(value, dict) else None
    return as_number(value)
