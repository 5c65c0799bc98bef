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

from signorom_post.arrays import FloatArray, with_unit
from signorom_post.errors import InputError
from signorom_post.plots.captions import deformed_title, magnification
from signorom_post.plots.drawing import draw_mesh, draw_shaded, frame
from signorom_post.plots.surface import draw_surface, frame_surface, view
from signorom_post.plots.viewpoint import best_corner
from signorom_post.readers.fields import FieldFile, FieldPoint
from signorom_post.style import SEQUENTIAL, new_figure

#: [1/inch] resolution of the pictures
RESOLUTION = 100


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
    figure = new_figure(6.4, 4.8)
    axes = figure.subplots()
    label = with_unit(name.replace("_", " "), fields.field(points[0], name).unit)
    figure.colorbar(ScalarMappable(norm, SEQUENTIAL), ax=axes, label=label, shrink=0.85)
    towards = view(*best_corner(mesh.coordinates, mesh.outer_faces)) if mesh.n_dim == 3 else None
    with writer.saving(figure, str(path), RESOLUTION):
        for i, (point, place, value) in enumerate(zip(points, places, values, strict=True)):
            axes.clear()
            if towards is None:
                draw_mesh(axes, mesh, mesh.coordinates[:, :2], "white")
                draw_shaded(axes, mesh, place[:, :2], value, (float(norm.vmin), float(norm.vmax)))
                frame(axes, everywhere[:, :2], mesh.unit, names)
            else:
                _draw_solid(axes, fields, place, norm, value, towards)
                frame_surface(axes, everywhere, mesh.unit, towards)
            axes.set_title(deformed_title(point, scale))
            if i == 0:  # otherwise the pictures jump
                figure.draw_without_rendering()
                figure.set_layout_engine("none")
            writer.grab_frame()
            yield


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
