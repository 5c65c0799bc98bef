# SPDX-License-Identifier: BSD-3-Clause
"""Where the camera of VTK's pictures stands: from which corner it looks, and what fits into the picture."""

from dataclasses import dataclass

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

from signorom_post.arrays import FloatArray, IntArray
from signorom_post.plots.vtk_window import hidden_window, image_of

#: [pixels] width and height of a picture
SIZE = (1600, 900)
#: [pixels] strip on the right for the color bar
BAR_STRIP = 260
#: [pixels] from the bodies to the edges of their part of the picture
MARGIN = 40
#: eight directions from the bodies to the viewer, the usual ones first
CORNERS = np.array([(x, y, z) for z in (1.1, -1.1) for y in (-1.8, 1.8) for x in (-1.0, 1.0)])
#: a usual direction is taken if it shows at least this share of what the best one shows
GOOD_SHARE = 0.9
#: [pixels] width and height of the pictures that tell how much of each body is seen
SKETCH = (240, 240)


@dataclass(frozen=True)
class Camera:
    """A parallel projection of the bodies onto a picture of the size SIZE."""

    #: unit vector from the bodies to the viewer, shape (3)
    towards: FloatArray
    #: direction that points upwards in the picture, shape (3)
    up: FloatArray
    #: point in the middle of the picture [unit of the mesh], shape (3)
    focus: FloatArray
    #: half of the picture's height [unit of the mesh]
    half_height: float

    @property
    def position(self) -> FloatArray:
        """Where the camera stands [unit of the mesh], shape (3): outside of the bodies."""
        return self.focus + 10.0 * self.half_height * self.towards

    def aim(self, renderer: "vtk.vtkRenderer") -> None:
        """Gives the camera of a renderer this place."""
        camera = renderer.GetActiveCamera()
        camera.ParallelProjectionOn()
        camera.SetFocalPoint(*self.focus)
        camera.SetPosition(*self.position)
        camera.SetViewUp(*self.up)
        camera.SetParallelScale(self.half_height)
        renderer.ResetCameraClippingRange()


def framed(points: FloatArray, towards: FloatArray, caption_strip: int) -> Camera:
    """Returns the camera that sees all `points`, shape (n, 3), from the direction `towards`, shape (3).

    The strip on the right for the color bar, the upper `caption_strip` pixels and a margin stay free. In the picture, z
    points upwards; if one looks along z, y does.
    """
    towards = towards / np.linalg.norm(towards)
    along_z = np.hypot(*towards[:2]) < 1e-6
    up = np.array([0.0, 1.0, 0.0]) if along_z else np.array([0.0, 0.0, 1.0])
    right = np.cross(up, towards)
    right /= np.linalg.norm(right)
    axes = np.array([right, np.cross(towards, right), towards])
    seen = points @ axes.T
    low, high = seen.min(axis=0), seen.max(axis=0)
    room = np.array([SIZE[0] - BAR_STRIP, SIZE[1] - caption_strip])
    pixel = float(((high - low)[:2] / (room - 2 * MARGIN)).max())
    # the middle of the picture is to the right of the room's middle, and above it
    middle = 0.5 * (low + high) + pixel * np.array([0.5 * BAR_STRIP, 0.5 * caption_strip, 0.0])
    return Camera(towards, up, middle @ axes, 0.5 * SIZE[1] * pixel)


def best_corner(grid: "vtk.vtkUnstructuredGrid") -> FloatArray:
    """Returns the one of the eight CORNERS that hides no body of solid cells, or hides it least; shape (3).

    Of a body, a corner shows a share: its pixels over those from the corner that shows most of it. What counts is the
    smallest share of all bodies. The first corner is taken whose share is at least 90 % of the best one.
    """
    pixels = _pixels_of_bodies(grid)
    shares = (pixels / np.maximum(pixels.max(axis=0), 1))[:, pixels.max(axis=0) > 0].min(axis=1)
    return CORNERS[int(np.argmax(shares >= GOOD_SHARE * shares.max()))]


def _pixels_of_bodies(grid: "vtk.vtkUnstructuredGrid") -> IntArray:
    """Returns how many pixels show each body from each of CORNERS, shape (8, n_bodies)."""
    renderer = vtk.vtkRenderer()
    renderer.AddActor(_numbered_bodies(grid))
    window = hidden_window(renderer, SKETCH)
    middle, radius = np.array(grid.GetCenter()), 0.5 * grid.GetLength()
    counts = []
    for corner in CORNERS:
        Camera(corner / np.linalg.norm(corner), np.array([0.0, 0.0, 1.0]), middle, radius).aim(renderer)
        counts.append(np.bincount(_codes(window)))
    window.Finalize()
    n_codes = max(map(len, counts))
    # code 0 is the background
    return np.array([np.pad(count, (0, n_codes - len(count))) for count in counts])[:, 1:]


def _numbered_bodies(grid: "vtk.vtkUnstructuredGrid") -> "vtk.vtkActor":
    """Returns the bodies, each in the color whose three bytes are its number, from 1."""
    bodies = vtk.vtkConnectivityFilter()
    bodies.SetInputData(grid)
    bodies.SetExtractionModeToAllRegions()
    bodies.ColorRegionsOn()
    surface = vtk.vtkGeometryFilter()
    surface.SetInputConnection(bodies.GetOutputPort())
    surface.Update()
    numbers = 1 + vtk_to_numpy(surface.GetOutput().GetCellData().GetArray("RegionId")).astype(np.uint32)
    bytes_of = np.column_stack([numbers & 255, numbers >> 8 & 255, numbers >> 16 & 255]).astype(np.uint8)
    surface.GetOutput().GetCellData().SetScalars(numpy_to_vtk(bytes_of, deep=True))
    mapper = vtk.vtkPolyDataMapper()
    mapper.SetInputData(surface.GetOutput())
    mapper.SetScalarModeToUseCellData()
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().LightingOff()
    return actor


def _codes(window: "vtk.vtkRenderWindow") -> IntArray:
    """Returns the number that the color of each pixel stands for, shape (n_pixels)."""
    colors = vtk_to_numpy(image_of(window).GetPointData().GetScalars())[:, :3].astype(np.int64)
    return colors @ np.array([1, 256, 65536])
