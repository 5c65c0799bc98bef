# SPDX-License-Identifier: BSD-3-Clause
"""Elastic constants of bodies that stay elastic as parameters where another body flows: models beside the full order."""

import re

import numpy as np
import pytest

from block_meshes import Mesh
from flow_decks import held, write_deck
from results import read_fields, read_table
from test_flow import two_tubes, with_model

# [-] the limit that such models are made for, over a history
FORCES = 0.01
# [-] the contact of a model in which nothing yields is that of the full order
EXACT = 1e-8
# [-] the last modes have 1e-8 of the energy of the first ones, so that rounding turns them by so much
RANKS = 1e-8
STUDY = "training: {sobol: 16}\ntest: {sobol: 2, seed: 1}\nreduction: {fields: true}\n"
# where the number of modes does not matter
FEW = STUDY.replace("16", "4")
MODULUS = {"modulus": (90000, 270000)}
# Poisson's ratio is interpolated
RATIO = {"ratio": (0.2, 0.4)}
UNSEEN = ("load=1.37,modulus=101000", "load=0.9,modulus=263000")


def tubes(folder, friction="", further=MODULUS, study=STUDY, strength=None, **constants):
    """Two hot tubes, of which the outer one yields and creeps; the constants of the inner one are `constants`."""
    mesh, model, sections = with_model(two_tubes(friction))
    new = {"young_modulus": "modulus", "poisson_ratio": 0.31, **constants}
    old = "young_modulus: 180000, poisson_ratio: 0.31"
    assert old in sections
    sections = sections.replace(old, ", ".join(f"{key}: {value}" for key, value in new.items()))
    if strength:
        sections = re.sub(r"yield_stress: 100", f"yield_stress: {strength}", sections)
        sections = re.sub(r"\},\n    creep: .*?\}\}\}", "}}", sections)
    return write_deck(folder, mesh, model, sections + study, further=further)


def hanging_blocks(folder, flows, friction):
    """A block on another one, which only contact holds up and down; `flows` is the region that yields."""
    mesh = Mesh()
    mesh.add_block(
        "lower",
        [np.linspace(0, 4, 9), np.linspace(0, 2, 5)],
        "Q4",
        {(1, 0): "foot", (1, 1): "lower_face", (0, 0): "lower_side"},
        0.1,
        seed=1,
    )
    mesh.add_block(
        "upper",
        [np.linspace(0, 2, 6), np.linspace(2, 3, 4)],
        "Q4",
        {(1, 0): "upper_face", (1, 1): "head", (0, 0): "upper_side"},
        0.1,
        seed=2,
    )
    mesh.make_quadratic("Q8")
    other = {"lower": "upper", "upper": "lower"}[flows]
    sections = (
        "materials:\n"
        f"  soft: {{regions: [{flows}], young_modulus: 70000, poisson_ratio: 0.3,\n"
        "    plasticity: {yield_stress: 100, isotropic_hardening: 3000}}\n"
        f"  hard: {{regions: [{other}], young_modulus: modulus, poisson_ratio: 0.3, thermal_expansion: 1.0e-5}}\n"
        f"{held(foot={'y': 0}, lower_side={'x': 0}, upper_side={'x': 0})}"
        f'imposed_strains: [{{region: {other}, temperature: "20 + 100*load*push*(1 + 0.2*x)", reference: 20}}]\n'
        'loads: [{boundary: head, pressure: "100*load*push*(1 + 0.3*x)"}]\n'
        f"contact: [{{first: upper_face, second: lower_face, formulation: mortar{friction}}}]\n"
        "history: {steps: [{until: 10, increments: 12}],\n"
        "  tables: {push: {time: [0, 4, 7, 10], value: [0, 1, 0.2, 1.1]}}}\n"
    )
    return write_deck(folder, mesh, "plane_strain", sections + STUDY, further=MODULUS)


def train(signorom, folder, n_ranks=1):
    """Trains the model of a folder; what was said."""
    signorom("sample", "deck.yaml", folder=folder, n_ranks=n_ranks)
    return signorom("train", "deck.yaml", folder=folder, n_ranks=n_ranks)


def forces(table):
    """Normal and tangential contact forces, shape (n_times, n_rows)."""
    return np.array([table[name] for name in table if name.startswith(("lambda_", "tau_"))]).T


def answered(signorom, folder, place, *options):
    """Forces that the model of a folder answers."""
    model = folder / "results" / "deck" / "model.h5"
    signorom("predict", model, "--at", place, "--output", folder / "answers.csv", *options, folder=folder)
    table = read_table(folder / "answers.csv")
    assert set(table["status"]) == {"answered"}
    return forces(table)


def solved(signorom, folder, place):
    """Forces of the full order of the deck of a folder."""
    signorom("solve", "deck.yaml", "--at", place, folder=folder)
    return forces(read_table(folder / "results" / "deck" / "history.csv"))


def relative(one, other):
    """Error over a history: largest difference over the largest value."""
    assert np.abs(other).max() > 0
    return np.abs(one - other).max() / np.abs(other).max()


def compare(signorom, folder, figures, name):
    """Compares answers at unseen points with the full order, and the verdict of the test histories."""
    for place in UNSEEN:
        error = relative(answered(signorom, folder, place), solved(signorom, folder, place))
        figures.at_most(name, f"error of forces, {place}", error, FORCES, "full order")
    table = read_table(folder / "results" / "deck" / "validation.csv")
    assert np.quantile(table["e_lambda_all"][np.isfinite(table["e_lambda_all"])], 0.95) < FORCES


@pytest.mark.parametrize("friction", ["", ", friction: 0.3"], ids=["slides", "rubs"])
def test_unseen_histories(signorom, tmp_path, figures, friction):
    """Forces, fields and verdict with a modulus, thermal strains in the same body, with friction and without."""
    tubes(tmp_path, friction)
    signorom("run", "deck.yaml", folder=tmp_path)
    compare(signorom, tmp_path, figures, f"tubes{friction}")
    place = UNSEEN[0]
    answered(signorom, tmp_path, place, "--fields")
    solved(signorom, tmp_path, place)
    times = range(1, 16)
    exact = [read_fields(tmp_path / "results" / "deck" / "fields.h5", i) for i in times]
    found = [read_fields(tmp_path / "answers_fields" / "fields.h5", i) for i in times]
    for name in ("displacement", "von_mises", "plastic_strain", "creep_strain"):
        error = relative(np.array([f[name] for f in found]), np.array([f[name] for f in exact]))
        figures.at_most(f"tubes{friction}", f"error of {name}, {place}", error, FORCES, "full order")


@pytest.mark.parametrize("friction", ["", ", friction: 0.3"], ids=["slides", "rubs"])
@pytest.mark.parametrize("flows", ["lower", "upper"])
def test_hanging_bodies(signorom, tmp_path, figures, flows, friction):
    """Either the body that flows or the elastic one is held by contact alone; the elastic one is heated, too."""
    hanging_blocks(tmp_path, flows, friction)
    signorom("run", "deck.yaml", folder=tmp_path)
    compare(signorom, tmp_path, figures, f"{flows} block{friction}")


def test_interpolated_ratio(signorom, tmp_path, figures):
    """Poisson's ratio beside the modulus: the responses of the elastic body are interpolated, and describe says so."""
    tubes(tmp_path, further=MODULUS | RATIO, poisson_ratio="ratio", study=STUDY.replace("16", "32"))
    train(signorom, tmp_path)
    words = signorom("describe", tmp_path / "results" / "deck" / "model.h5", folder=tmp_path)
    assert re.search(r"body \d +interpolated over 1 elastic constant, \d+ nodes", words)
    assert re.search(r"body \d +exact: all its moduli scale together", words)
    for place in ("load=1.37,modulus=101000,ratio=0.22", "load=0.9,modulus=263000,ratio=0.37"):
        error = relative(answered(signorom, tmp_path, place), solved(signorom, tmp_path, place))
        figures.at_most("Poisson's ratio", f"error of forces, {place}", error, FORCES, "full order")


@pytest.mark.parametrize("friction", ["", ", friction: 0.3"], ids=["slides", "rubs"])
def test_nothing_yields(signorom, tmp_path, figures, friction):
    """Far below the yield stress the model is the exact contact problem of elastic bodies, without modes.

    Its forces are those of the full order, and of a model whose modulus is a number.
    """
    place = UNSEEN[0]
    found = {}
    for name, modulus in (("parameter", "modulus"), ("number", 101000)):
        folder = tmp_path / name
        tubes(folder, friction, study=FEW, strength="1.0e9", young_modulus=modulus)
        assert ", 0 inelastic modes" in train(signorom, folder)
        found[name] = answered(signorom, folder, place)
    found["full order"] = solved(signorom, tmp_path / "parameter", place)
    for name in ("number", "full order"):
        error = relative(found["parameter"], found[name])
        figures.at_most(f"nothing yields{friction}", f"difference of forces from {name}", error, EXACT, name)


def test_ranks(signorom, tmp_path):
    """Models trained on 1 and 2 ranks answer the same."""
    found = []
    for n_ranks in (1, 2):
        folder = tmp_path / str(n_ranks)
        tubes(folder, ", friction: 0.3", study=FEW)
        train(signorom, folder, n_ranks)
        found.append(answered(signorom, folder, UNSEEN[0]))
    assert relative(found[1], found[0]) <= RANKS


def test_full_order(signorom, tmp_path):
    """A modulus as a parameter is the same modulus as a number, with both solvers."""
    found = []
    for i, modulus in enumerate(("modulus", 101000)):
        for solver in ("condensed", "active_set"):
            folder = tmp_path / f"{i}_{solver}"
            deck = tubes(folder, young_modulus=modulus)
            deck.write_text(deck.read_text().replace("type: auto", f"type: {solver}"))
            found.append(solved(signorom, folder, UNSEEN[0]))
    assert max(relative(other, found[0]) for other in found[1:]) <= EXACT
