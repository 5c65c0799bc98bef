# SPDX-License-Identifier: BSD-3-Clause
"""Writes all figures for which a results folder has the files."""

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from signorom_post.arrays import with_unit, without_unit_one
from signorom_post.errors import InputError, MissingFileError
from signorom_post.log import Log
from signorom_post.plots.clusters import clusters
from signorom_post.plots.enrichment import enrichment
from signorom_post.plots.errors import errors
from signorom_post.plots.errors_over_time import errors_over_time
from signorom_post.plots.histories import histories
from signorom_post.plots.hysteresis import hysteresis
from signorom_post.plots.initial_and_deformed import initial_and_deformed
from signorom_post.plots.multipliers import multipliers
from signorom_post.plots.pressure_maps import pressure_maps
from signorom_post.plots.reduced_domain import reduced_domain
from signorom_post.plots.singular_values import singular_values
from signorom_post.plots.solid_figures import initial_and_deformed_solid
from signorom_post.plots.stick_slip import stick_slip
from signorom_post.readers.fields import FieldFile, FieldPoint
from signorom_post.readers.histories import read_curves
from signorom_post.results import Results
from signorom_post.style import save, styled

FORMATS = ("png", "pdf", "svg")
COLORS = ("displacement", "contact")
#: [points] an error that names the points of a file names the last one and as many of the first ones as come to this sum
MOST_NAMED = 10


class NotDrawableError(Exception):
    """The files are valid, but have no data for this figure; the message says why."""


@dataclass(frozen=True)
class FigureOptions:
    """The choices of the user."""

    #: point of the figure `initial_and_deformed`: its number, from 1, or its label; None: the middle one of the file.
    #: The figure `stick_slip` shows the history of this point; None: the first one
    point: str | None = None
    #: columns of history.csv along the axes of the figure `hysteresis`; None: those of read_curves
    x: str | None = None
    y: str | None = None
    #: what gives the colors of the figure `initial_and_deformed`: `displacement` or `contact` (the contact pressure)
    color: str = "displacement"
    #: names of the figures to draw; None: all
    only: tuple[str, ...] | None = None


@dataclass(frozen=True)
class Outcome:
    """The outcome of one file of a figure, or of a figure that was left out."""

    #: name of the figure, a key of BUILDERS
    name: str
    #: file that was written; None if the figure was left out
    path: Path | None
    #: why the figure was left out
    reason: str = ""
    #: whether it was left out because a file is there, but cannot be used or does not have the chosen point
    is_failure: bool = False


def write_figures(
    results: Results, output: Path, file_format: str, options: FigureOptions
) -> Iterator[Outcome]:
    """Writes the chosen figures into the folder `output`, which must exist, and yields the outcome of each file.

    `file_format` is one of FORMATS. A figure that cannot be drawn gives one outcome without a path, and the next figure
    follows. A figure that does not apply to the kind of model, such as `clusters` if there are not several clusters,
    gives no outcome if all figures are chosen. OSError if a file cannot be written.
    """
    for name, build in BUILDERS.items():
        if options.only is not None and name not in options.only:
            continue
        try:
            with styled():
                for suffix, figure in build(results, options):
                    path = output / f"{name}{suffix}.{file_format}"
                    save(figure, path)
                    yield Outcome(name, path)
        except MissingFileError as error:
            yield Outcome(name, None, f"{error.path}: {error.sentence}")
        except NotDrawableError as error:
            yield Outcome(name, None, str(error))
        except InputError as error:
            yield Outcome(name, None, str(error), is_failure=True)


def follow_figures(
    log: Log, results: Results, output: Path, file_format: str, options: FigureOptions
) -> Iterator[Outcome]:
    """Writes the figures like `write_figures`, yields the outcome of each, and shows the progress."""
    names = [name for name in BUILDERS if options.only is None or name in options.only]
    outcomes = write_figures(results, output, file_format, options)
    return log.follow("figures", outcomes, len(names), lambda outcome: names.index(outcome.name) + 1)


def choose_point(fields: FieldFile, wanted: str | None) -> FieldPoint:
    """Returns the point of the field file whose number (from 1) is `wanted`, or else the first one with this label.

    If `wanted` is None, it returns the middle point; of an even number of points, the second one in the middle.
    NotDrawableError if the file has no points, InputError if no point has this number or label.
    """
    if not fields.points:
        raise NotDrawableError(f"{fields.path}: there is no parameter point")
    if wanted is None:
        return fields.points[len(fields.points) // 2]
    if wanted.isascii() and wanted.isdigit() and 1 <= int(wanted) <= len(fields.points):
        return fields.points[int(wanted) - 1]
    for point in fields.points:
        if point.label == without_unit_one(wanted):
            return point
    known = [f"{i} ({point.label})" for i, point in enumerate(fields.points, start=1)]
    if len(known) > MOST_NAMED:
        known[MOST_NAMED - 1 : -1] = ["..."]
    raise InputError(fields.path, f"there is no point '{wanted}'; the file has {', '.join(known)}")


def history_of(fields: FieldFile, point: FieldPoint) -> list[FieldPoint]:
    """Returns the points of the file that belong to the history of a point: neighbors whose times ascend."""
    times = [p.parameters[p.parameter_names.index("time")] for p in fields.points]
    first = last = next(i for i, other in enumerate(fields.points) if other is point)
    while first > 0 and times[first - 1] < times[first]:
        first -= 1
    while last + 1 < len(times) and times[last] < times[last + 1]:
        last += 1
    return fields.points[first : last + 1]


def _initial_and_deformed(results: Results, options: FigureOptions) -> Iterator[tuple[str, Figure]]:
    fields = results.fields
    point = choose_point(fields, options.point)
    needed = ["displacement", "contact_pressure"] if options.color == "contact" else ["displacement"]
    for name in needed:
        if name not in point.fields:
            raise NotDrawableError(f"{fields.path}: the point '{point.label}' has no field '{name}'")
    if fields.mesh.n_dim == 3:
        yield "", initial_and_deformed_solid(fields, point, options.color)
    else:
        yield "", initial_and_deformed(fields, point, options.color, axis_names(results))


def axis_names(results: Results) -> tuple[str, str]:
    """Returns the names of the axes from the model or, if there is no model, from the report; else x and y."""
    if results.model_if_present is not None:
        return results.model.axis_names
    try:
        mesh = results.report.get("deck", {}).get("mesh", {})
    except (MissingFileError, AttributeError):
        return ("x", "y")
    return ("r", "z") if mesh.get("model") == "axisymmetric" else ("x", "y")


def _reduced_domain(results: Results, options: FigureOptions) -> Iterator[tuple[str, Figure]]:
    fields, model = results.fields, results.model_if_present
    if model is None:
        if not any("reduced_domain" in point.fields for point in fields.points):
            raise NotDrawableError(f"{fields.path}: no point has the field 'reduced_domain'")
        yield "", reduced_domain(fields, None)
        return
    if not model.clusters:
        if options.only is not None:
            raise NotDrawableError(
                f"{model.path}: only a hyper-reduced model has a reduced integration domain"
            )
        return
    for cluster in model.clusters:
        suffix = f"_{cluster.name}" if len(model.clusters) > 1 else ""
        yield suffix, reduced_domain(fields, cluster, model.axis_names)


def _multipliers(results: Results, _options: FigureOptions) -> Iterator[tuple[str, Figure]]:
    fields = results.fields
    if not any("multipliers_full_order" in point.fields for point in fields.points):
        raise NotDrawableError(f"{fields.path}: no point has the field 'multipliers_full_order'")
    if fields.contact.n_rows == 0:
        raise NotDrawableError(f"{fields.path}: there are no contact rows")
    if fields.mesh.n_dim == 3:
        yield "", pressure_maps(fields, results.model_if_present, results.surfaces)
    else:
        yield "", multipliers(fields, results.model_if_present, axis_names(results), results.surfaces)


def _errors(results: Results, _options: FigureOptions) -> Iterator[tuple[str, Figure]]:
    yield "", errors(results.validation, results.model_if_present)


def _errors_over_time(results: Results, options: FigureOptions) -> Iterator[tuple[str, Figure]]:
    try:
        validation = results.validation
    except MissingFileError:
        if options.only is not None:
            raise
        return
    if validation.estimates is not None and "time" in validation.parameter_names:
        yield "", errors_over_time(validation, _units(_deck(results))["time"])
    elif options.only is not None:
        raise NotDrawableError(
            f"{validation.path}: there is no history whose answers have an estimate of their error"
        )


def _clusters(results: Results, options: FigureOptions) -> Iterator[tuple[str, Figure]]:
    if len(results.model.clusters) > 1:
        yield "", clusters(results.validation, results.model)
    elif options.only is not None:
        raise NotDrawableError(
            f"{results.model.path}: the model does not have several hyper-reduced clusters"
        )


def _singular_values(results: Results, options: FigureOptions) -> Iterator[tuple[str, Figure]]:
    if results.model.clusters:
        yield "", singular_values(results.model)
    elif options.only is not None:
        raise NotDrawableError(f"{results.model.path}: only a hyper-reduced model has singular values")


def _enrichment(results: Results, options: FigureOptions) -> Iterator[tuple[str, Figure]]:
    model = results.model_if_present
    if model is not None and not model.clusters:
        if options.only is not None:
            raise NotDrawableError(f"{model.path}: only a hyper-reduced model has hat functions")
        return
    histories = results.enrichment
    if not any(history.n_hats for history in histories):
        raise NotDrawableError(f"{results.folder / 'enrichment.csv'}: the model has no hat functions")
    yield "", enrichment(histories)


def _histories(results: Results, options: FigureOptions) -> Iterator[tuple[str, Figure]]:
    try:
        shown = results.histories
    except MissingFileError:
        if options.only is not None:
            raise
        return
    n_contacts = shown[0].areas.shape[1]
    if n_contacts == 0:
        raise NotDrawableError(f"{results.folder / 'history.csv'}: the deck has no contact")
    deck = _deck(results)
    contacts = deck.get("contact") if isinstance(deck.get("contact"), list) else []
    names = [
        f"{k + 1}: {_name_of(contacts[k])}" if k < len(contacts) else str(k + 1) for k in range(n_contacts)
    ]
    yield "", histories(shown, names, _units(deck))


def _deck(results: Results) -> dict[str, Any]:
    return _mapping(results.report.get("deck")) if (results.folder / "report.yaml").is_file() else {}


def _units(deck: dict[str, Any]) -> dict[str, str]:
    """Returns the units of time, force, area, moment and work, empty where the deck does not tell them."""
    told = _mapping(deck.get("units"))
    is_plane = str(_mapping(deck.get("mesh")).get("model")).startswith("plane")
    length, force = str(told.get("length", "")), str(told.get("force", ""))
    work = f"{force}*{length}" if force and length else ""
    return {
        "time": str(told.get("time", "")),
        "force": f"{force}/{length}" if is_plane and force else force,
        "area": length if is_plane or not length else f"{length}²",
        "work": f"{work}/{length}" if is_plane and work else work,
    }


#: pattern of a column of history.csv -> key of its unit in _units
COLUMN_UNITS = {
    r"time": "time",
    r"contact_force|contact_\d+_force_\w|lambda_\d+|tau_\d+(_\d)?": "force",
    r"contact_\d+_area": "area",
    r"contact_\d+_(moment\w*|dissipation)": "work",
}


def _hysteresis(results: Results, options: FigureOptions) -> Iterator[tuple[str, Figure]]:
    path = results.folder / "history.csv"
    is_wanted = options.only is not None or options.x is not None or options.y is not None
    if not is_wanted and not _has_friction(path):
        return
    curves, names = read_curves(path, options.x, options.y)
    units = _units(_deck(results))
    labels = [
        with_unit(name, next((units[u] for p, u in COLUMN_UNITS.items() if re.fullmatch(p, name)), ""))
        for name in names
    ]
    yield "", hysteresis(curves, (labels[0], labels[1]))


def _has_friction(path: Path) -> bool:
    """Returns whether there is a history.csv with columns of friction."""
    if not path.is_file():
        return False
    with path.open(encoding="utf-8", errors="replace") as file:
        return re.search(r"contact_\d+_dissipation", file.readline()) is not None


def _stick_slip(results: Results, options: FigureOptions) -> Iterator[tuple[str, Figure]]:
    try:
        fields = results.fields
    except MissingFileError:
        if options.only is not None:
            raise
        return
    has_status = any("friction_status" in point.fields for point in fields.points)
    if not has_status or "time" not in fields.points[0].parameter_names:
        if options.only is not None:
            raise NotDrawableError(f"{fields.path}: there is no history with friction")
        return
    history = history_of(fields, choose_point(fields, options.point or "1"))
    unit = _units(_deck(results))["time"]
    names = (*axis_names(results), "z")
    yield "", stick_slip(fields, history, results.surfaces.surfaces, names, unit)


def _mapping(value: Any) -> dict[str, Any]:
    return value if isinstance(value, dict) else {}


def _name_of(contact: Any) -> str:
    entry = _mapping(contact)
    return f"{entry.get('first', '?')} - {entry.get('second', 'obstacle')}"


#: name of a figure, which is its file without the ending -> procedure that draws it
BUILDERS: dict[str, Callable[[Results, FigureOptions], Iterator[tuple[str, Figure]]]] = {
    "initial_and_deformed": _initial_and_deformed,
    "reduced_domain": _reduced_domain,
    "multipliers": _multipliers,
    "histories": _histories,
    "hysteresis": _hysteresis,
    "stick_slip": _stick_slip,
    "errors": _errors,
    "errors_over_time": _errors_over_time,
    "clusters": _clusters,
    "singular_values": _singular_values,
    "enrichment": _enrichment,
}
