# SPDX-License-Identifier: BSD-3-Clause
"""Figure of the mesh with its reduced integration domain (paper, Figure 6a)."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from signorom_post.arrays import IntArray
from signorom_post.errors import InputError
from signorom_post.plots.drawing import draw_cells, draw_edges, draw_mesh, frame, marker_scale
from signorom_post.plots.solid_figures import reduced_domain_solid
from signorom_post.readers.fields import FieldFile
from signorom_post.readers.model import Cluster
from signorom_post.style import INK, SKY_BLUE, VERMILLION, new_figure

#: kind of node -> marker, color inside, color of its edge, size [typographic points], text of the legend; kinds that
#: stand later are drawn on top
NODES = {
    "contact": ("o", "none", VERMILLION, 8.0, "contact nodes"),
    "facing": ("s", "white", INK, 3.6, "facing nodes"),
    "seed": ("s", INK, INK, 3.6, "seed nodes"),
}
RID_COLOR = SKY_BLUE


def reduced_domain(fields: FieldFile, cluster: Cluster | None, names: tuple[str, str] = ("x", "y")) -> Figure:
    """Returns a figure of the cells of the reduced integration domain on the mesh at rest.

    Markers show the contact nodes, that is, the nodes of the domain's contact rows on both surfaces, and the seed and
    facing nodes of `cluster`. If `cluster` is None, the cells are those of the first point of the field file that has a
    reduced domain, and there are no seed or facing nodes. `names` are the names of the axes. A mesh in three dimensions
    is drawn by `reduced_domain_solid`, without seed and facing nodes. InputError if `cluster` is None and no point has
    a reduced domain, or if the field file has fewer nodes, cells or contact rows than `cluster` needs.
    """
    mesh = fields.mesh
    cells = _cells(fields, cluster)
    rows = fields.points[0].reduced_rows if fields.points else np.empty(0, dtype=np.int64)
    if cluster is not None and fields.contact.n_rows:
        rows = _checked(fields, cluster.contact_rows, fields.contact.n_rows)
    if mesh.n_dim == 3:
        return reduced_domain_solid(fields, cells, rows)
    nodes = {"contact": fields.contact.nodes_of(rows)}
    if cluster is not None:
        nodes["facing"] = np.setdiff1d(
            _checked(fields, cluster.facing_nodes, mesh.n_nodes), cluster.seed_nodes
        )
        nodes["seed"] = _checked(fields, cluster.seed_nodes, mesh.n_nodes)

    points = mesh.coordinates[:, :2]
    width, height = np.ptp(points, axis=0)
    figure_height = float(np.clip(4.3 * height / width + 0.6, 2.8, 8.0))
    figure = new_figure(6.4, figure_height, has_equal_axes=True)
    axes = figure.subplots()
    draw_mesh(axes, mesh, points)
    rid = draw_cells(axes, points, [mesh.cells[i] for i in cells], RID_COLOR)
    rid.set_label("reduced domain")
    reduced_mesh = type(mesh)(mesh.coordinates, [mesh.cells[i] for i in cells], 2)
    draw_edges(axes, points, reduced_mesh.edges, "#2F6F93", 0.6)
    draw_edges(axes, points, mesh.boundary_edges, INK, 0.9)

    scale = marker_scale(mesh, points, 72.0 * figure_height / max(width, height))
    handles: list[Patch | Line2D] = [
        Patch(facecolor=RID_COLOR, edgecolor="#2F6F93", label=f"RID, {len(cells)} cells")
    ]
    for name, (marker, fill, edge, size, text) in NODES.items():
        if name not in nodes or nodes[name].size == 0:
            continue
        style: dict[str, Any] = {
            "marker": marker,
            "markerfacecolor": fill,
            "markeredgecolor": edge,
            "markersize": size * scale,
        }
        style |= {"linestyle": "none", "markeredgewidth": 1.1, "label": f"{len(nodes[name])} {text}"}
        handles += axes.plot(*points[nodes[name]].T, zorder=4, clip_on=False, **style)
    frame(axes, points, mesh.unit, names)
    axes.legend(handles=handles, loc="center left", bbox_to_anchor=(1.02, 0.5), labelspacing=0.8)
    return figure


def _cells(fields: FieldFile, cluster: Cluster | None) -> IntArray:
    if cluster is not None:
        return _checked(fields, cluster.cells, fields.mesh.n_cells)
    for point in fields.points:
        if "reduced_domain" in point.fields:
            return np.flatnonzero(point.fields["reduced_domain"].values.reshape(fields.mesh.n_cells))
    raise InputError(fields.path, "no point has the field 'reduced_domain'")


def _checked(fields: FieldFile, items: IntArray, n_items: int) -> IntArray:
    if items.size and items.max() >= n_items:
        raise InputError(
            fields.path, "it does not belong to 'model.h5', which needs more nodes, cells or contact rows"
        )
    return items
