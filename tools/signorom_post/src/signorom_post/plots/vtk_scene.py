# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of bodies that VTK draws without a screen."""

import errno
from pathlib import Path

import matplotlib as mpl
import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk

from signorom_post.arrays import FloatArray, IntArray, with_unit
from signorom_post.mesh import Mesh
from signorom_post.palette import SEQUENTIAL
from signorom_post.plots.surface import view
from signorom_post.plots.viewpoint import best_corner
from signorom_post.plots.vtk_camera import SIZE, framed
from signorom_post.plots.vtk_window import hidden_window, image_of
from signorom_post.readers.fields import FieldFile, FieldPoint

#: RGB of texts and outlines
INK = (0.15, 0.15, 0.15)
#: RGB of the outlines of bodies at rest
PALE_INK = (0.65, 0.65, 0.65)
#: [characters] longest line of a caption, unless a parameter alone is longer
LONGEST_LINE = 110
#: [pixels] height of a line of the caption
LINE_HEIGHT = 32
#: opacity of the bodies around a contact surface in space
FAINT = 0.12
#: values that differ by less than this share are one value
ROUNDING = 1e-9
#: number of corners of a cell in space -> VTK's cell type
SOLIDS = {4: vtk.VTK_TETRA, 8: vtk.VTK_HEXAHEDRON}


class Scene:
    """The displaced bodies at one point of a field file."""

    def __init__(
        self,
        fields: FieldFile,
        point: FieldPoint,
        scale: float,
        captions: tuple[str, str],
        camera: FloatArray | None = None,
    ) -> None:
        """The bodies are displaced by `scale` times the displacement.

        `captions` stand above the bodies: in pictures of displaced bodies, and in those of bodies at rest. Contact
        surfaces are drawn at rest, because magnified bodies would overlap. `camera`, shape (3), is the direction from
        solid bodies to the viewer; default: a corner from which one sees all bodies.
        """
        self._fields = fields
        self._point = point
        self._captions = [_filled(caption) for caption in captions]
        mesh, at_rest = fields.mesh, fields.mesh.coordinates
        moved = at_rest + scale * point.fields["displacement"].values
        self._moved, self._at_rest = _grid(mesh, moved), _grid(mesh, at_rest)
        self._contact = _surface(at_rest, _contact_facets(fields), mesh.n_dim)
        if camera is None:
            solid = mesh.n_dim == 3
            camera = view(*best_corner(at_rest, mesh.outer_faces))[2] if solid else np.array([0.0, 0.0, 1.0])
        drawn = np.unique(np.concatenate(mesh.cells))
        strip = LINE_HEIGHT * max(map(len, self._captions))
        #: where the pictures are seen from: all bodies fit into them, at rest and displaced
        self.camera = framed(np.vstack([at_rest[drawn], moved[drawn]]), camera, strip)

    def draw(self, name: str, title: str, path: Path, on_contact: bool) -> None:
        """Writes one picture to `path` (PNG), colored by the field `name` of nodes or cells; a vector by its length.

        `on_contact`: only the contact surfaces are colored, at rest, from zero on; else the displaced bodies. `title`
        stands above the color bar with the unit. KeyError if the point does not have the field, OSError if the picture
        cannot be written.
        """
        quantity = self._point.fields[name]
        values = quantity.values if quantity.values.ndim == 1 else np.linalg.norm(quantity.values, axis=1)
        renderer = vtk.vtkRenderer()
        renderer.SetBackground(1, 1, 1)
        is_solid = self._fields.mesh.n_dim == 3
        has_nodes = len(values) == self._fields.mesh.n_nodes
        actor, colors = _colored(
            self._contact if on_contact else self._moved, values, has_nodes, from_zero=on_contact
        )
        # the light must not change the colors of the field
        has_light = is_solid and not on_contact
        actor.GetProperty().SetAmbient(0.65 if has_light else 1.0)
        actor.GetProperty().SetDiffuse(0.35 if has_light else 0.0)
        if on_contact:
            actor.GetProperty().SetLineWidth(7)
            renderer.AddActor(_plain(self._at_rest, FAINT if is_solid else 1.0))
        else:
            renderer.AddActor(_outline(self._at_rest, PALE_INK))
        renderer.AddActor(_outline(self._at_rest if on_contact else self._moved, INK))
        renderer.AddActor(actor)
        renderer.AddViewProp(color_bar(colors, with_unit(title, quantity.unit)))
        renderer.AddViewProp(_caption("\n".join(self._captions[on_contact])))
        self.camera.aim(renderer)
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
    grid: "vtk.vtkUnstructuredGrid", values: FloatArray, has_nodes: bool, from_zero: bool
) -> tuple["vtk.vtkActor", "vtk.vtkLookupTable"]:
    """Returns the grid in the colors of a field, gray where the field is nan, and the table of these colors."""
    array = numpy_to_vtk(np.ascontiguousarray(values, dtype=float), deep=True)
    (grid.GetPointData() if has_nodes else grid.GetCellData()).SetScalars(array)
    colors = color_table()
    colors.SetTableRange(*_range(values, from_zero))
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


def _range(values: FloatArray, from_zero: bool) -> tuple[float, float]:
    """Returns the least and the largest finite value, the former at most zero if `from_zero`.

    If they differ by rounding errors only, the latter becomes larger by 0.1 %, or by 1 if they are zero.
    """
    finite = values[np.isfinite(values)]
    lowest, highest = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 0.0)
    if from_zero:
        lowest = min(0.0, lowest)
    is_one_value = highest - lowest <= ROUNDING * max(abs(lowest), abs(highest))
    return lowest, highest + (1e-3 * abs(highest) or 1.0) if is_one_value else highest


def color_table() -> "vtk.vtkLookupTable":
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


def _outline(grid: "vtk.vtkUnstructuredGrid", color: tuple[float, float, float]) -> "vtk.vtkActor":
    """Returns the sharp edges and the borders of a grid; of edges at the same place, the dark ones are seen."""
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
    mapper.SetResolveCoincidentTopologyToPolygonOffset()
    mapper.SetRelativeCoincidentTopologyLineOffsetParameters(0.0, -20.0 if color == INK else 0.0)
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(*color)
    actor.GetProperty().SetLineWidth(1.5)
    return actor


def color_bar(colors: "vtk.vtkLookupTable", title: str) -> "vtk.vtkScalarBarActor":
    """Returns a bar of colors on the right of a picture, with numbers and this title."""
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
        ink(text, size)
    return bar


def _filled(text: str) -> list[str]:
    """Returns the lines of a caption: parts of `text`, one a line there, side by side as far as there is room."""
    lines: list[str] = []
    for part in text.split("\n"):
        if lines and len(lines[-1]) + len(part) < LONGEST_LINE:
            lines[-1] += f", {part}"
        else:
            lines.append(part)
    return lines


def _caption(text: str) -> "vtk.vtkTextActor":
    caption = vtk.vtkTextActor()
    caption.SetInput(text)
    caption.SetPosition(20, SIZE[1] - 20)
    ink(caption.GetTextProperty(), 24)
    caption.GetTextProperty().SetVerticalJustificationToTop()
    return caption


def ink(text: "vtk.vtkTextProperty", size: int) -> None:
    """Gives a text the color and the plain font of all texts."""
    text.SetColor(*INK)
    text.SetFontSize(size)
    text.BoldOff()
    text.ItalicOff()
    text.ShadowOff()


def _write(renderer: "vtk.vtkRenderer", path: Path) -> None:
    window = hidden_window(renderer, SIZE, n_samples=8)
    writer = vtk.vtkPNGWriter()
    writer.SetFileName(str(path))
    writer.SetInputData(image_of(window))
    writer.Write()
    window.Finalize()
    # VTK itself only prints
    if writer.GetErrorCode():
        raise OSError(errno.EIO, "VTK could not write the picture", str(path))
