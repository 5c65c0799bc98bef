# SPDX-License-Identifier: BSD-3-Clause
"""Sound files are read with the right shapes, index bases and units."""

from pathlib import Path

import h5py
import numpy as np
import pytest
from half_disk_results import (
    N_MODES,
    POINTS,
    SINGULAR_VALUES,
    TOLERANCE,
    TRAINING,
    HalfDisks,
    reduced_multipliers,
    validation_rows,
    write_enrichment,
    write_fields,
    write_model,
    write_validation,
)

from signorom_post.contact import Contact, ContactSide
from signorom_post.errors import InputError
from signorom_post.figures import choose_point
from signorom_post.plots.histories import histories
from signorom_post.readers.enrichment import read_enrichment
from signorom_post.readers.fields import FieldFile, read_fields
from signorom_post.readers.histories import read_histories
from signorom_post.readers.model import read_model
from signorom_post.readers.validation import read_validation
from signorom_post.results import Results

FORMAT = {"format": "signorom fields", "format_version": 3}


def test_mesh_comes_with_unit_and_dimension(fields: FieldFile, disks: HalfDisks) -> None:
    np.testing.assert_array_equal(fields.mesh.coordinates, disks.coordinates)
    np.testing.assert_array_equal(np.array(fields.mesh.cells), disks.cells)
    assert (fields.mesh.unit, fields.mesh.n_dim) == ("m", 2)


def test_mesh_edges_obey_euler(fields: FieldFile) -> None:
    """Two bodies without holes: nodes - edges + cells = 2; as many outline edges as outline nodes."""
    mesh = fields.mesh
    assert mesh.n_nodes - len(mesh.edges) + mesh.n_cells == 2
    assert len(mesh.boundary_edges) == len(np.unique(mesh.boundary_edges))


def test_large_files_are_read_field_by_field(
    disks: HalfDisks, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Points stand in the order of their numbers; a field is read, and checked, when it is asked for."""
    monkeypatch.setattr("signorom_post.readers.fields.MOST_IN_MEMORY", 2)
    path = tmp_path / "fields.h5"
    write_fields(path, disks, (0.2, 0.3, 0.4))
    with h5py.File(path, "a") as file:
        file.move("points/0001", "points/10000")
        del file["points/0003/contact_pressure"]
        file["points/0003/contact_pressure"] = [1.0, 2.0]
    points = read_fields(path).points
    assert [point.label for point in points] == ["squeeze = 0.3", "squeeze = 0.4", "squeeze = 0.2"]
    assert "displacement" in points[0].fields
    assert "stress" not in points[0].fields
    for point, squeeze in zip(points, (0.3, 0.4, 0.2), strict=True):
        np.testing.assert_array_equal(point.fields["displacement"].values, disks.displacement(squeeze))
    with pytest.raises(InputError, match="contact_pressure' has 2 entries"):
        _ = points[1].fields["contact_pressure"]


def test_contact_indices_become_0_based(fields: FieldFile, disks: HalfDisks) -> None:
    np.testing.assert_array_equal(fields.contact.owners, disks.first_nodes)
    np.testing.assert_array_equal(fields.contact.second.nodes, disks.second_nodes)
    np.testing.assert_array_equal(
        fields.contact.nodes_of(np.array([2])), [disks.first_nodes[2], disks.second_nodes[2]]
    )
    np.testing.assert_array_equal(fields.points[0].reduced_rows, disks.reduced_rows)


def test_rows_have_any_number_of_nodes() -> None:
    """An obstacle, then rows of two nodes of the second side, of which they share one."""
    first = ContactSide(np.array([0, 1, 2, 3]), np.array([5, 6, 7]), np.ones(3))
    second = ContactSide(np.array([0, 0, 2, 4]), np.array([10, 11, 11, 12]), np.array([0.3, 0.7, 0.4, 0.6]))
    contact = Contact(first, second, np.ones(3))
    assert contact.nodes_of().tolist() == [5, 6, 7, 10, 11, 12]
    assert contact.nodes_of(np.array([0])).tolist() == [5]
    assert contact.nodes_of(np.array([1])).tolist() == [6, 10, 11]
    assert contact.nodes_of(np.array([], dtype=int)).size == 0


def test_each_point_has_its_fields(fields: FieldFile, disks: HalfDisks) -> None:
    assert [point.parameters.tolist() for point in fields.points] == [[squeeze] for squeeze in POINTS]
    for point, squeeze in zip(fields.points, POINTS, strict=True):
        assert point.label == f"squeeze = {squeeze}"
        assert point.parameter_names == ["squeeze"]
        displacement = fields.field(point, "displacement")
        np.testing.assert_array_equal(displacement.values, disks.displacement(squeeze))
        assert displacement.unit == "m"
        reduced = fields.field(point, "multipliers_reduced")
        np.testing.assert_array_equal(reduced.values, reduced_multipliers(disks, squeeze))
        assert reduced.unit == "N/m"


def test_mixed_topology_is_cut_into_cells(tmp_path: Path) -> None:
    """A quadrilateral 0 1 4 3 and a triangle 1 2 4 in XDMF's mixed list (5 and 4 are their types)."""
    path = tmp_path / "fields.h5"
    with h5py.File(path, "w") as file:
        file.attrs.update(FORMAT)
        file["mesh/coordinates"] = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [1, 1, 0.0]]
        file["mesh/topology"] = [5, 0, 1, 4, 3, 4, 1, 2, 4]
    mesh = read_fields(path).mesh
    assert [cell.tolist() for cell in mesh.cells] == [[0, 1, 4, 3], [1, 2, 4]]
    assert len(mesh.triangles) == 3
    assert len(mesh.edges) == 6
    assert mesh.n_dim == 2


def test_tetrahedra_are_three_dimensional(tmp_path: Path) -> None:
    path = tmp_path / "fields.h5"
    with h5py.File(path, "w") as file:
        file.attrs.update(FORMAT)
        file["mesh/coordinates"] = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]]
        file["mesh/topology"] = [[0, 1, 2, 3]]
    assert read_fields(path).mesh.n_dim == 3


@pytest.mark.parametrize("is_quadratic", [False, True])
def test_hexahedron_prism_and_pyramid(tmp_path: Path, is_quadratic: bool) -> None:
    """A roof and a bay on a cube: 6 - 2 faces of the cube, 4 of each of the others, and their areas close the body.

    Types 9, 7 and 8, or 48, 39 and 40 with further nodes, of which pictures take none.
    """
    cells = [[9, 0, 1, 2, 3, 4, 5, 6, 7], [7, 4, 5, 6, 7, 8], [8, 1, 9, 2, 5, 10, 6]]
    if is_quadratic:
        more = {9: (48, 12), 7: (39, 8), 8: (40, 9)}
        cells = [[more[cell[0]][0], *cell[1:], *[0] * more[cell[0]][1]] for cell in cells]
    square = [[0, 0], [1, 0], [1, 1], [0, 1.0]]
    path = tmp_path / "fields.h5"
    with h5py.File(path, "w") as file:
        file.attrs.update(FORMAT)
        places = [[*corner, z] for z in (0, 1) for corner in square]
        file["mesh/coordinates"] = [*places, [0.5, 0.5, 2], [2, 0.5, 0], [2, 0.5, 1.0]]
        file["mesh/topology"] = [number for cell in cells for number in cell]
    mesh = read_fields(path).mesh
    faces = mesh.outer_faces
    assert sorted(faces.n_corners.tolist()) == [3] * 6 + [4] * 6
    corners = mesh.coordinates[faces.nodes]
    areas = 0.5 * np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    np.testing.assert_allclose(areas.sum(axis=0), 0.0, atol=1e-14)
    # divergence theorem: volume 1 + 1/3 + 1/2
    volume = sum(
        np.dot(np.cross(x[0], x[1]), x[2]) / 6 for nodes in faces.triangles for x in [mesh.coordinates[nodes]]
    )
    assert volume == pytest.approx(1 + 1 / 3 + 1 / 2)


def test_snapshots_are_read(results: Results, disks: HalfDisks) -> None:
    snapshots = results.snapshots
    np.testing.assert_array_equal(snapshots.parameters[:, 0], TRAINING)
    assert snapshots.parameter_names == ["squeeze"]
    assert snapshots.displacement.values.shape == (31, 2 * disks.n_nodes)
    np.testing.assert_array_equal(snapshots.multipliers.values[7], disks.multipliers(TRAINING[7]))
    assert (snapshots.multipliers.unit, snapshots.displacement.unit) == ("N/m", "m")
    assert snapshots.provenance == "0123456789abcdef"


def test_model_is_read(results: Results, disks: HalfDisks) -> None:
    model = results.model
    assert model.title == "Two half disks pressed together"
    assert model.unit_of("squeeze") == "m"
    assert model.pod_tolerance == TOLERANCE
    np.testing.assert_array_equal(model.training_points[:, 0], TRAINING)
    (cluster,) = model.clusters
    assert cluster.n_modes == N_MODES - 1
    assert cluster.condition_number == 3.217
    np.testing.assert_array_equal(cluster.singular_values, SINGULAR_VALUES)
    np.testing.assert_array_equal(cluster.seed_nodes, disks.first_nodes[disks.reduced_rows])
    np.testing.assert_array_equal(cluster.cells, disks.reduced_cells)


def test_clusters_come_in_numeric_order(tmp_path: Path, disks: HalfDisks) -> None:
    write_model(tmp_path / "model.h5", disks, n_clusters=11)
    names = [cluster.name for cluster in read_model(tmp_path / "model.h5").clusters]
    assert names == [str(number) for number in range(1, 12)]


@pytest.mark.parametrize(("kind", "unit"), [("plane_strain", "N m/m"), ("axisymmetric", "N m"), ("", "")])
def test_energy_unit_follows_the_kind_of_model(folder: Path, kind: str, unit: str) -> None:
    with h5py.File(folder / "model.h5", "r+") as file:
        del file["deck"]
        file["deck"] = f"mesh: {{model: '{kind}'}}"
    assert read_model(folder / "model.h5").energy_unit == unit


def test_fixed_length_text_loses_its_padding(folder: Path) -> None:
    """Fortran writes texts of one length, filled with blanks."""
    with h5py.File(folder / "model.h5", "r+") as file:
        del file["parameters/names"], file["title"]
        file["parameters/names"] = np.array([b"squeeze   "], dtype="S10")
        file["title"] = np.bytes_("Half disks  ")
    model = read_model(folder / "model.h5")
    assert (model.parameter_names, model.title) == (["squeeze"], "Half disks")


def test_validation_is_read(results: Results) -> None:
    validation = results.validation
    rows = validation_rows()
    assert validation.parameter_names == ["squeeze"]
    assert validation.parameters.shape == (101, 1)
    np.testing.assert_array_equal(validation.columns["e_u"], [row["e_u"] for row in rows])
    assert set(validation.solvers) == {"active_set"}


def test_enrichment_is_read(results: Results) -> None:
    (history,) = results.enrichment
    assert (history.cluster, history.n_hats) == (1, 3)
    np.testing.assert_array_equal(history.pairs, [0, 5, 2, 9])
    np.testing.assert_array_equal(history.n_columns, [9, 10, 11, 12])
    np.testing.assert_array_equal(history.condition_numbers, [np.inf, 40.0, 8.0, 1.2])
    np.testing.assert_array_equal(history.stiffness_conditions, [410.0, 420.0, 430.0, 440.0])
    assert history.first_solvable() == 1
    assert [history.first_below(kappa) for kappa in (100.0, 10.0, 8.0, 1.0)] == [1, 2, 2, None]


def test_each_cluster_has_its_enrichment(tmp_path: Path) -> None:
    write_enrichment(tmp_path / "enrichment.csv", n_clusters=2)
    histories = read_enrichment(tmp_path / "enrichment.csv")
    assert [(history.cluster, history.n_hats) for history in histories] == [(1, 3), (2, 3)]


def test_validation_keeps_infinite_and_undefined_errors(tmp_path: Path) -> None:
    rows = validation_rows(3)
    rows[0]["e_lambda_rid"], rows[1]["e_lambda_rid"], rows[2]["e_lambda_rid"] = "Infinity", "NaN", ""
    write_validation(tmp_path / "validation.csv", rows)
    values = read_validation(tmp_path / "validation.csv").columns["e_lambda_rid"]
    assert np.isinf(values[0])
    assert np.isnan(values[1:]).all()


def test_a_label_has_no_unit_1_and_is_found_with_it(folder: Path) -> None:
    """As report.yaml tells the point, with the unit that the deck gives."""
    with h5py.File(folder / "fields.h5", "r+") as file:
        attributes = file["points/0002"].attrs
        attributes["label"] = "squeeze = 0.3 1"
        attributes["parameter_units"] = np.array(["1"], dtype="S")
    fields = read_fields(folder / "fields.h5")
    assert fields.points[1].label == "squeeze = 0.3"
    assert fields.points[1].parameter_units == ["1"]
    assert choose_point(fields, "squeeze = 0.3 1") is fields.points[1]


def test_histories(tmp_path: Path) -> None:
    """Two points with two and three times; a contact with friction and one without."""
    path = tmp_path / "history.csv"
    contacts = [
        f"contact_{k}_area,contact_{k}_force_x,contact_{k}_force_y"
        + (",contact_2_slip_share,contact_2_dissipation" if k == 2 else "")
        for k in (1, 2)
    ]
    path.write_text(
        f"P,time,load,pull,status,n_active,contact_force,{','.join(contacts)},lambda_3\n"
        '2,0.5,1,9,"converged",1,5,0.1,3,4,7,8,9,0.5,3,5\n2,1,2,9,"converged",1,10,0.2,6,-8,7,8,9,1,4,10\n'
        '7,0.5,3,9,"converged",0,0,0,0,0,0,0,0,0,0,0\n'
        f'7,1,4,9,"not converged"{",nan" * 11}\n'
        '7,3,5,9,"converged",1,1,1,0,1,1,1,1,1,1,1\n'
    )
    first, second = read_histories(path)
    assert (first.point, second.point) == ({"P": 2.0}, {"P": 7.0})
    assert list(first.times) == [0.5, 1]
    assert list(second.times) == [0.5, 1, 3]
    assert list(second.tables["load"]) == [3, 4, 5]
    assert first.axes == ("x", "y")
    assert first.forces[:, :, 0] == pytest.approx(np.array([[3, 4], [6, -8]]))
    assert first.areas[:, 0] == pytest.approx([0.1, 0.2])
    assert first.slip_shares.keys() == first.works.keys() == {1}
    assert list(first.slip_shares[1]) == [0.5, 1]
    # of both steps together
    assert list(first.works[1]) == [3, 7]
    assert np.isnan(second.forces[1]).all()
    units = {"time": "h", "force": "N", "area": "mm²", "work": "mJ"}
    figure = histories([first, second], ["1: a - b", "2: c - d"], units)
    assert [axes.get_ylabel() for axes in figure.axes if axes.axison] == [
        "load",
        "contact area [mm²]",
        "pull",
        "share of the area\nthat slips",
        "contact 1:\nforce [N]",
        "work of friction [mJ]",
        "contact 2:\nforce [N]",
    ]


def test_histories_without_their_columns(tmp_path: Path) -> None:
    """A table of predict has the time behind other columns, or none."""
    path = tmp_path / "history.csv"
    path.write_text("time,P,status\n1,2,converged\n")
    with pytest.raises(InputError, match="the columns must be the parameters, time, the tables, status"):
        read_histories(path)
