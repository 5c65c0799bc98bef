# SPDX-License-Identifier: BSD-3-Clause
"""Derivatives of models through random histories with friction, against differences of their own exact answers."""

import re
from itertools import pairwise

import numpy as np
import pytest

from friction_decks import LOOSE, N_TIMES, PLANE, SOLID, write_random_deck
from program import needs_library

# Steps of differences as shares of the box: one serves as long as no contact changes its state within it, and then
# rounding in the difference is 1e-7 of the derivative.
STEPS = 1e-2 * 4.0 ** -np.arange(9)
ALLOWED = 1e-6
# [N per unit of a parameter] what rounding of forces of about 1 N leaves of a derivative that is 0
ROUNDING = 1e-12
KINDS = {"held by friction": LOOSE} | PLANE | SOLID


def write_deck(folder, kind, friction, seed):
    """A random deck whose slide grows with a parameter, and whose model is trained at a few points."""
    deck = write_random_deck(folder, kind, friction, seed)
    text = deck.read_text()
    if not kind.is_loose:
        for table in re.findall(r"slide_[xy]: \{time: .*, value: \[(.*)\]\}", text):
            text = text.replace(table, ", ".join(f'"size * ({value})"' for value in table.split(", ")))
        text = text.replace("mu: {min: 0, max: 1.5}", "mu: {min: 0, max: 1.5}, size: {min: 0.5, max: 1.5}")
    else:
        # loads grow with mu, and turn a block over where it is large
        text = text.replace("mu: {min: 0, max: 1.5}", "mu: {min: 0.2, max: 0.4}")
    text = re.sub(r"(?m)^output:.*$", "training: {sobol: 2}", text)
    deck.write_text(text)
    return deck


def walk(model, given, times):
    """Forces at the last of the times, and their derivatives when they are wanted."""
    with model.start(**given) as history:
        for time in times:
            answer = history.advance(time, nodes=[])
    return answer


def difference(model, given, name, length, times):
    """By Richardson's extrapolation, of the two steps whose differences are closest."""
    slopes = []
    for step in STEPS * length:
        above, below = (walk(model, given | {name: given[name] + way}, times) for way in (step, -step))
        slopes.append((above.multipliers - below.multipliers) / (2 * step))
    pairs = [(np.linalg.norm(fine - rough), fine + (fine - rough) / 15) for rough, fine in pairwise(slopes)]
    return min(pairs, key=lambda pair: pair[0])[1]


@pytest.mark.parametrize("name", KINDS)
def test_random_histories(signorom, tmp_path, monkeypatch, figures, name):
    """Reversals, tilts, lifting, turns of the direction; coefficient of friction, and size of the slide."""
    library = signorom.executable.parent / "src" / "online" / "libsignorom_online.so"
    if needs_library(library, "libasan"):
        pytest.skip("a program without sanitizers cannot load a library with them")
    monkeypatch.setenv("SIGNOROM_LIBRARY", str(library))
    from signorom_post import Model

    worst, n_compared = 0.0, 0
    for seed in (1, 2, 3):
        print("seed", seed)
        random = np.random.default_rng(seed)
        folder = tmp_path / str(seed)
        folder.mkdir()
        deck = write_deck(folder, KINDS[name], 0.3, seed)
        for command in ("sample", "train"):
            signorom(command, deck, folder=folder)
        with Model(folder / "results" / deck.stem / "model.h5") as model:
            chosen = {"mu": random.uniform(0.2, 0.4), "size": random.uniform(0.6, 1.4)}
            given = {p.name: chosen[p.name] for p in model.parameters[: model.n_given]}
            times = model.times[: random.integers(4, 2 * N_TIMES - 3)]
            while not walk(model, given, times).multipliers.any():
                times = times[:-1]
            gradient = walk(model, given, times).gradient
            for i, parameter in enumerate(model.parameters[: model.n_given]):
                assert not gradient.is_one_sided[i]
                wanted = difference(
                    model, given, parameter.name, parameter.maximum - parameter.minimum, times
                )
                if np.abs(wanted).max() <= ROUNDING:
                    # all forces stay as they are: nothing has slipped, so that the coefficient of friction does not
                    # matter, or all contacts slip on, so that how far they slip does not
                    assert np.abs(gradient.multipliers[i]).max() <= ROUNDING
                    continue
                error = np.linalg.norm(gradient.multipliers[i] - wanted)
                worst = max(worst, error / np.linalg.norm(wanted))
                n_compared += 1
    assert n_compared >= 3
    quantity = f"derivatives of forces over the parameters, {n_compared} random histories"
    figures.at_most(f"random blocks, {name}", quantity, worst, ALLOWED, "differences of whole histories")
