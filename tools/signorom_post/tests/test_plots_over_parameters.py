# SPDX-License-Identifier: BSD-3-Clause
"""Figures of errors and clusters over one, two and more parameters hold the data of the files."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from half_disk_results import (
    TRAINING,
    HalfDisks,
    validation_rows,
    write_model,
    write_validation,
)
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from pictures import check_picture, lines_of

from signorom_post.plots.clusters import clusters
from signorom_post.plots.errors import errors, status_changes
from signorom_post.readers.model import read_model
from signorom_post.readers.validation import read_validation
from signorom_post.results import Results
from signorom_post.style import styled


def panel(figure: Figure, text: str) -> Axes:
    """The axes whose y label has this text."""
    return next(axes for axes in figure.axes if text in axes.get_ylabel())


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
        x, y = names[min(i, j)], names[max(i, j)]
        assert (panels[i, j].get_xlabel(), panels[i, j].get_ylabel()) == (x, y)
        np.testing.assert_allclose(dots[column].get_offsets(), [(row[x], row[y]) for row in shown])
        (missing,) = lines_of(panels[i, j], "not drawable")
        assert len(missing.get_xdata()) == (i > j)
    assert [panels[i, i].get_xlabel() for i in range(3)] == list(names)
    for i, j in ((0, 1), (0, 2), (1, 2)):
        assert panels[i, j].get_xlim() == panels[j, i].get_xlim()
        assert panels[i, j].get_ylim() == panels[j, i].get_ylim()


def test_errors_over_many_parameters_have_a_panel_for_each(tmp_path: Path) -> None:
    """Eight parameters with large values; the labels of the ticks do not overlap."""
    random = np.random.default_rng(5)
    names = [f"modulus_{i}" for i in range(8)]
    rows = []
    for row in validation_rows(20):
        values = dict(zip(names, 60000 + 40000 * random.uniform(size=8), strict=True))
        del row["squeeze"]
        rows.append(values | row)
    write_validation(tmp_path / "validation.csv", rows)
    with styled():
        figure = errors(read_validation(tmp_path / "validation.csv"))
        check_picture(figure, tmp_path / "figure.png")
        figure.draw_without_rendering()
    assert [axes.get_xlabel() for axes in figure.axes] == names
    for axes in figure.axes:
        (multiplier,), (displacement,) = (lines_of(axes, column) for column in ("e_lambda_rid", "e_u"))
        np.testing.assert_allclose(multiplier.get_xdata(), [row[axes.get_xlabel()] for row in rows])
        np.testing.assert_allclose(displacement.get_ydata(), [row["e_u"] for row in rows])
        low, high = axes.get_xlim()
        labels = [label for label in axes.get_xticklabels() if low <= label.get_position()[0] <= high]
        boxes = [label.get_window_extent() for label in labels]
        assert len(boxes) >= 2
        assert all(left.x1 < right.x0 for left, right in pairwise(boxes))


@pytest.mark.parametrize("n_parameters", [1, 2, 3, 5])
def test_a_model_that_is_not_hyper_reduced_has_no_reduced_domain(
    results: Results, tmp_path: Path, n_parameters: int
) -> None:
    rows = [{f"p{i}": i + j for i in range(n_parameters)} | row for j, row in enumerate(validation_rows(6))]
    for row in rows:
        del row["squeeze"]
    write_validation(tmp_path / "validation.csv", rows)
    with styled():
        figure = errors(read_validation(tmp_path / "validation.csv"), replace(results.model, clusters=[]))
    legends = [*figure.legends, *(axes.get_legend() for axes in figure.axes)]
    texts = [text.get_text() for legend in legends if legend for text in legend.get_texts()]
    texts += [axes.get_ylabel() for axes in figure.axes]
    assert any("multiplier error" in text for text in texts)
    assert not any("RID" in text or "HHR" in text or "reconstructed" in text for text in texts)


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
            # on the axes of the answers to the same pair, which stand across the diagonal
            np.testing.assert_allclose(found[0], points[:12][:, [i, j]])
            np.testing.assert_allclose(found[1], points[12:][:, [i, j]])
            mirror = panels[j, i]
            assert panels[i, j].get_xlabel() == mirror.get_xlabel()
            assert panels[i, j].get_ylabel() == mirror.get_ylabel()
            assert (panels[i, j].get_xlim(), panels[i, j].get_ylim()) == (
                mirror.get_xlim(),
                mirror.get_ylim(),
            )
            (more,) = [c.get_offsets() for c in drawn if c.get_gid() == "more" and len(c.get_offsets())]
            np.testing.assert_allclose(more, points[10:12][:, [i, j]])
