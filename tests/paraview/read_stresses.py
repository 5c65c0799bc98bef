# SPDX-License-Identifier: BSD-3-Clause
"""For pvpython: read_stresses.py FIELDS.xdmf EXPECTED.npz compares stresses in each of ParaView's XDMF readers."""

import sys

import numpy as np
from paraview.vtk.util.numpy_support import vtk_to_numpy
from paraview_readers import read_with_each


def main():
    """Print a line per reader and field; exit code 1 where a name or a value is another."""
    fields, expected = sys.argv[1], np.load(sys.argv[2])
    is_good = True
    for reader_name, reader, grid in read_with_each(fields):
        information = reader.GetDataInformation()
        places = (
            ("stress", "cells", grid.GetCellData(), information.GetCellDataInformation()),
            ("stress_smoothed", "nodes", grid.GetPointData(), information.GetPointDataInformation()),
        )
        for i, (field, place, data, arrays) in enumerate(places):
            found = vtk_to_numpy(data.GetArray(field))
            array = arrays.GetArrayInformation(field)
            names = [array.GetComponentName(k) for k in range(array.GetNumberOfComponents())]
            is_same = names == list(expected["names"]) and found.shape == expected[place].shape
            worst = np.abs(found - expected[place]).max() if found.shape == expected[place].shape else np.inf
            is_same = is_same and worst <= expected["limits"][i]
            is_good = is_good and is_same
            print(
                f"  {'ok   ' if is_same else 'WRONG'} {reader_name:12} {field:15} {found.shape} {' '.join(names)}; "
                f"largest difference {worst:.2e}, allowed {expected['limits'][i]:.2e}, "
                f"largest stress {np.abs(expected[place]).max():.2e}"
            )
    return 0 if is_good else 1


sys.exit(main())
