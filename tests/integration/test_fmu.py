# SPDX-License-Identifier: BSD-3-Clause
"""Units of FMI 3.0, validated and run by FMPy: their outputs are the answers of the model, without Signorom at hand."""

import os
import shutil
import subprocess
import sys
import zipfile

import fmpy
import numpy as np
import pytest
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

from block_meshes import stacked_blocks
from program import needs_library
from runs import HERE, train_shifted_disks
from test_gradients import BLOCKS

pytestmark = pytest.mark.slow

POST = HERE.parents[1] / "tools" / "signorom_post" / "src"
NODES = [3, 7]
# rounding in the last digits: the unit asks the same library
SAME = 1e-12
SIMULATE = """
import sys
import fmpy
from fmpy.fmi3 import FMU3Slave
folder = fmpy.extract(sys.argv[1])
described = fmpy.read_model_description(folder)
fmu = FMU3Slave(
    guid=described.guid,
    modelIdentifier=described.coSimulation.modelIdentifier,
    unzipDirectory=folder,
    instanceName="one",
)
fmu.instantiate()
(force,) = [v.valueReference for v in described.modelVariables if v.name == "contact_1.force_y"]
print(repr(fmu.getFloat64([force])[0]))
with open("/proc/self/maps") as maps:
    print(*sorted({line.split()[-1] for line in maps if ".so" in line}))
"""


def run_post(library, *arguments, folder):
    """Run signorom-post."""
    command = [sys.executable, "-m", "signorom_post", *map(str, arguments)]
    environment = os.environ | {"SIGNOROM_LIBRARY": str(library), "PYTHONPATH": str(POST)}
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)


@pytest.fixture(scope="module")
def model_file(signorom, tmp_path_factory):
    """A trained model; contact in the plane, two parameters."""
    changes = {"method: hhr": "method: condensed"}
    return train_shifted_disks(signorom, tmp_path_factory.mktemp("study"), **changes)


@pytest.fixture(scope="module")
def unit(model_file, library):
    """The model as a unit, with displacements of two nodes."""
    output = model_file.with_name("disks.fmu")
    nodes = ",".join(map(str, NODES))
    done = run_post(
        library, "fmu", model_file, "--nodes", nodes, "--output", output, folder=model_file.parent
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == [str(output)]
    assert not done.stderr
    return output


@pytest.fixture(scope="module")
def model(model_file, post):
    with post.Model(model_file) as opened:
        yield opened


def numbers_of(answer):
    """Outputs of an answer, as the unit names them."""
    found = {
        "contact_1.area": answer.resultants.areas[0],
        "contact_1.moment_z": answer.resultants.moments[0, 0],
    }
    for k, axis in enumerate("xy"):
        found[f"contact_1.force_{axis}"] = answer.resultants.forces[0, k]
        for i, tag in enumerate(NODES):
            found[f"node_{tag}.displacement_{axis}"] = answer.displacement[i, k]
    # an output is there if the model gives a bound
    for name in ("relative_bound", "relative_displacement_bound"):
        if getattr(answer, name) is not None:
            found[name] = getattr(answer, name)
    return found


def ramps(model, low, high):
    """Inputs from one share of their ranges to another one in a second."""
    names = [parameter.name for parameter in model.parameters]
    signals = np.zeros(2, dtype=[("time", float), *((name, float) for name in names)])
    signals["time"] = [0, 1]
    for parameter in model.parameters:
        length = parameter.maximum - parameter.minimum
        signals[parameter.name] = [parameter.minimum + low * length, parameter.minimum + high * length]
    return signals


def test_unit_is_valid(unit):
    assert validate_fmu(str(unit)) == []
    described = fmpy.read_model_description(str(unit))
    assert described.modelExchange is not None
    assert described.coSimulation is not None
    text = zipfile.ZipFile(unit).read("modelDescription.xml").decode()
    assert text.count('providesDirectionalDerivatives="true"') == 2
    units = {variable.name: variable.unit for variable in described.modelVariables}
    # per unit thickness
    assert units["contact_1.force_x"] == "N/m"
    assert units["contact_1.area"] == "m"
    assert units["contact_1.moment_z"] == "N"


@pytest.mark.parametrize("kind", ["CoSimulation", "ModelExchange"])
def test_outputs_are_the_answers_of_the_model(unit, model, kind):
    """At each time; a step of co-simulation has the inputs of its start."""
    signals = ramps(model, 0.3, 0.7)
    found = fmpy.simulate_fmu(str(unit), fmi_type=kind, input=signals, stop_time=1, output_interval=0.25)
    assert len(found) >= 5
    for row in found:
        time = row["time"] if kind == "ModelExchange" else max(0, row["time"] - 0.25)
        point = {name: np.interp(time, [0, 1], signals[name]) for name in signals.dtype.names[1:]}
        answer = model.query(nodes=NODES, **point)
        for name, expected in numbers_of(answer).items():
            assert row[name] == pytest.approx(expected, rel=1e-9, abs=1e-9), name
        assert row["is_inside_box"]


class Instance:
    """An instance for co-simulation that keeps what it was told."""

    def __init__(self, folder, token=None):
        described = fmpy.read_model_description(str(folder))
        self.references = {variable.name: variable.valueReference for variable in described.modelVariables}
        self.said = []
        self.fmu = FMU3Slave(
            guid=token or described.guid,
            modelIdentifier=described.coSimulation.modelIdentifier,
            unzipDirectory=str(folder),
            instanceName="one",
        )

    def start(self):
        """Instantiate; an error of FMPy where the unit refuses it."""
        self.fmu.instantiate(logMessage=lambda *said: self.said.append(said[-1].decode()))
        return self

    def set(self, **values):
        self.fmu.setFloat64([self.references[name] for name in values], list(values.values()))

    def get(self, *names):
        return self.fmu.getFloat64([self.references[name] for name in names])


@pytest.fixture
def folder(unit, tmp_path):
    """The unit unpacked."""
    with zipfile.ZipFile(unit) as archive:
        archive.extractall(tmp_path / "unit")
    return tmp_path / "unit"


def test_two_instances_and_derivatives(folder, model):
    """Each has its own inputs; J v and J' v are those of the model's gradient."""
    points = [{"squeeze": 0.31, "shift": 0.02}, {"squeeze": 0.2, "shift": -0.03}]
    instances = [Instance(folder).start(), Instance(folder).start()]
    for instance, point in zip(instances, points, strict=True):
        instance.set(**point)
    for instance, point in zip(instances, points, strict=True):
        gradient = model.query(nodes=NODES, **point).gradient
        rows = {
            "contact_1.force_y": gradient.forces[:, 0, 1],
            "node_7.displacement_x": gradient.displacement[:, 1, 0],
        }
        unknowns = [instance.references[name] for name in rows]
        knowns = [instance.references[name] for name in point]
        jacobian = np.array(list(rows.values()))
        found = instance.fmu.getDirectionalDerivative(unknowns, knowns, [2.0, -3.0])
        np.testing.assert_allclose(found, jacobian @ [2.0, -3.0], rtol=SAME, atol=SAME * abs(jacobian).max())
        found = instance.fmu.getAdjointDerivative(unknowns, knowns, [0.5, 7.0])
        np.testing.assert_allclose(found, jacobian.T @ [0.5, 7.0], rtol=SAME, atol=SAME * abs(jacobian).max())
        expected = model.query(**point).resultants.forces[0, 1]
        assert instance.get("contact_1.force_y") == [pytest.approx(expected, rel=SAME)]
    for instance in instances:
        instance.fmu.freeInstance()


def test_outside_of_the_box_is_said(folder):
    instance = Instance(folder).start()
    instance.set(squeeze=0.9)
    assert not instance.fmu.getBoolean([instance.references["is_inside_box"]])[0]
    assert any("extrapolation" in sentence for sentence in instance.said)
    instance.fmu.freeInstance()


def test_no_answer_is_no_number(folder):
    """An input that is not a number: a sentence and fmi3Discard, and a number again afterwards."""
    instance = Instance(folder).start()
    before = instance.get("contact_1.force_y")
    old = instance.get("squeeze")[0]
    instance.set(squeeze=float("nan"))
    with pytest.raises(fmpy.fmi1.FMICallException) as caught:
        instance.get("contact_1.force_y")
    assert caught.value.status == 2
    assert instance.said
    instance.set(squeeze=old)
    assert instance.get("contact_1.force_y") == before
    instance.fmu.freeInstance()


def test_foreign_token_and_damaged_model_are_refused(folder):
    instance = Instance(folder, token="another")
    with pytest.raises(Exception, match="Failed to instantiate"):
        instance.start()
    assert any("another FMU" in sentence for sentence in instance.said)
    (folder / "resources" / "model.h5").write_bytes(b"no model")
    instance = Instance(folder)
    with pytest.raises(Exception, match="Failed to instantiate"):
        instance.start()
    assert any("model.h5" in sentence for sentence in instance.said)


def test_unit_without_derivatives_is_said(signorom, library, tmp_path):
    """A load that jumps in the middle of the box: the unit is there, and a warning says why it has no derivatives."""
    stacked_blocks("Q4", 2).write(tmp_path / "blocks.msh")
    deck = tmp_path / "blocks.yaml"
    deck.write_text(BLOCKS.replace('"-stroke"', '"stroke > 0.01 ? -stroke : 0"'))
    for command in ("sample", "train"):
        signorom(command, deck.name, folder=tmp_path)
    made = tmp_path / "blocks.fmu"
    done = run_post(library, "fmu", "results/blocks/model.h5", "--output", made, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == [str(made)]
    assert done.stderr.startswith(f"{made}: warning: the FMU has no derivatives, because the model has none")
    assert "as 'stroke' passes this point, 'stroke > 0.01 ? -stroke : 0' jumps" in done.stderr
    text = zipfile.ZipFile(made).read("modelDescription.xml").decode()
    assert text.count('providesDirectionalDerivatives="false"') == 2


def test_unit_carries_its_libraries(unit, model, library, tmp_path):
    """Without a variable and outside of the build folder; all libraries but those of glibc come from the unit."""
    names = ["libsignorom_online", "libhdf5_serial", "libmuparser", "libquadmath.so"]
    # the Fortran library of Debian 13 takes these functions from glibc
    names = [name for name in names[1:] if needs_library(library, name)] + names[:1]
    command = [sys.executable, "-c", SIMULATE, shutil.copy(unit, tmp_path)]
    done = subprocess.run(command, cwd=tmp_path, env={"HOME": str(tmp_path)}, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    force, loaded = done.stdout.splitlines()[-2:]
    middle = {p.name: (p.minimum + p.maximum) / 2 for p in model.parameters}
    assert float(force) == pytest.approx(model.query(**middle).resultants.forces[0, 1], rel=SAME)
    assert len(names) >= 3
    for name in names:
        places = [path for path in loaded.split() if f"/{name}" in path]
        assert places, name
        assert all("/binaries/x86_64-linux/" in path for path in places), places


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["model.h5", "--nodes", "3,x"], "--nodes is '3,x'; it needs whole numbers with commas"),
        (["model.h5", "--nodes", "99999"], "the mesh of the model has no node 99999"),
        (["missing.h5"], "missing.h5: error: "),
        (["model.h5", "--output", "no/such/folder.fmu"], "the FMU cannot be written"),
    ],
)
def test_mistakes_are_named(model_file, library, arguments, sentence):
    done = run_post(library, "fmu", *arguments, folder=model_file.parent)
    assert done.returncode == 2
    assert sentence in done.stderr
    assert "Traceback" not in done.stderr
