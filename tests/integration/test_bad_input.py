# SPDX-License-Identifier: BSD-3-Clause
"""Bad decks, meshes, pairs and parameter points end at once, on all ranks, with exit code 2 and a sentence."""

import re

import pytest

from runs import HERE, refuse, write_deck

# Every rank must leave when one finds an error.
pytestmark = pytest.mark.parametrize(("command", "n_ranks"), [("check", 1), ("run", 3)])


def test_no_such_deck(signorom, tmp_path, command, n_ranks):
    words = refuse(signorom, command, "nothing.yaml", folder=tmp_path, n_ranks=n_ranks)
    assert words.startswith("nothing.yaml: error: ")
    assert "no such file" in words.lower()


def test_directory_as_deck(signorom, tmp_path, command, n_ranks):
    words = refuse(signorom, command, tmp_path, folder=tmp_path, n_ranks=n_ranks)
    assert words.startswith(f"{tmp_path}: error: ")
    assert "directory" in words or "folder" in words


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "empty"),
        (b" \n\t\n", "empty"),
        (bytes(range(256)) * 20, "binary|text"),
        (b"\x89HDF\r\n\x1a\n\x00\x00\x00", "binary|text"),
        (b"title: caf\xe9\n", "UTF-8"),
        (b"title: a\n\tmesh: b\n", "tab"),
    ],
    ids=["empty", "blank", "binary", "hdf5", "latin_1", "tab"],
)
def test_file_that_is_no_deck(signorom, tmp_path, command, n_ranks, content, message):
    (tmp_path / "bad.yaml").write_bytes(content)
    words = refuse(signorom, command, "bad.yaml", folder=tmp_path, n_ranks=n_ranks)
    assert words.startswith("bad.yaml:")
    assert any(part in words for part in message.split("|")), words


CHANGES = {
    "missing_region": ({"lower, upper": "lower"}, ["lacks|no material|belong", "upper"]),
    "region_that_the_mesh_lacks": (
        {"lower, upper": "lower, uper"},
        [
            "patch.yaml:6:28: error: the mesh has no region 'uper'; it has lower, upper",
            "did you mean 'upper'?",
        ],
    ),
    "boundary_that_the_mesh_lacks": (
        {"boundary: bottom,": "boundary: botom,"},
        ["patch.yaml:8:16: error: ", "'botom'", "top", "left sides", "did you mean 'bottom'?"],
    ),
    "surface_that_the_mesh_lacks": (
        {"second: upper_face": "second: upperface"},
        ["patch.yaml:12:33: error: ", "'upperface'", "lower_face", "did you mean 'upper_face'?"],
    ),
    "boundary_with_exact_displacements": (
        {"{method: hhr}": "{displacement: {boundaries: [topp]}}"},
        ["patch.yaml:17:41: error: ", "'topp'", "did you mean 'top'?"],
    ),
    "points_as_contact_surface": (
        {"second: upper_face": "second: top_left"},
        ["patch.yaml:12:33: error: 'top_left' of the mesh is no surface"],
    ),
    "contact_with_itself_by_another_name": (
        {"second: upper_face": "second: faces"},
        ["patch.yaml:12:", "face"],
    ),
    "surfaces_that_do_not_face_each_other": (
        {"second: upper_face": "second: left sides"},
        ["patch.yaml:12:", "face"],
    ),
    "direction_that_points_away": (
        {"direction: [0, 1]": "direction: [0, -1]"},
        ["patch.yaml:12:", "direction"],
    ),
    "direction_along_the_surface": (
        {"direction: [0, 1]": "direction: [1, 0]"},
        ["patch.yaml:12:"],
    ),
    "mesh_with_shifted_nodes": (
        {
            "two_blocks.msh": "invalid/not_facing.msh",
            "direction: [0, 1]": "direction: [0, 1], formulation: node_to_node",
        },
        ["patch.yaml:12:", "node"],
    ),
    "mesh_of_another_dimension": (
        {"two_blocks.msh": "cube.msh"},
        ["cube.msh: error: the model needs a mesh of dimension 2", "of its elements is 3"],
    ),
    "plane_mesh_in_a_solid_model": (
        {"plane_strain": "solid", "direction: [0, 1]": "direction: [0, 0, 1]"},
        ["two_blocks.msh: error: the model needs a mesh of dimension 3", "of its elements is 2"],
    ),
    "mesh_behind_the_axis": (
        {
            "two_blocks.msh": "small_disks.msh",
            "plane_strain": "axisymmetric",
            "displacement: {y: 0}": "displacement: {z: 0}",
            "displacement: {y: -push}": "displacement: {z: -push}",
            "displacement: {x: 0}": "displacement: {r: 0}",
        },
        ["small_disks.msh: error: node ", "has x = -1", "must not be negative"],
    ),
    "mesh_that_is_missing": (
        {"two_blocks.msh": "nothing.msh"},
        ["patch.yaml:3:14: error: cannot read the mesh file", "nothing.msh", "o such file"],
    ),
    "mesh_that_is_a_directory": (
        {"two_blocks.msh": "invalid"},
        ["patch.yaml:3:14: error: cannot read the mesh file", "invalid", "directory|folder"],
    ),
    "mesh_that_is_no_mesh": (
        {"two_blocks.msh": "make_meshes.sh"},
        ["make_meshes.sh", "gmsh"],
    ),
    "truncated_mesh": (
        {"two_blocks.msh": "invalid/truncated.msh"},
        ["truncated.msh:", "end"],
    ),
    "truncated_binary_mesh": (
        {"two_blocks.msh": "invalid/truncated_binary.msh"},
        ["truncated_binary.msh", "end"],
    ),
    "mesh_without_names": (
        {"two_blocks.msh": "two_blocks_without_names.msh"},
        ["patch.yaml:", "the mesh has no region", "it has surface_1, surface_2"],
    ),
    "mesh_of_third_order": (
        {"two_blocks.msh": "invalid/cubic.msh"},
        ["cubic.msh:", "4-node line", "Mesh.ElementOrder = 2"],
    ),
    "mesh_turned_out_of_the_plane": (
        {"two_blocks.msh": "invalid/not_in_plane.msh"},
        ["not_in_plane.msh", "plane"],
    ),
    "poisson_ratio_of_one_half": (
        {"poisson_ratio: 0": "poisson_ratio: 0.5"},
        ["patch.yaml:6:73: error: materials.block.poisson_ratio is 0.5; it must be less than 0.5"],
    ),
    "negative_young_modulus": (
        {"young_modulus: 2.0e6": "young_modulus: -2.0e6"},
        ["patch.yaml:6:51: error: materials.block.young_modulus", "greater than 0"],
    ),
    "empty_range": (
        {"min: 0.02": "min: 0.1"},
        ["patch.yaml:4:", "min"],
    ),
    "unknown_name": (
        {"y: -push": "y: -psh"},
        ["patch.yaml:9:39: error: ", "unknown name 'psh'", "did you mean 'push'?"],
    ),
    "division_by_zero": (
        {"y: -push": "y: -1/(push - 0.02)"},
        ["patch.yaml:9:39: error: ", "not finite", "push = 0.02 m"],
    ),
    "division_by_zero_at_a_grid_point": (
        {"y: -push": "y: -1/(push - 0.04)"},
        ["patch.yaml:9:39: error: ", "not finite", "push = 0.04 m"],
    ),
    "training_points_in_no_file": (
        {"grid: {push: 5}": "file: points.csv"},
        ["points.csv", "o such file"],
    ),
}


@pytest.mark.parametrize("name", CHANGES)
def test_changed_deck(signorom, tmp_path, command, n_ranks, name):
    replacements, expected = CHANGES[name]
    deck = write_deck("patch", tmp_path, **replacements)
    words = refuse(signorom, command, deck.name, folder=tmp_path, n_ranks=n_ranks)
    for alternatives in expected:
        assert any(part in words for part in alternatives.split("|")), words


def test_prescribed_displacements_that_penetrate(signorom, tmp_path, command, n_ranks):
    """The corners of the arcs are 2.1 m apart and prescribed on both sides, so no contact force can part them."""
    deck = write_deck("small_disks", tmp_path, **{"max: 0.45": "max: 1.1"})
    words = refuse(signorom, command, deck.name, folder=tmp_path, n_ranks=n_ranks)
    place, penetration = re.match(
        r"(\S+) error: .* nodes 1 and 16 .* surfaces (\S+) m into each other", words
    ).groups()
    assert place == "small_disks.yaml:11:13:"
    # squeeze = 1.1 m is the first of 15 grid points above 1.05 m
    assert "squeeze = 1.1 m" in words
    assert float(penetration) == pytest.approx(2 * 1.1 - 2.1, rel=1e-12)


def test_prescribed_displacements_that_just_touch(signorom, tmp_path, command, n_ranks):
    """A gap that closes exactly is no penetration, whatever the rounding."""
    deck = write_deck("small_disks", tmp_path, **{"max: 0.45": "max: 1.05", "{squeeze: 15}": "{squeeze: 2}"})
    signorom(command, deck.name, folder=tmp_path, n_ranks=n_ranks)


def test_all_errors_of_a_deck_at_once(signorom, tmp_path, command, n_ranks):
    deck = HERE / "decks" / "invalid" / "many_errors.yaml"
    words = refuse(signorom, command, deck, folder=tmp_path, n_ranks=n_ranks)
    lines = [line for line in words.splitlines() if line.startswith(str(deck))]
    assert [int(line.removeprefix(f"{deck}:").split(":")[0]) for line in lines] == [2, 4, 6, 11, 13]
