# SPDX-License-Identifier: BSD-3-Clause
"""Derivatives through histories with friction, against differences of whole histories."""

from ctypes import byref, c_int
from itertools import pairwise

import numpy as np
import pytest

from decks import copy_deck
from program import ROOT
from test_friction import write_deck

pytestmark = pytest.mark.slow

# Of differences by Richardson's extrapolation. The step is as small as a contact near another state needs; then
# rounding in a difference is 1e-7 of the derivative.
ALLOWED = 1e-6
STEPS = 1e-2 * 4.0 ** -np.arange(8)
NAMES = ["load", "shear"]


def trained(signorom, deck):
    """File of the model of a deck."""
    for command in ("sample", "train"):
        signorom(command, deck, folder=deck.parent)
    return deck.parent / "results" / deck.stem / "model.h5"


@pytest.fixture(scope="module")
def blocks(signorom, tmp_path_factory):
    """The model of two blocks in space."""
    return trained(signorom, write_deck(tmp_path_factory.mktemp("blocks"), 3))


def walk(model, given, steps, nodes):
    """The last answer of a history; a step has a time and perhaps values of the tables."""
    with model.start(**given) as history:
        for time, *tables in steps:
            answer = history.advance(time, nodes=nodes, **dict(zip(NAMES, tables, strict=False)))
    return answer


def difference(ask, length):
    """Derivatives of forces and displacements at 0: those whose step, a share of the length, serves best."""
    slopes = []
    for step in STEPS * length:
        above, below = ask(step), ask(-step)
        slopes.append(
            [
                (getattr(above, name) - getattr(below, name)) / (2 * step)
                for name in ("multipliers", "displacement")
            ]
        )
    best = np.argmin([np.linalg.norm(fine[0] - rough[0]) for rough, fine in pairwise(slopes)])
    return [(16 * fine - rough) / 15 for rough, fine in zip(slopes[best], slopes[best + 1], strict=True)]


def compare(found, wanted):
    """Of both, relative to their size."""
    for one, other in zip(found, wanted, strict=True):
        assert np.linalg.norm(one - other) <= ALLOWED * np.linalg.norm(other)


def check_given(model, given, steps, nodes):
    """Derivatives over the deck's parameters."""
    gradient = walk(model, given, steps, nodes).gradient
    assert gradient.n_grazing == 0
    for i, parameter in enumerate(model.parameters[: len(given)]):
        assert not gradient.is_one_sided[i]
        name = parameter.name
        wanted = difference(
            lambda step, name=name: walk(model, given | {name: given[name] + step}, steps, nodes),
            parameter.maximum - parameter.minimum,
        )
        compare((gradient.multipliers[i], gradient.displacement[i]), wanted)
    return gradient


@pytest.mark.parametrize(("deck", "ends"), [("press_fit_pull", (3, 9, 20, 43)), ("bolted_joint", (1, 4, 9))])
def test_decks_of_users(signorom, post, tmp_path, deck, ends):
    """The tables follow the parameters."""
    model_file = trained(signorom, copy_deck(ROOT / "input" / f"{deck}.yaml", tmp_path))
    random = np.random.default_rng(1)
    with post.Model(model_file) as model:
        nodes = model.nodes[0][:: len(model.nodes[0]) // 5]
        for end in ends:
            given = {
                parameter.name: parameter.minimum + share * (parameter.maximum - parameter.minimum)
                for parameter, share in zip(model.parameters[:2], random.uniform(0.1, 0.9, 2), strict=True)
            }
            steps = [(time,) for time in model.times[: end + 1]]
            if deck == "press_fit_pull" and end == 3:
                # friction begins just behind this time: it has no derivative over the time, and later times do not mind
                with pytest.raises(post.NoAnswerError, match="as 'time' passes this point"):
                    _ = walk(model, given, steps, nodes).gradient
                continue
            check_given(model, given, steps, nodes)


def test_elastic_constants(signorom, post, tmp_path):
    """The modulus of the bolt is a parameter: W changes with it."""
    deck = copy_deck(ROOT / "input" / "bolted_joint.yaml", tmp_path)
    text = deck.read_text()
    for old, new in {
        "  mu: {min: 0.1,": "  young: {min: 100e3, max: 250e3}\n  mu: {min: 0.1,",
        "young_modulus: 210.0e3": "young_modulus: young",
        "{mu: 0.12, tightening: 0.01}, {mu: 0.25, tightening": "{mu: 0.12, young: 200e3, tightening",
    }.items():
        assert old in text
        text = text.replace(old, new)
    deck.write_text(text)
    with post.Model(trained(signorom, deck)) as model:
        given = {"young": 180e3, "mu": 0.17, "tightening": 0.012}
        nodes = model.nodes[0][:: len(model.nodes[0]) // 5]
        for end in (4, 9):
            check_given(model, given, [(time,) for time in model.times[: end + 1]], nodes)


def random_steps(random, n):
    """Times and values of the tables: pressed at first, then sheared to and fro."""
    return [(k + 1.0, random.uniform(2, 4), random.uniform(-0.8, 0.8) if k > 0 else 0.1) for k in range(n)]


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_random_tables(post, blocks, seed):
    """A coefficient matters at all times, and a value of a table at its own time."""
    random = np.random.default_rng(seed)
    print("seed", seed)
    steps = random_steps(random, 4)
    given = {"P": 4.0, "mu": random.uniform(0.3, 0.6)}
    with post.Model(blocks) as model:
        nodes = model.nodes[0]
        gradient = walk(model, given, steps, nodes).gradient
        assert not gradient.is_one_sided.any()
        # the tables do not ask the parameter P
        assert np.abs(gradient.multipliers[0]).max() <= 1e-12
        for i in (1, 3, 4):
            name, length = model.parameters[i].name, 0.5

            def ask(step, name=name):
                moved = list(steps[-1])
                if name in NAMES:
                    moved[1 + NAMES.index(name)] += step
                now = given | {"mu": given["mu"] + step} if name == "mu" else given
                return walk(model, now, [*steps[:-1], moved], nodes)

            compare((gradient.multipliers[i], gradient.displacement[i]), difference(ask, length))


def test_time_that_changes_nothing(post, blocks):
    """Held loads: derivatives over the parameters stay; over the tables, contacts that have slipped have two sides."""
    steps = [(1.0, 3.0, 0.0), (2.0, 3.0, 0.8)]
    given = {"P": 4.0, "mu": 0.35}
    with post.Model(blocks) as model:
        before = walk(model, given, steps, []).gradient
        held = walk(model, given, [*steps, (3.0, 3.0, 0.8)], [])
        assert before.n_grazing == 0
        assert held.gradient.n_grazing > 0
        assert held.gradient.multipliers[1] == pytest.approx(before.multipliers[1], rel=1e-8, abs=1e-10)
        assert held.gradient.is_one_sided.tolist() == [False, False, False, True, True]
        # on, contacts slip; back, they stick
        for gradient, sign in ((held.gradient, 1), (held.backward_gradient, -1)):
            step = sign * 1e-6
            moved = walk(model, given, [*steps, (3.0, 3.0, 0.8 + step)], [])
            slope = (moved.multipliers - held.multipliers) / step
            assert np.linalg.norm(gradient.multipliers[4] - slope) <= 1e-5 * np.linalg.norm(slope)
        assert np.abs(held.gradient.multipliers[4] - held.backward_gradient.multipliers[4]).max() > 0.01


@pytest.mark.filterwarnings("ignore:the model extrapolates")
def test_nothing_is_loaded_yet(signorom, post, tmp_path):
    """Contacts touch without a force: a load would close them, and parameters that change nothing here matter later."""
    loads = "loads: [{boundary: top, pressure: load}, {boundary: top, traction: {x: shear}}]"
    pushed = '{boundary: top, displacement: {x: "1e-6 * shear", y: "-1e-6 * load"}}'
    held = "boundary_conditions: ["
    deck = write_deck(tmp_path, 2, **{loads: "loads: []", held: f"{held}{pushed}, "})
    steps = [(1.0, 0.0, 0.0), (2.0, 3.0, 0.1), (3.0, 3.0, 6.0)]
    given = {"P": 4.0, "mu": 0.35}
    with post.Model(trained(signorom, deck)) as model:
        nodes = model.nodes[0]
        answer = walk(model, given, steps[:1], nodes)
        with pytest.raises(post.NoAnswerError, match="touches without a force"):
            _ = answer.gradient
        gradient = walk(model, given, steps, nodes).gradient
        assert not gradient.is_one_sided.any()
        wanted = difference(lambda step: walk(model, given | {"mu": given["mu"] + step}, steps, nodes), 0.7)
        assert np.linalg.norm(wanted[0]) > 0.1
        compare((gradient.multipliers[1], gradient.displacement[1]), wanted)


def test_tied_surfaces(signorom, post, tmp_path):
    """Nothing remembers, whatever was asked before: forces are linear in the loads."""
    changes = {
        "friction: mu": "tied: true",
        ", mu: {min: 0.3, max: 1}": "",
        "{P: 2, mu: 2}": "{P: 2}",
        "[{P: 4, mu: 0.8}, {P: 4, mu: 0.3}]": "[{P: 4}]",
    }
    with post.Model(trained(signorom, write_deck(tmp_path, 2, **changes))) as model:
        for load in (3.0, 5.0):
            answer = model.query(P=4, time=1, load=load, shear=0.2 * load)
            gradient = answer.gradient
            slopes = gradient.multipliers[2] + 0.2 * gradient.multipliers[3]
            assert load * slopes == pytest.approx(answer.multipliers, rel=1e-9, abs=1e-10)
            assert not gradient.is_one_sided.any()


def test_asked_for_time_by_time(post, blocks):
    """The library carries derivatives as long as they are asked for."""
    from signorom_post.library import NO_ANSWER, OK, doubles, text_of

    steps = random_steps(np.random.default_rng(1), 3)
    with post.Model(blocks) as model:
        gradient = walk(model, {"P": 4.0, "mu": 0.4}, steps, []).gradient
        library, given = model._library, np.array([4.0, 0.4])
        forces = np.zeros_like(gradient.multipliers)
        with model._handles.context() as context:
            for is_skipped in (False, True):
                assert library.signorom_start(context, doubles(given)) == OK
                for k, (time, *tables) in enumerate(steps):
                    assert library.signorom_advance(context, time, doubles(np.array(tables)), None) == OK
                    if k == 1 and is_skipped:
                        continue
                    n_grazing = c_int()
                    code = library.signorom_differentiate(context, 1, byref(n_grazing), None)
                    assert code == (NO_ANSWER if k == 2 and is_skipped else OK)
                if is_skipped:
                    message = text_of(library.signorom_message(context))
                    assert "were not asked for at each time" in message
                    continue
                assert library.signorom_get_multiplier_gradient(context, doubles(forces)) == OK
                assert (forces == gradient.multipliers).all()
