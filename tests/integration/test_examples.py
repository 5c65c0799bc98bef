# SPDX-License-Identifier: BSD-3-Clause
"""The calibration example: its fit finds the values that the readings were made with, at its own noise."""

import os
import re
import subprocess
import sys

import numpy as np
import pytest
from scipy.stats import chi2

from runs import HERE

ROOT = HERE.parents[1]
N_STATES = 12
N_READINGS = N_STATES * 20


@pytest.fixture(scope="module")
def outcome(signorom, library, tmp_path_factory):
    """Folder and output of the example with fewer training points, load states and draws."""
    folder = tmp_path_factory.mktemp("calibration")
    for name in ("input", "meshes"):
        (folder / name).mkdir()
    (folder / "meshes" / "fuel_rod.msh").symlink_to(ROOT / "meshes" / "fuel_rod.msh")
    deck = (ROOT / "input" / "fuel_rod.yaml").read_text()
    deck = re.sub(r"(?m)^training: .*$", "training: {sobol: 40}", deck)
    (folder / "input" / "fuel_rod.yaml").write_text(deck)
    for command in ("sample", "train"):
        signorom(command, "input/fuel_rod.yaml", folder=folder)
    text = (ROOT / "input" / "calibration.py").read_text()
    for old, new in {"N_STATES = 30": f"N_STATES = {N_STATES}", "N_DRAWS = 3400": "N_DRAWS = 200"}.items():
        assert old in text
        text = text.replace(old, new)
    (folder / "input" / "calibration.py").write_text(text)
    done = subprocess.run(
        [sys.executable, "input/calibration.py"],
        cwd=folder,
        env=os.environ
        | {
            "MPLBACKEND": "Agg",
            "SIGNOROM_EXECUTABLE": str(signorom.executable),
            "SIGNOROM_LIBRARY": str(library),
            "PYTHONPATH": str(ROOT / "tools" / "signorom_post" / "src"),
        },
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return folder, done.stdout


def test_fit_finds_the_true_values(outcome):
    """Within 4 deviations; the interval of the fit is 2 * 1.96 of them, and that of Monte Carlo is nearly the same."""
    _, said = outcome
    rows = dict(re.findall(r"(?m)^(gap|E_cladding|nu_cladding) +(.*)$", said))
    assert len(rows) == 3
    for row in rows.values():
        truth, fitted, low, high, drawn_low, drawn_high = map(float, row.split())
        deviation = (high - low) / (2 * 1.96)
        assert abs(fitted - truth) <= 4 * deviation
        # a quantile of some hundred weighted draws is good to half a deviation
        assert abs(drawn_low - low) <= deviation
        assert abs(drawn_high - high) <= deviation
        # known to a few per cent: the readings tell all three apart
        assert deviation <= 0.05 * truth


def test_what_is_left_is_noise(outcome):
    """The sum of squares is one of chi-squared, but for three fitted values; one run in 10 000 is beyond."""
    _, said = outcome
    misfit = float(re.search(r"misfit per reading: (\S+)", said).group(1))
    low, high = chi2.ppf([5e-5, 1 - 5e-5], N_READINGS - 3)
    assert np.sqrt(low / N_READINGS) <= misfit <= np.sqrt(high / N_READINGS)


def test_derivatives_lead_to_the_fit(outcome):
    """Newton's steps: a handful from the middle of the ranges, where wrong derivatives take many or stop short."""
    _, said = outcome
    assert int(re.search(r"fit: (\d+) evaluations", said).group(1)) <= 12


def test_pictures(outcome):
    """Three, none of them empty."""
    folder, _ = outcome
    for name in ("readings", "unknowns", "contact_force"):
        assert (folder / "results" / "calibration" / f"{name}.png").stat().st_size > 10000
