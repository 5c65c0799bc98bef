# SPDX-License-Identifier: BSD-3-Clause
"""For pvpython: read_views.py SCRIPT OUTPUT.json runs a script of `signorom-post view` and tells what its views show."""

import json
import runpy
import sys
from pathlib import Path

from paraview import simple


def main():
    """Write, for each field in color: range of its values, range of its colors, box around what is drawn, scale."""
    script, output = sys.argv[1:]
    scale = runpy.run_path(script)["SCALE"]
    shown = {}
    for view in simple.GetRenderViews():
        for display in view.Representations:
            place, field = getattr(display, "ColorArrayName", (None, ""))
            if field:
                data = display.GetRepresentedDataInformation()
                arrays = (
                    data.GetPointDataInformation() if place == "POINTS" else data.GetCellDataInformation()
                )
                colors = simple.GetColorTransferFunction(field).RGBPoints
                shown[field] = {
                    "values": arrays.GetArrayInformation(field).GetComponentFiniteRange(-1),
                    "colors": [colors[0], colors[-4]],
                    "box": data.GetBounds(),
                    "scale": scale,
                }
    Path(output).write_text(json.dumps(shown))


main()
