# SPDX-License-Identifier: BSD-3-Clause
"""tools/install_dependencies.sh with an apt-get that installs nothing: what a user sees of it."""

import os
import shutil
import subprocess

import pytest

from program import ROOT

NOISE = "update-alternatives: error: no alternatives for libmpi"
FAKES = {
    # installed as soon as apt-get was there
    "dpkg-query": "test -e installed && echo installed",
    "apt-get": f'echo "{NOISE}"; echo "{NOISE}" >&2; case "$*" in *install*) $END;; esac',
    "id": "echo 0",
    "gcc": "echo no-such-machine",
}


@pytest.fixture
def clone(tmp_path):
    """A folder with the script, an environment that needs nothing, and the programs that it calls."""
    (tmp_path / "tools").mkdir()
    for name in ("common.sh", "install_dependencies.sh", "requirements-test.txt"):
        shutil.copy(ROOT / "tools" / name, tmp_path / "tools")
    (tmp_path / "tools" / "signorom_post").mkdir()
    shutil.copy(ROOT / "tools" / "signorom_post" / "pyproject.toml", tmp_path / "tools" / "signorom_post")
    programs = tmp_path / "programs"
    environment = tmp_path / "build" / "venv" / "bin"
    environment.mkdir(parents=True)
    programs.mkdir()
    for path, text in ((programs, FAKES), (environment, {"signorom-post": ""})):
        for name, line in text.items():
            (path / name).write_text(f"#!/bin/sh\n{line}\n")
            (path / name).chmod(0o755)
    (environment.parent / "signorom-requirements").write_text("-r\n")
    return tmp_path


def install(clone, end):
    """Run the script; apt-get ends with this command."""
    environment = os.environ | {"PATH": f"{clone / 'programs'}:{os.environ['PATH']}", "END": end}
    command = ["bash", clone / "tools" / "install_dependencies.sh"]
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=False)


def test_what_apt_says_goes_to_a_file(clone):
    done = install(clone, "touch installed")
    assert done.returncode == 0, done.stderr
    assert "Debian packages to install: gcc gfortran cmake" in done.stdout
    assert NOISE not in done.stdout + done.stderr
    assert NOISE in (clone / "build" / "apt.log").read_text()


def test_it_is_shown_where_apt_fails(clone):
    done = install(clone, "exit 100")
    assert done.returncode == 1
    assert NOISE in done.stderr
    assert "apt-get failed (see above)." in done.stderr
