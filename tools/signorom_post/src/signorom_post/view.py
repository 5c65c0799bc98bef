# SPDX-License-Identifier: BSD-3-Clause
"""Draws the standard pictures of a result by VTK, and writes a script that draws them in ParaView."""

from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

from signorom_post.arrays import FloatArray
from signorom_post.errors import InputError
from signorom_post.paraview_script import paraview_script
from signorom_post.plots.captions import deformed_title, magnification
from signorom_post.readers.fields import FieldFile, FieldPoint

#: name of a picture -> field of fields.h5 that gives its colors, and title of the color bar
PICTURES = {
    "displacement": ("displacement", "displacement"),
    "von_mises": ("von_mises_smoothed", "von Mises stress"),
    "contact_pressure": ("contact_pressure", "contact pressure"),
    "reduced_domain": ("reduced_domain", "reduced domain"),
}
#: why bodies that touch may look as if they did not
GAPS_REMARK = "Only displacements are magnified: bodies that touch may seem to overlap or to stand apart."


def write_view(
    fields: FieldFile, point: FieldPoint, output: Path, camera: FloatArray | None = None
) -> Iterator[Path]:
    """Writes a picture of each field of PICTURES that the point has, then the script; yields the path of each file.

    The files are in the folder `output`, which is made if needed; the script is `in_paraview.py`. A field that is zero
    everywhere gets no picture. `camera`, shape (3), is the direction from solid bodies to the viewer; default: the
    corner that shows most of all bodies. InputError if VTK or the displacement is missing, or if a plane mesh gets a
    camera; OSError if a file cannot be written.
    """
    if find_spec("vtk") is None:
        raise InputError(
            "signorom-post view",
            "VTK is not installed; hint: in the Python environment of signorom-post: pip install 'vtk>=9.2'",
        )
    from signorom_post.plots.vtk_scene import Scene

    if "displacement" not in point.fields:
        raise InputError(fields.path, f"the point '{point.label}' has no field 'displacement'")
    if camera is not None and fields.mesh.n_dim == 2:
        raise InputError(fields.path, "the mesh is plane; --camera is for bodies in space")
    scale = magnification(point.fields["displacement"].values, fields.mesh.size)
    scene = Scene(fields, point, scale, _captions(fields, point, scale), camera)
    output.mkdir(parents=True, exist_ok=True)
    drawn = {}
    for name, (field, title) in PICTURES.items():
        if field not in point.fields or not point.fields[field].values.any():
            continue
        path = output / f"{name}.png"
        scene.draw(field, title, path, on_contact=field == "contact_pressure")
        drawn[name] = field
        yield path
    script = output / "in_paraview.py"
    script.write_text(paraview_script(fields, point, scale, scene.camera, drawn, script), encoding="utf-8")
    yield script


def _captions(fields: FieldFile, point: FieldPoint, scale: float) -> tuple[str, str]:
    """Returns the captions of displaced bodies and of bodies at rest: the label of the point.

    If displacements are magnified, the former gives the factor, and says what this does to contacts.
    """
    remark = f"\n{GAPS_REMARK}" if scale != 1 and fields.contact.n_rows else ""
    return deformed_title(point, scale) + remark, deformed_title(point, 1)
