# SPDX-License-Identifier: BSD-3-Clause
"""An animation of a field at the nodes of the displaced bodies, a picture per point of fields.h5."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.animation import AbstractMovieWriter, FFMpegWriter, PillowWriter
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize

from signorom_post.arrays import FloatArray, format_number, with_unit
from signorom_post.errors import InputError
from signorom_post.plots.captions import magnification, wrapped
from signorom_post.plots.drawing import draw_mesh, draw_shaded, frame
from signorom_post.plots.surface import draw_surface, frame_surface, view
from signorom_post.plots.viewpoint import best_corner
from signorom_post.readers.fields import FieldFile, FieldPoint
from signorom_post.style import SEQUENTIAL, new_figure

#: [1/inch] resolution of the pictures
RESOLUTION = 100
#: [inch] largest size of the bodies in a picture
LARGEST = (5.0, 4.2)
#: [inch] room for the scale of colors beside the bodies, for the axes below them, and for a line of the title
BESIDE, BELOW, LINE = 1.7, 0.6, 0.17
#: [inch] smallest width of the bodies with their title, and number of its characters in an inch
NARROWEST, PER_INCH = 2.6, 12


def writer_for(path: Path, n_per_second: float) -> AbstractMovieWriter:
    """Returns what writes the file; InputError if its name does not end in .gif or .mp4, or ffmpeg is missing for it.

    `n_per_second`: number of pictures in a second.
    """
    if path.suffix == ".gif":
        return PillowWriter(fps=n_per_second)
    if path.suffix != ".mp4":
        raise InputError(path, "an animation ends in .gif or .mp4")
    if not FFMpegWriter.isAvailable():
        raise InputError(
            path, "MP4 needs the program ffmpeg, which is not installed; .gif needs nothing more"
        )
    return FFMpegWriter(fps=n_per_second)


def animate(
    fields: FieldFile,
    points: Sequence[FieldPoint],
    name: str,
    path: Path,
    n_per_second: float = 10.0,
    names: tuple[str, str] = ("x", "y"),
) -> Iterator[None]:
    """Writes the animation, and yields after each picture; the file is complete at the end.

    `name`: a field of nodes, of vectors its size, as colors on one scale for all pictures, as is the factor of the
    displacement. `names`: of the axes in the plane. InputError if a point lacks the displacement or the field, if it is
    no field of nodes, or as in writer_for.
    """
    writer = writer_for(path, n_per_second)
    mesh = fields.mesh
    moved = [fields.field(point, "displacement").values for point in points]
    values = [_sizes(fields, point, name) for point in points]
    norm = Normalize(min(0.0, *(v.min() for v in values)), max(v.max() for v in values) or 1.0)
    scale = magnification(np.vstack(moved), mesh.size)
    places = [mesh.coordinates + scale * displacement for displacement in moved]
    everywhere = np.vstack([mesh.coordinates, *places])
    towards = view(*best_corner(mesh.coordinates, mesh.outer_faces)) if mesh.n_dim == 3 else None
    width, height = size_of(everywhere, towards)
    titles = _titles(points, scale, int(PER_INCH * width))
    n_lines = titles[0].count("\n") + 1
    figure = new_figure(width + BESIDE, height + BELOW + LINE * n_lines, has_equal_axes=True)
    axes = figure.subplots()
    label = with_unit(name.replace("_", " "), fields.field(points[0], name).unit)
    figure.colorbar(ScalarMappable(norm, SEQUENTIAL), ax=axes, label=label, shrink=0.85)
    if towards is None:
        draw_mesh(axes, mesh, mesh.coordinates[:, :2], "white")
        frame(axes, everywhere[:, :2], mesh.unit, names)
    else:
        frame_surface(axes, everywhere, mesh.unit, towards)
    fixed = axes.get_children()
    with writer.saving(figure, str(path), RESOLUTION):
        for i, (title, place, value) in enumerate(zip(titles, places, values, strict=True)):
            for artist in set(axes.get_children()).difference(fixed):
                artist.remove()
            if towards is None:
                draw_shaded(axes, mesh, place[:, :2], value, (float(norm.vmin), float(norm.vmax)))
            else:
                _draw_solid(axes, fields, place, norm, value, towards)
            axes.set_title(title)
            if i == 0:  # otherwise the pictures jump
                figure.draw_without_rendering()
                # not "none", for which Matplotlib draws each picture twice
                figure.set_layout_engine(None)
            writer.grab_frame()
            yield


def size_of(points: FloatArray, towards: FloatArray | None) -> tuple[float, float]:
    """Returns width and height [inch] of the bodies in a picture, whose shape is that of the frame around them.

    `points`, shape (n, 3): all places of their nodes; `towards`: the rotation to the viewer, None in the plane.
    """
    size = np.ptp(points[:, :2] if towards is None else points @ towards[:2].T, axis=0)
    # the frame is wider: see `frame` and `frame_surface`
    size = size + float(size.max()) * np.array([0.06, 0.06] if towards is None else [0.1, 0.35])
    width, height = size * min(LARGEST[0] / size[0], LARGEST[1] / size[1])
    # films need an even number of points along each side
    return max(NARROWEST, round(float(width), 1)), max(1.0, round(float(height), 1))


def _titles(points: Sequence[FieldPoint], scale: float, n_characters: int) -> list[str]:
    """Returns the label of each point with the factor of its displacement, all with the same number of lines."""
    factor = f", displacement x {format_number(scale)}" if scale != 1 else ""
    titles = [wrapped(point.label + factor, n_characters) for point in points]
    most = max(title.count("\n") for title in titles)
    return [title + "\n" * (most - title.count("\n")) for title in titles]


def _sizes(fields: FieldFile, point: FieldPoint, name: str) -> FloatArray:
    """Returns the values of a field of nodes, of vectors their sizes; InputError if it is none."""
    values = fields.field(point, name).values
    if len(np.atleast_1d(values)) != fields.mesh.n_nodes or (values.ndim == 2 and values.shape[1] > 3):
        raise InputError(fields.path, f"'{name}' has no number or vector for each node")
    sizes = np.linalg.norm(values, axis=1) if values.ndim == 2 else values
    if not np.isfinite(sizes).all():
        raise InputError(fields.path, f"'{name}' has no number at some nodes")
    return sizes


def _draw_solid(
    axes: Axes, fields: FieldFile, place: FloatArray, norm: Normalize, values: FloatArray, towards: FloatArray
) -> None:
    faces = fields.mesh.outer_faces
    colors = mpl.colormaps[SEQUENTIAL](norm(values[faces.nodes].mean(axis=1)))[:, :3]
    draw_surface(axes, place, faces, colors, towards)
