# SPDX-License-Identifier: BSD-3-Clause
"""For pvpython: read_fields.py FIELDS.xdmf EXPECTED.npz compares cells and arrays in each of ParaView's XDMF readers."""

import sys

import numpy as np
from paraview.vtk.util.numpy_support import vtk_to_numpy
from paraview_readers import read_with_each


def main():
    """Print a line per reader; exit code 1 where an array lacks or has other values."""
    path, expected = sys.argv[1], np.load(sys.argv[2])
    is_good = True
    for name, _, grid in read_with_each(path):
        wrong = [key for key in expected.files if not is_same(grid, key, expected[key])]
        is_good = is_good and not wrong
        state = "WRONG: " + ", ".join(wrong) if wrong else "ok"
        print(
            f"  {name:12} {grid.GetNumberOfPoints()} nodes, {grid.GetNumberOfCells()} cells, "
            f"{len(expected.files)} arrays: {state}"
        )
    return 0 if is_good else 1


def is_same(grid, key, values):
    """Keys are node/name and cell/name; sizes is the number of nodes of each cell, places are in single precision."""
    if key == "sizes":
        found = np.array([grid.GetCell(i).GetNumberOfPoints() for i in range(grid.GetNumberOfCells())])
        return np.array_equal(found, values)
    if key == "places":
        return np.allclose(vtk_to_numpy(grid.GetPoints().GetData()), values, rtol=1e-6, atol=1e-6)
    place, name = key.split("/", 1)
    array = (grid.GetPointData() if place == "node" else grid.GetCellData()).GetArray(name)
    return array is not None and np.array_equal(vtk_to_numpy(array), values, equal_nan=True)


sys.exit(main())
