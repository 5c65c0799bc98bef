# SPDX-License-Identifier: BSD-3-Clause
"""The part of an exploration as VTK draws it: one answer, or two side by side, seen by one camera."""

import os
from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy

from signorom_post.answer import Cells, Fields
from signorom_post.arrays import FloatArray, IntArray
from signorom_post.convert.elements import VTK_MIDDLES, Kind, from_middles, kind_of
from signorom_post.explore.colors import Color
from signorom_post.plots.surface import view
from signorom_post.plots.vtk_scene import INK, PALE_INK, color_bar, color_table, ink
from signorom_post.plots.vtk_window import hidden_window, image_of

#: name of a kind of element -> VTK's cell type; kinds with nodes inside their faces are drawn without these
VTK_TYPES = {
    "L2": vtk.VTK_LINE,
    "L3": vtk.VTK_QUADRATIC_EDGE,
    "T3": vtk.VTK_TRIANGLE,
    "T6": vtk.VTK_QUADRATIC_TRIANGLE,
    "Q4": vtk.VTK_QUAD,
    "Q8": vtk.VTK_QUADRATIC_QUAD,
    "T4": vtk.VTK_TETRA,
    "T10": vtk.VTK_QUADRATIC_TETRA,
    "P5": vtk.VTK_PYRAMID,
    "P13": vtk.VTK_QUADRATIC_PYRAMID,
    "W6": vtk.VTK_WEDGE,
    "W15": vtk.VTK_QUADRATIC_WEDGE,
    "H8": vtk.VTK_HEXAHEDRON,
    "H20": vtk.VTK_QUADRATIC_HEXAHEDRON,
}
WITHOUT_INNER_NODES = {"Q9": "Q8", "P14": "P13", "W18": "W15", "H27": "H20"}
#: opacity of bodies around contact surfaces in space
FAINT = 0.15
#: size of the picture over that of the part in it, so that displaced parts fit, too
MARGIN = 1.15
#: [pixels] size of a downloaded picture
PNG_SIZE = (1600, 900)
#: name of a view -> direction to the viewer, and direction upwards
VIEWS = {
    "corner": (tuple(view()[2]), (0.0, 0.0, 1.0)),
    "x": ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
    "y": ((0.0, -1.0, 0.0), (0.0, 0.0, 1.0)),
    "z": ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0)),
}


@dataclass(frozen=True)
class Shown:
    """What one side of the scene shows. Without fields, the bodies stand at rest and have no color."""

    fields: Fields | None
    color: Color | None
    #: factor of the displacement
    scale: float
    #: lowest and highest value of the scale of colors
    limits: tuple[float, float]


class Scene:
    """Two sides of one window; the second is hidden unless two answers are compared."""

    def __init__(self, cells: Cells, coordinates: FloatArray) -> None:
        """`coordinates`: of the nodes, shape (n_nodes, n_dimensions)."""
        self.is_solid = coordinates.shape[1] == 3
        self._at_rest = np.pad(coordinates, ((0, 0), (0, 3 - coordinates.shape[1])))
        grid = grid_of(cells, self._at_rest)
        body = _surface_of(grid)
        self._drawn = np.unique(cells.nodes)
        contact = _surface_of(_facet_grid(cells, self._at_rest))
        self._sides = [_Side(body, contact, self.is_solid) for _ in range(2)]
        self.window = hidden_window(self._sides[0].renderer, (800, 450), n_samples=0)
        self.window.AddRenderer(self._sides[1].renderer)
        self._camera = self._sides[0].renderer.GetActiveCamera()
        self._camera.ParallelProjectionOn()
        self._sides[1].renderer.SetActiveCamera(self._camera)
        self.interactor = vtk.vtkRenderWindowInteractor()
        self.interactor.SetRenderWindow(self.window)
        style = vtk.vtkInteractorStyleTrackballCamera() if self.is_solid else vtk.vtkInteractorStyleImage()
        self.interactor.SetInteractorStyle(style)
        self._has_two = False
        self.compare(False)

    def compare(self, has_two: bool) -> None:
        """Shows two sides, or the first one alone, from the standard view."""
        self._has_two = has_two
        self._sides[0].renderer.SetViewport(0.0, 0.0, 0.5 if has_two else 1.0, 1.0)
        self._sides[1].renderer.SetViewport(0.5, 0.0, 1.0, 1.0)
        self._sides[1].renderer.SetDraw(has_two)
        self.look_from("corner" if self.is_solid else "z")

    def show(self, side: int, shown: Shown) -> None:
        """Changes what a side, 0 or 1, shows; the window is not drawn yet."""
        places = self._at_rest
        if shown.fields is not None:
            moved = np.nan_to_num(shown.scale * shown.fields.displacement)
            places = places + np.pad(moved, ((0, 0), (0, 3 - moved.shape[1])))
        self._sides[side].show(shown, places, self._at_rest)

    def look_from(self, name: str) -> None:
        """Places the camera in one of the directions of VIEWS, so that all bodies are seen."""
        towards, up = (np.array(direction) for direction in VIEWS[name])
        right = np.cross(up, towards)
        right /= np.linalg.norm(right)
        axes = np.array([right, np.cross(towards, right), towards])
        seen = self._at_rest[self._drawn] @ axes.T
        low, high = seen.min(axis=0), seen.max(axis=0)
        width, height = self.window.GetSize()
        aspect = (0.5 if self._has_two else 1.0) * width / height
        half = 0.5 * MARGIN * max(high[1] - low[1], (high[0] - low[0]) / aspect)
        focus = 0.5 * (low + high) @ axes
        self._camera.SetFocalPoint(*focus)
        self._camera.SetPosition(*(focus + 10.0 * half * towards))
        self._camera.SetViewUp(*up)
        self._camera.SetParallelScale(half)
        self._sides[0].renderer.ResetCameraClippingRange()

    def turn(self, azimuth: float, elevation: float) -> None:
        """Turns the camera around the part by angles [degrees]; in the plane it moves instead."""
        if self.is_solid:
            self._camera.Azimuth(azimuth)
            self._camera.Elevation(elevation)
            self._camera.OrthogonalizeViewUp()
        else:
            step = self._camera.GetParallelScale() / 100.0
            for get, put in (
                (self._camera.GetFocalPoint, self._camera.SetFocalPoint),
                (self._camera.GetPosition, self._camera.SetPosition),
            ):
                x, y, z = get()
                put(x + azimuth * step, y + elevation * step, z)
        self._sides[0].renderer.ResetCameraClippingRange()

    def zoom(self, factor: float) -> None:
        """Makes the part larger in the picture."""
        self._camera.Zoom(factor)

    def smooth_edges(self, is_smooth: bool) -> None:
        """Sets whether edges are drawn smooth, which takes several times as long without a graphics card."""
        for side in self._sides:
            side.renderer.SetUseFXAA(is_smooth)

    def png(self, captions: tuple[str, ...], title: str, has_scale: bool) -> bytes:
        """Returns the picture as a PNG file, with a caption for each side, and a bar with the title of the colors."""
        size = self.window.GetSize()
        extra = []
        for side, caption in zip(self._sides, captions, strict=False):
            text = vtk.vtkTextActor()
            text.SetInput(caption)
            text.GetPositionCoordinate().SetCoordinateSystemToNormalizedViewport()
            text.SetPosition(0.02, 0.98)
            text.GetTextProperty().SetVerticalJustificationToTop()
            ink(text.GetTextProperty(), 24)
            extra.append((side.renderer, text))
        if has_scale:
            extra.append((self._sides[len(captions) - 1].renderer, color_bar(self._sides[0].table, title)))
        for renderer, prop in extra:
            renderer.AddViewProp(prop)
        self.window.SetSize(*PNG_SIZE)
        self.smooth_edges(True)
        try:
            writer = vtk.vtkPNGWriter()
            writer.WriteToMemoryOn()
            writer.SetInputData(image_of(self.window))
            writer.Write()
            return bytes(memoryview(writer.GetResult()))
        finally:
            self.smooth_edges(False)
            for renderer, prop in extra:
                renderer.RemoveViewProp(prop)
            self.window.SetSize(*size)


class _Side:
    """One part of the window: bodies, contact surfaces, outlines."""

    def __init__(self, body: "vtk.vtkPolyData", contact: "vtk.vtkPolyData", is_solid: bool) -> None:
        self._is_solid = is_solid
        edges = _edges_of(body)
        self._body, self._contact, self._outline, self._rest = (
            _Layer(data) for data in (body, contact, edges, edges)
        )
        self._scale = color_table()
        self.table = self._scale
        self.renderer = vtk.vtkRenderer()
        self.renderer.SetBackground(1.0, 1.0, 1.0)
        for layer in (self._body, self._contact):
            layer.mapper.UseLookupTableScalarRangeOn()
            layer.mapper.SetScalarModeToUsePointData()
        self._contact.actor.GetProperty().SetLineWidth(7)
        for layer, color in ((self._rest, PALE_INK), (self._outline, INK)):
            layer.actor.GetProperty().SetColor(*color)
            layer.actor.GetProperty().SetLineWidth(1.3)
            layer.mapper.SetResolveCoincidentTopologyToPolygonOffset()
        # contact surfaces lie on faces of the bodies, which are faint around them
        self._contact.mapper.SetResolveCoincidentTopologyToPolygonOffset()
        self._contact.mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(-2.0, -200.0)
        self._outline.mapper.SetRelativeCoincidentTopologyLineOffsetParameters(0.0, -20.0)
        for layer in (self._rest, self._body, self._outline, self._contact):
            self.renderer.AddActor(layer.actor)

    def show(self, shown: Shown, places: FloatArray, at_rest: FloatArray) -> None:
        """Draws bodies at `places`, contact surfaces at rest: magnified bodies would overlap. Shapes (n_nodes, 3)."""
        on_contact = shown.color is not None and shown.color.on_contact
        values = None if shown.fields is None or shown.color is None else shown.color.of(shown.fields)
        bodies_at = at_rest if on_contact else places
        self._body.place(bodies_at, None if on_contact else values)
        self._outline.place(bodies_at)
        self._rest.place(at_rest)
        self._rest.actor.SetVisibility(not on_contact and shown.fields is not None)
        self._contact.actor.SetVisibility(on_contact and values is not None)
        if on_contact:
            self._contact.place(at_rest, values)
        self._set_table(shown)
        self._body.mapper.SetInterpolateScalarsBeforeMapping(True)
        look = self._body.actor.GetProperty()
        look.SetColor(0.87, 0.87, 0.87)
        look.SetOpacity(FAINT if on_contact and self._is_solid else 1.0)
        # the light must not change the colors of a field on contact surfaces, nor in the plane
        has_light = self._is_solid and not on_contact
        look.SetAmbient(0.65 if has_light else 1.0)
        look.SetDiffuse(0.35 if has_light else 0.0)
        self._contact.actor.GetProperty().LightingOff()

    def _set_table(self, shown: Shown) -> None:
        has_states = shown.color is not None and shown.color.states is not None
        self.table = _table_of(shown.color) if has_states else self._scale
        if not has_states:
            self.table.SetTableRange(*shown.limits)
        for layer in (self._body, self._contact):
            layer.mapper.SetLookupTable(self.table)
        self._contact.mapper.SetInterpolateScalarsBeforeMapping(not has_states)


def _table_of(color: Color) -> "vtk.vtkLookupTable":
    """Returns the colors of a field of states."""
    states = color.states or {}
    last = max(states)
    table = vtk.vtkLookupTable()
    table.SetNumberOfTableValues(last)
    table.SetTableRange(0.5, last + 0.5)
    for state in range(1, last + 1):
        table.SetTableValue(state - 1, *mpl.colors.to_rgba(states.get(state, ("", "#ffffff"))[1]))
    return table


class _Layer:
    """A surface or lines whose points are nodes of the mesh, and the actor that draws them."""

    def __init__(self, template: "vtk.vtkPolyData") -> None:
        self._data = vtk.vtkPolyData()
        self._data.ShallowCopy(template)
        nodes = template.GetPointData().GetArray("node")
        self._nodes = vtk_to_numpy(nodes).astype(np.int64) if nodes else np.zeros(0, dtype=np.int64)
        self._data.GetPointData().Initialize()
        self.mapper = vtk.vtkPolyDataMapper()
        self.mapper.SetInputData(self._data)
        self.actor = vtk.vtkActor()
        self.actor.SetMapper(self.mapper)

    def place(self, places: FloatArray, values: FloatArray | None = None) -> None:
        """Moves the points to `places`, shape (n_nodes, 3), and colors them by `values`, shape (n_nodes)."""
        points = vtk.vtkPoints()
        points.SetData(numpy_to_vtk(places[self._nodes].astype(np.float32), deep=True))
        self._data.SetPoints(points)
        if values is not None:
            self._data.GetPointData().SetScalars(
                numpy_to_vtk(values[self._nodes].astype(np.float32), deep=True)
            )
        self.mapper.SetScalarVisibility(values is not None)


def grid_of(cells: Cells, places: FloatArray) -> "vtk.vtkUnstructuredGrid":
    """Returns the mesh with its nodes at `places`, shape (n_nodes, 3), without nodes inside of faces."""
    n_dim = 3 if _is_solid(places, cells) else 2
    return _grid(cells.starts, cells.nodes, n_dim, places)


def _is_solid(places: FloatArray, cells: Cells) -> bool:
    """Returns whether cells are solid: plane meshes have z = 0 everywhere."""
    return bool(np.ptp(places[:, 2]) > 0.0) if len(cells.nodes) else False


def _facet_grid(cells: Cells, places: FloatArray) -> "vtk.vtkUnstructuredGrid":
    n_dim = 2 if _is_solid(places, cells) else 1
    return _grid(cells.facet_starts, cells.facet_nodes, n_dim, places)


def _grid(starts: IntArray, nodes: IntArray, n_dim: int, places: FloatArray) -> "vtk.vtkUnstructuredGrid":
    """Returns cells of one dimension; cell i has the nodes[starts[i]:starts[i + 1]] in gmsh's order."""
    sizes = np.diff(starts)
    types = np.zeros(len(sizes), dtype=np.uint8)
    orders: dict[int, IntArray] = {}
    for n in np.unique(sizes):
        kind = kind_of(n_dim, int(n))
        drawn = (
            kind if kind.name in VTK_TYPES else kind_of(n_dim, _n_nodes_of(WITHOUT_INNER_NODES[kind.name]))
        )
        orders[int(n)] = _vtk_order(kind, drawn)
        types[sizes == n] = VTK_TYPES[drawn.name]
    lengths = np.array([len(orders[int(n)]) for n in sizes], dtype=np.int64)
    offsets = np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64)
    connections = np.zeros(offsets[-1], dtype=np.int64)
    for n, order in orders.items():
        which = np.flatnonzero(sizes == n)
        connections[offsets[which][:, None] + np.arange(len(order))] = nodes[starts[which][:, None] + order]
    array = vtk.vtkCellArray()
    array.SetData(
        numpy_to_vtkIdTypeArray(offsets, deep=True), numpy_to_vtkIdTypeArray(connections, deep=True)
    )
    grid = vtk.vtkUnstructuredGrid()
    points = vtk.vtkPoints()
    points.SetData(numpy_to_vtk(np.ascontiguousarray(places), deep=True))
    grid.SetPoints(points)
    grid.SetCells(numpy_to_vtk(types, deep=True, array_type=vtk.VTK_UNSIGNED_CHAR), array)
    ids = numpy_to_vtkIdTypeArray(np.arange(len(places), dtype=np.int64), deep=True)
    ids.SetName("node")
    grid.GetPointData().AddArray(ids)
    return grid


def _n_nodes_of(name: str) -> int:
    return {"Q8": 8, "P13": 13, "W15": 15, "H20": 20}[name]


def _vtk_order(kind: Kind, drawn: Kind) -> IntArray:
    """Returns where VTK's nodes of the element `drawn` stand among gmsh's nodes of `kind`, which may have more."""
    places = np.argsort(from_middles(drawn, VTK_MIDDLES))
    return np.array([kind.nodes.index(drawn.nodes[i]) for i in places], dtype=np.int64)


def _surface_of(grid: "vtk.vtkUnstructuredGrid") -> "vtk.vtkPolyData":
    """Returns the outer faces as triangles and quadrilaterals between all nodes, which the array `node` numbers."""
    surface = vtk.vtkGeometryFilter()
    surface.SetInputData(grid)
    surface.SetNonlinearSubdivisionLevel(1)
    surface.Update()
    return surface.GetOutput()


def _edges_of(surface: "vtk.vtkPolyData") -> "vtk.vtkPolyData":
    """Returns sharp edges and borders of a surface."""
    edges = vtk.vtkFeatureEdges()
    edges.SetInputData(surface)
    edges.SetFeatureAngle(30)
    edges.ManifoldEdgesOff()
    edges.ColoringOff()
    edges.Update()
    return edges.GetOutput()


def vtu(cells: Cells, coordinates: FloatArray, fields: Fields) -> bytes:
    """Returns the mesh at rest with all fields as a file for ParaView (VTU); `coordinates`: (n_nodes, n_dimensions)."""
    n_nodes, n_cells = len(coordinates), len(cells.starts) - 1
    grid = grid_of(cells, np.pad(coordinates, ((0, 0), (0, 3 - coordinates.shape[1]))))
    grid.GetPointData().Initialize()
    for name, unit in fields.units.items():
        values = getattr(fields, name, None)
        if values is None or len(values) not in (n_nodes, n_cells):
            continue
        if values.ndim == 2 and values.shape[1] == 2:
            values = np.pad(values, ((0, 0), (0, 1)))
        array = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
        array.SetName(f"{name} [{unit}]" if unit not in ("", "-") else name)
        (grid.GetPointData() if len(values) == n_nodes else grid.GetCellData()).AddArray(array)
    writer = vtk.vtkXMLUnstructuredGridWriter()
    writer.SetInputData(grid)
    writer.WriteToOutputStringOn()
    writer.SetDataModeToBinary()
    writer.Write()
    return os.fsencode(writer.GetOutputString())
