# SPDX-License-Identifier: BSD-3-Clause
"""Figures of bodies in three dimensions: displacement, reduced domain, and pressure on the contact surface."""

import matplotlib as mpl
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.tri import Triangulation

from signorom_post.arrays import FloatArray, IntArray, with_unit
from signorom_post.plots.captions import deformed_title, magnification
from signorom_post.plots.surface import draw_surface, frame_surface, one_color, view
from signorom_post.plots.viewpoint import best_corner
from signorom_post.readers.fields import FieldFile, FieldPoint
from signorom_post.style import BODY, SEQUENTIAL, SKY_BLUE, VERMILLION, new_figure

#: largest number of panels side by side; more would be too small to read
MAX_PANELS = 4


def initial_and_deformed_solid(fields: FieldFile, point: FieldPoint, color: str = "displacement") -> Figure:
    """Returns a figure of the outer faces of solid cells before and after the deformation at one point.

    `color` says what the colors of the latter show: `displacement`, its magnitude, or `contact`, the contact pressure.
    Small displacements are multiplied by a factor that the title names. InputError if the point lacks the displacement
    or, for `contact`, the contact pressure.
    """
    mesh = fields.mesh
    displacement = fields.field(point, "displacement")
    scale = magnification(displacement.values, mesh.size)
    deformed = mesh.coordinates + scale * displacement.values
    if color == "contact":
        shown = fields.field(point, "contact_pressure")
        values, label = shown.values, with_unit("contact pressure", shown.unit)
    else:
        values = np.linalg.norm(displacement.values, axis=1)
        label = with_unit("displacement magnitude", displacement.unit)
    norm = Normalize(0.0, float(values.max()) or 1.0)
    faces = mesh.outer_faces
    towards = view(*best_corner(mesh.coordinates, faces))
    figure = new_figure(8.2, 4.4, has_equal_axes=True)
    left, right = figure.subplots(1, 2, sharex=True, sharey=True)
    draw_surface(left, mesh.coordinates, faces, one_color(faces, BODY), towards)
    draw_surface(right, deformed, faces, _colors(norm, values[faces.nodes].mean(axis=1)), towards)
    both = np.vstack([mesh.coordinates, deformed])
    for axes in (left, right):
        frame_surface(axes, both, mesh.unit, towards)
    left.set_title("initial")
    right.set_title(deformed_title(point, scale))
    figure.colorbar(ScalarMappable(norm, SEQUENTIAL), ax=[left, right], label=label, shrink=0.85, pad=0.02)
    return figure


def reduced_domain_solid(fields: FieldFile, cells: IntArray, rows: IntArray) -> Figure:
    """Returns a figure. Left: the bodies; their outer faces in the domain have a color. Right: the domain alone.

    `cells` are the cells of the domain and `rows` its contact rows, both from 0. Dots on the right are contact nodes.
    """
    mesh = fields.mesh
    faces = mesh.outer_faces
    towards = view(*best_corner(mesh.coordinates, faces))
    figure = new_figure(8.2, 4.4, has_equal_axes=True)
    left, right = figure.subplots(1, 2, sharex=True, sharey=True)
    colors = one_color(faces, BODY)
    colors[np.isin(faces.cells, cells)] = mpl.colors.to_rgb(SKY_BLUE)
    draw_surface(left, mesh.coordinates, faces, colors, towards)
    own = mesh.faces_of(cells)
    draw_surface(right, mesh.coordinates, own, one_color(own, SKY_BLUE), towards)
    nodes = fields.contact.nodes_of(rows)
    style = {
        "s": 14,
        "c": VERMILLION,
        "edgecolors": "white",
        "linewidths": 0.4,
        "zorder": 3,
        "gid": "contact",
    }
    right.scatter(*(mesh.coordinates[nodes] @ towards[:2].T).T, **style)
    for axes in (left, right):
        frame_surface(axes, mesh.coordinates, mesh.unit, towards)
    left.set_title("on the bodies")
    right.set_title("alone")
    handles = [
        Patch(facecolor=SKY_BLUE, label=f"reduced domain, {len(cells)} of {mesh.n_cells} cells"),
        Line2D(
            [], [], marker="o", linestyle="none", color=VERMILLION, label=f"its {len(nodes)} contact nodes"
        ),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=2)
    return figure


def contact_surface(fields: FieldFile) -> Figure:
    """Returns a figure of the contact pressure of solid bodies, with one column per point.

    It shows the surfaces that carry the contact forces, in the plane of the two axes along which they are longest. Up
    to four points are drawn, spread over those with full-order forces; at least one point must have them. The pressure
    of a contact row is its force divided by its area. The full order is above, the reduced model below if there is one.
    """
    points = [point for point in fields.points if "multipliers_full_order" in point.fields]
    chosen = [points[i] for i in sorted({round(i) for i in np.linspace(0, len(points) - 1, MAX_PANELS)})]
    kinds = ["multipliers_full_order"]
    if any("multipliers_reduced" in point.fields for point in chosen):
        kinds.append("multipliers_reduced")
    faces = fields.contact_faces
    pressures = {
        (kind, i): point.fields[kind].values / fields.contact.areas
        for kind in kinds
        for i, point in enumerate(chosen)
        if kind in point.fields
    }
    norm = Normalize(0.0, max(float(values.max()) for values in pressures.values()) or 1.0)
    flat, names = _flattened(fields)
    sizes = np.ptp(flat, axis=0)
    height = float(np.clip(2.6 * sizes[1] / sizes[0], 0.8, 4.0))
    figure = new_figure(
        1.6 + 2.6 * len(chosen), max(2.8, 1.2 + (height + 0.2) * len(kinds)), has_equal_axes=True
    )
    panels = figure.subplots(len(kinds), len(chosen), squeeze=False, sharex=True, sharey=True)
    local = np.searchsorted(np.sort(fields.contact.owners), faces.triangles)
    triangles = Triangulation(*flat.T, np.argsort(fields.contact.owners)[local])
    for (kind, i), values in pressures.items():
        axes = panels[kinds.index(kind), i]
        axes.tripcolor(
            triangles, values, shading="gouraud", cmap=SEQUENTIAL, norm=norm, rasterized=True, gid=kind
        )
        axes.set_aspect("equal")
    for i, point in enumerate(chosen):
        panels[0, i].set_title("\n".join(point.label.split(", ")))
        panels[-1, i].set_xlabel(with_unit(f"${names[0]}$", fields.mesh.unit))
    for row, kind in zip(panels, kinds, strict=True):
        text = {"multipliers_full_order": "full order", "multipliers_reduced": "reduced"}[kind]
        row[0].set_ylabel(f"{text}\n" + with_unit(f"${names[1]}$", fields.mesh.unit))
    unit = f"{fields.field(chosen[0], kinds[0]).unit}/{fields.mesh.unit}²"
    figure.colorbar(
        ScalarMappable(norm, SEQUENTIAL),
        ax=panels,
        label=with_unit("contact pressure", unit),
        pad=0.02,
    )
    return figure


def _colors(norm: Normalize, values: FloatArray) -> FloatArray:
    return mpl.colormaps[SEQUENTIAL](norm(values))[:, :3]


def _flattened(fields: FieldFile) -> tuple[FloatArray, str]:
    """Returns the contact nodes' coordinates along the surface's two longest axes, and the names of these axes."""
    points = fields.mesh.coordinates[fields.contact.owners]
    axes = np.sort(np.argsort(np.ptp(points, axis=0), kind="stable")[1:])
    return points[:, axes], "".join("xyz"[i] for i in axes)
