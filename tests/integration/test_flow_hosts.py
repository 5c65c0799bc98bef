# SPDX-License-Identifier: BSD-3-Clause
"""Hosts of models whose materials yield and creep: a power history from outside, step by step, in Python and as FMU."""

import re
import zipfile

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu

from block_meshes import stacked_blocks
from results import read_fields, read_table
from test_fmu import Instance, run_post

pytestmark = pytest.mark.slow

DECK = """title: A block that yields and creeps
units: {length: mm, force: N, time: h}
mesh: {file: part.msh, model: plane_strain}
parameters: {peak: {min: 0.0005, max: 0.003}, sy: {min: 150, max: 250}, stiff: {min: 2.0e5, max: 6.0e5}}
history:
  tables: {power: {time: [0, 1, 2, 3], value: [0, peak, peak, "0.2 * peak"]}}
  steps: [{until: 3, increments: 6}]
materials:
  soft:
    regions: [lower]
    young_modulus: 2.0e5
    poisson_ratio: 0.3
    plasticity: {yield_stress: sy, isotropic_hardening: 1000}
    creep: {norton: {coefficient: 1e-12, exponent: 4}}
  hard: {regions: [upper], young_modulus: stiff, poisson_ratio: 0.2}
boundary_conditions:
  - {boundary: bottom, displacement: {x: 0, y: 0}}
  - {boundary: top, displacement: {x: 0, y: "-power"}}
contact: [{first: lower_face, second: upper_face}]
training: {sobol: 4}
test: {sobol: 1, seed: 1}
reduction: {fields: true}
"""
GIVEN = {"peak": 0.002, "sy": 180.0, "stiff": 3.1e5}
# time and power: other steps and another course than those of the training
STEPS = [(0.4, 0.001), (0.9, 0.0026), (1.2, 0.0024), (2.5, 0.0024), (2.6, 0.0005), (3.0, 0.0022)]
OUTPUTS = ["contact_1.force_x", "contact_1.force_y", "contact_1.moment_z", "error_estimate"]
# the hosts ask the same library; a table of `predict` has all digits of forces, and seven of estimates
SAME, PRINTED = 1e-12, 5e-7


@pytest.fixture(scope="module")
def model_file(signorom, tmp_path_factory):
    """A trained model of two blocks in the plane."""
    folder = tmp_path_factory.mktemp("flow")
    stacked_blocks("Q8", 2).write(folder / "part.msh")
    (folder / "part.yaml").write_text(DECK)
    for command in ("sample", "train"):
        signorom(command, "part.yaml", folder=folder)
    return folder / "results" / "part" / "model.h5"


@pytest.fixture(scope="module")
def table(signorom, model_file):
    """What `predict --history` says of STEPS; its fields are beside it."""
    rows = [f"{time!r},{power!r}" for time, power in STEPS]
    folder = model_file.parent
    (folder / "power.csv").write_text("\n".join(["time,power", *rows]) + "\n")
    place = ",".join(f"{name}={value}" for name, value in GIVEN.items())
    command = ["predict", model_file, "--at", place, "--history", "power.csv", "--fields"]
    signorom(*command, "--output", "predicted.csv", folder=folder)
    return read_table(folder / "predicted.csv")


@pytest.fixture(scope="module")
def told(table):
    """The outputs of the unit, by `predict`; shape (n_steps, n_outputs)."""
    columns = ["contact_1_force_x", "contact_1_force_y", "contact_1_moment", "error_estimate"]
    return np.array([[float(value) for value in table[name]] for name in columns]).T


def close_to(values):
    """Forces and, at the end, the estimate, as `predict` prints them."""
    return [pytest.approx(v, rel=SAME, abs=SAME) for v in values[:-1]] + [
        pytest.approx(values[-1], rel=PRINTED)
    ]


def test_python_step_by_step(model_file, post, told):
    """Forces and estimates are those of `predict --history`; the estimate is none of the bounds."""
    with post.Model(model_file) as model, model.start(**GIVEN) as history:
        assert model.remembers
        for (time, power), expected in zip(STEPS, told, strict=True):
            answer = history.advance(time, nodes=[], power=power)
            sums = answer.resultants
            assert [*sums.forces[0], *sums.moments[0], answer.error_estimate] == close_to(expected)
            assert answer.bound is None
            assert answer.relative_bound is None
    assert (told[:, 3] > 0).any()
    assert (told[:, 3] < 0.1).all()


def test_python_arrays(signorom, model_file, post):
    """Estimates of histories of many points have the time as second axis."""
    points = [[0.002, 180.0, 2.2e5], [0.0012, 240.0, 5.8e5]]
    rows = "".join(",".join(map(str, point)) + "\n" for point in points)
    (model_file.parent / "points.csv").write_text("peak,sy,stiff\n" + rows)
    command = ["predict", model_file, "--points", "points.csv", "--output", "many.csv"]
    signorom(*command, folder=model_file.parent)
    expected = read_table(model_file.parent / "many.csv")["error_estimate"]
    with post.Model(model_file) as model:
        found = model.query_history(np.array(points)).error_estimate
    assert found.shape == (2, 6)
    np.testing.assert_allclose(found.ravel(), expected, rtol=PRINTED, atol=0)


def test_fields(model_file, post, table):
    """Stresses and inelastic strains are those of `predict --fields`, bit by bit."""
    names = ["stress", "von_mises", "von_mises_smoothed", "gap"]
    for kind in ("plastic", "creep"):
        names += [f"{kind}_strain", f"{kind}_strain_tensor", f"{kind}_strain_smoothed"]
    assert len(table["time"]) == len(STEPS)
    path = model_file.parent / "predicted_fields" / "fields.h5"
    with post.Model(model_file) as model, model.start(**GIVEN) as history:
        for i, (time, power) in enumerate(STEPS, start=1):
            history.advance(time, nodes=[], power=power)
            fields, expected = history.fields(), read_fields(path, i)
            for name in names:
                np.testing.assert_array_equal(getattr(fields, name), expected[name], name)
                assert name in fields.units
    assert fields.plastic_strain.max() > 0
    assert fields.creep_strain.max() > 0
    assert (fields.plastic_strain >= 0).all()
    assert fields.tangential_traction is None


def test_model_without_flow_has_no_estimate(signorom, post, tmp_path):
    """None and NaN, as where there is no bound; the unit has no such output."""
    flow = re.search(r"    plasticity.*\n    creep.*\n", DECK)[0]
    stacked_blocks("Q8", 2).write(tmp_path / "part.msh")
    (tmp_path / "part.yaml").write_text(DECK.replace(flow, "").replace("yield_stress: sy", ""))
    for command in ("sample", "train"):
        signorom(command, "part.yaml", folder=tmp_path)
    with post.Model(tmp_path / "results" / "part" / "model.h5") as model:
        with model.start(**GIVEN) as history:
            assert history.advance(1.0, nodes=[]).error_estimate is None
            assert history.fields().plastic_strain is None
            assert history.fields().creep_strain is None
        assert np.isnan(model.query_history(np.array([[0.002, 180.0, 4.0e5]])).error_estimate).all()


WHY = "yield_stress of the material 'soft' is not finite or out of its range at an integration point: it must be"


def test_property_out_of_its_range(signorom, model_file, post):
    """`predict` and the hosts name the property and the material, also at the times after the first one; exit code 3."""
    folder = model_file.parent
    command = ["predict", model_file, "--at", "peak=0.001,sy=-5,stiff=4e5", "--output", "bad.csv"]
    done = signorom.run(*command, folder=folder)
    assert done.returncode == 3
    table = read_table(folder / "bad.csv")
    assert len(table["status"]) == 6
    assert all(status.startswith(WHY) for status in table["status"])
    with post.Model(model_file) as model, model.start(peak=0.001, sy=-5, stiff=4e5) as history:
        for time in (1.0, 2.0):
            with pytest.raises(post.NoAnswerError, match=WHY):
                history.advance(time)
        with pytest.raises(post.NoAnswerError, match="the model remembers"):
            model.query(peak=0.001, sy=180, stiff=4e5, time=1, power=0.001)


@pytest.fixture(scope="module")
def unit(model_file, library):
    """The model as a unit. It has no derivatives, and the command says so."""
    output = model_file.with_name("part.fmu")
    done = run_post(library, "fmu", model_file, "--output", output, folder=model_file.parent)
    assert done.returncode == 0, done.stderr
    assert "there are no derivatives where materials yield or creep" in done.stderr
    return output


@pytest.fixture
def folder(unit, tmp_path):
    """The unit unpacked."""
    with zipfile.ZipFile(unit) as archive:
        archive.extractall(tmp_path / "unit")
    return tmp_path / "unit"


def step(instance, number):
    """Makes a step of STEPS; returns the outputs."""
    before = STEPS[number - 1][0] if number > 0 else 0.0
    time, power = STEPS[number]
    instance.set(power=power)
    instance.fmu.doStep(before, time - before)
    return instance.get(*OUTPUTS)


def test_unit_is_valid(unit):
    """For co-simulation alone, without derivatives; the estimate is an output and called one."""
    assert validate_fmu(str(unit)) == []
    described = fmpy.read_model_description(str(unit))
    assert described.modelExchange is None
    text = zipfile.ZipFile(unit).read("modelDescription.xml").decode()
    assert 'providesDirectionalDerivatives="false"' in text
    estimate = next(variable for variable in described.modelVariables if variable.name == "error_estimate")
    assert estimate.causality == "output"
    assert estimate.description.startswith("Estimate (no bound)")
    assert not any("bound" in variable.name for variable in described.modelVariables)


def test_unit_step_by_step(folder, told):
    """The unit gives what `predict --history` gives, also after it went back to an earlier state, twice."""
    instance = Instance(folder).start()
    instance.set(**GIVEN)
    instance.fmu.enterInitializationMode()
    instance.fmu.exitInitializationMode()
    assert instance.get(*OUTPUTS) == [0, 0, 0, 0]
    for number in range(3):
        assert step(instance, number) == close_to(told[number])
    state = instance.fmu.getFMUState()
    for _ in range(2):
        # something else happens: the block yields much more
        instance.set(power=0.003)
        instance.fmu.doStep(STEPS[2][0], 5.0)
        assert instance.get(*OUTPUTS) != close_to(told[2])
        instance.fmu.setFMUState(state)
        assert instance.get(*OUTPUTS) == close_to(told[2])
        for number in range(3, len(STEPS)):
            assert step(instance, number) == close_to(told[number])
        instance.fmu.setFMUState(state)
    instance.fmu.freeFMUState(state)
    # begun again, the virgin state
    instance.fmu.reset()
    instance.set(**GIVEN)
    assert step(instance, 0) == close_to(told[0])
    instance.fmu.freeInstance()


def test_no_derivatives(model_file, post, folder):
    """Python and the unit say why."""
    why = "there are no derivatives where materials yield or creep"
    with post.Model(model_file) as model, model.start(**GIVEN) as history:
        answer = history.advance(1.0, nodes=[])
        with pytest.raises(post.NoAnswerError, match=why):
            _ = answer.gradient
    instance = Instance(folder).start()
    instance.set(**GIVEN)
    instance.fmu.enterInitializationMode()
    instance.fmu.exitInitializationMode()
    step(instance, 0)
    force, power = (instance.references[name] for name in ("contact_1.force_y", "power"))
    with pytest.raises(fmpy.fmi1.FMICallException):
        instance.fmu.getDirectionalDerivative([force], [power], [1.0])
    assert any(why in sentence for sentence in instance.said)
    instance.fmu.freeInstance()
