# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of bodies that VTK draws without a screen."""

import errno
from pathlib import Path

import matplotlib as mpl
import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk

from signorom_post.arrays import FloatArray, IntArray
from signorom_post.mesh import Mesh
from signorom_post.readers.fields import FieldFile, FieldPoint
from signorom_post.style import SEQUENTIAL

#: [pixels] width and height of a picture
SIZE = (1600, 900)
#: RGB of texts and outlines
INK = (0.15, 0.15, 0.15)
#: opacity of the bodies around a contact surface in space
FAINT = 0.12
#: number of corners of a cell in space -> VTK's cell type
SOLIDS = {4: vtk.VTK_TETRA, 8: vtk.VTK_HEXAHEDRON}


class Scene:
    """The displaced bodies at one point of a field file."""

    def __init__(self, fields: FieldFile, point: FieldPoint, scale: float) -> None:
        """The bodies are displaced by `scale` times the displacement.

        Contact surfaces are drawn at rest, because magnified bodies would overlap.
        """
        self._fields = fields
        self._point = point
        at_rest = fields.mesh.coordinates
        self._moved = _grid(fields.mesh, at_rest + scale * point.fields["displacement"].values)
        self._at_rest = _grid(fields.mesh, at_rest)
        self._contact = _surface(at_rest, _contact_facets(fields), fields.mesh.n_dim)

    def draw(self, name: str, title: str, caption: str, path: Path, on_contact: bool) -> None:
        """Writes one picture to `path` (PNG), colored by the field `name` of nodes or cells; a vector by its length.

        `on_contact`: only the contact surfaces are colored, at rest; else the displaced bodies. `title` stands above
        the color bar with the unit, and `caption` in the corner. KeyError if the point does not have the field, OSError
        if the picture cannot be written.
        """
        quantity = self._point.fields[name]
        values = quantity.values if quantity.values.ndim == 1 else np.linalg.norm(quantity.values, axis=1)
        renderer = vtk.vtkRenderer()
        renderer.SetBackground(1, 1, 1)
        n_dim = self._fields.mesh.n_dim
        bodies = self._at_rest if on_contact else self._moved
        has_nodes = len(values) == self._fields.mesh.n_nodes
        actor, colors = _colored(self._contact if on_contact else bodies, values, has_nodes)
        # the light must not change the colors of the field
        actor.GetProperty().SetAmbient(1.0 if on_contact or n_dim == 2 else 0.65)
        actor.GetProperty().SetDiffuse(0.0 if on_contact or n_dim == 2 else 0.35)
        if on_contact:
            actor.GetProperty().SetLineWidth(7)
            renderer.AddActor(_plain(bodies, FAINT if n_dim == 3 else 1.0))
        renderer.AddActor(_outline(bodies))
        renderer.AddActor(actor)
        unit = f" [{quantity.unit}]" if quantity.unit not in ("", "-") else ""
        renderer.AddViewProp(_bar(colors, title + unit))
        renderer.AddViewProp(_caption(caption))
        _aim(renderer, n_dim)
        _write(renderer, path)


def _grid(mesh: Mesh, points: FloatArray) -> "vtk.vtkUnstructuredGrid":
    """Returns the cells with their corners; plane cells are polygons through all their nodes."""
    grid = vtk.vtkUnstructuredGrid()
    grid.SetPoints(_points(points))
    for cell in mesh.cells:
        kind = vtk.VTK_POLYGON if mesh.n_dim == 2 else SOLIDS[len(cell)]
        grid.InsertNextCell(kind, len(cell), [int(node) for node in cell])
    return grid


def _points(points: FloatArray) -> "vtk.vtkPoints":
    placed = vtk.vtkPoints()
    placed.SetData(numpy_to_vtk(np.ascontiguousarray(points, dtype=float), deep=True))
    return placed


def _contact_facets(fields: FieldFile) -> list[IntArray]:
    """Returns the outer edges or faces whose corners all own a contact row."""
    if fields.mesh.n_dim == 2:
        edges = fields.mesh.boundary_edges
        return list(edges[np.isin(edges, fields.contact.owners).all(axis=1)])
    faces = fields.contact_faces
    return [nodes[:n] for nodes, n in zip(faces.nodes, faces.n_corners, strict=True)]


def _surface(points: FloatArray, facets: list[IntArray], n_dim: int) -> "vtk.vtkUnstructuredGrid":
    surface = vtk.vtkUnstructuredGrid()
    surface.SetPoints(_points(points))
    for facet in facets:
        kind = vtk.VTK_LINE if n_dim == 2 else vtk.VTK_POLYGON
        surface.InsertNextCell(kind, len(facet), [int(node) for node in facet])
    return surface


def _colored(
    grid: "vtk.vtkUnstructuredGrid", values: FloatArray, has_nodes: bool
) -> tuple["vtk.vtkActor", "vtk.vtkLookupTable"]:
    """Returns the grid in the colors of a field, gray where the field is nan, and the table of these colors."""
    array = numpy_to_vtk(np.ascontiguousarray(values, dtype=float), deep=True)
    (grid.GetPointData() if has_nodes else grid.GetCellData()).SetScalars(array)
    finite = values[np.isfinite(values)]
    lowest, highest = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
    colors = _sequential()
    colors.SetTableRange(lowest, highest if highest > lowest else lowest + 1.0)
    mapper = vtk.vtkDataSetMapper()
    mapper.SetInputData(grid)
    mapper.SetLookupTable(colors)
    mapper.UseLookupTableScalarRangeOn()
    mapper.InterpolateScalarsBeforeMappingOn()
    if has_nodes:
        mapper.SetScalarModeToUsePointData()
    else:
        mapper.SetScalarModeToUseCellData()
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    return actor, colors


def _sequential() -> "vtk.vtkLookupTable":
    """Returns the color map of all figures as VTK's table."""
    table = vtk.vtkLookupTable()
    table.SetNumberOfTableValues(256)
    for i, color in enumerate(mpl.colormaps[SEQUENTIAL](np.linspace(0.0, 1.0, 256))):
        table.SetTableValue(i, *color)
    table.SetNanColor(0.8, 0.8, 0.8, 1.0)
    return table


def _plain(grid: "vtk.vtkUnstructuredGrid", opacity: float) -> "vtk.vtkActor":
    mapper = vtk.vtkDataSetMapper()
    mapper.SetInputData(grid)
    mapper.ScalarVisibilityOff()
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(0.87, 0.87, 0.87)
    actor.GetProperty().LightingOff()
    actor.GetProperty().SetOpacity(opacity)
    return actor


def _outline(grid: "vtk.vtkUnstructuredGrid") -> "vtk.vtkActor":
    """Returns the sharp edges and the borders of a grid."""
    surface = vtk.vtkGeometryFilter()
    surface.SetInputData(grid)
    edges = vtk.vtkFeatureEdges()
    edges.SetInputConnection(surface.GetOutputPort())
    edges.SetFeatureAngle(30)
    edges.ManifoldEdgesOff()
    edges.ColoringOff()
    mapper = vtk.vtkPolyDataMapper()
    mapper.SetInputConnection(edges.GetOutputPort())
    mapper.ScalarVisibilityOff()
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(*INK)
    actor.GetProperty().SetLineWidth(1.5)
    return actor


def _bar(colors: "vtk.vtkLookupTable", title: str) -> "vtk.vtkScalarBarActor":
    bar = vtk.vtkScalarBarActor()
    bar.SetLookupTable(colors)
    bar.SetTitle(title)
    bar.SetNumberOfLabels(6)
    bar.SetLabelFormat("%.3g")
    bar.UnconstrainedFontSizeOn()
    bar.SetVerticalTitleSeparation(12)
    bar.SetPosition(0.86, 0.15)
    bar.SetWidth(0.09)
    bar.SetHeight(0.7)
    for text, size in ((bar.GetTitleTextProperty(), 22), (bar.GetLabelTextProperty(), 20)):
        _ink(text, size)
    return bar


def _caption(text: str) -> "vtk.vtkTextActor":
    caption = vtk.vtkTextActor()
    caption.SetInput(text)
    caption.SetPosition(20, SIZE[1] - 20)
    _ink(caption.GetTextProperty(), 24)
    caption.GetTextProperty().SetVerticalJustificationToTop()
    return caption


def _ink(text: "vtk.vtkTextProperty", size: int) -> None:
    text.SetColor(*INK)
    text.SetFontSize(size)
    text.BoldOff()
    text.ItalicOff()
    text.ShadowOff()


def _aim(renderer: "vtk.vtkRenderer", n_dim: int) -> None:
    """Places the camera: in front of a plane mesh, else above a corner; leaves room for the color bar on the right."""
    camera = renderer.GetActiveCamera()
    camera.ParallelProjectionOn()
    if n_dim == 3:
        camera.SetPosition(-1.0, -1.8, 1.1)
        camera.SetViewUp(0, 0, 1)
    renderer.ResetCamera()
    camera.Zoom(1.2 if n_dim == 2 else 1.1)
    camera.SetWindowCenter(0.14, 0.0)


def _write(renderer: "vtk.vtkRenderer", path: Path) -> None:
    # otherwise VTK prints a warning that there is no screen
    vtk.vtkLogger.SetStderrVerbosity(vtk.vtkLogger.VERBOSITY_ERROR)
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(8)
    window.SetSize(*SIZE)
    window.AddRenderer(renderer)
    window.Render()
    picture = vtk.vtkWindowToImageFilter()
    picture.SetInput(window)
    picture.ReadFrontBufferOff()
    writer = vtk.vtkPNGWriter()
    writer.SetFileName(str(path))
    writer.SetInputConnection(picture.GetOutputPort())
    writer.Write()
    window.Finalize()
    # VTK itself only prints
    if writer.GetErrorCode():
        raise OSError(errno.EIO, "VTK could not write the picture", str(path))
