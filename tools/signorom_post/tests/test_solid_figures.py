# SPDX-License-Identifier: BSD-3-Clause
"""Figures of bodies in three dimensions: which faces are drawn, where, and in which color."""

from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from pairs import contact_of_pairs
from pictures import check_picture

from signorom_post.arrays import Quantity
from signorom_post.mesh import Mesh
from signorom_post.plots.depth_buffer import DepthBuffer
from signorom_post.plots.pressure_maps import pressure_maps
from signorom_post.plots.reduced_domain import reduced_domain
from signorom_post.plots.sheet import lay_out
from signorom_post.plots.solid_figures import initial_and_deformed_solid, is_on_contact
from signorom_post.plots.surface import draw_surface, frame_surface, view
from signorom_post.plots.viewpoint import best_corner
from signorom_post.readers.fields import FieldFile, FieldPoint
from signorom_post.style import save, styled

N = 3
#: Kuhn's split of a box into six tetrahedra, by the corners of the hexahedron
TETRAHEDRA = [(0, 1, 2, 6), (0, 1, 5, 6), (0, 3, 2, 6), (0, 3, 7, 6), (0, 4, 5, 6), (0, 4, 7, 6)]


def box(low: float, first: int) -> tuple[np.ndarray, list[np.ndarray]]:
    """Nodes and hexahedra of a cube of N cells along each side, from the height low on."""
    line = np.linspace(0.0, 1.0, N + 1)
    points = np.stack(np.meshgrid(line, line, low + line, indexing="ij"), axis=-1).reshape(-1, 3)
    number = first + np.arange((N + 1) ** 3).reshape(N + 1, N + 1, N + 1)
    cells = []
    for i, j, k in np.ndindex(N, N, N):
        corner = [(0, 0), (1, 0), (1, 1), (0, 1)]
        cells.append(np.array([number[i + a, j + b, k + c] for c in (0, 1) for a, b in corner]))
    return points, cells


def two_cubes(element: str) -> Mesh:
    """One upon the other; every other cell is written inside out."""
    points, lower = box(0.0, 0)
    more, upper = box(1.0, len(points))
    cells = lower + upper
    if element == "T4":
        cells = [cell[list(corners)] for cell in cells for corners in TETRAHEDRA]
        cells = [cell[[0, 2, 1, 3]] if i % 2 else cell for i, cell in enumerate(cells)]
    else:
        cells = [cell[[0, 3, 2, 1, 4, 7, 6, 5]] if i % 2 else cell for i, cell in enumerate(cells)]
    return Mesh(np.vstack([points, more]), cells, 3, "mm")


def cubes_with_fields(element: str) -> FieldFile:
    """Pressure x on the contact face: force over area."""
    mesh = two_cubes(element)
    first = np.flatnonzero(mesh.coordinates[: (N + 1) ** 3, 2] == 1.0)
    second = (N + 1) ** 3 + np.flatnonzero(mesh.coordinates[(N + 1) ** 3 :, 2] == 1.0)
    x = mesh.coordinates[first, 0]
    areas = np.full(len(first), 1 / N**2)
    force = x * areas
    fields = {
        "displacement": Quantity(0.1 * mesh.coordinates, "mm"),
        "multipliers_full_order": Quantity(force, "N"),
        "multipliers_reduced": Quantity(0.5 * force, "N"),
        "reduced_domain": Quantity((np.arange(mesh.n_cells) < mesh.n_cells // 4).astype(float)),
        "rows_in_reduced_domain": Quantity((np.arange(len(first)) < 4).astype(float)),
    }
    return FieldFile(
        Path("fields.h5"),
        mesh,
        [FieldPoint("load = 1", ["load"], np.ones(1), fields)],
        contact_of_pairs(first, second, areas),
    )


@pytest.mark.parametrize(("element", "n_per_square"), [("H8", 1), ("T4", 2)])
def test_outer_faces_are_those_of_both_cubes_and_look_outwards(element: str, n_per_square: int) -> None:
    """Six sides of N x N squares each; area vectors of a closed surface: those up and down are as large as the side."""
    mesh = two_cubes(element)
    faces = mesh.outer_faces
    assert len(faces.nodes) == 2 * 6 * N**2 * n_per_square
    corners = mesh.coordinates[faces.nodes]
    areas = 0.5 * np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    middles = corners[:, :3].mean(axis=1)
    centers = np.where((faces.cells < mesh.n_cells // 2)[:, None], [0.5, 0.5, 0.5], [0.5, 0.5, 1.5])
    assert (np.einsum("ij,ij->i", areas, middles - centers) > 0).all()
    np.testing.assert_allclose(np.linalg.norm(areas, axis=1).sum(), 12.0)
    assert (faces.n_corners == (4 if element == "H8" else 3)).all()


def test_view_is_a_rotation() -> None:
    np.testing.assert_allclose(view() @ view().T, np.eye(3), atol=1e-15)
    np.testing.assert_allclose(np.cross(view()[0], view()[1]), view()[2], atol=1e-15)
    # up is up in the picture
    assert view()[1, 2] > 0


@pytest.mark.parametrize("element", ["H8", "T4"])
def test_bodies_at_rest_and_displaced(tmp_path: Path, element: str) -> None:
    """Three sides of the pile are seen, and of the upper cube's foot nothing; colors differ."""
    fields = cubes_with_fields(element)
    with styled():
        figure = initial_and_deformed_solid(fields, fields.points[0])
        check_picture(figure, tmp_path / "figure.png")
    left, right = figure.axes[:2]
    rest, shown = (surface_colors(axes) for axes in (left, right))
    # two lateral sides of the pile and its top look at the viewer
    assert (rest.min(axis=1) > 0.6).sum() == 3
    assert len(shown) > 20


def surface_colors(axes: Axes) -> np.ndarray:
    """The colors in the picture of the surface; those of edges are dark."""
    (image,) = [image for image in axes.images if image.get_gid() == "surface"]
    pixels = np.asarray(image.get_array()).reshape(-1, 4)
    pixels = pixels[pixels[:, 3] == 1.0, :3]
    # 21 bits of each color in one number, because millions of rows are sorted in seconds
    codes = np.round(pixels * 2**20).astype(np.int64) @ np.array([2**42, 2**21, 1])
    return pixels[np.unique(codes, return_index=True)[1]]


def plain_box(low: tuple[float, ...], high: tuple[float, ...], first: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and the one hexahedron of a box."""
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    return np.where(np.array(corners) == 1, high, low).astype(float), first + np.arange(8)


@pytest.mark.parametrize(
    ("low", "is_seen"),
    [((0.2, 5.8, 0.0), True), ((3.0, 3.0, 0.0), True), ((1.0, 5.8, -3.0), False)],
    ids=["on the far corner", "in the middle", "below the far corner"],
)
def test_near_parts_hide_far_ones(low: tuple[float, ...], is_seen: bool, tmp_path: Path) -> None:
    """A cube on a plate of one cell is seen as a whole, wherever it stands; below the plate nothing is seen of it.

    The side of the cube is 2. A face of the area A fills A n.t of the picture; n is its normal, t the direction to the
    viewer.
    """
    plate, cell = plain_box((0, 0, -1), (8, 8, 0), 0)
    cube, other = plain_box(low, tuple(x + 2 for x in low), 8)
    mesh = Mesh(np.vstack([plate, cube]), [cell, other], 3)
    faces = mesh.outer_faces
    red, blue = np.eye(3)[0], np.eye(3)[2]
    with styled():
        figure = Figure(figsize=(4.0, 4.0))
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        draw_surface(axes, mesh.coordinates, faces, np.where(faces.cells[:, None] == 1, red, blue))
        frame_surface(axes, mesh.coordinates, "mm")
        save(figure, tmp_path / "figure.png")
    pixels = matplotlib.image.imread(tmp_path / "figure.png")
    is_red = (pixels[..., 0] > 2 * pixels[..., 2]) & (pixels[..., 0] > pixels[..., 1] + 0.1)
    per_unit = 800 / np.ptp(axes.get_xlim())
    expected = 4 * np.abs(view()[2]).sum() * per_unit**2 if is_seen else 0.0
    # the edges are black and gray
    assert is_red.sum() == pytest.approx(expected, rel=0.1, abs=1)


@pytest.mark.parametrize("near", [0, 1])
def test_of_two_equal_triangles_the_near_one_is_seen(near: int) -> None:
    """Half of the square around them is filled; what lies between them is hidden, what is beside or above is not."""
    triangle = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    corners = np.array([triangle, triangle])
    corners[near, :, 2] = 1.0
    buffer = DepthBuffer(corners, 200)
    counts = np.bincount(buffer.owner + 1, minlength=3)
    assert counts[1 + near] == pytest.approx(200**2 / 2, rel=0.02)
    assert counts[2 - near] == 0
    places = np.array([[0.2, 0.2, 0.5], [0.2, 0.2, 1.0], [0.2, 0.2, 2.0], [0.8, 0.8, 0.5]])
    assert buffer.sees(places).tolist() == [False, True, True, True]


def test_the_view_shows_the_small_body() -> None:
    """A block stands in front of a wall on one side: of the eight corners one sees it from two above and two below."""
    for side, seen in (((2.5, -1, 3), {-55.0, -145.0, 215.0}), ((2.5, 1, 3), {35.0, 125.0})):
        wall, cell = plain_box((0, 0, 0), (6, 1, 6), 0)
        block, other = plain_box(side, tuple(np.add(side, 1)), 8)
        mesh = Mesh(np.vstack([wall, block]), [cell, other], 3)
        azimuth, elevation = best_corner(mesh.coordinates, mesh.outer_faces)
        assert elevation > 0
        assert azimuth in seen


@pytest.mark.parametrize(("element", "n_per_square"), [("H8", 1), ("T4", 2)])
def test_faces_beside_the_contact_are_not_on_it(element: str, n_per_square: int) -> None:
    """Of the sides of both cubes, one each: not those with an edge or a corner on the contact."""
    fields = cubes_with_fields(element)
    faces = fields.mesh.outer_faces
    chosen = is_on_contact(fields, faces)
    assert np.count_nonzero(chosen) == 2 * N**2 * n_per_square
    assert (fields.mesh.coordinates[faces.nodes[chosen]][..., 2] == 1.0).all()


@pytest.mark.parametrize("element", ["H8", "T4"])
def test_contact_pressure_on_the_surface(tmp_path: Path, element: str) -> None:
    """Force over area is x; the reduced model has half of it. The face looks along z: the picture is over x and y."""
    fields = cubes_with_fields(element)
    with styled():
        figure = pressure_maps(fields)
        check_picture(figure, tmp_path / "figure.png")
    names = ("multipliers_full_order", "multipliers_reduced")
    for axes, name, factor in zip(figure.axes, names, (1.0, 0.5), strict=False):
        (image,) = [image for image in axes.images if image.get_gid() == name]
        left, right, *_ = image.get_extent()
        pressure = image.get_array()
        n_columns = pressure.shape[1]
        x = left + (right - left) * (np.arange(n_columns) + 0.5) / n_columns
        is_inside = (x > 0.01) & (x < 0.99)
        assert not pressure.mask[10:-10, is_inside].any()
        np.testing.assert_allclose(pressure[10:-10, is_inside].mean(axis=0), factor * x[is_inside], atol=1e-9)
    assert figure.axes[2].get_ylabel() == "contact pressure [MPa]"


def test_an_inclined_surface_is_seen_from_its_front() -> None:
    """A square that rises by 45 degrees along x, with the body below it."""
    points = np.array([[0.0, 0, 0], [1, 0, 1], [1, 1, 1], [0, 1, 0]])
    up = np.tile([0.0, 0.0, 1.0], (4, 1))
    sheet = lay_out(points, [np.array([0, 3, 2, 1])], up, np.ones(4))
    np.testing.assert_allclose(sheet.towards[2], np.array([-1, 0, 1]) / np.sqrt(2), atol=1e-12)
    np.testing.assert_allclose(np.sort(sheet.size), [1.0, np.sqrt(2)])


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_bore_is_seen_from_aside_where_it_is_loaded(axis: int, side: float) -> None:
    """Seen along its axis a bore would be a circle. The loaded wall looks back to the axis of the bore."""
    angles = np.linspace(0, 2 * np.pi, 25)[:-1]
    ring = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(24)])
    points = np.roll(np.vstack([ring, ring + [0, 0, 1]]), axis + 1, axis=1)
    facets = [np.array([i, (i + 1) % 24, 24 + (i + 1) % 24, 24 + i]) for i in range(24)]
    inwards = -np.roll(np.vstack([ring, ring]), axis + 1, axis=1)
    across = (axis + 1) % 3
    loaded = (side * points[:, across] > 0.5).astype(float)
    sheet = lay_out(points, facets, inwards, loaded)
    assert not sheet.is_whole
    assert sheet.names is None
    assert abs(sheet.towards[2, axis]) < 0.9
    assert side * sheet.towards[2, across] < 0.0
    assert np.isin(np.flatnonzero(loaded), sheet.nodes).mean() > 0.7


def test_reduced_domain_in_three_dimensions(tmp_path: Path) -> None:
    fields = cubes_with_fields("H8")
    with styled():
        figure = reduced_domain(fields, None)
        check_picture(figure, tmp_path / "figure.png")
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    assert texts == [f"reduced domain, {2 * N**3 // 4} of {2 * N**3} cells", "its 8 contact nodes"]
