# SPDX-License-Identifier: BSD-3-Clause
"""Figure of the contact pressure of solid bodies: a column of panels for each contact and point."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from signorom_post.arrays import FloatArray, with_unit
from signorom_post.plots.captions import point_texts, surface_title
from signorom_post.plots.multipliers import spread
from signorom_post.plots.sheet import Sheet, color_nodes, frame_sheet, lay_out
from signorom_post.plots.surface import normals_of
from signorom_post.readers.fields import FieldFile
from signorom_post.readers.model import Model
from signorom_post.readers.surfaces import ContactSurface, ContactSurfaces, surfaces_of_fields
from signorom_post.style import SEQUENTIAL, new_figure

#: largest number of panels side by side; more would be too small to read
MAX_PANELS = 4
#: [characters] a longer name of a contact does not fit above a panel
NARROW = 16
#: forces of fields.h5 -> text beside its row of panels
ROWS = {"multipliers_full_order": "full order", "multipliers_reduced": "reduced model"}


def pressure_maps(
    fields: FieldFile, model: Model | None = None, surfaces: ContactSurfaces | None = None
) -> Figure:
    """Returns a figure of the contact pressure, with a column for each contact at each point.

    `lay_out` chooses the view of each surface. Up to four columns are drawn: of the contacts those
    with the largest pressures, and points spread over those with full-order forces; at least one must have them. The
    full order is above, the reduced model below if there is one. Units of parameters that `fields` lacks come from
    `model`. `surfaces` are those of contact.h5; default: those of `fields`, without names.
    """
    surfaces = surfaces_of_fields(fields) if surfaces is None else surfaces
    found = [i for i, point in enumerate(fields.points) if "multipliers_full_order" in point.fields]
    n_points = max(1, MAX_PANELS // len(surfaces.surfaces))
    chosen = [found[i] for i in spread(len(found), min(n_points, len(found)))]
    kinds = [kind for kind in ROWS if any(kind in fields.points[i].fields for i in chosen)]
    read = {
        (kind, i): surfaces.pressures(i, kind)
        for kind in kinds
        for i in chosen
        if kind in fields.points[i].fields
    }
    pressures = {key: quantity.values for key, quantity in read.items()}
    shown = _most_loaded(surfaces.surfaces, list(pressures.values()))
    norm = Normalize(0.0, max(_largest(values) for values in pressures.values()) or 1.0)
    weights = sum(np.nan_to_num(values) for values in pressures.values()) + 1e-3 * norm.vmax
    outward = _outward(fields)
    sheets = [lay_out(fields.mesh.coordinates, surface.facets, outward, weights) for surface in shown]
    columns = [(i_surface, i) for i_surface in range(len(shown)) for i in chosen]
    figure, panels = _panels(sheets, len(kinds), len(chosen))
    for row, kind in zip(panels, kinds, strict=True):
        for axes, (i_surface, i) in zip(row, columns, strict=True):
            if (kind, i) in pressures:
                color_nodes(axes, sheets[i_surface], pressures[kind, i], SEQUENTIAL, norm, kind)
            frame_sheet(axes, sheets[i_surface], fields.mesh.unit)
            is_narrow = sheets[i_surface].size[0] < sheets[i_surface].size[1]
            axes.xaxis.set_major_locator(MaxNLocator(2 if is_narrow else 3))
        _name_row(row[0], ROWS[kind], sheets[0])
    texts = point_texts(
        [fields.points[i] for i in chosen], model, 1 if len(chosen) > 1 else 45 * len(columns)
    )
    for axes, (i_surface, i) in zip(panels[0], columns, strict=True):
        name = surface_title(shown[i_surface].name, NARROW)
        name += "" if sheets[i_surface].is_whole else "\n(one side of it)"
        text = texts[chosen.index(i)].replace(",\n", "\n") if len(chosen) > 1 else ""
        axes.set_title("\n".join(part for part in (name, text) if part).strip(), fontsize=8)
    _add_title(figure, texts, len(shown), len(surfaces.surfaces))
    label = with_unit("contact pressure", next(iter(read.values())).unit)
    figure.colorbar(ScalarMappable(norm, SEQUENTIAL), ax=panels, label=label, pad=0.02)
    return figure


def _largest(values: FloatArray) -> float:
    return float(np.nan_to_num(values).max(initial=0.0))


def _most_loaded(surfaces: list[ContactSurface], pressures: list[FloatArray]) -> list[ContactSurface]:
    """Returns the surfaces with the largest pressures, as many as there may be columns, in their order."""
    largest = np.array([max(_largest(values[surface.nodes]) for values in pressures) for surface in surfaces])
    return [surfaces[i] for i in np.sort(np.argsort(-largest, kind="stable")[:MAX_PANELS])]


def _outward(fields: FieldFile) -> FloatArray:
    """Returns outward normals, not of unit length, at the corners of outer faces, else zero; shape (n_nodes, 3)."""
    faces = fields.mesh.outer_faces
    outward = np.zeros((fields.mesh.n_nodes, 3))
    for corner in range(4):
        np.add.at(outward, faces.nodes[:, corner], normals_of(fields.mesh.coordinates, faces))
    return outward


def _panels(sheets: list[Sheet], n_rows: int, n_points: int) -> tuple[Figure, np.ndarray]:
    """Returns the figure and its panels, shape (n_rows, number of sheets times n_points): as wide as their sheets."""
    shapes = np.clip([sheet.size[0] / max(sheet.size[1], 1e-12) for sheet in sheets], 0.4, 3.0)
    height = min(2.8, 3.6 / float(shapes.max()))
    widths = np.repeat(height * shapes, n_points)
    size = (1.6 + float(np.sum(widths + 0.7)), 1.5 + (height + 0.5) * n_rows)
    figure = new_figure(*size, has_equal_axes=True)
    ratios = {"width_ratios": widths.tolist()}
    return figure, figure.subplots(n_rows, len(widths), squeeze=False, gridspec_kw=ratios)


def _name_row(axes: Axes, text: str, sheet: Sheet) -> None:
    """Writes the text to the left of the first panel of a row, above the name of its axis if it has one."""
    if sheet.names is not None:
        axes.set_ylabel(f"{text}\n{axes.get_ylabel()}")
    else:
        style = {"rotation": 90, "ha": "right", "va": "center"}
        axes.text(-0.03, 0.5, text, transform=axes.transAxes, **style)


def _add_title(figure: Figure, texts: list[str], n_shown: int, n_surfaces: int) -> None:
    """Adds a title with the point if there is only one, and with the number of contacts if not all are shown."""
    lines = texts if len(texts) == 1 else []
    if n_shown < n_surfaces:
        lines = [*lines, f"{n_shown} of {n_surfaces} contacts, those with the largest pressures"]
    if lines:
        figure.suptitle("\n".join(lines), x=0.01, ha="left", fontsize=10)
