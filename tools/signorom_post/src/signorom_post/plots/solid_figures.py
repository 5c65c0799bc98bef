# SPDX-License-Identifier: BSD-3-Clause
"""Figures of bodies in three dimensions: displacement, and reduced domain."""

import matplotlib as mpl
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from signorom_post.arrays import BoolArray, FloatArray, IntArray, with_unit
from signorom_post.mesh import Faces
from signorom_post.plots.captions import deformed_title, magnification
from signorom_post.plots.surface import draw_surface, frame_surface, one_color, view
from signorom_post.plots.viewpoint import best_corner
from signorom_post.readers.fields import FieldFile, FieldPoint
from signorom_post.style import BODY, SEQUENTIAL, SKY_BLUE, VERMILLION, new_figure


def initial_and_deformed_solid(fields: FieldFile, point: FieldPoint, color: str = "displacement") -> Figure:
    """Returns a figure of the outer faces of solid cells before and after the deformation at one point.

    `color` says what the colors of the latter show: `displacement`, its magnitude, or `contact`, the contact pressure
    on faces whose corners are all contact nodes, while other faces are gray. Small displacements are multiplied by a
    factor that the title names. InputError if the point lacks the displacement or, for `contact`, the contact pressure.
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
    colors = _colors(norm, values[faces.nodes].mean(axis=1))
    if color == "contact":
        colors[~is_on_contact(fields, faces)] = mpl.colors.to_rgb(BODY)
    draw_surface(right, deformed, faces, colors, towards)
    both = np.vstack([mesh.coordinates, deformed])
    for axes in (left, right):
        frame_surface(axes, both, mesh.unit, towards)
    left.set_title("initial")
    right.set_title(deformed_title(point, scale))
    figure.colorbar(ScalarMappable(norm, SEQUENTIAL), ax=[left, right], label=label, shrink=0.85, pad=0.02)
    return figure


def is_on_contact(fields: FieldFile, faces: Faces) -> BoolArray:
    """Returns whether all corners of a face are contact nodes, shape (n_faces).

    A face beside a contact surface has no pressure, but one or two corners with a pressure.
    """
    return np.isin(faces.nodes, fields.contact.nodes_of()).all(axis=1)


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


def _colors(norm: Normalize, values: FloatArray) -> FloatArray:
    return mpl.colormaps[SEQUENTIAL](norm(values))[:, :3]
