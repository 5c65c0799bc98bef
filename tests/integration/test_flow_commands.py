# SPDX-License-Identifier: BSD-3-Clause
"""Decks with plasticity and creep through all commands. Figures: tests/verification/test_flow.py."""

import re
import subprocess

import h5py
import numpy as np
import pytest
import yaml

from block_meshes import Mesh, stacked_blocks
from results import read_fields, read_table
from runs import refuse

DECK = """units: {length: mm, force: N, time: h}
mesh: {file: part.msh, model: plane_strain}
parameters: {stroke: {min: 0, max: 0.02}}
history: {steps: [{until: 2, increments: 4}]}
materials:
  soft:
    regions: [lower]
    young_modulus: 2.0e5
    poisson_ratio: 0.3
    plasticity: {yield_stress: 200, isotropic_hardening: 1000}
    creep: {norton: {coefficient: 1e-12, exponent: 4}}
  hard: {regions: [upper], young_modulus: 4.0e5, poisson_ratio: 0.2}
boundary_conditions:
  - {boundary: bottom, displacement: {x: 0, y: 0}}
  - {boundary: top, displacement: {x: 0, y: "-stroke*time"}}
contact: [{first: lower_face, second: upper_face}]
training: {sobol: 4}
output: {points: [{stroke: 0.004}, {stroke: 0.01}]}
"""


#: cells of the lower block, with 2 x 2 points each
N_POINTS = 4 * sum(name == "lower" for _, name, _ in stacked_blocks("Q8", 2).elements)


def write_deck(folder, element="Q8", **changes):
    """Mesh and deck, with texts replaced."""
    mesh = stacked_blocks(element, 2)
    mesh.write(folder / "part.msh")
    text = DECK
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    (folder / "part.yaml").write_text(text)
    return folder / "part.yaml"


def test_check_fields(signorom, tmp_path):
    """`check --fields` has temperature and yield stress of each cell at --at and the last time; no number elsewhere."""
    deck = write_deck(
        tmp_path,
        **{
            "yield_stress: 200": 'yield_stress: "200 - 0.1*T"',
            "    poisson_ratio: 0.3\n": "    poisson_ratio: 0.3\n    thermal_expansion: 0\n",
            "boundary_conditions:": "imposed_strains:\n"
            '  - {region: lower, temperature: "20 + 5000*stroke*time*(2 + x)", reference: 20}\n'
            "boundary_conditions:",
        },
    )
    signorom("check", deck, "--fields", "--at", "stroke=0.01", folder=tmp_path)
    with h5py.File(tmp_path / "results" / "part" / "check.h5") as file:
        point = file["points/0001"]
        heat, strength, region = (point[name][()] for name in ("temperature", "yield_stress", "region"))
        assert point["yield_stress"].attrs["unit"] == "MPa"
        names = [name.decode() for name in file["check/regions"][()]]
    lower = region == 1 + names.index("lower")
    mesh = stacked_blocks("Q8", 2)
    cells = [nodes for kind, name, nodes in mesh.elements if name == "lower"]
    middles = np.array([mesh.coordinates[nodes[:4], 0].mean() for nodes in cells])
    np.testing.assert_allclose(np.sort(heat[lower]), np.sort(20 + 100 * (2 + middles)), rtol=0.01)
    np.testing.assert_allclose(strength[lower], 200 - 0.1 * heat[lower], rtol=1e-12)
    assert np.isnan(heat[~lower]).all()
    assert np.isnan(strength[~lower]).all()


def test_halve_steps_needs_flow(signorom, tmp_path):
    """--halve-steps of a deck in which nothing flows is refused."""
    deck = write_deck(
        tmp_path,
        **{
            "    plasticity: {yield_stress: 200, isotropic_hardening: 1000}\n": "",
            "    creep: {norton: {coefficient: 1e-12, exponent: 4}}\n": "",
        },
    )
    done = signorom.run("solve", deck, "--halve-steps", folder=tmp_path)
    assert done.returncode == 2
    assert "--halve-steps needs a material with plasticity or creep" in done.stderr


def test_solve(signorom, tmp_path):
    """Two points with four times each: fields of plastic and creep strain, history.csv, the report."""
    deck = write_deck(tmp_path)
    printed = signorom("check", deck, folder=tmp_path)
    assert f"materials yield or creep at {N_POINTS} integration points" in printed
    assert re.search(r"predicted, roughly: sampling of 16 states: 0\.\d+ s, \d+ MB", printed)
    assert re.search(r"predicted: memory for training: \d+ MB; model file of about \d+ MB or less", printed)
    signorom("solve", deck, folder=tmp_path)
    results = tmp_path / "results" / "part"
    report = yaml.safe_load((results / "report.yaml").read_text())
    assert [point["status"] for point in report["points"].values()] == ["converged"] * 8
    table = read_table(results / "history.csv")
    assert len(table["time"]) == 8
    # the second point begins from the virgin state again
    first = [read_fields(results / "fields.h5", i) for i in (1, 5)]
    assert first[1]["creep_strain"].max() < read_fields(results / "fields.h5", 8)["creep_strain"].max() / 2
    for last in (4, 8):
        field = read_fields(results / "fields.h5", last)
        assert field["plastic_strain"].max() == pytest.approx(
            report["points"][str(last)]["flow"]["largest_plastic_strain"], rel=0.5
        )
        trace = field["plastic_strain_tensor"][:, :3].sum(axis=1)
        assert np.abs(trace).max() <= 1e-12
        is_soft = field["region"] == field["region"][np.argmax(field["plastic_strain"])]
        assert np.all(field["plastic_strain"][~is_soft] == 0)
        assert np.all(field["creep_strain"][~is_soft] == 0)
        assert np.all(field["creep_strain"][is_soft] > 0)
        # accumulated strains do not fall
        before = read_fields(results / "fields.h5", last - 1)
        assert np.all(field["plastic_strain"] >= before["plastic_strain"] - 1e-15)
        assert np.all(field["creep_strain"] >= before["creep_strain"])
    with h5py.File(results / "fields.h5") as file:
        names = set(file["points/0001"])
    assert {"plastic_strain_smoothed", "creep_strain_smoothed", "creep_strain_tensor"} <= names


def test_without_creep_there_are_no_fields_of_it(signorom, tmp_path):
    """Only the fields of what the materials do."""
    deck = write_deck(tmp_path, **{"    creep: {norton: {coefficient: 1e-12, exponent: 4}}\n": ""})
    signorom("solve", deck, folder=tmp_path)
    field = read_fields(tmp_path / "results" / "part" / "fields.h5", 4)
    assert "plastic_strain" in field
    assert "creep_strain" not in field


STUDY = "test: {sobol: 1, seed: 1}\nreduction: {fields: true}\n"


def test_model(signorom, tmp_path):
    """`run` makes a model, whose answers have an estimate and no bound; it has no derivatives."""
    small = {
        "max: 0.02": "max: 0.002",
        "{stroke: 0.004}, {stroke: 0.01}": "{stroke: 0.0005}, {stroke: 0.001}",
    }
    deck = write_deck(tmp_path, **small)
    deck.write_text(deck.read_text() + STUDY)
    printed = signorom("run", deck, folder=tmp_path)
    assert re.search(r"trained inelastic model of 7 contact rows, \d+ inelastic modes?: ", printed)
    model = tmp_path / "results" / "part" / "model.h5"
    text = signorom("describe", model, folder=tmp_path)
    assert "reduced model (inelastic)" in text
    # what does not apply is left out
    for words in (" nan", "POD", "pivot", "exact at", "by lemke", "by none"):
        assert words not in text, text
    printed = signorom("predict", model, "--at", "stroke=0.0015", "--output", "answers.csv", folder=tmp_path)
    answers = read_table(tmp_path / "answers.csv")
    said = re.search(r"forces is estimated at up to (\S+) of their size \(column error_estimate", printed)
    assert float(said[1]) == pytest.approx(max(answers["error_estimate"]), rel=1e-3)
    assert set(answers["status"]) == {"answered"}
    assert set(answers["error_bound"]) == {"none"}
    assert np.all(answers["error_estimate"] >= 0)


@pytest.mark.parametrize("cells", [0, 16], ids=["coarse", "fine"])
def test_model_of_large_plastic_strains(signorom, tmp_path, cells):
    """Some per cent of plastic strain: all states of the test have an answer, with forces within 1 %.

    Such states ask for points that keep the energies of the modes: without them half of the states have no answer. On
    the coarse mesh these are all points, on the fine one less than a third.
    """
    deck = write_deck(
        tmp_path,
        **{
            "training: {sobol: 4}": "training: {sobol: 8}\ntest: {sobol: 6, seed: 1}\nreduction: {fields: true}",
        },
    )
    if cells:
        line = np.linspace(0, 1, cells + 1)
        mesh = Mesh()
        below = {(1, 0): "bottom", (1, 1): "lower_face"}
        mesh.add_block("lower", [line, line - 1], "Q4", below, 0.2, seed=1)
        mesh.add_block("upper", [line, line[::2]], "Q4", {(1, 0): "upper_face", (1, 1): "top"}, 0.2, seed=2)
        mesh.make_quadratic("Q8")
        mesh.write(tmp_path / "part.msh")
    done = signorom("run", deck, folder=tmp_path)
    table = read_table(tmp_path / "results" / "part" / "validation.csv")
    assert len(table["e_lambda_all"]) == 24
    assert np.all(np.isfinite(table["e_lambda_all"]))
    assert np.quantile(table["e_lambda_all"], 0.95) < 0.01
    chosen, everything = map(int, re.search(r"modes, (\d+) of (\d+) integration points", done).groups())
    assert chosen < everything / 3 or not cells


@pytest.mark.parametrize(
    ("key", "old", "new", "column"),
    [
        ("young_modulus", "young_modulus: 2.0e5", "young_modulus: 2.0e5 + stroke", 20),
        ("poisson_ratio", "poisson_ratio: 0.3\n", "poisson_ratio: 0.3 + stroke\n", 20),
    ],
)
def test_elastic_constants_of_a_body_that_flows(signorom, tmp_path, key, old, new, column):
    """They are refused in a model, with line, column and the reason."""
    deck = write_deck(tmp_path, **{old: new})
    deck.write_text(deck.read_text() + STUDY)
    message = refuse(signorom, "run", deck, folder=tmp_path)
    why = f"materials yield or creep, but materials.soft.{key} depends on parameters, and a body with this material"
    place = f"part.yaml:{8 + (key == 'poisson_ratio')}:{column}"
    assert f"{place}: error: {why}" in message
    assert "give it as a number" in message
    assert "the command solve needs no model" in message
    # solve takes the deck, so check says it and goes on
    done = signorom.run("check", deck, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert f"{place}: there cannot be a model, so only solve takes this deck: {why}" in done.stderr


STIFF = "  hard: {regions: [upper], young_modulus: 4.0e5"


def test_elastic_material_in_a_body_that_flows(signorom, tmp_path):
    """The body counts, not the material: one cell of an elastic material is part of the block that flows."""
    deck = write_deck(
        tmp_path,
        **{"regions: [upper], young_modulus: 4.0e5": "regions: [upper, cell], young_modulus: 4.0e5 + stroke"},
    )
    mesh = stacked_blocks("Q8", 2)
    kind, _, nodes = mesh.elements[0]
    mesh.elements[0] = (kind, "cell", nodes)
    mesh.write(tmp_path / "part.msh")
    message = refuse(signorom, "sample", deck, folder=tmp_path)
    assert (
        "part.yaml:12:49: error: materials yield or creep, but materials.hard.young_modulus depends"
        in message
    )
    assert "a body with this material yields or creeps" in message


def test_modulus_of_an_elastic_body(signorom, tmp_path):
    """The elastic block may have it, and the responses of sampled points are not those of elastic bodies."""
    deck = write_deck(
        tmp_path, **{STIFF: STIFF + "*(1 + 20*stroke)", "{sobol: 4}": "{sobol: 4, stiffness: interpolated}"}
    )
    deck.write_text(deck.read_text() + STUDY)
    printed = signorom.run("run", deck, folder=tmp_path)
    assert printed.returncode == 0, printed.stderr
    said = printed.stdout + printed.stderr
    assert re.search(
        "training.stiffness: interpolated has no effect.*each step has a stiffness of its own", said
    )
    assert "4 stiffnesses" in printed.stdout
    words = signorom("check", deck, folder=tmp_path)
    assert "# predicted, roughly: sampling of 16 states" in words
    assert "# predicted: memory for training" in words


def test_displacements_by_modes(signorom, tmp_path):
    """They are those of elastic bodies, and refused where an elastic constant is a parameter."""
    deck = write_deck(tmp_path, **{STIFF: STIFF + "*(1 + 20*stroke)"})
    deck.write_text(deck.read_text() + "reduction: {displacement: {boundaries: [top], elsewhere: modes}}\n")
    message = refuse(signorom, "sample", deck, folder=tmp_path)
    why = (
        "materials yield or creep, but materials.hard.young_modulus depends on parameters, "
        "and there are no displacements by modes"
    )
    assert f"part.yaml:12:43: error: {why}" in message


def test_model_where_nothing_yields(signorom, tmp_path):
    """Far below the yield stress: a model without modes, whose forces are those of the full order."""
    flow = DECK[DECK.index("    plasticity") : DECK.index("  hard")]
    deck = write_deck(
        tmp_path, **{flow: "    plasticity: {yield_stress: 1.0e9, isotropic_hardening: 1000}\n"}
    )
    deck.write_text(deck.read_text() + STUDY)
    assert ", 0 inelastic modes" in signorom("run", deck, folder=tmp_path)
    signorom("solve", deck, "--at", "stroke=0.013", folder=tmp_path)
    full = read_table(tmp_path / "results" / "part" / "history.csv")
    model = tmp_path / "results" / "part" / "model.h5"
    signorom("predict", model, "--at", "stroke=0.013", "--output", "answers.csv", folder=tmp_path)
    answers = read_table(tmp_path / "answers.csv")
    names = [name for name in full if name.startswith("lambda_")]
    assert max(np.abs(full[name]).max() for name in names) > 0
    for name in names:
        np.testing.assert_allclose(answers[name], full[name], rtol=1e-8, atol=1e-8 * np.abs(full[name]).max())


def test_training_that_takes_too_much_memory(signorom, tmp_path):
    """Refused before anything is sampled, with a sentence; check warns, because solve takes the deck."""
    deck = write_deck(tmp_path, **{"{sobol: 4}": "{sobol: 200000}"})

    def run_small(command):
        script = 'ulimit -v 2000000; exec "$0" "$1" "$2"'
        command = ["bash", "-c", script, signorom.executable, command, deck.name]
        return subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)

    why = "materials yield or creep, but the training of their model takes"
    done = run_small("sample")
    assert done.returncode == 2, done.stderr
    assert f"part.yaml:10:32: error: {why}" in done.stderr
    assert (
        f"7 contact forces and 800000 states at {N_POINTS} integration points; there is room for 1.2 GB"
        in done.stderr
    )
    assert not (tmp_path / "results" / "part" / "snapshots.part-1").exists()
    done = run_small("check")
    assert done.returncode == 0, done.stderr
    assert f"part.yaml:10:32: there cannot be a model, so only solve takes this deck: {why}" in done.stderr


def test_snesvi(signorom, tmp_path):
    """Refused where the deck says it, with what is allowed."""
    deck = write_deck(tmp_path)
    deck.write_text(deck.read_text() + "solver: {type: snesvi}\n")
    message = refuse(signorom, "check", deck, folder=tmp_path)
    line = len(deck.read_text().splitlines())
    assert (
        f"part.yaml:{line}:16: error: solver.type is 'snesvi', which does not solve for materials" in message
    )
    assert "it must be auto, condensed or active_set" in message


@pytest.mark.parametrize(("element", "why"), [("T3", "locks"), ("Q9", "has no rule of integration for that")])
def test_elements(signorom, tmp_path, element, why):
    """Elements that lock, or would have modes without stiffness, are refused in regions that flow."""
    deck = write_deck(tmp_path, element)
    done = signorom.run("solve", deck, folder=tmp_path)
    assert done.returncode == 2
    assert f"of its regions is a {element}, which {why}" in done.stderr
    assert "take Q8, T6 or Q4" in done.stderr


def test_elastic_regions_may_have_any_element(signorom, tmp_path):
    """The same deck whose materials are elastic takes Q9."""
    flow = DECK[DECK.index("    plasticity") : DECK.index("  hard")]
    signorom("solve", write_deck(tmp_path, "Q9", **{flow: ""}), folder=tmp_path)


def deck_with_heat(folder, yield_stress):
    """The deck with a yield stress of the temperature, which grows with time and along x."""
    return write_deck(
        folder,
        **{
            "yield_stress: 200": f'yield_stress: "{yield_stress}"',
            "poisson_ratio: 0.3\n": "poisson_ratio: 0.3\n    thermal_expansion: 0\n",
            "contact:": 'imposed_strains: [{region: lower, temperature: "120*time*x", reference: 0}]\ncontact:',
        },
    )


@pytest.mark.parametrize("command", ["check", "solve"])
def test_values_out_of_range_at_a_place(signorom, tmp_path, command):
    """A yield stress that the temperature makes negative at some points is refused before anything is solved."""
    deck = deck_with_heat(tmp_path, "200 - T")
    done = signorom.run(command, deck, folder=tmp_path)
    assert done.returncode == 2, done.stderr
    line = next(i for i, text in enumerate(deck.read_text().splitlines(), 1) if "yield_stress" in text)
    found = re.search(
        rf"{deck.name}:{line}:\d+: error: yield_stress of materials.soft is '200 - T', which is (\S+) "
        r"at T = ([^,]+), .*; it must be positive",
        done.stderr,
    )
    assert found, done.stderr
    value, degrees = map(float, found.groups())
    assert value < 0
    assert value == pytest.approx(200 - degrees, rel=1e-12)


def test_values_out_of_range_between_places(signorom, tmp_path):
    """Only temperatures between the lowest and the highest make it negative: the times before are answered."""
    done = signorom.run(
        "solve", deck_with_heat(tmp_path, "200 - 400*exp(-((T - 145) / 8)^2)"), folder=tmp_path
    )
    assert done.returncode == 3, done.stderr
    assert (
        "a value of plasticity or creep is not finite or out of its range at an integration point"
        in done.stderr
    )
    report = yaml.safe_load((tmp_path / "results" / "part" / "report.yaml").read_text())
    states = [point["status"] == "converged" for point in report["points"].values()]
    assert states == [True, True, True, False] * 2


RUBBING = """units: {length: m, force: N, time: h}
mesh: {file: part.msh, model: plane_strain}
parameters: {P: {min: 1, max: 9}}
history:
  tables:
    load: {time: [0, 1, 4], value: [0, P, P]}
    shear: {time: [0, 1, 2, 3, 4], value: [0, 0, "0.2 * P", "-0.2 * P", 0]}
  steps: [{until: 1, increments: 2}, {until: 4, increments: 12}]
materials:
  all: {regions: [lower, upper], young_modulus: 2.0e6, poisson_ratio: 0.3}
  far: {regions: [far], young_modulus: 2.0e6, poisson_ratio: 0.3}
boundary_conditions: [{boundary: bottom, displacement: {x: 0, y: 0}}, {boundary: foot, displacement: {x: 0, y: 0}}]
loads: [{boundary: top, pressure: load}, {boundary: top, traction: {x: shear}}]
contact: [{first: lower_face, second: upper_face, friction: 0.4}]
output: {points: [{P: 4}, {P: 8}]}
"""


@pytest.mark.parametrize("friction", [", friction: 0.4", ""])
def test_elastic_bodies_beside_a_material_that_flows(signorom, tmp_path, friction):
    """A body far away that yields changes nothing: Newton's method finds what the steps with friction find.

    The upper block is held by contact and friction alone, and slips to and fro; without friction it is held along x.
    """
    mesh = stacked_blocks("Q4", 2)
    line = np.linspace(0, 1, 3)
    mesh.add_block("far", [5 + line, line], "Q4", {(1, 0): "foot"})
    text = RUBBING.replace(", friction: 0.4", friction)
    if not friction:
        text = text.replace(
            "displacement: {x: 0, y: 0}}]",
            "displacement: {x: 0, y: 0}}, {boundary: top, displacement: {x: 0}}]",
        )
    found = []
    for name, law in (("elastic", ""), ("flowing", ", plasticity: {yield_stress: 1}")):
        folder = tmp_path / name
        folder.mkdir()
        mesh.write(folder / "part.msh")
        (folder / "part.yaml").write_text(
            text.replace("poisson_ratio: 0.3}\nboundary", f"poisson_ratio: 0.3{law}}}\nboundary")
        )
        signorom("solve", folder / "part.yaml", folder=folder)
        path = folder / "results" / "part" / "fields.h5"
        found.append([read_fields(path, i) for i in range(1, 29)])
    for one, other in zip(*found, strict=True):
        for field in ("displacement", "multipliers_full_order", "stress", *(["slip"] if friction else [])):
            scale = max(np.abs(state[field]).max() for state in found[0])
            np.testing.assert_allclose(other[field], one[field], rtol=0, atol=1e-9 * scale)
    if friction:
        assert max(np.abs(state["slip"]).max() for state in found[0]) > 0
