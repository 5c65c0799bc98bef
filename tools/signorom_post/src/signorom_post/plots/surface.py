# SPDX-License-Identifier: BSD-3-Clause
"""Procedures that draw bodies in three dimensions on plane axes: outer faces seen from a corner, with light from above.

`towards`, shape (3, 3), is the direction of the view: see `view`. Without it the view is the standard one.
"""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.colors import to_rgb

from signorom_post.arrays import BoolArray, FloatArray, IntArray, format_number
from signorom_post.mesh import Faces
from signorom_post.palette import INK
from signorom_post.plots.depth_buffer import DepthBuffer

if TYPE_CHECKING:  # the pictures by VTK need no axes, whose import takes a second
    from matplotlib.axes import Axes
    from matplotlib.image import AxesImage

#: [degrees] where the viewer stands: angle from x towards y, and angle above the x-y plane
AZIMUTH, ELEVATION = -55.0, 25.0
#: share of its brightness that a face in the shadow keeps
AMBIENT = 0.75
#: only sharp edges are drawn if more faces than this look at the viewer; the cosine of the least angle of those
MOST_EDGES, SHARP = 8000, np.cos(np.radians(30.0))
#: share of its brightness that a point on an edge keeps
EDGE = 0.55
#: an axis that the viewer sees shorter than this share of its length is not drawn
SHORTEST = 0.15


def view(azimuth: float = AZIMUTH, elevation: float = ELEVATION) -> FloatArray:
    """Returns a rotation, shape (3, 3); its rows are unit vectors to the right, upwards, and towards the viewer.

    The viewer stands in the direction `azimuth` [degrees], from x towards y, and `elevation` [degrees] above the x-y
    plane.
    """
    a, e = np.radians([azimuth, elevation])
    return np.array(
        [
            [-np.sin(a), np.cos(a), 0.0],
            [-np.sin(e) * np.cos(a), -np.sin(e) * np.sin(a), np.cos(e)],
            [np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)],
        ]
    )


def normals_of(points: FloatArray, faces: Faces) -> FloatArray:
    """Returns the outward unit normals of the faces, shape (n_faces, 3); `points` are the nodes, shape (n_nodes, 3)."""
    corners = points[faces.nodes]
    normals = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    normals /= np.maximum(np.linalg.norm(normals, axis=1), np.finfo(float).tiny)[:, None]
    return normals


def draw_surface(
    axes: "Axes", points: FloatArray, faces: Faces, colors: FloatArray, towards: FloatArray | None = None
) -> DepthBuffer:
    """Draws the faces as the viewer sees them, and returns the buffer that knows what is in front.

    `points`, shape (n_nodes, 3), are the places of all nodes; `colors`, shape (n_faces, 3), are RGB values, which the
    light makes darker. `towards` is the rotation that `view` returns; default: the standard view.
    """
    towards = view() if towards is None else towards
    normals = normals_of(points, faces)
    front = np.flatnonzero(normals @ towards[2] > 0.0)
    light = towards.T @ np.array([-0.4, 0.6, 0.7]) / np.linalg.norm([-0.4, 0.6, 0.7])
    brightness = AMBIENT + (1.0 - AMBIENT) * np.clip(normals[front] @ light, 0.0, 1.0)
    shaded = np.clip(colors[front] * brightness[:, None], 0.0, 1.0)
    triangles, owners = triangles_of(faces.take(front))
    buffer = DepthBuffer((points @ towards.T)[triangles])
    shown = np.append(owners, -1)[buffer.owner]
    # the face -1 is the background
    picture = np.vstack([np.pad(shaded, ((0, 0), (0, 1)), constant_values=1.0), np.zeros(4)])[shown]
    smooth = normals[front] if len(front) > MOST_EDGES else None
    edges = edges_of(shown.reshape(buffer.shape), smooth).ravel()
    picture[edges, :3] *= EDGE
    picture[edges, 3] = np.where(shown[edges] >= 0, 1.0, 1.0 - EDGE)
    draw_picture(axes, picture.reshape(*buffer.shape, 4), buffer, gid="surface")
    return buffer


def draw_picture(axes: "Axes", picture: FloatArray, buffer: DepthBuffer, **style: object) -> "AxesImage":
    """Draws the points of a buffer and returns the image; `picture` has its shape, or is RGBA values of that shape.

    `style` goes to `Axes.imshow`, but its `gid` to the image.
    """
    gid = style.pop("gid", None)
    image = axes.imshow(picture, extent=buffer.extent, origin="lower", interpolation="antialiased", **style)
    image.set_gid(gid)
    return image


def triangles_of(faces: Faces) -> tuple[IntArray, IntArray]:
    """Returns the nodes of the triangles of the faces, shape (n, 3), and the face of each, shape (n)."""
    quads = np.flatnonzero(faces.n_corners == 4)
    return faces.triangles, np.concatenate([np.arange(len(faces.nodes)), quads])


def edges_of(shown: IntArray, normals: FloatArray | None = None) -> BoolArray:
    """Returns the points of a picture where another face begins to the right or above; shape of `shown`.

    `shown` is the face at each point, -1 for none. With the `normals` of the faces only edges count where these turn by
    more than 30 degrees, and the border of the bodies.
    """
    is_edge = np.zeros(shown.shape, dtype=bool)
    for here, there, marked in (
        (shown[:, :-1], shown[:, 1:], is_edge[:, :-1]),
        (shown[:-1], shown[1:], is_edge[:-1]),
    ):
        differs = here != there
        if normals is not None:
            turn = np.einsum("...i,...i->...", normals[here], normals[there])
            differs &= (turn < SHARP) | (here < 0) | (there < 0)
        marked |= differs
    return is_edge


def one_color(faces: Faces, color: str) -> FloatArray:
    """Returns RGB values of the same color for every face, shape (n_faces, 3)."""
    return np.tile(to_rgb(color), (len(faces.nodes), 1))


def frame_surface(axes: "Axes", points: FloatArray, unit: str, towards: FloatArray | None = None) -> None:
    """Gives the axes equal scales and limits around `points`, and replaces ticks by two drawings below the picture.

    These are arrows along x, y and z, and a scale bar of a round length in `unit`. `points` has the shape (n, 3);
    `towards` is the rotation that `view` returns; default: the standard view.
    """
    towards = view() if towards is None else towards
    flat = points @ towards[:2].T
    low, high = flat.min(axis=0), flat.max(axis=0)
    size = float(np.max(high - low))
    axes.set_xlim(low[0] - 0.05 * size, high[0] + 0.05 * size)
    axes.set_ylim(low[1] - 0.3 * size, high[1] + 0.05 * size)
    axes.set_aspect("equal")
    axes.set_axis_off()
    origin = np.array([low[0] + 0.08 * size, low[1] - 0.2 * size])
    for name, direction in zip("xyz", towards[:2].T, strict=True):
        if np.linalg.norm(direction) < SHORTEST:
            continue
        end = origin + 0.1 * size * direction
        axes.annotate(
            "",
            xy=end,
            xytext=origin,
            arrowprops={"arrowstyle": "-|>", "color": INK, "shrinkA": 0, "shrinkB": 0},
        )
        axes.text(*(origin + 0.13 * size * direction), f"${name}$", ha="center", va="center", fontsize=8)
    length = _round_length(0.3 * size)
    start = np.array([high[0] - length, low[1] - 0.2 * size])
    axes.plot([start[0], start[0] + length], [start[1]] * 2, color=INK, linewidth=2.0, gid="scale")
    text = f"{format_number(length)} {unit}".strip()
    axes.text(start[0] + 0.5 * length, start[1] - 0.02 * size, text, ha="center", va="top", fontsize=8)


def _round_length(length: float) -> float:
    """Returns the largest number that is 1, 2 or 5 times a power of ten and not above `length`."""
    power = 10.0 ** np.floor(np.log10(length))
    return float(max(step * power for step in (1.0, 2.0, 5.0) if step * power <= length * (1 + 1e-12)))
