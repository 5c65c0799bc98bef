# SPDX-License-Identifier: BSD-3-Clause
"""Figure of the set-up of one contact: both surfaces, initial gaps, normals, and which nodes face which.

Nodes of the first surface that face nothing are marked.
"""

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from signorom_post.arrays import FloatArray, IntArray, format_number, with_unit
from signorom_post.plots.drawing import draw_arrows, draw_cells, draw_edges, frame
from signorom_post.plots.sheet import color_facets, frame_sheet, lay_out, sheet_from_corner
from signorom_post.plots.surface import frame_surface
from signorom_post.readers.check import LINK, SURFACE, CheckFile
from signorom_post.style import BLUE, BODY, GRAY, INK, LIGHT_GRAY, ORANGE, SEQUENTIAL, VERMILLION, new_figure

#: a figure has fewer than twice this number of normals: more would cover each other
MOST_NORMALS = 40
#: length of normals in the plane, as a share of the size of the contact surfaces; in space normals are twice as long
NORMAL = 0.07
#: lengths below this share of the size of the mesh are taken as rounding errors
ROUNDING = 1e-9
#: colors of gaps; facets whose nodes have no contact row are gray
GAPS = mpl.colormaps[SEQUENTIAL].with_extremes(bad=LIGHT_GRAY)
#: least width of the picture in space, as a share of its height; the directions and the scale below it need this width
LEAST_WIDTH = 0.7


def check_contact(check: CheckFile, entry: int) -> Figure:
    """Returns the figure of one contact: both surfaces, nodes that face each other, normals and gaps.

    `entry` is the number of the contact in the deck's section `contact`, from 1.
    """
    return _solid(check, entry) if check.mesh.n_dim == 3 else _plane(check, entry)


def _plane(check: CheckFile, entry: int) -> Figure:
    points = check.mesh.coordinates[:, :2]
    first, second = check.of(SURFACE, contact=entry, side=1), check.of(SURFACE, contact=entry, side=2)
    nodes = np.unique(np.concatenate(first + second))
    low, high = points[nodes].min(axis=0), points[nodes].max(axis=0)
    size = float((high - low).max())
    middle, half = 0.5 * (low + high), np.maximum(0.5 * (high - low) + 0.12 * size, 0.3 * size)
    low, high = middle - half, middle + half
    width, height = high - low
    figure = new_figure(8.6, float(np.clip(5.6 * height / width + 1.0, 3.0, 8.0)), has_equal_axes=True)
    axes = figure.subplots()
    draw_cells(axes, points, check.mesh.cells, BODY)
    draw_edges(axes, points, check.mesh.edges, LIGHT_GRAY, 0.4)
    _draw_links(axes, check, entry, points)
    axes.add_collection(
        LineCollection([points[line] for line in second], colors=ORANGE, linewidths=5.0, zorder=3)
    )
    gaps = _gap_colors(check, entry)
    lines = LineCollection([points[line] for line in first], linewidths=2.4, zorder=4, gid="first")
    lines.set(cmap=GAPS, norm=gaps, array=_of_facets(check, first))
    axes.add_collection(lines)
    _draw_normals(axes, check, entry, points, np.eye(3)[:2], NORMAL * size)
    _mark_nodes(axes, check, entry, points, nodes)
    frame(axes, points[nodes], check.mesh.unit, check.axis_names[:2])
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    _finish(figure, axes, check, entry, gaps)
    return figure


def _solid(check: CheckFile, entry: int) -> Figure:
    """Left: both surfaces at their places, from a corner. Right: the first surface alone, in the view of `lay_out`."""
    points = check.mesh.coordinates
    first, second = check.of(SURFACE, contact=entry, side=1), check.of(SURFACE, contact=entry, side=2)
    nodes = np.unique(np.concatenate(first + second))
    size = float(np.ptp(points[nodes], axis=0).max())
    gaps = _gap_colors(check, entry)
    aside = sheet_from_corner(points, first)
    flat = aside.flat
    figure = new_figure(10.6, 4.8, has_equal_axes=True)
    left, right = figure.subplots(1, 2)
    color_facets(left, aside, _of_facets(check, first), GAPS, gaps, "first at its place")
    left.add_collection(
        PolyCollection(
            [flat[face] for face in second], facecolors="none", edgecolors=ORANGE, linewidths=0.7, zorder=3
        )
    )
    _draw_links(left, check, entry, flat)
    _draw_normals(left, check, entry, flat, aside.towards[:2], 2.0 * NORMAL * size)
    room = _room(flat[nodes], points[nodes], aside.towards)
    frame_surface(left, np.vstack([points[nodes], room]), check.mesh.unit, aside.towards)
    alone = lay_out(points, first, check["contact_normal"], np.ones(len(points)))
    color_facets(right, alone, _of_facets(check, first), GAPS, gaps, "first")
    _mark_nodes(right, check, entry, alone.flat, alone.nodes)
    frame_sheet(right, alone, check.mesh.unit)
    right.set_title("first surface alone" + ("" if alone.is_whole else ", one side of it"))
    _finish(figure, left, check, entry, gaps)
    return figure


def _room(flat: FloatArray, points: FloatArray, towards: FloatArray) -> FloatArray:
    """Returns two points that widen the picture of a surface which the viewer sees from the side; shape (2, 3).

    `points` are nodes of the surface, and `flat` their places in the picture that `towards` gives.
    """
    width, height = np.ptp(flat, axis=0)
    aside = 0.5 * max(width, LEAST_WIDTH * height) * towards[0]
    middle = 0.5 * (flat.min(axis=0) + flat.max(axis=0)) @ towards[:2]
    depth = (points @ towards[2]).mean() * towards[2]
    return np.array([middle + depth - aside, middle + depth + aside])


def _of_facets(check: CheckFile, facets: list[IntArray]) -> FloatArray:
    """Returns the mean gap of the nodes of each facet, masked for a facet whose nodes have no contact row."""
    gaps = check["gap"]
    means = np.full(len(facets), np.nan)
    for i, facet in enumerate(facets):
        known = gaps[facet][np.isfinite(gaps[facet])]
        if known.size:
            means[i] = known.mean()
    return np.ma.masked_invalid(means)


def _owners(check: CheckFile, entry: int) -> IntArray:
    """Returns the nodes that own a contact row of this contact, inert pairs included."""
    return np.flatnonzero((check["contact_row"] > 0) & (check["contact_entry"] == entry))


def _gap_colors(check: CheckFile, entry: int) -> Normalize:
    gaps = check["gap"][_owners(check, entry)]
    if _is_constant(check, entry):
        middle = float(gaps.mean()) if gaps.size else 0.0
        return Normalize(middle - check.mesh.size, middle + check.mesh.size)
    return Normalize(float(gaps.min()), float(gaps.max()))


def _is_constant(check: CheckFile, entry: int) -> bool:
    gaps = check["gap"][_owners(check, entry)]
    return not gaps.size or float(np.ptp(gaps)) <= ROUNDING * check.mesh.size


def _draw_links(axes: Axes, check: CheckFile, entry: int, flat: FloatArray) -> None:
    """Draws a line from each node with a contact row to each node that it faces.

    The smaller the share of the facing node in the row, the paler is the line.
    """
    links = check.indices(LINK, contact=entry)
    if not links.size:
        return
    shares = np.clip(check["share"][links], 0.08, 1.0)
    colors = np.column_stack([np.tile(0.35, (len(links), 3)), shares])
    segments = [flat[check.cells[i]] for i in links]
    axes.add_collection(LineCollection(segments, colors=colors, linewidths=0.7, zorder=2, gid="links"))


def _draw_normals(
    axes: Axes, check: CheckFile, entry: int, flat: FloatArray, directions: FloatArray, length: float
) -> None:
    """Draws the normals of some contact nodes, spread over the surface."""
    nodes = _owners(check, entry)
    order = np.lexsort(np.round(flat[nodes], 12).T)
    nodes = nodes[order][:: max(1, len(nodes) // MOST_NORMALS)]
    arrows = length * check["contact_normal"][nodes] @ directions.T
    draw_arrows(axes, flat[nodes], arrows, BLUE, "normals", zorder=5)


def _mark_nodes(axes: Axes, check: CheckFile, entry: int, flat: FloatArray, shown: IntArray) -> None:
    """Marks, of the nodes `shown`, those that face nothing (crosses), and the inert pairs (squares)."""
    alone, inert = (np.intersect1d(nodes, shown) for nodes in (_alone(check, entry), _inert(check, entry)))
    axes.plot(*flat[alone].T, "x", color=VERMILLION, markersize=6, markeredgewidth=1.4, zorder=6, gid="alone")
    style = {
        "markerfacecolor": "white",
        "markeredgecolor": INK,
        "markersize": 4.5,
        "zorder": 6,
        "gid": "inert",
    }
    axes.plot(*flat[inert].T, "s", **style)


def _alone(check: CheckFile, entry: int) -> IntArray:
    nodes = np.unique(np.concatenate(check.of(SURFACE, contact=entry, side=1)))
    return nodes[check["contact_side"][nodes] == 0]


def _inert(check: CheckFile, entry: int) -> IntArray:
    nodes = _owners(check, entry)
    return nodes[check["contact_row"][nodes] == 2]


def _finish(figure: Figure, axes: Axes, check: CheckFile, entry: int, gaps: Normalize) -> None:
    """Adds the title, the legend and the color scale of the gaps; of a constant gap the legend has the number."""
    owners, alone, inert = _owners(check, entry), _alone(check, entry), _inert(check, entry)
    title = f"contact {entry}: {check.names['contacts'][entry - 1]}"
    if check.mesh.n_dim == 3:
        figure.suptitle(title, x=0.01, ha="left", fontsize=10)
    else:
        axes.set_title(title)
    partners = check["n_partners"][owners]
    most = int(partners.max(initial=0))
    facing = {0: "rigid obstacle", 1: "pairs of nodes"}.get(most, f"up to {most} partners of a node")
    has_second = bool(check.of(SURFACE, contact=entry, side=2))
    if has_second and not owners.size:
        facing = "nothing faces each other"
    area, unit = float(check["contact_area"][owners].sum()), check.fields["contact_area"].unit
    handles = [
        Line2D([], [], color=ORANGE, linewidth=2.0, label="second surface"),
        Line2D([], [], color=BLUE, marker=">", markersize=4, label="normals, first to second"),
        Line2D([], [], color=GRAY, linewidth=0.8, label=facing),
        Line2D([], [], linestyle="none", label=f"nodes with a row: {len(owners)}"),
        Line2D([], [], linestyle="none", label=f"area {format_number(area)} {unit.replace('2', '²')}"),
    ]
    if not has_second:
        handles = [handles[1], handles[2], *handles[3:]]
    if inert.size:
        mark = {"marker": "s", "markerfacecolor": "white", "markeredgecolor": INK, "markersize": 4.5}
        handles.append(
            Line2D([], [], linestyle="none", label=f"prescribed on both sides: {len(inert)}", **mark)
        )
    if alone.size:
        mark = {"marker": "x", "color": VERMILLION, "markeredgewidth": 1.4}
        handles.append(
            Line2D([], [], linestyle="none", label=f"nodes that face nothing: {len(alone)}", **mark)
        )
    unit = check.fields["gap"].unit
    if not owners.size:
        pass
    elif _is_constant(check, entry):
        gap = float(check["gap"][owners[0]])
        gap = 0.0 if abs(gap) < ROUNDING * check.mesh.size else gap
        handles.append(
            Line2D([], [], linestyle="none", label=f"gap everywhere {format_number(gap)} {unit}".rstrip())
        )
    else:
        label = with_unit("gap of the first surface", unit)
        figure.colorbar(ScalarMappable(gaps, GAPS), ax=figure.axes, label=label, pad=0.02, shrink=0.85)
    figure.legend(handles=handles, loc="outside lower center", ncols=4, columnspacing=1.2)
