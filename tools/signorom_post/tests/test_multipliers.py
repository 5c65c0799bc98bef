# SPDX-License-Identifier: BSD-3-Clause
"""Contact forces along each contact: panels, positions, quantities and legends, and the surfaces of contact.h5."""

from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from half_disk_results import HalfDisks, write_dataset
from pairs import contact_of_pairs
from pictures import check_picture, lines_of

from signorom_post.arrays import Quantity
from signorom_post.errors import InputError
from signorom_post.mesh import Mesh
from signorom_post.plots.chains import chains_of, positions_along
from signorom_post.plots.multipliers import multipliers
from signorom_post.readers.fields import FieldFile, FieldPoint, read_fields
from signorom_post.readers.surfaces import ContactSurface, ContactSurfaces, read_surfaces, surfaces_of_fields
from signorom_post.results import Results
from signorom_post.style import styled

#: places of the contact nodes: a wall at x = 1, and a floor far beside it
WALL = np.array([[1.0, y, 0.0] for y in (0.0, 1.0, 2.0, 3.0)])
FLOOR = np.array([[x, 0.0, 0.0] for x in (11.0, 12.0, 13.0)])
FORCES = np.array([1.0, 2.0, 3.0, 4.0, 7.0, 0.0, 9.0])


def two_contacts(n_parameters: int = 1, n_points: int = 1) -> ContactSurfaces:
    """Forces 1 to 4 up the wall; 7, 0, 9 along the floor; the reduced model has the same ones."""
    points = np.vstack([WALL, FLOOR])
    nodes = np.arange(len(points))
    mesh = Mesh(points, [np.array([0, 1, 4])], 2, "mm")
    names = [f"parameter_{i}" for i in range(n_parameters)]
    found = []
    for i_point in range(n_points):
        fields = {
            "multipliers_full_order": Quantity(FORCES, "N/mm"),
            "multipliers_reduced": Quantity(FORCES, "N/mm"),
            "rows_in_reduced_domain": Quantity(np.ones(len(points))),
        }
        values = np.array([1000.0 + i_point, *range(1, n_parameters)])
        found.append(FieldPoint("point", names, values, fields, ["MPa"] + ["1"] * (n_parameters - 1)))
    areas = np.full(len(points), 0.5)
    fields = FieldFile(Path("fields.h5"), mesh, found, contact_of_pairs(nodes, nodes, areas))
    chains = [[np.array([a, a + 1]) for a in range(3)], [np.array([a, a + 1]) for a in (4, 5)]]
    names = ("wall - block", "floor - block")
    surfaces = [ContactSurface(name, facets) for name, facets in zip(names, chains, strict=True)]
    return ContactSurfaces(fields, surfaces, is_quadratic=False)


def test_each_contact_has_its_panel_and_no_line_joins_two(tmp_path: Path) -> None:
    surfaces = two_contacts()
    with styled():
        figure = multipliers(surfaces.fields, None, ("x", "y"), surfaces)
        check_picture(figure, tmp_path / "figure.png")
    assert [axes.get_title("left") for axes in figure.axes] == ["wall - block", "floor - block"]
    (wall,), (floor,) = (lines_of(axes, "full order") for axes in figure.axes)
    # the wall has one x: its panel is over y
    np.testing.assert_array_equal(wall.get_xydata(), np.column_stack([WALL[:, 1], FORCES[:4]]))
    np.testing.assert_array_equal(floor.get_xydata(), np.column_stack([FLOOR[:, 0], FORCES[4:]]))
    assert figure.axes[0].get_xlabel() == "position on the contact surface, $y$ [mm]"
    assert figure.axes[1].get_xlabel() == "position on the contact surface, $x$ [mm]"
    assert figure.axes[0].get_ylabel() == r"multiplier $\lambda$ [N/mm]"


def test_no_line_joins_the_parts_of_one_contact() -> None:
    """An entry of the deck may have several surfaces: between 3, the height of the wall, and the floor is nothing."""
    surfaces = two_contacts()
    both = ContactSurface("both - block", [facet for part in surfaces.surfaces for facet in part.facets])
    surfaces = replace(surfaces, surfaces=[both])
    with styled():
        figure = multipliers(surfaces.fields, None, ("x", "y"), surfaces)
    (curve,) = lines_of(figure.axes[0], "full order")
    assert np.isnan(curve.get_xydata()[4]).all()
    np.testing.assert_array_equal(np.delete(curve.get_ydata(), 4), FORCES)
    np.testing.assert_array_equal(curve.get_xdata()[:4], [0, 1, 2, 3])
    np.testing.assert_array_equal(np.diff(curve.get_xdata()[5:]), [1, 1])
    assert figure.axes[0].get_xlabel() == "length along the contact surface [mm]"


def test_a_model_without_a_reduced_domain_is_called_a_reduced_model() -> None:
    surfaces = two_contacts()
    with styled():
        figure = multipliers(surfaces.fields, None, ("x", "y"), surfaces)
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["full order", "reduced model"]
    (marks,) = lines_of(figure.axes[1], "model")
    # both models have no force in the middle
    np.testing.assert_array_equal(marks.get_ydata(), [7.0, 9.0])


def test_many_parameters_leave_room_for_the_axes(tmp_path: Path) -> None:
    """Points that differ in one parameter are told by it; of a single point all are there, in several lines."""
    for n_points, texts in ((2, ["parameter_0 = 1000 MPa", "parameter_0 = 1001 MPa"]), (1, None)):
        surfaces = two_contacts(8, n_points)
        with styled():
            figure = multipliers(surfaces.fields, None, ("x", "y"), surfaces)
            check_picture(figure, tmp_path / "figure.png")
        shown = [text.get_text() for text in figure.legends[1].get_texts()]
        if texts is None:
            assert shown[0].startswith("parameter_0 = 1000 MPa, parameter_1 = 1, ")
            assert shown[0].count(" = ") == 8
        else:
            assert shown == texts
        assert sum(axes.get_position().width for axes in figure.axes) > 0.7


def test_pressure_is_shown_on_quadratic_facets() -> None:
    """Force over area, here 1/2 mm: its unit is MPa."""
    surfaces = replace(two_contacts(), is_quadratic=True)
    with styled():
        figure = multipliers(surfaces.fields, None, ("x", "y"), surfaces)
    assert figure.axes[0].get_ylabel() == "contact pressure [MPa]"
    (wall,) = lines_of(figure.axes[0], "full order")
    np.testing.assert_array_equal(wall.get_ydata(), 2.0 * FORCES[:4])


def test_a_closed_line_comes_back_and_has_lengths() -> None:
    """The sides of a square of side 2, given in any order: 8 around it."""
    points = np.array([[0.0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]])
    facets = [np.array(pair) for pair in ((2, 3), (0, 1), (3, 0), (1, 2))]
    (chain,) = chains_of(facets, points)
    assert chain[0] == chain[-1]
    (position,), label = positions_along([chain], points, ("x", "y"), "mm")
    np.testing.assert_allclose(position, [0, 2, 4, 6, 8])
    assert label == "length along the contact surface [mm]"


def test_walls_above_each_other_stand_side_by_side_on_the_axis() -> None:
    """Two walls have the same heights: lengths, one wall after the other."""
    points = np.array([[0.0, 0, 0], [0, 3, 0], [1, 0, 0], [1, 3, 0]])
    chains = chains_of([np.array([1, 0]), np.array([2, 3])], points)
    positions, label = positions_along(chains, points, ("x", "y"), "")
    assert label.startswith("length")
    np.testing.assert_allclose(positions[0], [0, 3])
    assert positions[1][0] > 3
    np.testing.assert_allclose(np.diff(positions[1]), 3)


def write_contact(folder: Path, disks: HalfDisks, squeezes: tuple[float, ...] = (0.2, 0.3, 0.4)) -> Path:
    """contact.h5 of the half disks, in two entries, parts of the arc. Pressures are 100, 101, ..."""
    path = folder / "contact.h5"
    n = disks.n_pairs
    with h5py.File(path, "w") as file:
        file.attrs["format"], file.attrs["format_version"] = "signorom fields", 3
        file["contact/names"] = np.array(["left - upper", "right - upper"], dtype="S")
        write_dataset(file, "mesh/nodes", disks.first_nodes + 1)
        write_dataset(file, "mesh/topology", np.column_stack([np.arange(n - 1), np.arange(1, n)]))
        write_dataset(file, "mesh/cell_types", np.full(n - 1, 2))
        for number, squeeze in enumerate(squeezes, start=1):
            group = file.create_group(f"points/{number:04d}")
            group.attrs["parameters"] = [squeeze]
            write_dataset(group, "contact", np.where(np.arange(n - 1) < n // 2, 1, 2))
            write_dataset(group, "contact_pressure", 100.0 + np.arange(n))
    return path


def test_surfaces_of_contact_h5_have_names_and_pressures(folder: Path, disks: HalfDisks) -> None:
    write_contact(folder, disks)
    surfaces = Results(folder).surfaces
    assert [surface.name for surface in surfaces.surfaces] == ["left - upper", "right - upper"]
    nodes = np.concatenate([surface.nodes for surface in surfaces.surfaces])
    np.testing.assert_array_equal(np.unique(nodes), disks.first_nodes)
    pressure = surfaces.pressures(1, "multipliers_full_order")
    np.testing.assert_array_equal(pressure.values[disks.first_nodes], 100.0 + np.arange(disks.n_pairs))
    assert np.isnan(pressure.values[disks.second_nodes]).all()
    assert pressure.unit == "Pa"


def test_a_contact_h5_of_other_points_is_not_used(folder: Path, disks: HalfDisks) -> None:
    """Left over from an earlier run: the surfaces are those of fields.h5."""
    fields = read_fields(folder / "fields.h5")
    surfaces = read_surfaces(write_contact(folder, disks, (0.2, 0.3, 0.5)), fields)
    assert [surface.name for surface in surfaces.surfaces] == [""]
    assert surfaces.surfaces[0].nodes.tolist() == surfaces_of_fields(fields).surfaces[0].nodes.tolist()


@pytest.mark.parametrize(
    ("name", "values", "sentence"),
    [
        ("mesh/topology", [[0, 99]], "'/mesh/topology' and '/mesh/nodes' do not fit each other"),
        ("points/0001/contact", [9], "'/contact/names', '/mesh/topology' and the field 'contact' do not fit"),
        ("mesh/nodes", [0], "dataset '/mesh/nodes' has the number 0"),
    ],
)
def test_a_damaged_contact_h5_is_an_error(
    folder: Path, disks: HalfDisks, name: str, values: list, sentence: str
) -> None:
    path = write_contact(folder, disks)
    with h5py.File(path, "r+") as file:
        del file[name]
        file[name] = np.array(values)
    with pytest.raises(InputError, match=sentence):
        read_surfaces(path, read_fields(folder / "fields.h5"))
