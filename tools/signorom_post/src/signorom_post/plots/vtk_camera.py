# SPDX-License-Identifier: BSD-3-Clause
"""Where the camera of VTK's pictures stands: from where it looks, and what fits into the picture."""

from dataclasses import dataclass

import numpy as np
import vtk

from signorom_post.arrays import FloatArray

#: [pixels] width and height of a picture
SIZE = (1600, 900)
#: [pixels] strip on the right for the color bar
BAR_STRIP = 260
#: [pixels] from the bodies to the edges of their part of the picture
MARGIN = 40


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
