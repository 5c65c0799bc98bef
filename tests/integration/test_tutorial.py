# SPDX-License-Identifier: BSD-3-Clause
"""The tutorial, as a user does it: files and commands of input/TUTORIAL.md in an empty folder, one after the other."""

import os
import re
import shutil
import subprocess
import sys

import numpy as np
import pytest

from program import ROOT
from results import read_table

BLOCK = re.compile(r"(?ms)^```(\w+)\n(.*?)^```$")
# [s] gmsh and some hundred full-order points of a few thousand unknowns
SOON = 300


pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(shutil.which("gmsh") is None, reason="gmsh is not installed"),
]


@pytest.fixture(scope="module")
def said(signorom, library, tmp_path_factory):
    """What each command of the tutorial says, by its text, and the folder."""
    folder = tmp_path_factory.mktemp("tutorial")
    programs = tmp_path_factory.mktemp("programs")
    (programs / "signorom").symlink_to(signorom.executable)
    post = programs / "signorom-post"
    post.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m signorom_post "$@"\n')
    post.chmod(0o755)
    environment = os.environ | {
        "CLONE": str(ROOT),
        "PATH": f"{programs}:{os.environ['PATH']}",
        "PYTHONPATH": str(ROOT / "tools" / "signorom_post" / "src"),
        "SIGNOROM_LIBRARY": str(library),
        "MPLBACKEND": "Agg",
        "OMPI_ALLOW_RUN_AS_ROOT": "1",
        "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
        "OMPI_MCA_rmaps_base_oversubscribe": "1",
    }
    outputs = {}
    for kind, text in BLOCK.findall((ROOT / "input" / "TUTORIAL.md").read_text()):
        if kind in ("geo", "yaml"):
            (name,) = re.findall(r"^(?:#|//) ([\w.]+)", text)
            (folder / name).write_text(text)
            continue
        commands = text.splitlines() if kind == "sh" else [text]
        for command in commands:
            words = [sys.executable, "-c", command] if kind == "python" else ["sh", "-c", command]
            done = subprocess.run(
                words, cwd=folder, env=environment, capture_output=True, text=True, timeout=SOON, check=False
            )
            assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
            outputs[command] = done.stdout + done.stderr
    return outputs, folder


def test_every_command_succeeds(said):
    """In the plane, in space, with friction, and where materials flow."""
    outputs, folder = said
    assert len(outputs) >= 45
    for name in ("clip", "jaw"):
        assert (folder / "results" / name / "model.h5").exists()
        assert (folder / "results" / name / "figures" / "check_bodies.png").exists()
        assert (folder / "results" / name / "figures" / "initial_and_deformed.png").exists()


def test_models_are_accepted(said):
    """The verdict that the tutorial explains."""
    outputs, _ = said
    for command, text in outputs.items():
        if " run " in command:
            # where materials flow, whole histories are judged
            assert re.search(
                r"forces accepted: p95 of (e_lambda_all|the largest error of forces in a history) is", text
            )
            assert re.search(
                r"fields accepted: p95 of (e_u_energy_relative|the largest error of displacements in a history) is",
                text,
            )


def test_words_of_the_tutorial_are_said(said):
    """What the tutorial quotes of `check`."""
    outputs, _ = said
    clip = outputs["signorom check clip.yaml --fields"]
    assert "contact[1]: clip_face - base_face" in clip
    assert "gaps 0.1 to 0.1 mm" in clip
    assert "note: contact[1]: mortar, because" in clip
    assert (
        "only contact holds the body 'jaw' (translation in z)" in outputs["signorom check jaw.yaml --fields"]
    )


def test_init_found_the_contacts(said):
    """Of both parts, before the decks were filled in."""
    outputs, _ = said
    for name in ("clip", "jaw"):
        assert "1 contact guessed" in outputs[f"signorom init {name}.msh"]


def test_history_of_the_tutorial(said):
    """Numbers and pictures that it names: the shaft that is pulled out."""
    outputs, folder = said
    checked = outputs["signorom check $CLONE/input/press_fit_pull.yaml --fields"]
    assert "440 training, 220 test; 44 times of each point are counted" in checked
    results = folder / "results" / "press_fit_pull"
    last = {name: values[-1] for name, values in read_table(results / "history.csv").items()}
    assert f"{last['contact_1_force_z']:.0f}" == "23396"
    assert last["contact_1_slip_share"] == pytest.approx(1)
    for name in ("hysteresis.png", "stick_slip.png", "animation.gif"):
        assert (results / "figures" / name).exists()
    assert (folder / "results" / "cycle" / "figures" / "hysteresis.png").exists()
    force = read_table(folder / "results" / "cycle" / "history.csv")["contact_1_force_z"]
    assert -force.min() > 1.1 * force.max()


def test_cycles_of_the_tutorial(said):
    """Numbers and pictures that it names: the bolted joint."""
    outputs, folder = said
    assert (
        "only contact holds the body 'bolt'"
        in outputs["signorom check $CLONE/input/bolted_joint.yaml --fields"]
    )
    results = folder / "results" / "bolted_joint"
    for name in ("figures/hysteresis.png", "figures/stick_slip.png", "head/hysteresis.png"):
        assert (results / name).exists()
    table = read_table(folder / "results" / "shear" / "history.csv")
    assert f"{table['contact_1_force_z'][-1]:.0f}" == "1709"
    assert f"{-table['contact_1_force_x'][-1]:.0f}" == "205"
    assert f"{-table['contact_2_force_x'][-1]:.0f}" == "205"
    first, second = (table["contact_1_force_x"][np.isclose(table["time"], time)] for time in (6, 10))
    assert second == pytest.approx(first, rel=1e-6)
    assert (folder / "results" / "shear" / "figures" / "hysteresis.png").exists()


def test_cycles_of_power_of_the_tutorial(said):
    """Numbers and pictures that it names: the fuel rod."""
    outputs, folder = said
    trained = outputs["signorom run $CLONE/input/pcmi.yaml"]
    assert re.search(r"inelastic strains: \d+ modes, \d+ of 144 integration points", trained)
    assert "5 training histories: largest estimate of 100 candidates" in trained
    assert re.search(
        r"selected \d+ points by audit, tolerance 0.01, max_points 12: ended by tolerance", trained
    )
    assert "strains accepted" in trained
    results = folder / "results" / "pcmi"
    for name in ("histories.png", "errors_over_time.png", "animation.gif"):
        assert (results / "figures" / name).exists()
    table = read_table(results / "history.csv")
    force = {
        time: abs(table["contact_1_force_r"][np.isclose(table["time"], time)][0]) for time in (12, 60, 66, 72)
    }
    assert [f"{value:.0f}" for value in force.values()] == ["7563", "4771", "0", "4809"]
    assert force[12] == -table["contact_1_force_r"].min()
    slow = read_table(folder / "results" / "slow" / "history.csv")
    assert -slow["contact_1_force_r"].min() == pytest.approx(6890, rel=2e-3)
    assert (folder / "results" / "slow" / "figures" / "histories.png").exists()


def test_bolt_of_the_tutorial(said):
    """Numbers and pictures that it names: the bolt that creeps, and is tightened again."""
    _, folder = said
    results = folder / "results" / "clamp_creep"
    for name in ("hysteresis.png", "check_bodies.png"):
        assert (results / "figures" / name).exists()
    table = read_table(results / "history.csv")
    at = table["contact_2_force_z"][np.isclose(table["time"], 1000)]
    assert [f"{value:.0f}" for value in (table["contact_2_force_z"][0], *at)] == ["4911", "2941", "2336"]
    again = read_table(folder / "results" / "again" / "history.csv")
    at = [again["contact_2_force_z"][np.isclose(again["time"], time)][0] for time in (500, 502, 1000)]
    assert at == pytest.approx([3060, 4510, 3060], rel=3e-3)
    assert again["error_estimate"][-1] < 0.005
    assert (folder / "results" / "again" / "figures" / "histories.png").exists()
