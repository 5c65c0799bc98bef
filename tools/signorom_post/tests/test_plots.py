# SPDX-License-Identifier: BSD-3-Clause
"""Figures hold the artists that they should, with the files' data, and are written in the right size."""

from dataclasses import replace
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from half_disk_results import (
    N_MODES,
    POINTS,
    SINGULAR_VALUES,
    TOLERANCE,
    HalfDisks,
    reduced_multipliers,
    write_fields,
    write_model,
)
from matplotlib.collections import PathCollection, PolyCollection, TriMesh
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from pairs import contact_of_pairs
from pictures import check_picture, lines_of

from signorom_post.arrays import Quantity
from signorom_post.errors import InputError
from signorom_post.mesh import Mesh
from signorom_post.plots.captions import magnification
from signorom_post.plots.enrichment import enrichment
from signorom_post.plots.initial_and_deformed import initial_and_deformed
from signorom_post.plots.multipliers import multipliers
from signorom_post.plots.reduced_domain import NODES, RID_COLOR, reduced_domain
from signorom_post.plots.singular_values import energy_tail, singular_values
from signorom_post.readers.fields import FieldFile, FieldPoint, read_fields
from signorom_post.readers.model import read_model
from signorom_post.results import Results
from signorom_post.style import PARAMETERS, cluster_colors, styled


def rid_polygons(figure: Figure) -> PolyCollection:
    polygons = [c for c in figure.axes[0].collections if isinstance(c, PolyCollection)]
    found = [c for c in polygons if to_hex(c.get_facecolor()[0]) == RID_COLOR.lower()]
    assert len(found) == 1
    return found[0]


def test_initial_and_deformed(fields: FieldFile, disks: HalfDisks, tmp_path: Path) -> None:
    with styled():
        figure = initial_and_deformed(fields, fields.points[1])
        check_picture(figure, tmp_path / "figure.png")
    left, right, bar = figure.axes
    assert left.get_aspect() == right.get_aspect() == 1.0
    assert (left.get_xlim(), left.get_ylim()) == (right.get_xlim(), right.get_ylim())
    assert (left.get_xlabel(), left.get_ylabel()) == ("$x$ [m]", "$y$ [m]")
    assert bar.get_ylabel() == "displacement magnitude [m]"
    assert (left.get_title("left"), right.get_title("left")) == ("initial", "squeeze = 0.3")
    (shading,) = [c for c in right.collections if isinstance(c, TriMesh)]
    displacement = disks.displacement(0.3)
    np.testing.assert_allclose(shading.get_array(), np.linalg.norm(displacement, axis=1))
    deformed = disks.coordinates + displacement
    np.testing.assert_allclose(shading._triangulation.x, deformed[:, 0])
    np.testing.assert_allclose(shading._triangulation.y, deformed[:, 1])
    (cells,) = [c for c in left.collections if isinstance(c, PolyCollection)]
    assert len(cells.get_paths()) == len(disks.cells)


def test_contact_pressure_stands_at_the_contact_nodes(fields: FieldFile, tmp_path: Path) -> None:
    with styled():
        figure = initial_and_deformed(fields, fields.points[1], color="contact")
        check_picture(figure, tmp_path / "figure.png")
    dots = [c for c in figure.axes[1].collections if isinstance(c, PathCollection)]
    (active,) = [c for c in dots if c.get_gid() == "active"]
    nodes = fields.contact.nodes_of()
    pressure = fields.points[1].fields["contact_pressure"].values[nodes]
    np.testing.assert_array_equal(active.get_array(), pressure[pressure > 0])
    assert sum(len(c.get_offsets()) for c in dots) == len(nodes)
    assert figure.axes[2].get_ylabel() == "contact pressure [N/m2]"


def test_visible_displacements_are_not_magnified() -> None:
    assert magnification(np.full((3, 3), 0.3), 2.0) == 1.0
    assert magnification(np.zeros((3, 3)), 2.0) == 1.0


@pytest.mark.parametrize(("largest", "factor"), [(2e-3, 20.0), (1e-3, 20.0), (4e-5, 1000.0), (8e-5, 500.0)])
def test_small_displacements_are_magnified_by_a_round_factor(largest: float, factor: float) -> None:
    """The largest of 1, 2, 5 times a power of ten that keeps them within 4 % of the size, here 1."""
    assert magnification(np.array([[largest, 0.0, 0.0]]), 1.0) == pytest.approx(factor)


def test_magnification_is_named(fields: FieldFile) -> None:
    point = fields.points[0]
    small = replace(point.fields["displacement"], values=point.fields["displacement"].values * 1e-4)
    with styled():
        figure = initial_and_deformed(fields, replace(point, fields={"displacement": small}))
    assert figure.axes[1].get_title("left") == "squeeze = 0.2  (displacement x 2000)"


def test_reduced_domain(fields: FieldFile, results: Results, disks: HalfDisks, tmp_path: Path) -> None:
    with styled():
        figure = reduced_domain(fields, results.model.clusters[0])
        check_picture(figure, tmp_path / "figure.png")
    axes = figure.axes[0]
    assert len(rid_polygons(figure).get_paths()) == len(disks.reduced_cells)
    shown = {line.get_label().split(" ", 1)[1]: line.get_xydata() for line in axes.lines}
    seeds = disks.coordinates[disks.first_nodes[disks.reduced_rows], :2]
    facing = disks.coordinates[disks.second_nodes[disks.reduced_rows], :2]
    np.testing.assert_array_equal(shown[NODES["seed"][4]], seeds)
    np.testing.assert_array_equal(shown[NODES["facing"][4]], facing)
    np.testing.assert_array_equal(shown[NODES["contact"][4]], np.vstack([seeds, facing]))
    texts = [text.get_text() for text in axes.get_legend().get_texts()]
    assert texts == [
        f"RID, {len(disks.reduced_cells)} cells",
        "6 contact nodes",
        "3 facing nodes",
        "3 seed nodes",
    ]
    assert axes.get_aspect() == 1.0


def test_reduced_domain_without_a_model(fields: FieldFile, disks: HalfDisks) -> None:
    with styled():
        figure = reduced_domain(fields, None)
    assert len(rid_polygons(figure).get_paths()) == len(disks.reduced_cells)
    assert [line.get_label() for line in figure.axes[0].lines] == ["6 contact nodes"]


def test_model_of_a_larger_mesh_is_refused(fields: FieldFile, tmp_path: Path) -> None:
    write_model(tmp_path / "model.h5", HalfDisks(9, 30))
    with pytest.raises(InputError, match=r"it does not belong to 'model\.h5'"):
        reduced_domain(fields, read_model(tmp_path / "model.h5").clusters[0])


def test_multipliers(fields: FieldFile, results: Results, disks: HalfDisks, tmp_path: Path) -> None:
    with styled():
        figure = multipliers(fields, results.model)
        check_picture(figure, tmp_path / "figure.png")
    (axes,) = figure.axes
    x = disks.coordinates[disks.first_nodes, 0]
    order = np.argsort(x)
    curves = lines_of(axes, "full order")
    assert len(curves) == len(POINTS)
    for i_point, squeeze in enumerate(POINTS):
        np.testing.assert_array_equal(curves[i_point].get_xdata(), x[order])
        np.testing.assert_array_equal(curves[i_point].get_ydata(), disks.multipliers(squeeze)[order])
        on_rid = lines_of(axes, "reduced")[i_point]
        expected = reduced_multipliers(disks, squeeze)
        is_on_rid = np.isin(order, disks.reduced_rows)
        np.testing.assert_array_equal(on_rid.get_xdata(), x[order][is_on_rid])
        np.testing.assert_array_equal(on_rid.get_ydata(), expected[order][is_on_rid])
        other = lines_of(axes, "reconstructed")[i_point]
        is_other = ~is_on_rid & (expected[order] > 0)
        np.testing.assert_array_equal(other.get_ydata(), expected[order][is_other])
        assert other.get_alpha() < 1.0
        assert on_rid.get_color() == curves[i_point].get_color()
    assert len({to_hex(curve.get_color()) for curve in curves}) == len(POINTS)
    assert axes.get_ylabel() == r"multiplier $\lambda$ [N/m]"
    assert axes.get_xlabel() == "position on the contact surface, $x$ [m]"
    kinds, points = ([text.get_text() for text in legend.get_texts()] for legend in figure.legends)
    assert kinds == ["full order", "HHR, on the RID", "HHR, reconstructed"]
    assert points == ["squeeze = 0.2 m", "squeeze = 0.3 m", "squeeze = 0.4 m"]


def test_multipliers_of_many_points_are_thinned_out(tmp_path: Path) -> None:
    write_fields(tmp_path / "fields.h5", HalfDisks(), tuple(np.round(np.linspace(0.2, 0.4, 11), 3)))
    with styled():
        figure = multipliers(read_fields(tmp_path / "fields.h5"))
    texts = [text.get_text() for text in figure.legends[1].get_texts()]
    assert texts == [f"squeeze = {value}" for value in (0.2, 0.24, 0.28, 0.32, 0.36, 0.4)]


def test_multipliers_without_a_reduced_model_have_no_markers_in_the_legend(folder: Path) -> None:
    fields = read_fields(folder / "fields.h5")
    for point in fields.points:
        point.fields.pop("multipliers_reduced")
    with styled():
        figure = multipliers(fields, None, ("r", "z"))
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["full order"]
    assert "$r$" in figure.axes[0].get_xlabel()


def test_bar_of_flat_bodies_lies_below_them(tmp_path: Path) -> None:
    """Beside them its label is longer than the figure is high."""
    points = np.array([[x, y, 0.0] for y in (0.0, 1.0) for x in range(11)])
    cells = [np.array([i, i + 1, i + 12, i + 11]) for i in range(10)]
    displacement = {"displacement": Quantity(0.1 * points, "mm")}
    point = FieldPoint("load = 1", ["load"], np.ones(1), displacement)
    none = np.empty(0, dtype=np.int64)
    flat = FieldFile(Path("fields.h5"), Mesh(points, cells, 2, "mm"), [point], contact_of_pairs(none, none))
    with styled():
        figure = initial_and_deformed(flat, point)
        check_picture(figure, tmp_path / "figure.png")
    bar = figure.axes[2]
    assert bar.get_xlabel() == "displacement magnitude [mm]"
    assert bar.get_position().y1 < figure.axes[0].get_position().y0


def test_many_clusters_have_colors_of_their_own() -> None:
    for n in (1, 6, 7, 20):
        assert len(set(cluster_colors(n))) == n


def test_energy_tail_of_a_geometric_series() -> None:
    """With squares 1, 1/10, 1/100 the tails are 0.11 / 1.11 and 0.01 / 1.11."""
    tail = energy_tail(10.0 ** (-0.5 * np.arange(3)))
    np.testing.assert_allclose(tail, [1.0, 0.11 / 1.11, 0.01 / 1.11, 0.0])


def test_singular_values(results: Results, tmp_path: Path) -> None:
    with styled():
        figure = singular_values(results.model)
        check_picture(figure, tmp_path / "figure.png")
    left, right = figure.axes
    assert left.get_yscale() == right.get_yscale() == "log"
    kept, dropped = lines_of(left, "kept")[0], lines_of(left, "dropped")[0]
    assert (len(kept.get_xdata()), len(dropped.get_xdata())) == (N_MODES, 31 - N_MODES)
    decay = SINGULAR_VALUES / SINGULAR_VALUES[0]
    np.testing.assert_allclose(np.append(kept.get_ydata(), dropped.get_ydata()), decay)
    (chosen,) = lines_of(right, "chosen")
    assert chosen.get_xdata()[0] == N_MODES
    assert chosen.get_ydata()[0] < TOLERANCE
    assert lines_of(right, "tolerance")[0].get_ydata()[0] == TOLERANCE
    assert [text.get_text() for text in right.get_legend().get_texts()] == [rf"$\ell = {N_MODES}$"]


def test_vanishing_singular_values_are_drawn_without_a_warning(results: Results, tmp_path: Path) -> None:
    values = np.array([1.0, 0.5, 0.0, 0.0])
    model = replace(results.model, clusters=[replace(results.model.clusters[0], singular_values=values)])
    with styled():
        check_picture(singular_values(model), tmp_path / "figure.png")


def test_each_cluster_has_its_curve(tmp_path: Path, disks: HalfDisks) -> None:
    write_model(tmp_path / "model.h5", disks, n_clusters=2)
    with styled():
        figure = singular_values(read_model(tmp_path / "model.h5"))
    texts = [text.get_text() for text in figure.axes[1].get_legend().get_texts()]
    assert texts == [r"cluster 1: $\ell = 9$", r"cluster 2: $\ell = 9$"]


def test_enrichment(results: Results, tmp_path: Path) -> None:
    with styled():
        figure = enrichment(results.enrichment)
        check_picture(figure, tmp_path / "figure.png")
    left, right = figure.axes
    assert left.get_yscale() == right.get_yscale() == "log"
    assert lines_of(left, "full rank")[0].get_xydata().tolist() == [[10, 40.0], [11, 8.0], [12, 1.2]]
    assert lines_of(left, "rank too low")[0].get_xydata().tolist() == [[9, 900.0]]
    assert lines_of(left, "solvable")[0].get_xdata()[0] == 10
    assert right.lines[0].get_ydata().tolist() == [410.0, 420.0, 430.0, 440.0]


def test_style_does_not_leak() -> None:
    before = matplotlib.rcParams["font.size"]
    matplotlib.rcParams["font.size"] = 31
    with styled():
        assert matplotlib.rcParams["font.size"] == PARAMETERS["font.size"]
    assert matplotlib.rcParams["font.size"] == 31
    matplotlib.rcParams["font.size"] = before
