# SPDX-License-Identifier: BSD-3-Clause
"""Figures of the paper's case b show the numbers that they are given."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from half_disk_results import HalfDisks
from pairs import contact_of_pairs
from pictures import check_picture, lines_of

from signorom_post.mesh import Mesh
from signorom_post.plots.cluster_map import ClusterMap, cluster_map
from signorom_post.plots.contact_forces import ContactForces, contact_forces
from signorom_post.plots.enrichment_errors import ErrorSeries, errors_and_kappa, errors_and_size
from signorom_post.plots.error_map import ErrorMap, error_maps
from signorom_post.plots.errors_of_modes import ModeSeries, errors_of_modes
from signorom_post.plots.partition import Partition, partition
from signorom_post.plots.reduced_domain import reduced_domain
from signorom_post.plots.two_bodies import two_bodies
from signorom_post.readers.fields import FieldFile
from signorom_post.results import Results
from signorom_post.style import styled

SERIES = ErrorSeries(
    label="one",
    sizes=np.array([36, 37, 38, 39]),
    condition_numbers=np.array([np.inf, 300.0, 20.0, 2.0]),
    primal=np.array([0.02, 0.01, 0.011, 0.012]),
    dual=np.array([0.9, 0.5, 0.1, 0.02]),
    first_solvable=1,
)


def test_errors_over_kappa_leave_out_what_is_infinite(tmp_path: Path) -> None:
    with styled():
        figure = errors_and_kappa(SERIES)
        check_picture(figure, tmp_path / "figure.png")
    left, right = figure.axes
    np.testing.assert_allclose(lines_of(left, "one")[0].get_xydata(), [[300, 50], [20, 10], [2, 2]])
    np.testing.assert_allclose(lines_of(right, "one")[0].get_ydata(), [1.0, 1.1, 1.2])
    assert left.get_xscale() == left.get_yscale() == "log"


def test_errors_over_the_size_of_the_basis(tmp_path: Path) -> None:
    other = replace(SERIES, label="two", sizes=SERIES.sizes + 9, first_solvable=None)
    with styled():
        figure = errors_and_size([SERIES, other])
        check_picture(figure, tmp_path / "figure.png")
    left, right = figure.axes
    np.testing.assert_allclose(lines_of(left, "one")[0].get_ydata(), [90.0, 50.0, 10.0, 2.0])
    np.testing.assert_array_equal(lines_of(left, "two")[0].get_xdata(), [45, 46, 47, 48])
    assert [line.get_xdata()[0] for line in lines_of(left, "solvable")] == [37]
    assert [line.get_xdata()[0] for line in lines_of(right, "solvable")] == [300.0]
    assert [text.get_text() for text in figure.legends[0].get_texts()] == [
        "one",
        "first full rank (11)",
        "two",
    ]


def test_errors_over_extra_modes(tmp_path: Path) -> None:
    series = [
        ModeSeries(name, [[0.01, 0.02], [0.03, 0.04]], [[0.1, 0.2], [0.3, scale]])
        for name, scale in (("a", 0.5), ("b", 0.6), ("c", np.inf))
    ]
    with styled():
        figure = errors_of_modes([0, 9], series, ["strong", "weak"])
        check_picture(figure, tmp_path / "figure.png")
    dual_strong, dual_weak, primal_strong, primal_weak = figure.axes
    np.testing.assert_allclose(lines_of(dual_strong, "a")[0].get_xydata(), [[0, 10], [9, 20]])
    np.testing.assert_allclose(lines_of(dual_weak, "b")[0].get_ydata(), [30, 60])
    np.testing.assert_allclose(lines_of(dual_weak, "c")[0].get_ydata(), [30])
    np.testing.assert_allclose(lines_of(primal_strong, "a")[0].get_ydata(), [1, 2])
    np.testing.assert_allclose(lines_of(primal_weak, "c")[0].get_ydata(), [3, 4])


def test_maps_put_each_point_in_its_cell(tmp_path: Path) -> None:
    """Points in shuffled order; one undefined, one infinite."""
    x, y = (axis.ravel() for axis in np.meshgrid([5.0, 70.0, 200.0], [0.6, 6.0]))
    errors = np.array([np.nan, 0.02, 0.03, np.inf, 0.05, 0.06])
    order = np.array([3, 0, 5, 1, 4, 2])
    item = ErrorMap("title", x[order], y[order], errors[order])
    with styled():
        figure = error_maps([item, item])
        check_picture(figure, tmp_path / "figure.png")
    cells = {mesh.get_gid(): mesh.get_array() for mesh in figure.axes[0].collections}
    np.testing.assert_allclose(cells["errors"].filled(-1).ravel(), [-1, 2, 3, -1, 5, 6])
    np.testing.assert_array_equal(cells["infinite"].mask.ravel(), [True, True, True, False, True, True])
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    assert texts == [
        "no contact in either, or no full-order solution",
        "contact in the reduced model only, or no answer",
    ]


def test_contact_forces(tmp_path: Path) -> None:
    position = np.linspace(0.0, 7.0, 8)
    panel = ContactForces(
        "title", position, np.arange(8.0), position[::2], np.arange(8.0)[::2] * 1.1, "N", "mm"
    )
    with styled():
        figure = contact_forces([panel, panel])
        check_picture(figure, tmp_path / "figure.png")
    axes = figure.axes[0]
    lines = {c.get_gid(): c.get_segments() for c in axes.collections}
    assert [segment[1].tolist() for segment in lines["full order"]] == [[i, i] for i in range(1, 8)]
    np.testing.assert_allclose([segment[1] for segment in lines["reduced"]], [[2.2, 2], [4.4, 4], [6.6, 6]])
    (tips,) = lines_of(axes, "reduced")
    np.testing.assert_allclose(tips.get_xdata(), [0.0, 2.2, 4.4, 6.6])
    assert (axes.get_xlabel(), axes.get_ylabel()) == (r"contact force $\lambda$ [N]", "height $z$ [mm]")


def test_clusters_and_their_snapshots(tmp_path: Path) -> None:
    """A shared snapshot is a dot of the first cluster and a ring of the second."""
    x, y = np.array([5.0, 200.0, 5.0, 200.0]), np.array([6.0, 6.0, 0.6, 0.6])
    members = [np.array([[5.0, 6.0], [5.0, 3.0]]), np.array([[5.0, 3.0], [5.0, 0.6]])]
    with styled():
        figure = cluster_map(ClusterMap(x, y, np.array([0, 0, 1, 1]), members))
        check_picture(figure, tmp_path / "figure.png")
    (axes,) = figure.axes
    (cells,) = [c for c in axes.collections if c.get_gid() == "labels"]
    np.testing.assert_array_equal(cells.get_array(), [[1, 1], [0, 0]])
    assert lines_of(axes, "first 0")[0].get_xydata().tolist() == [[5.0, 6.0], [5.0, 3.0]]
    assert lines_of(axes, "first 1")[0].get_xydata().tolist() == [[5.0, 0.6]]
    assert lines_of(axes, "second 1")[0].get_xydata().tolist() == [[5.0, 3.0]]
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    assert texts == ["cluster 1: 2 snapshots", "cluster 2: 2 snapshots"]


def test_partition(tmp_path: Path) -> None:
    """Snapshots left, answers right, hatches where the second cluster has half of the first one's votes or more."""
    points = np.array([[x, y] for x in (5.0, 100.0, 200.0) for y in (0.6, 3.0, 6.0)])
    labels = np.array([0, 0, 1] * 3)
    ratios = np.array([0.0, 0.9, 0.1] * 3)
    members = [points[labels == 0], points[labels == 1]]
    with styled():
        figure = partition(Partition(members, points, labels, ratios))
        check_picture(figure, tmp_path / "figure.png")
    left, right = figure.axes
    for i in (0, 1):
        np.testing.assert_array_equal(lines_of(left, f"snapshots {i}")[0].get_xydata(), members[i])
    (cells,) = [c for c in right.collections if c.get_gid() == "labels"]
    np.testing.assert_array_equal(cells.get_array(), [[0] * 3, [0] * 3, [1] * 3])
    (near,) = [c for c in right.collections if c.get_gid() == "near"]
    heights = np.vstack([path.vertices for path in near.get_paths()])[:, 1]
    # 0.5 lies between 0 at 0.6 mm and 0.9 at 3 mm, and between 0.9 and 0.1 at 6 mm
    assert (heights.min(), heights.max()) == pytest.approx((0.6 + 2.4 * 5 / 9, 3.0 + 3.0 / 2))
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    assert texts[:2] == ["cluster 1: 6 snapshots", "cluster 2: 3 snapshots"]
    assert texts[2] == "second cluster: at least 50 % of the votes of the first"


def two_blocks() -> Mesh:
    """Unit squares side by side, the second thinner."""
    corners = [[0, 0], [4, 0], [4, 7], [0, 7], [4.1, 0], [4.7, 0], [4.7, 7], [4.1, 7]]
    coordinates = np.column_stack([np.array(corners, dtype=float), np.zeros(8)])
    return Mesh(coordinates, [np.arange(4), np.arange(4, 8)], 2, "mm")


def test_two_bodies(tmp_path: Path) -> None:
    fields = FieldFile(tmp_path, two_blocks(), [], contact_of_pairs(np.array([1, 2]), np.array([4, 7])))
    with styled():
        figure = two_bodies(fields, np.arange(8) < 4, 3.2)
        check_picture(figure, tmp_path / "figure.png")
    left, right = figure.axes
    assert {text.get_text() for text in left.texts} >= {"fuel", "cladding", "$P_1$", "$z = h_1$"}
    assert right.get_title("left") == "8 nodes, 2 cells"
    assert (left.get_xlabel(), left.get_ylabel()) == ("$r$ [mm]", "$z$ [mm]")


def test_markers_shrink_on_fine_meshes(results: Results, fields: FieldFile) -> None:
    fine = HalfDisks(24, 72)
    mesh = Mesh(fine.coordinates, list(fine.cells), 2, "m")
    with styled():
        coarse = reduced_domain(fields, results.model.clusters[0])
        shrunk = reduced_domain(replace(fields, mesh=mesh), results.model.clusters[0])
    for before, after in zip(coarse.axes[0].lines, shrunk.axes[0].lines, strict=True):
        assert after.get_markersize() < before.get_markersize()
