# SPDX-License-Identifier: BSD-3-Clause
"""The first parts of the tutorial, in the plane and in space; verification.test_(friction|flow)_parts do the others."""

import shutil

import pytest

from tutorial import BLOCK, HEADLINES, TEXT, blocks_of, check_verdicts, follow

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(shutil.which("gmsh") is None, reason="gmsh is not installed"),
]


@pytest.fixture(scope="module", params=["clip", "jaw"])
def part(request):
    """Name of a part."""
    return request.param


@pytest.fixture(scope="module")
def said(signorom, library, part, tmp_path_factory):  # noqa: ARG001 without the library there are no pictures
    """What each command of the part says, by its text, and the folder."""
    folder = tmp_path_factory.mktemp(part)
    return follow(part, signorom, folder), folder


def test_no_command_is_left_out():
    """All commands stand in the parts, whose names other files of tests have too."""
    parts = [block for name in HEADLINES for block in blocks_of(name)]
    assert parts == BLOCK.findall(TEXT)
    assert sum(len(text.splitlines()) for kind, text in parts if kind == "sh") >= 40


def test_every_command_succeeds(said, part):
    """Up to the pictures."""
    _, folder = said
    assert (folder / "results" / part / "model.h5").exists()
    assert (folder / "results" / part / "figures" / "check_bodies.png").exists()
    assert (folder / "results" / part / "figures" / "initial_and_deformed.png").exists()


def test_models_are_accepted(said):
    """The verdict that the tutorial explains."""
    check_verdicts(said[0])


def test_words_of_the_tutorial_are_said(said, part):
    """What the tutorial quotes of `check`."""
    outputs, _ = said
    quoted = {
        "clip": [
            "contact[1]: clip_face - base_face",
            "gaps 0.1 to 0.1 mm",
            "note: contact[1]: mortar, because",
        ],
        "jaw": ["only contact holds the body 'jaw' (translation in z)"],
    }
    for words in quoted[part]:
        assert words in outputs[f"signorom check {part}.yaml --fields"]


def test_init_found_the_contacts(said, part):
    """Of the part, before the deck was filled in."""
    outputs, _ = said
    assert "1 contact guessed" in outputs[f"signorom init {part}.msh"]
