# SPDX-License-Identifier: BSD-3-Clause
"""Figure of the bodies before and after loading, side by side (paper, Figure 5)."""

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from signorom_post.arrays import with_unit
from signorom_post.plots.captions import deformed_title, magnification
from signorom_post.plots.drawing import draw_mesh, draw_shaded, frame
from signorom_post.readers.fields import FieldFile, FieldPoint
from signorom_post.style import GRAY, SEQUENTIAL, new_figure

#: the color bar stands below the panels if the height of the bodies is less than this share of their width
FLAT = 0.4


def initial_and_deformed(
    fields: FieldFile, point: FieldPoint, color: str = "displacement", names: tuple[str, str] = ("x", "y")
) -> Figure:
    """Returns a figure of a plane mesh at rest and displaced at one point, on equal axes.

    `color` says what the colors show. `displacement`: the magnitude of the displacement everywhere. `contact`: the
    contact pressure on the contact nodes; nodes without pressure, and all on the mesh at rest, are white. Small
    displacements are multiplied by a round factor that the title names. `names` are the names of the axes. InputError
    if the point lacks the displacement or, for `contact`, the contact pressure.
    """
    mesh = fields.mesh
    displacement = fields.field(point, "displacement")
    scale = magnification(displacement.values, mesh.size)
    initial = mesh.coordinates[:, :2]
    deformed = initial + scale * displacement.values[:, :2]
    both = np.vstack([initial, deformed])
    width, height = np.ptp(both, axis=0)
    figure = new_figure(8.2, float(np.clip(3.15 * height / width + 0.8, 2.6, 7.5)), has_equal_axes=True)
    left, right = figure.subplots(1, 2, sharex=True, sharey=True)

    if color == "contact":
        shown = fields.field(point, "contact_pressure")
        label = with_unit("contact pressure", shown.unit)
        limits = (0.0, float(shown.values.max()) or 1.0)
        nodes = fields.contact.nodes_of()
        is_open = shown.values[nodes] == 0.0
        for axes, points, is_white in ((left, initial, np.ones_like(is_open)), (right, deformed, is_open)):
            draw_mesh(axes, mesh, points)
            axes.scatter(
                *points[nodes[is_white]].T, s=9, c="white", edgecolors=GRAY, linewidths=0.7, zorder=3
            )
        active = nodes[~is_open]
        style = {"s": 18, "cmap": SEQUENTIAL, "norm": Normalize(*limits), "zorder": 4, "gid": "active"}
        right.scatter(*deformed[active].T, c=shown.values[active], **style)
    else:
        magnitude = np.linalg.norm(displacement.values, axis=1)
        label = with_unit("displacement magnitude", displacement.unit)
        limits = (0.0, float(magnitude.max()) or 1.0)
        draw_mesh(left, mesh, initial)
        draw_shaded(right, mesh, deformed, magnitude, limits)

    frame(left, both, mesh.unit, names)
    frame(right, both, mesh.unit, names)
    right.set_ylabel("")
    left.set_title("initial")
    right.set_title(deformed_title(point, scale))
    # beside flat bodies there is no room for the label of the color bar
    place = {"location": "bottom", "aspect": 40} if height < FLAT * width else {"shrink": 0.85}
    shading = ScalarMappable(Normalize(*limits), SEQUENTIAL)
    bar = figure.colorbar(shading, ax=[left, right], label=label, pad=0.02, **place)
    bar.locator = MaxNLocator(5)
    return figure
