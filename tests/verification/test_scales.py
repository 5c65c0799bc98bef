# SPDX-License-Identifier: BSD-3-Clause
"""Every deck with all lengths and all forces a million times larger or smaller: the same answers, words and verdicts."""

import re

import h5py
import numpy as np
import pytest

from results import read_table
from runs import HERE, INPUT, read_report
from scaled_decks import Scales, write_scaled_deck

UNSCALED = Scales(1.0, 1.0)
# together they change energies as well as compliances
SCALES = [Scales(length, force) for length in (1e6, 1e-6) for force in (1e6, 1e-6)]
# [-] of the largest value of a field; fields of a model may be in single precision; errors are relative already
SAME_FORCE, SAME_FIELD, SAME_MODEL, SAME_ERROR = 1e-10, 1e-9, 1e-6, 1e-6
# models of materials that flow look at chosen points, and rounding decides between points that serve equally well:
# a tenth of reduction.inelastic_tolerance
SAME_INELASTIC = 1e-3
FORCES = ("multipliers_full_order", "contact_force")
# what depends on the time of day, on the speed of the machine or on the numbers themselves
# [s] of one run of the largest deck on a busy machine
TIME_LIMIT = 3600
RESULTS = ("solver", "full_order", "error_bound", "displacement_bound")
NOT_COMPARED = {
    "version",
    "deck",
    "provenance",
    "run",
    "times",
    "seconds",
    "residuals",
    "point",
    "largest_at",
}


class Outcome:
    """What a run said and wrote."""

    def __init__(self, signorom, source, folder, scales, changes):
        """Runs a scaled deck in a new folder: `run` if it has training points, else `solve`."""
        folder.mkdir()
        deck = write_scaled_deck(source, folder, scales, changes)
        command = "run" if "training:" in deck.read_text() else "solve"
        done = signorom.run(command, deck.name, folder=folder, time_limit=TIME_LIMIT)
        self.code = done.returncode
        self.words = words_of(done.stdout + done.stderr)
        self.results = folder / "results" / source.stem
        self.report = read_report(folder, source.stem) if self.code == 0 else {}

    def table(self):
        """Returns the columns of validation.csv."""
        path = self.results / "validation.csv"
        return read_table(path) if path.is_file() else {}

    def stiffness(self):
        """Returns the largest Young's modulus that is a number."""
        moduli = [entry["young_modulus"] for entry in self.report["deck"]["materials"].values()]
        return max([value for value in moduli if isinstance(value, float)], default=0.0)

    def is_inelastic(self):
        """Returns whether the model is one of materials that flow."""
        return self.report.get("reduction", {}).get("kind") == "inelastic"

    def fields(self):
        """Returns the datasets of all output points: name -> (values, unit)."""
        found = {}
        if not (self.results / "fields.h5").is_file():
            return found
        with h5py.File(self.results / "fields.h5") as file:
            for point, group in file["points"].items():
                found |= {
                    f"{point}/{name}": (data[()], data.attrs.get("unit", "-")) for name, data in group.items()
                }
        return found


def without_numbers(text):
    """Returns a text with # for its numbers and single blanks."""
    return " ".join(re.sub(r"(?<![A-Za-z_\[])[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?(?!\w)", "#", text).split())


def words_of(text):
    """Returns the lines of a run without their numbers, but for those that tell times and progress."""
    lines = [
        line for line in text.splitlines() if not re.search(r"\d (?:s|min|MB)\b|\d+ of \d+$|\d %$", line)
    ]
    return [without_numbers(line) for line in lines]


def differences(found, expected, scales):
    """Returns texts that say in what two outcomes differ."""
    if found.code != expected.code or not found.report:
        return [f"exit code {found.code}, not {expected.code}: {found.words[-3:]}"]
    texts = []
    if found.words != expected.words:
        texts += [f"said: {line}" for line in found.words if line not in expected.words]
        texts += [f"not said: {line}" for line in expected.words if line not in found.words]
    texts += report_differences(found.report, expected.report, "")
    inelastic = SAME_INELASTIC if expected.is_inelastic() else 0.0
    texts += table_differences(found.table(), expected.table(), inelastic)
    return texts + field_differences(
        found.fields(), expected.fields(), scales, expected.stiffness(), max(SAME_MODEL, inelastic)
    )


def report_differences(found, expected, place):
    """Compares the words and the counts of two reports."""
    if isinstance(expected, dict) and isinstance(found, dict):
        texts = [f"report{place}: keys {set(found) ^ set(expected)}"] if set(found) != set(expected) else []
        for key in (key for key in expected if key in found and key not in NOT_COMPARED):
            texts += report_differences(found[key], expected[key], f"{place}.{key}")
        return texts
    if isinstance(expected, list) and isinstance(found, list) and len(expected) == len(found):
        return [
            text for a, b in zip(found, expected, strict=True) for text in report_differences(a, b, place)
        ]
    if isinstance(expected, str) and isinstance(found, str):
        found, expected = without_numbers(found), without_numbers(expected)
    if isinstance(expected, float) and isinstance(found, float):
        return []
    return [] if found == expected else [f"report{place}: {found}, not {expected}"]


def table_differences(found, expected, inelastic):
    """Compares counts, words and relative errors at the test points; not energies, which have a unit, nor the points.

    `inelastic`: by how much errors of models of materials that flow may differ.
    """
    texts = []
    for name, values in expected.items():
        if name in ("e_energy", "e_energy_rid", "e_u_energy") or (
            name not in RESULTS and name[:2] not in ("e_", "n_")
        ):
            continue
        # energies of bodies that move as a whole are rounding, and so are their relative errors
        allowed = 1e-2 if name.startswith("e_energy") else 0.0 if name[:2] == "n_" else SAME_ERROR
        allowed = max(allowed, inelastic if name[:2] == "e_" else 0.0)
        pairs = [(a, b) for a, b in zip(found[name], values, strict=True) if not is_same(a, b, allowed)]
        if pairs:
            texts.append(f"{name} differs at {len(pairs)} of {len(values)} test points, as by {pairs[0]}")
    return texts


def is_same(found, expected, allowed):
    """Returns whether two words, counts or relative errors are the same; errors may differ by 1 % or `allowed`."""
    try:
        found, expected = float(found), float(expected)
    except ValueError:
        return found == expected
    return np.isclose(found, expected, rtol=1e-2 if allowed else 0, atol=allowed, equal_nan=True)


def field_differences(found, expected, scales, stiffness, same_model):
    """Compares the fields at the output points.

    What gaps and stresses come from is larger than they are: displacements, and rounding of them times the stiffness.
    """
    texts = []
    for name, (values, unit) in expected.items():
        if name not in found:
            texts.append(f"no field {name}")
            continue
        scaled = found[name][0] / scales.of(unit)
        if not np.array_equal(np.isnan(scaled), np.isnan(values)):
            texts.append(f"{name} has other values that are no numbers")
            continue
        size = np.nanmax(np.abs(values), initial=0.0)
        if name.endswith("gap"):
            size = max(size, np.abs(expected[name.replace("gap", "displacement")][0]).max())
        if "stress" in name or "mises" in name:
            size = max(size, 1e-6 * stiffness)
        if "strain" in name:
            size = max(size, 1e-6)
        change = np.nanmax(np.abs(scaled - values), initial=0.0)
        allowed = SAME_FORCE if name.endswith(FORCES) else same_model if "reduced" in name else SAME_FIELD
        if change > (0 if np.issubdtype(values.dtype, np.integer) else allowed) * size:
            texts.append(f"{name} differs by {change / size if size else np.inf:.2g}")
    return texts


def compare(signorom, source, folder, all_scales=SCALES, changes=None):
    """Runs a deck as it stands and scaled, and returns what differs."""
    expected = Outcome(signorom, source, folder / "unscaled", UNSCALED, changes)
    texts = []
    for scales in all_scales:
        name = f"length_{scales.length:g}_force_{scales.force:g}"
        found = Outcome(signorom, source, folder / name, scales, changes)
        texts += [f"{name}: {text}" for text in differences(found, expected, scales)]
    return texts


# Cheap to solve, and every kind of trouble: bodies that contact alone holds, interference, points without load, modes.
# The bracket keeps its training points: pivot transforms of the default model come from many sets.
SMALL = {
    "input/bracket": {"test": {"sobol": 40, "seed": 1}},
    "input/shrink_fit": {},
    "input/punch": {"test": {"grid": {"depth": 4}}},
    "verification/full_basis": {
        "training": {"grid": {"left": 3, "right": 3}},
        "test": {"grid": {"left": 4, "right": 3}},
    },
}
OPPOSITE = [Scales(1e6, 1e-6), Scales(1e-6, 1e6)]
FOLDERS = {"input": INPUT, "verification": HERE / "decks"}
ALL = [f"{folder}/{deck.stem}" for folder, path in FOLDERS.items() for deck in sorted(path.glob("*.yaml"))]
# the tests that use these decks make their meshes
WITHOUT_MESH = (
    "patch_models",
    "quarter_rings",
    "rigid_plane",
    "rigid_sphere",
    "thick_cylinder",
    "random_loads",
)


def path_of(name):
    """Returns the path of a deck such as input/bracket."""
    folder, stem = name.split("/")
    return FOLDERS[folder] / f"{stem}.yaml"


@pytest.mark.parametrize("name", SMALL)
def test_small_decks(signorom, tmp_path, name):
    """Lengths a million times larger and forces a million times smaller, and the other way round."""
    texts = compare(signorom, path_of(name), tmp_path, OPPOSITE, SMALL[name])
    assert not texts, "\n".join(texts)


# 2650 contact rows: minutes of training at any number of points
LARGE = {"input/flange": {"training": {"sobol": 20}, "test": {"sobol": 5, "seed": 1}}}


@pytest.mark.long
@pytest.mark.parametrize(
    "name", [name for name in ALL if name not in LARGE and not name.endswith(WITHOUT_MESH)]
)
def test_all_decks(signorom, tmp_path, name):
    """All decks whose mesh is there, with all their training points, in all four scales: half an hour of one core."""
    texts = compare(signorom, path_of(name), tmp_path, SCALES, {"test": points_of(path_of(name))})
    assert not texts, "\n".join(texts)


@pytest.mark.long
@pytest.mark.parametrize("name", LARGE)
def test_large_decks(signorom, tmp_path, name):
    """Fewer points, and two scales."""
    texts = compare(signorom, path_of(name), tmp_path, OPPOSITE, LARGE[name])
    assert not texts, "\n".join(texts)


def points_of(path):
    """Returns 30 test points of a deck, or None if it has no training."""
    return {"sobol": 30, "seed": 1} if "training:" in path.read_text() else None
