# SPDX-License-Identifier: BSD-3-Clause
"""Writes a script that draws the pictures of `signorom-post view` in ParaView."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from signorom_post.readers.fields import FieldFile, FieldPoint

if TYPE_CHECKING:  # VTK is optional
    from signorom_post.plots.vtk_camera import Camera

SCRIPT = '''# Pictures of {name} in ParaView: pvpython {script}, or Tools, Python Shell, Run Script.
from paraview import simple

FOLDER = {folder!r}
FIELDS = {fields!r}
CONTACT = {contact!r}  # the contact surfaces
SCALE = {scale!r}  # of the displacements
TIME = {time!r}  # number of the point: {label}


def show(view, source, place, field):
    """A source in the colors of a field."""
    display = simple.Show(source, view)
    simple.ColorBy(display, (place, field))
    simple.GetColorTransferFunction(field).ApplyPreset("Viridis (matplotlib)", True)
    display.RescaleTransferFunctionToDataRange()
    display.SetScalarBarVisibility(view, True)
    return display


def show_bodies(view, place, field):
    """The bodies, displaced and colored by a field."""
    show(view, simple.WarpByVector(Input=bodies, Vectors=["POINTS", "displacement"], ScaleFactor=SCALE), place, field)


def show_contact(view, place, field):
    """The contact surfaces at rest, in colors from zero on, and the bodies around them."""
    around = simple.Show(bodies, view)
    simple.ColorBy(around, None)
    around.DiffuseColor, around.Opacity = [0.87, 0.87, 0.87], {opacity!r}
    show(view, simple.Xdmf3ReaderT(FileName=[CONTACT]), place, field).LineWidth = 7
    colors = simple.GetColorTransferFunction(field)
    colors.RescaleTransferFunction(min(0.0, colors.RGBPoints[0]), colors.RGBPoints[-4])


def picture(name, draw, place, field):
    """A picture of its own, seen as signorom-post does; the first Render would move the camera."""
    view = simple.CreateRenderView(ViewSize=[1600, 900])
    draw(view, place, field)
    simple.Render(view)
    view.CameraParallelProjection, view.CameraParallelScale = 1, {camera.half_height!r}
    view.CameraPosition, view.CameraFocalPoint = {position!r}, {focus!r}
    view.CameraViewUp = {up!r}
    simple.SaveScreenshot(FOLDER + "/paraview_" + name + ".png", view)


bodies = simple.Xdmf3ReaderT(FileName=[FIELDS])
# a view takes its time from the animation, and not from what it is made with
scene = simple.GetAnimationScene()
scene.UpdateAnimationUsingDataTimeSteps()
scene.AnimationTime = TIME
{pictures}
'''


def paraview_script(
    fields: FieldFile,
    point: FieldPoint,
    scale: float,
    camera: "Camera",
    pictures: Mapping[str, str],
    script: Path,
) -> str:
    """Returns a script for pvpython that draws this point of fields.xdmf, as signorom-post draws it.

    `scale` is the factor of the displacements, and `pictures` are the names of the pictures with their fields. The
    contact pressure is read from contact.xdmf, and left out if there is no such file. `script` is the path of the
    script, beside which it writes its pictures.
    """
    contact = fields.path.with_name("contact.xdmf")
    calls = []
    for name, field in pictures.items():
        draw = "show_contact" if field == "contact_pressure" else "show_bodies"
        has_nodes = len(point.fields[field].values) == fields.mesh.n_nodes
        if draw == "show_bodies" or contact.exists():
            calls.append(f'picture("{name}", {draw}, "{"POINTS" if has_nodes else "CELLS"}", "{field}")')
    return SCRIPT.format(
        name=fields.path.parent.name,
        script=script.name,
        folder=str(script.parent.absolute()),
        fields=str(fields.path.with_suffix(".xdmf").absolute()),
        contact=str(contact.absolute()),
        scale=scale,
        time=float(fields.points.index(point) + 1),
        label=point.label,
        opacity=0.12 if fields.mesh.n_dim == 3 else 1.0,
        camera=camera,
        position=camera.position.tolist(),
        focus=camera.focus.tolist(),
        up=camera.up.tolist(),
        pictures="\n".join(calls),
    )
