# SPDX-License-Identifier: BSD-3-Clause
"""Figure of the set-up of a deck: regions, named boundaries, supports and loads."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from signorom_post.arrays import BoolArray, FloatArray, IntArray, format_number
from signorom_post.mesh import Faces
from signorom_post.plots.captions import wrapped
from signorom_post.plots.depth_buffer import DepthBuffer
from signorom_post.plots.drawing import draw_arrows, draw_cells, draw_edges, frame
from signorom_post.plots.loads import NEGLIGIBLE, Arrows, load_arrows, nodal_arrows
from signorom_post.plots.surface import draw_surface, frame_surface, normals_of, view
from signorom_post.plots.viewpoint import best_corner
from signorom_post.readers.check import BODY, BOUNDARY, CheckFile
from signorom_post.style import BLUE, GRAY, INK, VERMILLION, cluster_colors, new_figure

#: share of white that is mixed into the colors of the regions
PALE = 0.72
#: length of the longest arrow, as a share of the size of the mesh
ARROW = 0.1
#: shares of the longest arrow: on the outline of a body, an arrow longer than SMALL is stretched to at least SHORTEST,
#: so that small loads are seen beside large ones; an arrow shorter than SMALL keeps its length
SHORTEST, SMALL = 0.3, 0.01
#: there are fewer than twice this number of arrows of one kind on outlines, and inside: more would cover each other.
#: Marks of supports are smaller if there are more marks than this
MOST_ARROWS = 60
#: matplotlib's markers of a prescribed component. In the plane they are carets that point along the component; in space
#: they are dashes for x and y and a ring for z
MARKS = (5, 6)
SOLID_MARKS = ("_", "|", "o")
#: distances of the numbers of boundaries, from the outline and from each other, as shares of the size of the picture
SHIFT, APART = 0.035, 0.06
#: [characters] length of a line of the title in the plane and in space
TITLES = (85, 105)


def check_bodies(check: CheckFile) -> Figure:
    """Returns a figure of the bodies with supports, loads and boundaries, in the plane or in space.

    A support is a mark for each prescribed component. Loads of facets and prescribed displacements that are not zero are
    arrows, some of them if there are many. Named boundaries have numbers. In space there are two views from opposite
    corners, the first one where most is seen of all bodies. Neither shows what the bodies hide.
    """
    return _solid(check) if check.mesh.n_dim == 3 else _plane(check)


def _plane(check: CheckFile) -> Figure:
    mesh, points = check.mesh, check.mesh.coordinates[:, :2]
    width, height = np.ptp(points, axis=0)
    figure = new_figure(8.6, float(np.clip(4.6 * height / width + 0.9, 3.2, 8.0)), has_equal_axes=True)
    axes = figure.subplots()
    regions = check["region"][check.indices(BODY)].astype(int)
    colors = _region_colors(check)
    for region in np.unique(regions):
        draw_cells(
            axes, points, [mesh.cells[i] for i in np.flatnonzero(regions == region)], colors[region - 1]
        )
    draw_edges(axes, points, mesh.edges, "#0000001c", 0.35)
    draw_edges(axes, points, mesh.boundary_edges, INK, 0.9)
    frame(axes, points, mesh.unit, check.axis_names[:2])
    outward = _outward_in_plane(check)
    _number_boundaries(axes, check, outward, np.eye(3), None)
    _draw_supports(axes, check, points, np.ones(mesh.n_nodes, dtype=bool))
    _draw_arrows(axes, check, outward, np.eye(3), None)
    _widen(axes, mesh.size)
    axes.set_title(wrapped(check.label, TITLES[0]))
    axes.legend(
        handles=_handles(check, colors), loc="center left", bbox_to_anchor=(1.02, 0.5), labelspacing=0.6
    )
    return figure


def _solid(check: CheckFile) -> Figure:
    """Two panels: the bodies seen from the best corner, and from the opposite one."""
    mesh = check.mesh
    figure = new_figure(10.2, 4.6, has_equal_axes=True)
    faces, colors = mesh.outer_faces, _region_colors(check)
    rgb = np.array([to_rgb(color) for color in colors])
    regions = check["region"][check.indices(BODY)].astype(int)[faces.cells]
    outward = _outward_in_space(check, faces)
    azimuth, elevation = best_corner(mesh.coordinates, faces)
    titles = ("from above", "from below, behind") if elevation > 0 else ("from below", "from above, behind")
    looks = (view(azimuth, elevation), view(azimuth + 180.0, -elevation))
    for axes, towards, title in zip(figure.subplots(1, 2), looks, titles, strict=True):
        turned = mesh.coordinates @ towards.T
        buffer = draw_surface(axes, mesh.coordinates, faces, rgb[regions - 1], towards)
        frame_surface(axes, mesh.coordinates, mesh.unit, towards)
        _number_boundaries(axes, check, outward, towards, buffer)
        _draw_supports(axes, check, turned[:, :2], buffer.sees(turned))
        _draw_arrows(axes, check, outward, towards, buffer)
        axes.set_title(title)
    figure.suptitle(wrapped(check.label, TITLES[1]), x=0.01, ha="left", fontsize=10)
    figure.legend(handles=_handles(check, colors), loc="outside right center", labelspacing=0.6)
    return figure


def _outward_in_space(check: CheckFile, faces: Faces) -> FloatArray:
    """Returns outward normals, not of unit length, at nodes of outer faces, else zero; shape (n_nodes, 3)."""
    outward = np.zeros((check.mesh.n_nodes, 3))
    normals = normals_of(check.mesh.coordinates, faces)
    for corner in range(4):
        np.add.at(outward, faces.nodes[:, corner], normals)
    middles, middle_normals = _middles(check, outward)
    np.add.at(outward, middles, middle_normals)
    return outward


def _middles(check: CheckFile, outward: FloatArray) -> tuple[IntArray, FloatArray]:
    """Returns the nodes of named quadratic facets that are not corners, and the outward unit normal of their facets.

    A node of two facets comes twice. `outward`, shape (n_nodes, 3), is an outward normal at the corners of the outer
    faces, and zero at all other nodes.
    """
    middles, normals = [np.empty(0, dtype=np.int64)], [np.empty((0, 3))]
    for facet in check.of(BOUNDARY):
        if len(facet) <= 4:
            continue
        around = check.mesh.coordinates[facet]
        normal = np.cross(around, np.roll(around, -1, axis=0)).sum(axis=0)
        normal /= max(float(np.linalg.norm(normal)), np.finfo(float).tiny)
        own = facet[~np.any(outward[facet], axis=1)]
        middles.append(own)
        normals.append(
            np.tile(normal if normal @ outward[facet].sum(axis=0) > 0.0 else -normal, (len(own), 1))
        )
    return np.concatenate(middles), np.concatenate(normals)


def _region_colors(check: CheckFile) -> list[Any]:
    colors = cluster_colors(len(check.names["regions"]))
    return [tuple(1.0 - (1.0 - PALE) * (1.0 - np.array(to_rgb(color)))) for color in colors]


def _outward_in_plane(check: CheckFile) -> FloatArray:
    """Returns outward normals, not of unit length, at nodes of outlines, else zero; shape (n_nodes, 3)."""
    mesh = check.mesh
    outward = np.zeros((mesh.n_nodes, 3))
    edges = np.vstack([np.column_stack([cell, np.roll(cell, -1)]) for cell in mesh.cells])
    owners = np.concatenate([np.full(len(cell), i) for i, cell in enumerate(mesh.cells)])
    _, first, counts = np.unique(np.sort(edges, axis=1), axis=0, return_index=True, return_counts=True)
    for i in first[counts == 1]:
        start, end = mesh.coordinates[edges[i]]
        normal = np.array([end[1] - start[1], start[0] - end[0], 0.0])
        inside = mesh.coordinates[mesh.cells[owners[i]]].mean(axis=0)
        outward[edges[i]] += normal if normal @ (start - inside) > 0.0 else -normal
    return outward


def _number_boundaries(
    axes: Axes, check: CheckFile, outward: FloatArray, towards: FloatArray, buffer: DepthBuffer | None
) -> None:
    """Writes the number of each named boundary next to its middle node, shifted into the body.

    If another number is there, it stands at the nearest node of the boundary that is free. Only facets whose middle the
    viewer sees count; a boundary without them gets no number. `outward`, `towards`, `buffer`: see `_draw_arrows`.
    """
    points = check.mesh.coordinates
    flat, aside = points @ towards[:2].T, outward @ towards[:2].T
    size = float(np.ptp(flat, axis=0).max())
    lengths = np.maximum(np.linalg.norm(aside, axis=1), np.finfo(float).tiny)
    inside = flat - SHIFT * size * aside / lengths[:, None]
    taken = np.full((1, 2), np.inf)
    for number in range(1, len(check.names["boundaries"]) + 1):
        cells = check.of(BOUNDARY, boundary=number)
        if buffer is not None and cells:
            middles = np.array([points[cell].mean(axis=0) for cell in cells])
            cells = [cells[i] for i in np.flatnonzero(buffer.sees(middles @ towards.T))]
        if not cells:
            continue
        nodes = np.unique(np.concatenate(cells))
        far = np.linalg.norm(flat[nodes] - flat[nodes].mean(axis=0), axis=1)
        room = np.linalg.norm(inside[nodes, None] - taken, axis=2).min(axis=1)
        # without a free node the middle one, too
        place = inside[nodes[np.lexsort((far, room < APART * size))[0]]]
        taken = np.vstack([taken, place])
        box = {"boxstyle": "circle,pad=0.2", "facecolor": "white", "edgecolor": GRAY, "linewidth": 0.6}
        axes.text(*place, str(number), ha="center", va="center", fontsize=7, bbox=box, zorder=7)


def _draw_supports(axes: Axes, check: CheckFile, flat: FloatArray, seen: BoolArray) -> None:
    """Draws one mark per prescribed component at the nodes that are `seen`; `flat`: places of the nodes."""
    for component in range(check.mesh.n_dim):
        is_held = check["prescribed"][:, component] != 0
        style = _support_style(check, component, int(is_held.sum()))
        axes.plot(*flat[is_held & seen].T, zorder=5, gid=f"support {component}", **style)


def _support_style(check: CheckFile, component: int, n_nodes: int) -> dict[str, Any]:
    size = 6.0 if n_nodes <= MOST_ARROWS else 3.5
    marker = (SOLID_MARKS if check.mesh.n_dim == 3 else MARKS)[component]
    return {
        "marker": marker,
        "linestyle": "none",
        "color": INK,
        "markersize": size,
        "markerfacecolor": "none",
    }


def _draw_arrows(
    axes: Axes, check: CheckFile, outward: FloatArray, towards: FloatArray, buffer: DepthBuffer | None
) -> None:
    """Draws loads and prescribed displacements as arrows: those that the viewer sees, and not all if they are many.

    An arrow ends at its place where it points into the body, and starts there where it points out of the body.
    `outward`, shape (n_nodes, 3): outward normals, zero at nodes inside of the bodies; `towards`: see `view`; `buffer`
    knows what the viewer sees; None: everything.
    """
    found = {
        "load": (load_arrows(check, outward), VERMILLION),
        "prescribed_displacement": (nodal_arrows(check, "prescribed_displacement", outward), BLUE),
    }
    for name, (arrows, color) in found.items():
        if not len(arrows.places):
            continue
        seen = np.ones(len(arrows.places), bool) if buffer is None else buffer.sees(arrows.places @ towards.T)
        is_outer = np.any(arrows.outward, axis=1)
        chosen = np.concatenate([_some(np.flatnonzero(seen & kind)) for kind in (is_outer, ~is_outer)])
        drawn = ARROW * check.mesh.size * _stretched(arrows, is_outer) @ towards[:2].T
        pushes = np.einsum("ij,ij->i", arrows.vectors, arrows.outward)[chosen] < 0.0
        for which, pivot in ((chosen[pushes], "tip"), (chosen[~pushes], "tail")):
            style = {"pivot": pivot, "zorder": 6, "clip_on": False}
            draw_arrows(axes, (arrows.places @ towards[:2].T)[which], drawn[which], color, name, **style)


def _stretched(arrows: Arrows, is_outer: BoolArray) -> FloatArray:
    """Returns the vectors over the size of the largest one; small ones on outlines are longer, see SHORTEST."""
    sizes = np.linalg.norm(arrows.vectors, axis=1)
    largest = max(float(sizes.max()), np.finfo(float).tiny)
    is_stretched = (sizes > SMALL * largest) & is_outer
    lengths = np.where(is_stretched, np.maximum(sizes, SHORTEST * largest), sizes)
    return arrows.vectors * (lengths / (np.maximum(sizes, np.finfo(float).tiny) * largest))[:, None]


def _some(which: IntArray) -> IntArray:
    return which[:: max(1, len(which) // MOST_ARROWS)]


def _widen(axes: Axes, size: float) -> None:
    """Widens the axes so that arrows outside of the bodies fit."""
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    margin = ARROW * size
    axes.set_xlim(left - margin, right + margin)
    axes.set_ylim(low - margin, high + margin)


def _handles(check: CheckFile, colors: list[Any]) -> list[Patch | Line2D]:
    handles: list[Patch | Line2D] = [
        Patch(facecolor=color, edgecolor=GRAY, label=name)
        for name, color in zip(check.names["regions"], colors, strict=True)
    ]
    for component in range(check.mesh.n_dim):
        nodes = np.flatnonzero(check["prescribed"][:, component])
        if nodes.size:
            label = _support_label(check, component, nodes)
            handles.append(Line2D([], [], label=label, **_support_style(check, component, 1)))
    for name, color, text in (
        ("prescribed_displacement", BLUE, "prescribed displacement"),
        ("load", VERMILLION, "loads of facets, sum "),
    ):
        vectors, unit = check[name], check.fields[name].unit
        if np.any(vectors):
            total = ", ".join(format_number(_rounded(vectors, i)) for i in range(check.mesh.n_dim))
            label = text if name != "load" else f"{text}({total}) {unit}"
            handles.append(Line2D([], [], color=color, marker=">", markersize=4, label=label))
    handles += [
        Line2D([], [], linestyle="none", label=f"{i}  {name}")
        for i, name in enumerate(check.names["boundaries"], start=1)
    ]
    return handles


def _rounded(vectors: FloatArray, component: int) -> float:
    """Returns the sum of a component over all nodes, or zero if the sum is only a rounding error."""
    total = float(vectors[:, component].sum())
    return total if abs(total) > NEGLIGIBLE * float(np.abs(vectors).sum()) else 0.0


def _support_label(check: CheckFile, component: int, nodes: IntArray) -> str:
    values = check["prescribed_displacement"][nodes, component]
    ends = " to ".join(dict.fromkeys(format_number(value) for value in (values.min(), values.max())))
    unit = check.fields["prescribed_displacement"].unit if np.any(values) else ""
    count = f"{len(nodes)} node" + ("s" if len(nodes) != 1 else "")
    return f"$u_{check.axis_names[component]}$ = {ends} {unit}".rstrip() + f", {count}"
