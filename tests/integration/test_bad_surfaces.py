# SPDX-License-Identifier: BSD-3-Clause
"""Contact surfaces that cannot be right: each is refused with the place in the deck, the surface and what to do."""

import re

import numpy as np
import pytest

from block_meshes import LINEAR, QUADRATIC, Mesh
from decks import write_held_blocks
from runs import refuse

FIRST, SECOND = 13, 33  # columns of the names in the deck
FACES = "first: lower_face, second: upper_face"


def blocks(n_dim=2, elements=("T3", "T3"), shift=0.0, gap=0.0):
    """Two blocks whose faces do not match, the upper one moved aside and up."""
    mesh, up = Mesh(), n_dim - 1
    for name, element, n, floor in zip(("lower", "upper"), elements, (3, 5), (-1.0, gap), strict=True):
        side = int(name == "lower")
        faces = {
            (up, side): f"{name}_face",
            (up, 1 - side): "bottom" if side else "top",
            (0, 0): f"{name}_left",
        }
        across = np.linspace(0, 1, n + 1)
        lines = [across + (0 if side else shift)] + [across] * (up - 1) + [np.linspace(floor, floor + 1, 3)]
        mesh.add_block(name, lines, LINEAR.get(element, element), faces)
        if element in QUADRATIC:
            mesh.make_quadratic(element, [name, *faces.values()])
    return mesh


def with_third(n_dim=2):
    """A third block on the upper one; `both` names the two sides of the interface below."""
    mesh = blocks(n_dim, ("T3", "T3") if n_dim == 2 else ("H8", "T4"))
    lines = [np.linspace(0, 1, 4)] * (n_dim - 1) + [np.linspace(1, 2, 3)]
    mesh.add_block(
        "upper", lines, "T3" if n_dim == 2 else "T4", {(n_dim - 1, 0): "third", (n_dim - 1, 1): "top"}
    )
    return named(mesh, "both", ("lower_face", "upper_face"))


def named(mesh, name, groups, chosen=slice(None)):
    """Some facets of groups get another name, too."""
    facets = [(kind, nodes) for kind, group, nodes in mesh.elements if group in groups]
    mesh.elements += [(kind, name, nodes) for kind, nodes in facets[chosen]]
    return mesh


def halves(n_dim=2):
    """`half` and `rest` share the nodes between them."""
    mesh = blocks(n_dim, ("T3", "T3") if n_dim == 2 else ("H8", "T4"))
    return named(named(mesh, "half", ("lower_face",), slice(2)), "rest", ("lower_face",), slice(2, None))


def with_lost_facet():
    """A facet that no cell has."""
    mesh = blocks()
    n = len(mesh.coordinates)
    mesh.coordinates = np.vstack([mesh.coordinates, [[8.0, 8.0, 0.0], [9.0, 8.0, 0.0]]])
    mesh.elements.append(("L2", "lost", [n, n + 1]))
    return mesh


def without_middles(face, n_dim):
    """Quadratic cells under facets that have corners only."""
    mesh = blocks(n_dim, ("T6", "T6") if n_dim == 2 else ("T4", "T10"))
    linear, n_corners = {2: ("L2", 2), 3: ("T3", 3)}[n_dim]
    mesh.elements = [
        (linear, name, nodes[:n_corners]) if name == face else (kind, name, nodes)
        for kind, name, nodes in mesh.elements
    ]
    return mesh


def write_deck(folder, mesh, contact):
    """The blocks held at bottom and top."""
    mesh.write(folder / "blocks.msh")
    n_dim = 3 if any(name in ("T4", "H8", "T10") for name, _, _ in mesh.elements) else 2
    entries = "\n".join(f"  - {{{entry}}}" for entry in contact)
    return write_held_blocks(folder / "bad.yaml", n_dim, f"contact:\n{entries}").name


LOOK_AT = r"'lower_face' lies within \(0\.0, .*\) to \(1\.0, .*\), 'upper_face' within \({}\.0, .*\) to \(.*\); name"
NOT_FACING = r"contact\[1\]: the surfaces 'lower_face' and 'upper_face' do not face each other along "
UPON = r"contact\[1\]: the surface 'both' is folded onto itself: node \d+ \(.*\) and node \d+ \(.*\) have opposite"
TWO_NAMES = "give each side its own name in the .geo file"
# mesh, entries of the section contact, place in the deck, message, hint
CASES = {
    "aside": (blocks(shift=5.0), [FACES], (8, FIRST), NOT_FACING + ".*: no part of the first", LOOK_AT.format(5)),
    "aside in space": (
        blocks(3, ("H8", "T4"), shift=5.0), [FACES], (8, FIRST),
        NOT_FACING + ".*: no part of the first", LOOK_AT.format(5),
    ),
    "too far": (
        blocks(gap=60.0), [FACES], (8, FIRST), NOT_FACING + ".* within the search distance", LOOK_AT.format(0),
    ),
    "look away from each other": (
        blocks(), ["first: bottom, second: top"], (8, FIRST),
        r"contact\[1\]: the surfaces 'bottom' and 'top' do not face .* every node overlaps by 2\.0 or more, which",
        r"'bottom' lies within \(0\.0, -1\.0\) to \(1\.0, -1\.0\), 'top' within \(0\.0, 1\.0\) to",
    ),
    "look the same way": (
        blocks(), ["first: lower_face, second: top, direction: [0, 1]"], (8, FIRST),
        r"contact\[1\]: the surfaces 'lower_face' and 'top' do not face .*: the outer side of one of them points away",
        "'lower_face' lies within",
    ),
    "reversed direction": (
        blocks(), [FACES + ", direction: [0, -1]"], (8, 56),
        r"contact\[1\]: the contact direction \(0\.0, -1\.0\) points from 'upper_face' to 'lower_face'",
        r"write direction: \[0\.0, 1\.0\], or swap first and second",
    ),
    "reversed direction in space": (
        blocks(3, ("T4", "H8")), [FACES + ", direction: [0, 0, -1], formulation: mortar"], (8, 56),
        r"contact\[1\]: the contact direction \(0\.0, 0\.0, -1\.0\) points from 'upper_face' to 'lower_face'",
        r"write direction: \[0\.0, 0\.0, 1\.0\], or swap",
    ),
    "empty first": (
        with_lost_facet(), ["first: lost, second: upper_face"], (8, FIRST),
        "the surface 'lost' of the mesh has no element whose nodes all belong to", "see that the mesh has elements",
    ),
    "empty second": (
        with_lost_facet(), ["first: lower_face, second: lost"], (8, SECOND),
        "the surface 'lost' of the mesh has no element whose nodes all belong to", "see that the mesh has elements",
    ),
    "a region": (
        blocks(), ["first: lower_face, second: upper"], (8, SECOND),
        "'upper' of the mesh is no surface but a region of cells; the mesh has bottom, lower_face,", None,
    ),
    "same facets in both": (
        named(blocks(), "copy", ("lower_face",)), ["first: lower_face, second: copy"], (8, FIRST),
        r"contact\[1\]: node 3 \(0\.0, 0\.0\) is on both surfaces, 'lower_face' and 'copy'",
        "contact needs two bodies with nodes of their own",
    ),
    "first upon itself": (with_third(), ["first: both, second: third"], (8, FIRST), UPON, TWO_NAMES),
    "second upon itself": (with_third(), ["first: third, second: both"], (8, 28), UPON, TWO_NAMES),
    "first upon itself in space": (with_third(3), ["first: both, second: third"], (8, FIRST), UPON, TWO_NAMES),
    "one node in two first surfaces": (
        halves(), ["first: half, second: upper_face", "first: rest, second: upper_face"], (9, FIRST),
        r"contact\[2\]: node 9 \(0\.666667, 0\.0\) is in contact\[1\], too, of 'half' and 'upper_face'",
        "give each contact its own surfaces, which share no node",
    ),
    "one node in two first surfaces in space": (
        halves(3), ["first: half, second: upper_face", "first: rest, second: upper_face"], (9, FIRST),
        r"contact\[2\]: node \d+ \(.*\) is in contact\[1\], too, of 'half' and 'upper_face'",
        "give each contact its own surfaces, which share no node",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("case", "n_ranks"), [*((case, 1) for case in CASES), ("first upon itself", 3)])
def test_refused_with_place_surface_and_remedy(signorom, tmp_path, case, n_ranks):
    mesh, contact, (line, column), message, hint = CASES[case]
    deck = write_deck(tmp_path, mesh, contact)
    words = refuse(signorom, "check", deck, folder=tmp_path, n_ranks=n_ranks)
    assert re.match(rf"bad\.yaml:{line}:{column}: error: {message}", words), words
    assert hint is None or re.search(rf"(?m)^hint: {hint}", words), words


@pytest.mark.parametrize("n_dim", [2, 3])
def test_middles_are_missing(signorom, tmp_path, n_dim):
    """The mesh is at fault, so its file is named, with both elements and the line of the first."""
    deck = write_deck(tmp_path, without_middles("upper_face", n_dim), [FACES])
    words = refuse(signorom, "check", deck, folder=tmp_path)
    kinds = {2: ("line", "T6"), 3: ("T3", "T10")}[n_dim]
    message = rf"blocks\.msh:(\d+):1: error: the {kinds[0]} (\d+) of 'upper_face' and the {kinds[1]} \d+ of 'upper' "
    found = re.match(message + "do not have the same node in the middle", words)
    assert found, words
    line = (tmp_path / "blocks.msh").read_text().splitlines()[int(found.group(1)) - 1]
    assert line.split()[0] == found.group(2)
    assert len(line.split()) == 5 + n_dim
    assert "hint: mesh boundaries and regions together with one Mesh.ElementOrder" in words


def test_plate_in_a_slot_is_no_fold(signorom, tmp_path):
    """A plate of a tenth of its edges: its sides look away from each other, those of the slot have it between them."""
    mesh = Mesh()
    plate = [np.linspace(0, 1, 4), np.linspace(0, 0.03, 3)]
    mesh.add_block("upper", plate, "Q4", {(1, 0): "plate", (1, 1): "plate", (0, 0): "top"})
    for floor, side in ((-1.0, 1), (0.03, 0)):
        faces = {(1, side): "slot", (1, 1 - side): "bottom"}
        mesh.add_block("lower", [np.linspace(-1, 2, 8), np.linspace(floor, floor + 1, 3)], "Q4", faces)
    deck = write_deck(tmp_path, mesh, ["first: slot, second: plate"])
    said = signorom("check", deck, folder=tmp_path)
    assert "mortar, because" in said
