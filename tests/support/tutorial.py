# SPDX-License-Identifier: BSD-3-Clause
"""The parts of input/TUTORIAL.md, done as a user does them: files and commands, one after the other, in an empty folder.

Each part is done once, by the file of tests that also asks what its results mean.
"""

import os
import re
import subprocess
import sys

import pytest

from program import ROOT, is_sanitized

TEXT = (ROOT / "input" / "TUTORIAL.md").read_text()
BLOCK = re.compile(r"(?ms)^```(\w+)\n(.*?)^```$")
#: part -> its headline
HEADLINES = {
    "clip": "A clip over its base, in the plane",
    "jaw": "A jaw from a STEP file, in space",
    "press_fit_pull": "A shaft pulled out of its hub: friction and histories",
    "bolted_joint": "A bolted joint that is sheared: tied surfaces and hysteresis",
    "pcmi": "A fuel rod in two cycles of power: plasticity and creep",
    "clamp_creep": "A hot bolt that loses its force: creep in space",
}
# [s] for one command, on a busy machine
SOON = 600


def blocks_of(part):
    """Returns the kinds and texts of the blocks of a part."""
    section = TEXT.split(f"\n## {HEADLINES[part]}\n")[1]
    return BLOCK.findall(section.split("\n## ")[0])


def follow(part, program, folder):
    """Does a part in an empty folder, where its results then are: what each command says, by its text.

    With sanitizers in the program, signorom-post cannot load the library: its commands are left out.
    """
    environment = os.environ | environment_of(program, folder)
    outputs = {}
    for kind, text in blocks_of(part):
        if kind in ("geo", "yaml"):
            (name,) = re.findall(r"^(?:#|//) ([\w.]+)", text)
            (folder / name).write_text(text)
            continue
        for command in text.splitlines() if kind == "sh" else [text]:
            if command.startswith("signorom-post") and is_sanitized(program.executable):
                continue
            words = [sys.executable, "-c", command] if kind == "python" else ["sh", "-c", command]
            done = subprocess.run(
                words, cwd=folder, env=environment, capture_output=True, text=True, timeout=SOON, check=False
            )
            assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
            outputs[command] = done.stdout + done.stderr
    return outputs


def part_fixture(part):
    """Returns a fixture that does a part once: what its commands say, and the folder of all results."""

    @pytest.fixture(scope="module")
    def followed(signorom, tmp_path_factory):
        folder = tmp_path_factory.mktemp(part)
        return follow(part, signorom, folder), folder / "results"

    return followed


def environment_of(program, folder):
    """Returns the variables with which `signorom` and `signorom-post` are those under test."""
    programs = folder.with_name(folder.name + "_programs")
    programs.mkdir()
    (programs / "signorom").symlink_to(program.executable)
    post = programs / "signorom-post"
    post.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m signorom_post "$@"\n')
    post.chmod(0o755)
    return {
        "CLONE": str(ROOT),
        "PATH": f"{programs}:{os.environ['PATH']}",
        "PYTHONPATH": str(ROOT / "tools" / "signorom_post" / "src"),
        "SIGNOROM_LIBRARY": str(program.executable.parent / "src" / "online" / "libsignorom_online.so"),
        "MPLBACKEND": "Agg",
        "OMPI_ALLOW_RUN_AS_ROOT": "1",
        "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
        "OMPI_MCA_rmaps_base_oversubscribe": "1",
    }


def check_verdicts(outputs):
    """Every `run` says that forces and fields are accepted; where materials flow, whole histories are judged."""
    runs = [text for command, text in outputs.items() if " run " in command]
    assert runs
    for text in runs:
        assert re.search(
            r"forces accepted: p95 of (e_lambda_all|the largest error of forces in a history) is", text
        )
        assert re.search(
            r"fields accepted: p95 of (e_u_energy_relative|the largest error of displacements in a history) is",
            text,
        )


def check_pictures(program, results, *names):
    """All of them are there; skips the test where signorom-post could not run."""
    if is_sanitized(program.executable):
        pytest.skip("signorom-post cannot load a library with sanitizers")
    for name in names:
        assert (results / name).exists(), name
