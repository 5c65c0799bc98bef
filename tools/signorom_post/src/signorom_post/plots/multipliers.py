# SPDX-License-Identifier: BSD-3-Clause
"""Figure of the contact forces of both models along each contact surface in the plane (paper, Figure 6b)."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from signorom_post.arrays import BoolArray, FloatArray, IntArray, with_unit
from signorom_post.plots.captions import point_texts, surface_title
from signorom_post.plots.chains import chains_of, positions_along
from signorom_post.readers.fields import FieldFile, FieldPoint
from signorom_post.readers.model import Model
from signorom_post.readers.surfaces import ContactSurface, ContactSurfaces, surfaces_of_fields
from signorom_post.style import GRAY, INK, add_grid, new_figure, ordered_colors

#: largest number of curves; the reader could not tell more of them apart
MAX_CURVES = 6
#: largest number of panels, and of panels side by side
MAX_PANELS, MAX_COLUMNS = 9, 3
#: forces up to this share of the largest one are rounding
ROUNDING = 1e-9
#: [characters] what fits into an inch of the legend, and what an entry needs beside its text
PER_INCH, HANDLE = 12.0, 6
#: markers of a contact in the RID, of a reconstructed force, and of a model without a RID
MARKERS: dict[str, dict[str, Any]] = {
    "reduced": {"markersize": 6.5, "markeredgecolor": "white", "markeredgewidth": 0.8, "zorder": 4},
    "reconstructed": {
        "markersize": 4.0,
        "markerfacecolor": "white",
        "markeredgewidth": 0.8,
        "alpha": 0.55,
        "zorder": 3,
    },
    "model": {"markersize": 4.0, "markerfacecolor": "none", "markeredgewidth": 0.8, "zorder": 3},
}


def multipliers(
    fields: FieldFile,
    model: Model | None = None,
    names: tuple[str, str] = ("x", "y"),
    surfaces: ContactSurfaces | None = None,
) -> Figure:
    """Returns a figure with a panel for each contact surface, at up to six points with full-order multipliers.

    Lines are full-order multipliers and markers are reduced ones. In a hyper-reduced model a filled marker is a contact
    in the RID, a pale one a reconstructed multiplier. Off the RID there is no marker where both multipliers are zero.
    On quadratic facets, whose nodal forces alternate, the figure shows the contact pressure. The x axis says whether it
    is a coordinate or the length along the surface. If there are more than six such points, six of them are drawn,
    spread over the file; at least one must be there. `model` tells its kind and the units of the parameters, `names`
    are the names of the axes of the mesh. `surfaces` are those of contact.h5; default: those of `fields`, no names.
    """
    surfaces = surfaces_of_fields(fields) if surfaces is None else surfaces
    found = [i for i, point in enumerate(fields.points) if "multipliers_full_order" in point.fields]
    chosen = found if len(found) <= MAX_CURVES else [found[i] for i in spread(len(found), MAX_CURVES)]
    chosen = sorted(chosen, key=lambda i: tuple(fields.points[i].parameters))
    curves = [_Curves(surfaces, i, _is_hyper_reduced(fields.points[i], model)) for i in chosen]
    shown = _most_loaded(surfaces.surfaces, curves)
    n_columns = min(len(shown), MAX_COLUMNS)
    n_rows = -(-len(shown) // n_columns)
    width = 7.2 if n_columns == 1 else 1.0 + 3.4 * n_columns
    texts = point_texts([fields.points[i] for i in chosen], model, round(PER_INCH * width) - HANDLE)
    n_lines = sum(text.count("\n") + 1 for text in texts)
    figure = new_figure(width, 0.6 + (3.7 if n_rows == 1 else 2.9) * n_rows + 0.15 * n_lines)
    panels = figure.subplots(n_rows, n_columns, squeeze=False, sharey=True).ravel()
    colors = ordered_colors(len(chosen))
    for axes, surface in zip(panels, shown, strict=False):
        _draw(axes, surface, curves, colors, names)
        axes.set_title(surface_title(surface.name))
    for axes in panels[len(shown) :]:
        axes.set_axis_off()
    quantity = "contact pressure" if surfaces.is_quadratic else r"multiplier $\lambda$"
    for axes in panels[::n_columns]:
        axes.set_ylabel(with_unit(quantity, curves[0].unit))
    if len(shown) < len(surfaces.surfaces):
        figure.suptitle(
            f"{len(shown)} of {len(surfaces.surfaces)} contacts, those with the largest forces",
            x=0.01,
            ha="left",
        )
    figure.legend(handles=_kinds(curves), loc="outside upper center", ncols=3, columnspacing=1.8)
    _add_points(figure, texts, colors, width)
    return figure


def spread(n_items: int, n_chosen: int) -> list[int]:
    """Returns up to `n_chosen` indices from 0 to n_items - 1 at equal distances, the first and the last included."""
    return sorted({round(i) for i in np.linspace(0, n_items - 1, n_chosen)})


def _is_hyper_reduced(point: FieldPoint, model: Model | None) -> bool:
    """Returns whether a RID, not all contacts, carries the reduced forces; the model tells it, else the fields."""
    if model is not None:
        return bool(model.clusters)
    return len(point.reduced_rows) < len(point.fields["multipliers_full_order"].values)


class _Curves:
    """What is drawn of one point: values at the nodes, shape (n_nodes), nan where there are none."""

    def __init__(self, surfaces: ContactSurfaces, i_point: int, is_hyper_reduced: bool) -> None:
        read = surfaces.pressures if surfaces.is_quadratic else surfaces.forces
        point = surfaces.fields.points[i_point]
        full = read(i_point, "multipliers_full_order")
        self.full, self.unit = full.values, full.unit
        self.points, self.length_unit = surfaces.fields.mesh.coordinates, surfaces.fields.mesh.unit
        self.in_domain = np.zeros(len(self.full), dtype=bool)
        self.in_domain[surfaces.fields.contact.owners[point.reduced_rows]] = True
        self.markers: dict[str, FloatArray] = {}
        if "multipliers_reduced" not in point.fields:
            return
        reduced = read(i_point, "multipliers_reduced").values
        if not is_hyper_reduced:
            self.markers["model"] = np.where(_is_force(reduced) | _is_force(self.full), reduced, np.nan)
            return
        is_other = ~self.in_domain & (_is_force(reduced) | _is_force(self.full))
        self.markers["reconstructed"] = np.where(is_other, reduced, np.nan)
        self.markers["reduced"] = np.where(self.in_domain, reduced, np.nan)

    def is_shown(self, nodes: IntArray) -> BoolArray:
        """Returns whether the x axis must have each node: it is closed in the full order, or in the RID."""
        is_marked = self.in_domain[nodes] & ("reduced" in self.markers)
        return is_marked | _is_force(self.full)[nodes]


def _is_force(values: FloatArray) -> BoolArray:
    """Returns whether each value is more than rounding; nan is none."""
    sizes = np.abs(np.nan_to_num(values))
    return sizes > ROUNDING * sizes.max(initial=0.0)


def _most_loaded(surfaces: list[ContactSurface], curves: list[_Curves]) -> list[ContactSurface]:
    """Returns the surfaces with the largest values, as many as there may be panels, in their order."""
    largest = [
        max(float(np.nan_to_num(curve.full[surface.nodes]).max()) for curve in curves) for surface in surfaces
    ]
    kept = np.sort(np.argsort(-np.array(largest), kind="stable")[:MAX_PANELS])
    return [surfaces[i] for i in kept]


def _draw(
    axes: Axes,
    surface: ContactSurface,
    curves: list[_Curves],
    colors: list[Any],
    names: tuple[str, str],
) -> None:
    """Draws the curves of all points along one surface: a line joins only nodes that are neighbors."""
    add_grid(axes)
    axes.axhline(0.0, color=GRAY, linewidth=0.8, zorder=1)
    points = curves[0].points
    chains = chains_of(surface.facets, points)
    places, label = positions_along(chains, points, names, curves[0].length_unit)
    # nan between two lines
    nodes = np.concatenate([np.append(chain, -1) for chain in chains])[:-1]
    position = np.concatenate([np.append(place, np.nan) for place in places])[:-1]
    shown = np.zeros(len(nodes), dtype=bool)
    for curve, color in zip(curves, colors, strict=True):
        at = np.where(nodes >= 0, curve.full[nodes], np.nan)
        axes.plot(position, at, color=color, linewidth=1.5, zorder=2, gid="full order")
        shown |= (nodes >= 0) & curve.is_shown(nodes)
        for kind, values in curve.markers.items():
            is_there = (nodes >= 0) & ~np.isnan(values[nodes])
            place, value = position[is_there], values[nodes[is_there]]
            axes.plot(place, value, "o", color=color, gid=kind, **MARKERS[kind])
    _limit(axes, position, shown)
    axes.set_xlabel(label)
    axes.xaxis.set_major_locator(MaxNLocator(5))
    axes.ticklabel_format(axis="x", useOffset=False)


def _limit(axes: Axes, position: FloatArray, shown: BoolArray) -> None:
    """Limits the x axis, with a margin, to the positions `shown` and two neighbors each; to all if there are none."""
    near = np.convolve(shown, np.ones(5))[2:-2] > 0.5 if shown.any() else np.ones_like(shown)
    low, high = np.nanmin(position[near]), np.nanmax(position[near])
    margin = 0.06 * float(high - low)
    axes.set_xlim(low - margin, high + margin)


def _kinds(curves: list[_Curves]) -> list[Line2D]:
    """Returns the entries of the legend; markers have none if there is no reduced model."""
    texts = {
        "model": "reduced model",
        "reduced": "HHR, on the RID",
        "reconstructed": "HHR, reconstructed",
    }
    kinds = [Line2D([], [], color=INK, linewidth=1.5, label="full order")]
    for kind, text in texts.items():
        if any(kind in curve.markers for curve in curves):
            style = {name: value for name, value in MARKERS[kind].items() if name != "zorder"}
            kinds.append(Line2D([], [], marker="o", linestyle="none", color=INK, label=text, **style))
    return kinds


def _add_points(figure: Figure, texts: list[str], colors: list[Any], width: float) -> None:
    """Adds a legend below the panels with the parameters of each point; `width` of the figure [inch]."""
    longest = max(len(line) for text in texts for line in text.split("\n")) + HANDLE
    handles = [
        Line2D([], [], color=color, linewidth=1.5, label=text)
        for color, text in zip(colors, texts, strict=True)
    ]
    n_columns = int(np.clip(PER_INCH * width // longest, 1, 4))
    figure.legend(handles=handles, loc="outside lower center", ncols=n_columns, columnspacing=1.8)
