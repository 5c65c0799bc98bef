# SPDX-License-Identifier: BSD-3-Clause
"""The manual page and the completion of bash have what --help has, and the completion works."""

import re
import subprocess

import pytest


@pytest.fixture(scope="module")
def app(signorom):
    """Folder that the build writes both into."""
    return signorom.executable.parent / "src" / "app"


@pytest.fixture(scope="module")
def help_text(signorom, tmp_path_factory):
    return signorom("--help", folder=tmp_path_factory.mktemp("help"))


def complete(app, folder, *words):
    """What bash offers for the last word of a command line."""
    quoted = " ".join(f"'{word}'" for word in words)
    script = (
        f"source {app / 'signorom.bash'}; COMP_WORDS=({quoted}); COMP_CWORD={len(words) - 1}; _signorom; "
    )
    script += 'printf "%s\\n" "${COMPREPLY[@]}"'
    done = subprocess.run(
        ["bash", "--norc", "-c", script], cwd=folder, capture_output=True, text=True, check=True
    )
    assert done.stderr == ""
    return sorted(filter(None, done.stdout.split("\n")))


def test_manual_page_has_every_command_option_and_exit_code(app, help_text):
    page = (app / "signorom.1").read_text().replace("\\", "")
    named = re.findall(r"(?m)^  (--[\w-]+|[a-z]+(?= [A-Z]{4})|\d+)\b", help_text)
    assert {"predict", "--threads", "130"} <= set(named)
    for name in named:
        assert re.search(rf"(?m)^\.BI? {name}\b", page), name


def test_first_word_is_a_command(app, tmp_path, help_text):
    commands = re.findall(r"(?m)^  ([a-z]+) [A-Z]{4}", help_text)
    assert complete(app, tmp_path, "signorom", "") == sorted([*commands, "--help", "--version"])
    assert complete(app, tmp_path, "signorom", "va") == ["validate"]
    assert complete(app, tmp_path, "build/release/signorom", "va") == ["validate"]


def test_files_of_the_kind_and_options_of_the_command_follow(app, tmp_path):
    for name in ("my part.yaml", "part.msh", "model.h5", "points.csv", "notes.txt"):
        (tmp_path / name).touch()
    (tmp_path / "results").mkdir()
    assert complete(app, tmp_path, "signorom", "run", "my") == ["my part.yaml"]
    assert complete(app, tmp_path, "signorom", "init", "p") == ["part.msh"]
    assert complete(app, tmp_path, "signorom", "describe", "r") == ["results"]
    assert complete(app, tmp_path, "signorom", "predict", "model.h5", "--points", "p") == ["points.csv"]
    assert complete(app, tmp_path, "signorom", "predict", "model.h5", "--t") == ["--threads"]
    assert complete(app, tmp_path, "signorom", "train", "a.yaml", "--t") == []
    assert complete(app, tmp_path, "signorom", "solve", "a.yaml", "--log", "n") == ["notes.txt"]
    assert complete(app, tmp_path, "signorom", "solve", "a.yaml", "--at", "n") == []
