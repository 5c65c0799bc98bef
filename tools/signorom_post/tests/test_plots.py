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
    TRAINING,
    HalfDisks,
    reduced_multipliers,
    validation_rows,
    write_fields,
    write_model,
    write_validation,
)
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection, PolyCollection, TriMesh
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from pictures import check_picture, lines_of

from signorom_post.errors import InputError
from signorom_post.plots.clusters import clusters
from signorom_post.plots.enrichment import enrichment
from signorom_post.plots.errors import errors, status_changes
from signorom_post.plots.initial_and_deformed import initial_and_deformed, magnification
from signorom_post.plots.multipliers import multipliers
from signorom_post.plots.reduced_domain import NODES, RID_COLOR, reduced_domain
from signorom_post.plots.singular_values import energy_tail, singular_values
from signorom_post.readers.fields import FieldFile, read_fields
from signorom_post.readers.model import read_model
from signorom_post.readers.validation import read_validation
from signorom_post.results import Results
from signorom_post.style import PARAMETERS, cluster_colors, styled


def panel(figure: Figure, text: str) -> Axes:
    """The axes whose y label has this text."""
    return next(axes for axes in figure.axes if text in axes.get_ylabel())


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
    nodes = np.concatenate([fields.first_nodes, fields.second_nodes])
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
    with pytest.raises(InputError, match=r"the mesh is not the one of 'model\.h5'"):
        reduced_domain(fields, read_model(tmp_path / "model.h5").clusters[0])


def test_multipliers(fields: FieldFile, results: Results, disks: HalfDisks, tmp_path: Path) -> None:
    with styled():
        figure = multipliers(fields, results.model)
        check_picture(figure, tmp_path / "figure.png")
    (axes,) = figure.axes
    x = disks.coordinates[disks.first_nodes, 0]
    order = np.argsort(x)
    curves = [line for line in axes.lines if line.get_linestyle() == "-" and line.get_gid() is None][1:]
    assert len(curves) == len(POINTS)
    for i_point, squeeze in enumerate(POINTS):
        np.testing.assert_array_equal(curves[i_point].get_xdata(), x[order])
        np.testing.assert_array_equal(curves[i_point].get_ydata(), disks.multipliers(squeeze)[order])
        on_rid = lines_of(axes, "reduced")[i_point]
        expected = reduced_multipliers(disks, squeeze)
        np.testing.assert_array_equal(on_rid.get_xdata(), x[disks.reduced_rows])
        np.testing.assert_array_equal(on_rid.get_ydata(), expected[disks.reduced_rows])
        other = lines_of(axes, "reconstructed")[i_point]
        is_other = ~np.isin(np.arange(len(x)), disks.reduced_rows) & (expected > 0)
        np.testing.assert_array_equal(other.get_ydata(), expected[is_other])
        assert other.get_alpha() < 1.0
        assert on_rid.get_color() == curves[i_point].get_color()
    assert len({to_hex(curve.get_color()) for curve in curves}) == len(POINTS)
    assert axes.get_ylabel() == r"multiplier $\lambda$ [N/m]"
    assert axes.get_xlabel() == "position on the contact surface, $x$ [m]"
    assert axes.get_legend().get_title().get_text() == "squeeze [m]"
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["0.2", "0.3", "0.4"]


def test_multipliers_of_many_points_are_thinned_out(tmp_path: Path) -> None:
    write_fields(tmp_path / "fields.h5", HalfDisks(), tuple(np.round(np.linspace(0.2, 0.4, 11), 3)))
    with styled():
        figure = multipliers(read_fields(tmp_path / "fields.h5"))
    texts = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert texts == ["0.2", "0.24", "0.28", "0.32", "0.36", "0.4"]


def test_errors_over_one_parameter(results: Results, tmp_path: Path) -> None:
    with styled():
        figure = errors(results.validation, results.model)
        check_picture(figure, tmp_path / "figure.png")
    rows = validation_rows()
    squeeze = [float(row["squeeze"]) for row in rows]
    for text, columns in (
        ("$e_u$", ["e_u"]),
        ("lambda", ["e_lambda_rid", "e_lambda_all"]),
        ("ener", ["e_energy", "e_energy_rid"]),
        ("active contact pairs", ["n_active", "n_active_full_order"]),
    ):
        axes = panel(figure, text)
        assert axes.get_yscale() == ("linear" if "active" in text else "log")
        for column in columns:
            (line,) = lines_of(axes, column)
            np.testing.assert_allclose(line.get_xdata(), squeeze)
            np.testing.assert_allclose(line.get_ydata(), [row[column] for row in rows])
        (marks,) = lines_of(axes, "training")
        np.testing.assert_array_equal(marks.get_xdata(), TRAINING)
    assert panel(figure, "ener").get_ylabel().endswith("[N m/m]")
    assert figure.axes[2].get_xlabel() == "squeeze [m]"


def test_changes_of_status_are_drawn_between_the_points(results: Results) -> None:
    """The fixture has 2 * int(12 sqrt(squeeze - 0.05)) pairs: two more wherever it passes (n / 12)**2 + 0.05."""
    with styled():
        figure = errors(results.validation, results.model)
    expected = [(n / 12) ** 2 + 0.05 for n in (4, 5, 6, 7)]
    for axes in figure.axes:
        (changes,) = [c for c in axes.collections if c.get_gid() == "status change"]
        drawn = [path.vertices[0, 0] for path in changes.get_paths()]
        np.testing.assert_allclose(drawn, expected, atol=0.003)


def test_status_changes() -> None:
    parameter, n_active = np.array([0.0, 1.0, 2.0, 4.0]), np.array([2, 2, 4, 3])
    np.testing.assert_array_equal(status_changes(parameter, n_active), [1.5, 3.0])
    assert status_changes(parameter, np.zeros(4)).size == 0


def test_errors_without_a_model_have_no_units_and_no_training_points(results: Results) -> None:
    with styled():
        figure = errors(results.validation)
    assert figure.axes[2].get_xlabel() == "squeeze"
    assert lines_of(figure.axes[0], "training") == []
    assert "training point" not in [text.get_text() for text in figure.legends[0].get_texts()]


def test_errors_that_a_log_axis_cannot_show_are_counted(tmp_path: Path) -> None:
    rows = validation_rows(11)
    rows[2]["e_u"], rows[3]["e_u"], rows[4]["e_u"] = 0.0, "inf", "nan"
    write_validation(tmp_path / "validation.csv", rows)
    with styled():
        figure = errors(read_validation(tmp_path / "validation.csv"))
        check_picture(figure, tmp_path / "figure.png")
    assert [text.get_text() for text in panel(figure, "$e_u$").texts] == [
        "3 values zero, infinite or undefined: not shown"
    ]
    assert len(panel(figure, "lambda").texts) == 0


def test_errors_all_zero_still_give_a_figure(tmp_path: Path) -> None:
    rows = [row | {"e_u": 0.0} for row in validation_rows(5)]
    write_validation(tmp_path / "validation.csv", rows)
    with styled():
        check_picture(errors(read_validation(tmp_path / "validation.csv")), tmp_path / "figure.png")


def test_errors_over_two_parameters_are_maps(tmp_path: Path) -> None:
    rows = [
        {"pressure": float(i % 4), "height": float(i // 4)} | row for i, row in enumerate(validation_rows(12))
    ]
    for row in rows:
        del row["squeeze"]
    rows[5]["e_lambda_rid"] = "inf"
    write_validation(tmp_path / "validation.csv", rows)
    with styled():
        figure = errors(read_validation(tmp_path / "validation.csv"))
        check_picture(figure, tmp_path / "figure.png")
    dots = {c.get_gid(): c for axes in figure.axes for c in axes.collections if c.get_gid()}
    assert set(dots) == {"e_u", "e_energy", "e_lambda_rid", "e_lambda_all"}
    np.testing.assert_allclose(dots["e_u"].get_array(), [row["e_u"] for row in rows])
    np.testing.assert_array_equal(
        dots["e_u"].get_offsets(), [(row["pressure"], row["height"]) for row in rows]
    )
    assert len(dots["e_lambda_rid"].get_array()) == 11
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["zero, infinite or undefined"]
    assert (figure.axes[2].get_xlabel(), figure.axes[2].get_ylabel()) == ("pressure", "height")


def three_parameters(n_points: int, n_clusters: int) -> list[dict[str, object]]:
    """Rows over pressure, height and gap; the clusters lie above one another in height."""
    random = np.random.default_rng(4)
    rows = []
    for point, row in zip(random.uniform(size=(n_points, 3)), validation_rows(n_points), strict=True):
        del row["squeeze"]
        row["cluster"] = 1 + int(n_clusters * point[1])
        rows.append({"pressure": 5 + 195 * point[0], "height": 0.6 + 5.4 * point[1], "gap": point[2]} | row)
    return rows


def test_errors_over_three_parameters_show_each_pair(tmp_path: Path) -> None:
    """Multiplier errors below the diagonal, displacement errors above it, both on it; the largest lie on top."""
    rows = three_parameters(30, 1)
    rows[5]["e_lambda_rid"] = "inf"
    write_validation(tmp_path / "validation.csv", rows)
    with styled():
        figure = errors(read_validation(tmp_path / "validation.csv"))
        check_picture(figure, tmp_path / "figure.png")
    names = ("pressure", "height", "gap")
    panels = np.array(figure.axes[:9]).reshape(3, 3)
    for i, j in np.ndindex(3, 3):
        dots = {c.get_gid(): c for c in panels[i, j].collections}
        if i == j:
            assert {line.get_gid() for line in panels[i, j].lines} == {"e_lambda_rid alone", "e_u alone"}
            continue
        column = "e_lambda_rid" if i > j else "e_u"
        shown = sorted((row for row in rows if row[column] != "inf"), key=lambda row: row[column])
        np.testing.assert_allclose(dots[column].get_array(), [row[column] for row in shown])
        np.testing.assert_allclose(
            dots[column].get_offsets(), [(row[names[j]], row[names[i]]) for row in shown]
        )
        (missing,) = lines_of(panels[i, j], "not drawable")
        assert len(missing.get_xdata()) == (i > j)
    assert [axes.get_xlabel() for axes in panels[2]] == list(names)
    assert (panels[0, 1].get_ylabel(), panels[1, 0].get_ylabel()) == ("pressure", "height")


@pytest.mark.parametrize("n_parameters", [1, 2, 3])
def test_clusters_over_any_number_of_parameters(tmp_path: Path, disks: HalfDisks, n_parameters: int) -> None:
    """Answers below the diagonal, snapshots above it, shares that add up to 1 on it."""
    names = ["pressure", "height", "gap"][3 - n_parameters :]
    rows = [
        {name: row[name] for name in row if name not in ("pressure", "height", "gap")[: 3 - n_parameters]}
        for row in three_parameters(200, 2)
    ]
    write_validation(tmp_path / "validation.csv", rows)
    write_model(tmp_path / "model.h5", disks, n_clusters=2)
    box = np.array([[5.0, 200.0], [0.6, 6.0], [0.0, 1.0]])[3 - n_parameters :]
    whole = read_model(tmp_path / "model.h5")
    points = box[:, 0] + np.random.default_rng(1).uniform(size=(20, n_parameters)) * np.ptp(box, axis=1)
    members = [np.arange(12), np.arange(10, 20)]
    model = replace(
        whole,
        parameter_names=names,
        parameter_units=["mm"] * n_parameters,
        minimum=box[:, 0],
        maximum=box[:, 1],
        training_points=points,
        clusters=[replace(c, training_points=m) for c, m in zip(whole.clusters, members, strict=True)],
    )
    with styled():
        figure = clusters(read_validation(tmp_path / "validation.csv"), model)
        check_picture(figure, tmp_path / "figure.png")
    panels = np.array(figure.axes).reshape(n_parameters, n_parameters)
    for i, j in np.ndindex(n_parameters, n_parameters):
        drawn = [c for c in panels[i, j].collections if c.get_gid()]
        if i == j:
            tops = [bar.get_y() + bar.get_height() for bar in panels[i, j].patches[-20:]]
            np.testing.assert_allclose(tops, 1.0)
        elif i > j:
            (answers,) = drawn
            np.testing.assert_allclose(answers.get_offsets()[:, 0], [row[names[j]] for row in rows])
            colors = [to_hex(color) for color in answers.get_facecolors()]
            assert len(set(colors)) == 2
            assert all(
                (color == colors[0]) == (row["cluster"] == rows[0]["cluster"])
                for color, row in zip(colors, rows, strict=True)
            )
        else:
            found = [c.get_offsets() for c in drawn if c.get_gid() == "snapshots"]
            np.testing.assert_allclose(found[0], points[:12][:, [j, i]])
            np.testing.assert_allclose(found[1], points[12:][:, [j, i]])
            (more,) = [c.get_offsets() for c in drawn if c.get_gid() == "more" and len(c.get_offsets())]
            np.testing.assert_allclose(more, points[10:12][:, [j, i]])


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
