# SPDX-License-Identifier: BSD-3-Clause
"""Units of FMI 3.0 of models with friction: a step of the master is a step of the history."""

import zipfile

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu

from test_fmu import Instance, run_post
from test_friction import write_deck

pytestmark = pytest.mark.slow

GIVEN = {"P": 4.0, "mu": 0.35}
# time, load, shear: it slips, is turned round and slips back
STEPS = [(0.5, 2.0, 0.1), (1.0, 4.0, 0.7), (1.3, 4.0, 0.9), (2.1, 4.0, -0.9), (3.0, 5.0, 0.2)]
OUTPUTS = ["contact_1.force_x", "contact_1.force_y", "contact_1.moment_z"]
SAME = 1e-12


@pytest.fixture(scope="module")
def model_file(signorom, tmp_path_factory):
    """A trained model of two blocks in the plane."""
    deck = write_deck(tmp_path_factory.mktemp("unit"))
    for command in ("sample", "train"):
        signorom(command, deck, folder=deck.parent)
    return deck.parent / "results" / "part" / "model.h5"


@pytest.fixture(scope="module")
def unit(model_file, library):
    """The model as a unit."""
    output = model_file.with_name("part.fmu")
    done = run_post(
        library, "fmu", model_file, "--nodes", "1,19", "--output", output, folder=model_file.parent
    )
    assert done.returncode == 0, done.stderr
    assert not done.stderr
    return output


@pytest.fixture
def folder(unit, tmp_path):
    """The unit unpacked."""
    with zipfile.ZipFile(unit) as archive:
        archive.extractall(tmp_path / "unit")
    return tmp_path / "unit"


@pytest.fixture(scope="module")
def expected(model_file, post):
    """Answers of the model: outputs at each time, and their derivatives over both tables."""
    found, slopes = [], []
    with post.Model(model_file) as model, model.start(**GIVEN) as history:
        for time, load, shear in STEPS:
            answer = history.advance(time, nodes=[19], load=load, shear=shear)
            sums = answer.resultants
            found.append([*sums.forces[0], *sums.moments[0], *answer.displacement[0]])
            gradient = answer.gradient
            slopes.append([[*gradient.forces[i, 0], *gradient.moments[i, 0]] for i in (3, 4)])
    return np.array(found), np.array(slopes)


def begun(folder):
    """An instance with parameters."""
    instance = Instance(folder).start()
    instance.set(**GIVEN)
    instance.fmu.enterInitializationMode()
    instance.fmu.exitInitializationMode()
    return instance


def step(instance, number):
    """Makes a step of STEPS; returns the outputs."""
    time, load, shear = STEPS[number]
    before = STEPS[number - 1][0] if number > 0 else 0.0
    instance.set(load=load, shear=shear)
    instance.fmu.doStep(before, time - before)
    return instance.get(*OUTPUTS, "node_19.displacement_x", "node_19.displacement_y")


def close_to(values):
    return pytest.approx(values, rel=SAME, abs=SAME)


def test_unit_is_valid(unit):
    """For co-simulation alone; parameters of the deck are fixed, and the time is no input."""
    assert validate_fmu(str(unit)) == []
    described = fmpy.read_model_description(str(unit))
    assert described.modelExchange is None
    text = zipfile.ZipFile(unit).read("modelDescription.xml").decode()
    assert text.count('providesDirectionalDerivatives="true"') == 1
    causality = {variable.name: variable.causality for variable in described.modelVariables}
    assert causality["mu"] == "parameter"
    assert causality["load"] == "input"
    assert "parameter.time" not in causality


def test_steps_are_those_of_the_history(folder, expected):
    """Before the first one nothing has happened, and an input alone changes nothing."""
    instance = begun(folder)
    assert instance.get(*OUTPUTS) == [0, 0, 0]
    for number in range(len(STEPS)):
        assert step(instance, number) == close_to(expected[0][number])
    instance.set(load=1.0)
    assert instance.get(*OUTPUTS) == close_to(expected[0][-1][:3])
    with pytest.raises(fmpy.fmi1.FMICallException):
        instance.set(mu=0.4)
    assert any("a parameter stays as it is" in sentence for sentence in instance.said)
    instance.fmu.reset()
    instance.set(**GIVEN)
    assert instance.get(*OUTPUTS) == [0, 0, 0]
    assert step(instance, 0) == close_to(expected[0][0])
    instance.fmu.freeInstance()


def test_state_has_the_memory(folder, expected):
    """Back to an earlier step, and on from there, twice; what was done meanwhile does not count."""
    instance = begun(folder)
    start = instance.fmu.getFMUState()
    step(instance, 0)
    step(instance, 1)
    state = instance.fmu.getFMUState()
    for _ in range(2):
        instance.set(load=4.0, shear=-0.9)
        instance.fmu.doStep(1.0, 0.1)
        assert instance.get(*OUTPUTS) != close_to(expected[0][1][:3])
        instance.fmu.setFMUState(state)
        assert instance.get(*OUTPUTS) == close_to(expected[0][1][:3])
        for number in range(2, len(STEPS)):
            assert step(instance, number) == close_to(expected[0][number])
        instance.fmu.setFMUState(state)
    instance.fmu.setFMUState(start)
    assert instance.get(*OUTPUTS) == [0, 0, 0]
    for number in range(len(STEPS)):
        assert step(instance, number) == close_to(expected[0][number])
    instance.fmu.freeFMUState(state)
    instance.fmu.freeFMUState(start)
    instance.fmu.freeInstance()


def test_derivatives_over_the_tables(folder, expected):
    """Of the last step, whatever the earlier ones had; asking for them changes nothing."""
    instance = begun(folder)
    unknowns = [instance.references[name] for name in OUTPUTS]
    knowns = [instance.references[name] for name in ("load", "shear")]
    for number in range(len(STEPS)):
        step(instance, number)
        if number == 1:
            continue
        found = instance.fmu.getDirectionalDerivative(unknowns, knowns, [2.0, -3.0])
        assert found == pytest.approx([2.0, -3.0] @ expected[1][number], rel=1e-10, abs=1e-10)
        assert instance.get(*OUTPUTS) == close_to(expected[0][number][:3])
    with pytest.raises(fmpy.fmi1.FMICallException):
        instance.fmu.getDirectionalDerivative(unknowns, [instance.references["mu"]], [1.0])
    instance.fmu.freeInstance()


def test_step_without_an_answer_may_be_tried_again(folder, expected):
    """fmi3Discard, and the state of the step before."""
    instance = begun(folder)
    step(instance, 0)
    instance.set(load=float("nan"), shear=0.0)
    with pytest.raises(fmpy.fmi1.FMICallException) as caught:
        instance.fmu.doStep(0.5, 0.5)
    assert caught.value.status == 2
    assert instance.said
    assert instance.get(*OUTPUTS) == close_to(expected[0][0][:3])
    for number in range(1, len(STEPS)):
        assert step(instance, number) == close_to(expected[0][number])
    # a time that is not later
    with pytest.raises(fmpy.fmi1.FMICallException):
        instance.fmu.doStep(1.0, 0.5)
    assert any("not later" in sentence for sentence in instance.said)
    assert instance.get(*OUTPUTS) == close_to(expected[0][-1][:3])
    instance.fmu.freeInstance()


def test_model_without_history(signorom, library, post, tmp_path):
    """All loads come at once: outputs are functions of the inputs, and an older input leaves nothing behind."""
    history = (
        "history:" + write_deck(tmp_path).read_text().partition("history:")[2].partition("materials:")[0]
    )
    changes = {
        history: "",
        "pressure: load": "pressure: P",
        "shear}": '"0.28 * P"}',
        "[{P: 4, mu: 0.8}, {P: 4, mu: 0.3}]": "[{P: 4, mu: 0.8}]",
    }
    deck = write_deck(tmp_path, **changes)
    for command in ("sample", "train"):
        signorom(command, deck, folder=tmp_path)
    model_file, made = tmp_path / "results" / "part" / "model.h5", tmp_path / "part.fmu"
    done = run_post(library, "fmu", model_file, "--nodes", "19", "--output", made, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    with zipfile.ZipFile(made) as archive:
        archive.extractall(tmp_path / "unit")
    instance = Instance(tmp_path / "unit").start()
    name = "node_19.displacement_x"
    slopes = []
    with post.Model(model_file) as model:

        def ask(pressure, friction):
            return model.query(nodes=[19], P=pressure, mu=friction).displacement[0, 0]

        for pressure, friction in ((8.0, 0.32), (4.0, 0.8)):
            instance.set(P=pressure, mu=friction)
            assert instance.get(name) == [pytest.approx(ask(pressure, friction), rel=SAME)]
            slopes.append((ask(pressure, friction + 1e-4) - ask(pressure, friction - 1e-4)) / 2e-4)
            references = [instance.references[name]], [instance.references["mu"]]
            found = instance.fmu.getDirectionalDerivative(*references, [1.0])
            assert found == [pytest.approx(slopes[-1], rel=1e-6, abs=1e-14)]
    # with the smaller coefficient contacts slip
    assert abs(slopes[0]) > 1e-6
    instance.fmu.freeInstance()
