# SPDX-License-Identifier: BSD-3-Clause
"""fields.xdmf as VTK's Xdmf2 reader shows it, the one that PyPI's vtk has. ParaView's others: tests/paraview."""

from dataclasses import dataclass

import numpy as np
import pytest


@dataclass
class Shown:
    """What VTK shows at one time step."""

    #: shape (n_nodes, 3), single precision
    points: np.ndarray
    n_cells: int
    #: by name
    nodes: dict[str, np.ndarray]
    cells: dict[str, np.ndarray]
    #: numbers of the step
    numbers: dict[str, float]


def read_with_vtk(path):
    """Returns time -> Shown of an XDMF file; skips the test if vtk is not installed."""
    pytest.importorskip("vtkmodules.vtkIOXdmf2")
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
    from vtkmodules.vtkIOXdmf2 import vtkXdmfReader

    reader = vtkXdmfReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    shown = {}
    for time in reader.GetOutputInformation(0).Get(vtkStreamingDemandDrivenPipeline.TIME_STEPS()):
        reader.UpdateTimeStep(time)
        grid = reader.GetOutputDataObject(0)
        arrays = [
            {
                data.GetArrayName(i): vtk_to_numpy(data.GetArray(i)).copy()
                for i in range(data.GetNumberOfArrays())
            }
            for data in (grid.GetPointData(), grid.GetCellData())
        ]
        data = grid.GetFieldData()
        numbers = {
            data.GetArrayName(i): data.GetArray(i).GetValue(0) for i in range(data.GetNumberOfArrays())
        }
        points = vtk_to_numpy(grid.GetPoints().GetData()).copy()
        shown[time] = Shown(points, grid.GetNumberOfCells(), *arrays, numbers)
    return shown
