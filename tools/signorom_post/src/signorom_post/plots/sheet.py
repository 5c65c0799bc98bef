# SPDX-License-Identifier: BSD-3-Clause
"""One contact surface in space, laid out so that the viewer sees it, and colored by values of nodes or facets."""

from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, Normalize

from signorom_post.arrays import FloatArray, IntArray
from signorom_post.mesh import Faces
from signorom_post.plots.depth_buffer import DepthBuffer
from signorom_post.plots.drawing import frame
from signorom_post.plots.surface import EDGE, draw_picture, edges_of, frame_surface, normals_of, view
from signorom_post.plots.viewpoint import corner_of_sheet, is_open, view_of_surface

#: a surface whose mean normal has this share of its length along x, y or z is shown on the plane of the other two
ALONG = 0.95
#: number of points of a panel along its longer side
RESOLUTION = 900
#: planes of two coordinates: their axes to the right, upwards and towards the viewer, by the axis towards the viewer
PLANES = (
    ([[0, 1, 0], [0, 0, 1], [1, 0, 0]], ("y", "z")),
    ([[1, 0, 0], [0, 0, 1], [0, -1, 0]], ("x", "z")),
    ([[1, 0, 0], [0, 1, 0], [0, 0, 1]], ("x", "y")),
)


@dataclass(frozen=True)
class Sheet:
    """A surface as triangles, and the direction from which it is shown."""

    #: places of all nodes of the mesh, shape (n_nodes, 3)
    points: FloatArray
    #: nodes of the triangles that are shown, from 0, shape (n, 3)
    triangles: IntArray
    #: facet of each of these triangles, from 0, shape (n)
    facets: IntArray
    #: rotation of the view, see `view`
    towards: FloatArray
    #: names of the two coordinates of a surface that is shown on a coordinate plane; None: it is shown from aside
    names: tuple[str, str] | None
    #: false: the surface closes on itself, and only one side of it is shown
    is_whole: bool = True

    @property
    def flat(self) -> FloatArray:
        """Places of all nodes in the picture, shape (n_nodes, 2)."""
        return self.points @ self.towards[:2].T

    @property
    def nodes(self) -> IntArray:
        """Nodes that are shown, from 0."""
        return np.unique(self.triangles)

    @property
    def size(self) -> FloatArray:
        """Width and height in the picture."""
        return np.ptp(self.flat[self.nodes], axis=0)


def lay_out(points: FloatArray, facets: list[IntArray], outward: FloatArray, weights: FloatArray) -> Sheet:
    """Returns the surface in the view that shows it best.

    An open surface is shown as a whole, also the parts that look away from the viewer. If its mean normal is nearly
    along x, y or z, it is shown on the plane of the other two coordinates (PLANES), which may be from behind; otherwise
    from its front. A surface that closes on itself is shown from a corner, and only the part that looks at the viewer:
    of a bore the far half. `facets` have the nodes around each face; `outward`, shape (n_nodes, 3), are outward normals
    of any length, zero where unknown. `weights`, shape (n_nodes), are only for a closed surface: parts with larger
    weights count more in the choice of the corner.
    """
    triangles, owners = _fans(facets)
    faces = Faces(triangles[:, [0, 1, 2, 2]], owners)
    towards_outside = np.einsum("ij,ij->i", normals_of(points, faces), outward[triangles].sum(axis=1))
    turned = np.where((towards_outside < 0.0)[:, None], triangles[:, ::-1], triangles)
    faces = Faces(turned[:, [0, 1, 2, 2]], owners)
    towards = view_of_surface(points, faces, weights[turned].mean(axis=1))
    if not is_open(points, faces):
        front = normals_of(points, faces) @ towards[2] > 0.0
        return Sheet(points, turned[front], owners[front], towards, None, is_whole=False)
    axis = int(np.argmax(np.abs(towards[2])))
    if abs(towards[2, axis]) < ALONG:
        return Sheet(points, turned, owners, towards, None)
    plane, names = PLANES[axis]
    return Sheet(points, turned, owners, np.array(plane, dtype=float), names)


def sheet_from_corner(points: FloatArray, facets: list[IntArray]) -> Sheet:
    """Returns the surface as seen from the upper corner from which it looks largest; both of its sides are shown."""
    triangles, owners = _fans(facets)
    towards = view(*corner_of_sheet(points, Faces(triangles[:, [0, 1, 2, 2]], owners)))
    return Sheet(points, triangles, owners, towards, None)


def _fans(facets: list[IntArray]) -> tuple[IntArray, IntArray]:
    """Returns the triangles of all facets, shape (n, 3), and the facet of each, from 0."""
    fans = [(facet[0], facet[j], facet[j + 1]) for facet in facets for j in range(1, len(facet) - 1)]
    owners = np.repeat(np.arange(len(facets)), [len(facet) - 2 for facet in facets])
    return np.array(fans, dtype=np.int64).reshape(-1, 3), owners


def color_nodes(
    axes: Axes, sheet: Sheet, values: FloatArray, colors: str | Colormap, norm: Normalize, gid: str
) -> None:
    """Draws the sheet in colors of `values`, shape (n_nodes), linear on each triangle; nothing where they are nan."""
    buffer = _buffer(sheet)
    places, shares = buffer.shares()
    picture = np.full(len(buffer.owner), np.nan)
    picture[places] = (shares * values[sheet.triangles[buffer.owner[places]]].T).sum(axis=0)
    shown = np.ma.masked_invalid(picture).reshape(buffer.shape)
    draw_picture(axes, shown, buffer, gid=gid, cmap=colors, norm=norm)


def color_facets(
    axes: Axes, sheet: Sheet, values: FloatArray, colors: str | Colormap, norm: Normalize, gid: str
) -> None:
    """Draws the sheet with one color for each facet, whose `values` have the shape (n_facets), and their borders.

    Masked values have the color that the map has for them.
    """
    buffer = _buffer(sheet)
    is_there = buffer.owner >= 0
    facets = np.where(is_there, sheet.facets[buffer.owner], -1)
    picture = np.where(is_there, np.ma.filled(values, np.nan)[facets], np.nan)
    shown = np.where(
        is_there[:, None], mpl.colormaps.get_cmap(colors)(norm(np.ma.masked_invalid(picture))), 0.0
    )
    edges = edges_of(facets.reshape(buffer.shape)).ravel()
    shown[edges, :3] *= EDGE
    draw_picture(axes, shown.reshape(*buffer.shape, 4), buffer, gid=gid)


def _buffer(sheet: Sheet) -> DepthBuffer:
    return DepthBuffer((sheet.points @ sheet.towards.T)[sheet.triangles], RESOLUTION)


def frame_sheet(axes: Axes, sheet: Sheet, unit: str) -> None:
    """Gives the axes coordinates on a coordinate plane, else directions and a scale; `unit` is that of lengths."""
    if sheet.names is not None:
        frame(axes, sheet.flat[sheet.nodes], unit, sheet.names)
    else:
        frame_surface(axes, sheet.points[sheet.nodes], unit, sheet.towards)
