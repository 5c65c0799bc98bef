# SPDX-License-Identifier: BSD-3-Clause
"""Windows of VTK that need no screen, and the pictures in them."""

import vtk


def hidden_window(
    renderer: "vtk.vtkRenderer", size: tuple[int, int], n_samples: int = 0
) -> "vtk.vtkRenderWindow":
    """Returns a window of this size [pixels] that is not shown; `n_samples` per pixel make edges smooth."""
    # otherwise VTK prints a warning that there is no screen
    vtk.vtkLogger.SetStderrVerbosity(vtk.vtkLogger.VERBOSITY_ERROR)
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(n_samples)
    window.SetSize(*size)
    window.AddRenderer(renderer)
    return window


def image_of(window: "vtk.vtkRenderWindow") -> "vtk.vtkImageData":
    """Draws the window and returns what it shows."""
    window.Render()
    picture = vtk.vtkWindowToImageFilter()
    picture.SetInput(window)
    picture.ReadFrontBufferOff()
    picture.Update()
    return picture.GetOutput()
