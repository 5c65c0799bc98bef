# SPDX-License-Identifier: BSD-3-Clause
"""Fields of models: predict --fields, C and Python say what a full-order solution at the point says."""

import h5py
import numpy as np
import pytest

from block_meshes import stacked_blocks
from c_programs import compile_c, run_c
from results import read_fields, read_table
from runs import refuse, write_deck
from test_tied import TIED, write_strip
from vtk_fields import read_with_vtk

# [-] of the largest value; a condensed model is the full-order problem but for rounding
ROUNDING = 1e-9
# a training point and two others; the upper block opens on one side where it is hot
POINTS = ({"heat": 0.0, "press": 1e3}, {"heat": 300.0, "press": 1e4}, {"heat": 120.0, "press": 2e3})
SHAPES = [
    ("mixed", "plane_strain"),
    ("T6", "plane_stress"),
    ("Q8", "axisymmetric"),
    ("H8", "solid"),
    ("T10", "solid"),
]


def write_blocks(folder, element, model, young_modulus="2.0e6", reduction="method: condensed"):
    """Two blocks of two materials, the upper one held by contact alone; heat bends the lower one."""
    n_dim = 3 if model == "solid" else 2
    mesh = stacked_blocks(element, n_dim)
    mesh.coordinates[:, 0] += 1.0 if model == "axisymmetric" else 0.0
    mesh.write(folder / "blocks.msh")
    across, up = {"axisymmetric": "rz", "solid": "xz"}.get(model, "xy")
    held = [
        f"{{boundary: bottom, displacement: {{{up}: 0}}}}",
        f"{{boundary: left, displacement: {{{across}: 0}}}}",
    ]
    if n_dim == 3:
        held.append("{boundary: front, displacement: {y: 0}}")
    points = ", ".join(f"{{heat: {point['heat']}, press: {point['press']}}}" for point in POINTS)
    (folder / "hot.yaml").write_text(
        f"mesh: {{file: blocks.msh, model: {model}}}\n"
        "parameters: {heat: {min: 0, max: 400, unit: K}, press: {min: 1e3, max: 2e4, unit: Pa}}\n"
        "materials:\n"
        f"  soft: {{regions: [lower], young_modulus: {young_modulus}, poisson_ratio: 0.3, thermal_expansion: 1.0e-4}}\n"
        "  hard: {regions: [upper], young_modulus: 6.0e6, poisson_ratio: 0.2}\n"
        f"boundary_conditions: [{', '.join(held)}]\n"
        "loads:\n  - {boundary: top, pressure: press}\n"
        "imposed_strains:\n"
        f'  - {{region: lower, temperature: "heat * {across} * (1 + {up})", reference: 20}}\n'
        f'  - {{region: upper, strain: {{{across * 2}: "1e-5 * heat"}}}}\n'
        f"contact:\n  - {{first: lower_face, second: upper_face, direction: {[0] * (n_dim - 1) + [1]}}}\n"
        "training: {grid: {heat: 2, press: 2}}\n"
        f"output: {{points: [{points}]}}\n"
        f"reduction: {{{reduction}, fields: true}}\n"
    )
    return folder / "hot.yaml"


def train(signorom, deck, n_ranks=1):
    """Folder of the results: a model, and full-order fields of the points."""
    for command in ("sample", "train", "solve"):
        signorom(command, deck.name, folder=deck.parent, n_ranks=n_ranks)
    return deck.parent / "results" / deck.stem


def predict(signorom, folder, points=POINTS):
    """Folder of the fields that the model of a results folder answers at some points."""
    rows = [",".join(str(value) for value in point.values()) for point in points]
    (folder / "points.csv").write_text("\n".join([",".join(points[0]), *rows, ""]))
    signorom(
        "predict", "model.h5", "--points", "points.csv", "--output", "answers.csv", "--fields", folder=folder
    )
    return folder / "answers_fields"


def differences(expected, found):
    """Largest difference of each field of a point, of its largest value; both have the same fields, units and NaN."""
    worst = {}
    names = {"multipliers_full_order": "multipliers_reduced"}
    assert {names.get(name, name) for name in expected} == set(found)
    for name, dataset in expected.items():
        told = found[names.get(name, name)]
        assert told.attrs["unit"] == dataset.attrs["unit"], name
        a, b = dataset[()], told[()]
        np.testing.assert_array_equal(np.isnan(a), np.isnan(b), err_msg=name)
        scale = np.nanmax(np.abs(a))
        worst[name] = np.nanmax(np.abs(a - b)) / (scale if scale > 0 else 1.0)
    return worst


@pytest.mark.parametrize(("element", "model"), SHAPES)
def test_condensed_fields_are_full_order_ones(signorom, tmp_path, element, model):
    """Every field of both files, at a training point and at others, under temperature and swelling."""
    results = train(signorom, write_blocks(tmp_path, element, model))
    answers = predict(signorom, results)
    for name in ("fields.h5", "contact.h5"):
        with h5py.File(results / name) as a, h5py.File(answers / name) as b:
            assert list(a["points"]) == list(b["points"]) == ["0001", "0002", "0003"]
            np.testing.assert_array_equal(a["mesh/topology"][()], b["mesh/topology"][()])
            for point in a["points"]:
                assert dict(a["points"][point].attrs)["label"] == b["points"][point].attrs["label"]
                worst = differences(a["points"][point], b["points"][point])
                # a gap that is closed is rounding
                worst.pop("gap")
                assert max(worst.values()) < ROUNDING, worst
    with h5py.File(answers / "fields.h5") as file:
        gap = [np.nanmax(file[f"points/000{i}/gap"][()]) for i in (1, 2, 3)]
        assert [name.decode() for name in file["mesh/region_names"][()]] == ["lower", "upper"]
        expected = read_fields(results / "fields.h5", 3)["gap"]
        assert np.nanmax(np.abs(file["points/0003/gap"][()] - expected)) < 1e-12
    assert max(gap) > 1e-6, "a contact opens"


def test_interpolated_fields_have_the_error_of_the_forces(signorom, tmp_path):
    """Elastic constants as expressions: stresses take them at the point."""
    deck = write_blocks(tmp_path, "Q8", "axisymmetric", young_modulus='"4e6 - 5e3 * heat"')
    text = deck.read_text().replace("poisson_ratio: 0.3", "poisson_ratio: 0.25 + heat / 4000")
    deck.write_text(text.replace("{heat: 2, press: 2}", "{heat: 4, press: 3}"))
    results = train(signorom, deck)
    answers = predict(signorom, results)
    with h5py.File(results / "fields.h5") as a, h5py.File(answers / "fields.h5") as b:
        for point in a["points"]:
            worst = differences(a["points"][point], b["points"][point])
            # reduction.stiffness_tolerance is 1e-6
            assert max(worst[name] for name in ("stress", "stress_smoothed", "displacement")) < 1e-6, worst


@pytest.mark.parametrize("clusters", ["", "clusters: {number: 2}\n"], ids=["one_model", "clusters"])
def test_hyper_reduced_fields_are_near(signorom, tmp_path, clusters):
    """Displacements by modes give stresses with an error of their size over the mesh width."""
    changes = {"reduction: {method: hhr,": clusters + "reduction: {method: hhr, fields: true,"}
    results = train(signorom, write_deck("small_disks", tmp_path, **changes))
    answers = predict(signorom, results, ({"squeeze": 0.2}, {"squeeze": 0.4}))
    with h5py.File(results / "fields.h5") as a, h5py.File(answers / "fields.h5") as b:
        for point in a["points"]:
            worst = differences(a["points"][point], b["points"][point])
            assert worst["displacement"] < 1e-3
            assert 0 < worst["stress"] < 0.05


def test_tied_models_have_fields(signorom, post, tmp_path):
    """By modes, with an error that the answer tells; the exact ones are those of the model with the whole matrix."""
    answers = []
    for name, reduction in ("tied", TIED + ", fields: true"), ("whole", "fields: true"):
        deck = write_strip(tmp_path / name, reduction)
        signorom("run", deck.name, folder=tmp_path / name, n_ranks=2 if name == "tied" else 1)
        with post.Model(tmp_path / name / "results" / "strip" / "model.h5") as model:
            assert model.kind == {"tied": "tied", "whole": "condensed"}[name]
            answers.append((model.query(press=1.3e-3, tilt=0.011), model.fields(press=1.3e-3, tilt=0.011)))
    (tied, tied_fields), (_, fields) = answers
    bound = tied.relative_displacement_bound
    assert 1e-9 < bound < 1e-2
    errors = read_table(tmp_path / "tied" / "results" / "strip" / "validation.csv")
    for true, told in zip(errors["e_u_energy_relative"], errors["displacement_bound"], strict=True):
        assert float(true) <= float(told) * (1 + 1e-5)
    largest = abs(fields.displacement).max()
    assert abs(tied_fields.displacement - fields.displacement).max() <= 10 * bound * largest
    assert abs(tied_fields.von_mises - fields.von_mises).max() <= 10 * bound * fields.von_mises.max()


@pytest.fixture(scope="module")
def study(signorom, tmp_path_factory):
    """A condensed model of plane blocks with its full-order fields and its predicted ones."""
    results = train(
        signorom, write_blocks(tmp_path_factory.mktemp("fields"), "mixed", "plane_strain"), n_ranks=2
    )
    predict(signorom, results)
    return results


def test_vtk_opens_predicted_fields(study):
    """Points are time steps, numbers are field data, nothing is without a number, values are those of HDF5."""
    shown = read_with_vtk(study / "answers_fields" / "fields.xdmf")
    assert list(shown) == [1.0, 2.0, 3.0]
    with h5py.File(study / "answers_fields" / "fields.h5") as file:
        for step, point, values in zip(shown.values(), file["points"].values(), POINTS, strict=True):
            assert step.numbers["heat [K]"] == values["heat"]
            assert step.numbers["press [Pa]"] == values["press"]
            assert step.numbers["contact_1_area [m]"] == point["contact_1_area"][()]
            assert {"region", "contact_status", "stress", "imposed_strain"} <= step.cells.keys()
            for name, shown_values in (step.nodes | step.cells).items():
                np.testing.assert_array_equal(shown_values, point[name][()], err_msg=name)
                assert np.isfinite(shown_values).all(), name
    surface = read_with_vtk(study / "answers_fields" / "contact.xdmf")
    for step, values in zip(surface.values(), POINTS, strict=True):
        assert step.numbers["heat [K]"] == values["heat"]
        status = step.cells["contact_status"]
        assert set(status) <= {1, 2, 3}
        closed = step.nodes["status"] == 2
        assert (status == 2).any() == (closed.sum() > 1)


def test_status_and_area_agree_with_the_forces(study):
    """Both sides of a closed pair are closed, and the cells around them are; the area is that of the closed rows."""
    with h5py.File(study / "answers_fields" / "fields.h5") as file:
        first, second = (file[f"contact/{side}/nodes"][()] - 1 for side in ("first", "second"))
        areas = file["contact/areas"][()]
        for point in file["points"].values():
            force, status = point["multipliers_reduced"][()], point["contact_status"][()]
            assert point["contact_1_area"][()] == pytest.approx(areas[force > 0].sum(), rel=1e-12)
            assert np.count_nonzero(status) > 0
            assert ((status == 2) | (status == 3)).any() == (force > 0).any()
            pressed = point["contact_pressure"][()]
            np.testing.assert_array_equal(pressed[first] > 0, force > 0)
            np.testing.assert_allclose(pressed[second], pressed[first], rtol=1e-12)


def test_python_and_c_say_the_same(study, post, library, tmp_path):
    point = POINTS[1]
    expected = read_fields(study / "answers_fields" / "fields.h5", 2)
    with post.Model(study / "model.h5") as model:
        fields, cells = model.fields(**point), model.cells
        answer = model.query(**point)
    for name in ("stress", "von_mises", "imposed_strain", "stress_smoothed", "von_mises_smoothed", "gap"):
        np.testing.assert_array_equal(getattr(fields, name), expected[name], err_msg=name)
    for name in ("displacement", "contact_force"):
        np.testing.assert_array_equal(getattr(fields, name), expected[name][:, :2], err_msg=name)
    np.testing.assert_array_equal(fields.contact_status, expected["contact_status"])
    assert fields.contact_area == pytest.approx([expected["contact_1_area"]])
    assert (fields.units["stress"], fields.units["contact_area"], fields.units["gap"]) == ("Pa", "m", "m")
    for name in ("displacement_bound", "relative_displacement_bound"):
        assert getattr(fields, name) == getattr(answer, name)
    assert cells.region_names == ["lower", "upper"]
    np.testing.assert_array_equal(cells.regions + 1, expected["region"])
    assert len(cells.starts) == len(fields.von_mises) + 1
    with h5py.File(study / "contact.h5") as file:
        assert len(cells.facet_contacts) == len(file["mesh/topology"])
    done = run_c(compile_c("tell_fields", library, tmp_path), study / "model.h5", *point.values())
    assert done.returncode == 0, done.stdout + done.stderr
    lines = done.stdout.splitlines()
    assert lines[0].split()[0] == str(len(fields.von_mises))
    assert lines[0].endswith("Pa m")
    assert lines[1:3] == ["lower", "upper"]
    told = {line.split()[0]: np.array([float(word) for word in line.split()[1:]]) for line in lines[3:]}
    np.testing.assert_array_equal(told["stress"], fields.stress.ravel())
    np.testing.assert_array_equal(told["pressure"], fields.contact_pressure)
    assert told["closed"] == (fields.status == 2).sum()


@pytest.mark.usefixtures("post")
def test_picture_of_a_predicted_folder(study, tmp_path):
    """signorom-post view needs nothing but the folder."""
    pytest.importorskip("vtk")
    from signorom_post.cli import main

    assert main(["view", str(study / "answers_fields"), "--output", str(tmp_path)]) == 0
    assert {"displacement.png", "von_mises.png", "contact_pressure.png"} <= {
        path.name for path in tmp_path.iterdir()
    }


def test_fields_beside_the_model_without_a_table_file(signorom, study, tmp_path):
    """The table goes to the terminal, and a line to stderr says where the fields are."""
    (tmp_path / "model.h5").write_bytes((study / "model.h5").read_bytes())
    done = signorom.run("predict", "model.h5", "--at", "heat=300,press=1e4", "--fields", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("heat,press,")
    assert done.stderr.startswith("fields of 1 point")
    assert "): ./predicted_fields/fields.xdmf" in done.stderr
    found = {path.name for path in (tmp_path / "predicted_fields").iterdir()}
    assert found == {"fields.h5", "fields.xdmf", "contact.h5", "contact.xdmf"}


def test_models_without_fields_say_what_helps(signorom, post, tmp_path):
    """A deck that asks for none; the same sentence from the program and from Python."""
    deck = write_blocks(tmp_path, "mixed", "plane_strain")
    deck.write_text(deck.read_text().replace("fields: true", "fields: false"))
    for command in ("sample", "train"):
        signorom(command, deck.name, folder=tmp_path)
    results = tmp_path / "results" / "hot"
    words = refuse(signorom, "predict", "model.h5", "--at", "heat=0,press=1e3", "--fields", folder=results)
    sentence = "the model keeps no mesh for fields: train it with reduction.fields: true in the deck"
    assert sentence in words
    with post.Model(results / "model.h5") as model:
        with pytest.raises(post.NoAnswerError, match=sentence):
            model.fields(heat=0.0, press=1e3)
        with pytest.raises(post.NoAnswerError, match=sentence):
            _ = model.cells
