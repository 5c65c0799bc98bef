# SPDX-License-Identifier: BSD-3-Clause
"""`signorom init`: a first deck for a mesh, which works once its places are filled in."""

import re
import subprocess
import sys

import numpy as np
import pytest
import yaml

from block_meshes import Mesh, stacked_blocks
from gmsh_mesh import make_mesh
from results import read_fields
from runs import HERE, refuse

MESHES = HERE.parents[1] / "meshes"
# contacts that the decks of input/ have on these meshes
CONTACTS = {
    "bracket": [
        {"bracket_foot_1", "block_foot_1"},
        {"bracket_foot_2", "block_foot_2"},
        {"bracket_stop", "block_wall"},
    ],
    "half_disks": [{"lower_arc", "upper_arc"}],
    "fuel_rod": [{"fuel_surface", "cladding_inside"}],
    "shrink_fit": [{"inner_face", "outer_face"}],
    "angle_bracket": [{"foot_face", "plate_face"}],
    "saddle": [{"saddle_foot_1", "block_foot_1"}, {"saddle_foot_2", "block_foot_2"}],
}


def copy_mesh(name, folder):
    """A mesh of the repository in a folder of its own."""
    mesh = folder / f"{name}.msh"
    mesh.write_bytes((MESHES / mesh.name).read_bytes())
    return mesh


@pytest.mark.parametrize("name", CONTACTS)
def test_contacts_of_known_meshes(signorom, tmp_path, name):
    """All contacts of the decks that we have, and no other."""
    signorom("init", copy_mesh(name, tmp_path), folder=tmp_path)
    deck = yaml.safe_load((tmp_path / f"{name}.yaml").read_text())
    assert [{entry["first"], entry["second"]} for entry in deck["contact"]] == CONTACTS[name]


BLOCKS = {
    # thin plates one above the other, with gaps of 0.2: no contact through a plate
    "leaves": (
        ["lower {0, 0, 0, 40, 2}", "middle {0, 2.2, 0, 40, 2}", "upper {0, 4.4, 0, 40, 2}"],
        [{"lower_top", "middle_bottom"}, {"middle_top", "upper_bottom"}],
    ),
    # a region of two bodies, whose bottoms are one surface
    "feet": (
        ["lower {0, 0, 0, 40, 20}", "upper {0, 20, 0, 15, 8}", "upper {25, 20, 0, 15, 8}"],
        [{"lower_top", "upper_bottom"}],
    ),
}


@pytest.mark.parametrize("name", BLOCKS)
def test_contacts_of_blocks(signorom, tmp_path, name):
    rectangles, contacts = BLOCKS[name]
    lines, groups = ['SetFactory("OpenCASCADE");', "Mesh.MeshSizeMax = 2;"], {}
    for i, rectangle in enumerate(rectangles, 1):
        region, place = rectangle.split(" ", 1)
        lines.append(f"Rectangle({i}) = {place};")
        for group, number in (
            (f'Surface("{region}")', i),
            (f'Curve("{region}_bottom")', 4 * i - 3),
            (f'Curve("{region}_top")', 4 * i - 1),
        ):
            groups.setdefault(group, []).append(str(number))
    lines += [f"Physical {group} = {{{', '.join(numbers)}}};" for group, numbers in groups.items()]
    (tmp_path / "part.geo").write_text("\n".join(lines) + "\n")
    make_mesh(tmp_path / "part.geo", tmp_path / "part.msh")
    signorom("init", "part.msh", folder=tmp_path)
    deck = yaml.safe_load((tmp_path / "part.yaml").read_text())
    assert [{entry["first"], entry["second"]} for entry in deck["contact"]] == contacts


# named by one surface each, all around: a twentieth of the ball and of the block face each other
BALL = """SetFactory("OpenCASCADE");
Sphere(1) = {0, 0, 10.01, 10};
Box(2) = {-30, -30, -10, 60, 60, 10};
Physical Volume("ball") = {1};
Physical Volume("block") = {2};
Physical Surface("skin_of_ball") = {1};
Physical Surface("skin_of_block") = {2, 3, 4, 5, 6, 7};
Mesh.MeshSizeMax = 3;
"""


def test_sides_of_single_cells_do_not_face_each_other(signorom, tmp_path):
    """A small cube, turned by 45 degrees, on a large one, a cell each: only the bottom faces the top."""
    corners = np.array([(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]) - [
        0.5,
        0.5,
        0,
    ]
    half = 0.5**0.5
    turned = 0.2 * corners @ [[half, half, 0], [-half, half, 0], [0, 0, 1]] + [0, 0, 1]
    sides = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    nodes = [f"{i} {x} {y} {z}" for i, (x, y, z) in enumerate(np.vstack([corners, turned]), 1)]
    elements = []
    for body in (0, 1):
        cells = [(5, body + 1, range(8))] + [(3, 10 * body + k, side) for k, side in enumerate(sides, 1)]
        for kind, tag, own in cells:
            elements.append(
                f"{len(elements) + 1} {kind} 2 {tag} {tag} {' '.join(str(8 * body + i + 1) for i in own)}"
            )
    sections = {
        "MeshFormat": ["2.2 0 8"],
        "Nodes": [str(len(nodes)), *nodes],
        "Elements": [str(len(elements)), *elements],
    }
    text = "".join("\n".join([f"${name}", *lines, f"$End{name}", ""]) for name, lines in sections.items())
    (tmp_path / "part.msh").write_text(text)
    signorom("init", "part.msh", folder=tmp_path)
    deck = yaml.safe_load((tmp_path / "part.yaml").read_text())
    assert [{entry["first"], entry["second"]} for entry in deck["contact"]] == [{"surface_2", "surface_11"}]


def test_surfaces_that_wrap_around_their_bodies(signorom, tmp_path):
    (tmp_path / "part.geo").write_text(BALL)
    make_mesh(tmp_path / "part.geo", tmp_path / "part.msh", 3)
    signorom("init", "part.msh", folder=tmp_path)
    (entry,) = yaml.safe_load((tmp_path / "part.yaml").read_text())["contact"]
    assert {entry["first"], entry["second"]} == {"skin_of_ball", "skin_of_block"}


def test_one_name_per_region_and_boundary(signorom, tmp_path):
    """Cells and faces with several names: one material, one line, one contact each."""
    mesh = stacked_blocks("H8", 3)
    again = {
        "lower": ["all"],
        "upper": ["all", "top_block"],
        "lower_face": ["lower_face_2", "skin_of_lower"],
        "bottom": ["skin_of_lower"],
        "upper_face": ["skin_of_upper"],
        "top": ["skin_of_upper"],
    }
    mesh.elements += [
        (kind, new, nodes) for kind, name, nodes in mesh.elements for new in again.get(name, [])
    ]
    mesh.write(tmp_path / "part.msh")
    signorom("init", "part.msh", folder=tmp_path)
    text = (tmp_path / "part.yaml").read_text()
    deck = yaml.safe_load(text)
    # upper and top_block are the same cells: gmsh's groups come in the order of the file
    assert set(deck["materials"]) == {"lower", "top_block"}
    assert "# Other names of the same cells: all upper\n" in text
    assert [{entry["first"], entry["second"]} for entry in deck["contact"]] == [{"lower_face", "upper_face"}]
    assert re.search(r"#   lower_face: .* \(also: lower_face_2\)", text)
    assert "#   lower_face_2:" not in text


@pytest.mark.parametrize(("name", "unit", "pressure"), [("bracket", "mm", "MPa"), ("half_disks", "m", "Pa")])
def test_unit_of_length_is_guessed(signorom, tmp_path, name, unit, pressure):
    """Both meshes measure what their README says: 1 m across, and tens of mm."""
    signorom("init", copy_mesh(name, tmp_path), folder=tmp_path)
    deck = yaml.safe_load((tmp_path / f"{name}.yaml").read_text())
    assert deck["units"] == {"length": unit, "force": "N"}
    assert deck["parameters"]["P"]["unit"] == pressure


@pytest.mark.parametrize("n_dim", [2, 3])
def test_bodies_that_share_nodes_are_split(signorom, tmp_path, n_dim):
    """init says it, the command that it names parts them, and init then finds the contact."""
    mesh = stacked_blocks("Q4" if n_dim == 2 else "H8", n_dim)
    lower, upper = mesh.nodes_of("lower_face"), mesh.nodes_of("upper_face")
    same = {
        node: lower[np.linalg.norm(mesh.coordinates[lower] - mesh.coordinates[node], axis=1).argmin()]
        for node in upper
    }
    mesh.elements = [
        (kind, name, [same.get(node, node) for node in nodes])
        for kind, name, nodes in mesh.elements
        if name not in ("lower_face", "upper_face")
    ]
    mesh.write(tmp_path / "part.msh")
    done = signorom.run("init", "part.msh", folder=tmp_path)
    assert "1 pair of regions shares nodes" in done.stdout + done.stderr
    text = (tmp_path / "part.yaml").read_text()
    assert f"The regions lower and upper share {len(lower)} nodes: they stick to each other there." in text
    (command,) = re.findall(r"#   signorom-post (convert .*)", text)
    words = [word.strip("'") for word in command.split()]
    subprocess.run([sys.executable, "-m", "signorom_post", *words], cwd=tmp_path, check=True)
    signorom("init", "part_split.msh", folder=tmp_path)
    (entry,) = yaml.safe_load((tmp_path / "part_split.yaml").read_text())["contact"]
    assert {entry["first"], entry["second"]} == {"lower_to_upper", "upper_to_lower"}


ROLLER = """SetFactory("OpenCASCADE");
Disk(1) = {0, 10.01, 0, 10};
Rectangle(2) = {-60, -10, 0, 120, 10};
Physical Surface("roller") = {1};
Physical Surface("block") = {2};
Physical Curve("rim") = {1};
Physical Curve("face") = {4};
Physical Curve("bottom") = {2};
Mesh.MeshSizeMax = 1;
"""


def test_curved_on_flat_takes_the_normal_of_the_flat_surface(signorom, tmp_path):
    """The deck of init has it as direction; without it `check` says so."""
    (tmp_path / "part.geo").write_text(ROLLER)
    make_mesh(tmp_path / "part.geo", tmp_path / "part.msh")
    signorom("init", "part.msh", folder=tmp_path)
    deck = tmp_path / "part.yaml"
    (entry,) = yaml.safe_load(deck.read_text())["contact"]
    assert entry == {"first": "rim", "second": "face", "direction": [0.0, -1.0]}
    text = deck.read_text()
    for old, new in {
        ", direction: [0.0, -1.0]": "",
        "min: FILL_IN, max: FILL_IN": "min: 1, max: 9",
        "young_modulus: FILL_IN, poisson_ratio: FILL_IN": "young_modulus: 2.0e5, poisson_ratio: 0.3",
        "boundary: FILL_IN, pressure": "boundary: face, pressure",
    }.items():
        text = text.replace(old, new)
    for boundary in ("rim", "bottom"):
        text = text.replace("boundary: FILL_IN", f"boundary: {boundary}", 1)
    # its nodes must be free to carry the contact forces
    deck.write_text(text.replace("rim, displacement: {x: 0, y: 0}", "rim, displacement: {x: 0}"))
    done = signorom.run("check", deck, folder=tmp_path)
    assert "'face' is flat and 'rim' is not: direction: [0.0, -1.0]" in done.stdout + done.stderr


BESIDE = """SetFactory("OpenCASCADE");
Rectangle(1) = {0, 0, 0, 2, 2};
Rectangle(2) = {5, 3, 0, 100, 2};
Rectangle(3) = {0, -2.01, 0, 4, 2};
Physical Surface("pin") = {1};
Physical Surface("plate") = {2};
Physical Surface("base") = {3};
Physical Curve("skin") = {1, 3};
Physical Curve("face") = {5};
Physical Curve("top") = {11};
Physical Curve("bottom") = {9};
Physical Curve("end") = {6};
Mesh.MeshSizeMax = 1;
"""


def test_what_cannot_be_a_contact_is_left_out(signorom, tmp_path):
    """A plate beside a pin is near, and its normals are opposite, but it faces nothing: `check` would refuse it."""
    (tmp_path / "part.geo").write_text(BESIDE)
    make_mesh(tmp_path / "part.geo", tmp_path / "part.msh")
    said = signorom("init", "part.msh", folder=tmp_path)
    assert "1 contact guessed" in said
    deck = tmp_path / "part.yaml"
    (entry,) = yaml.safe_load(deck.read_text())["contact"]
    assert {entry["first"], entry["second"]} == {"skin", "top"}
    assert re.search(
        r"(?m)^# Left out: .first: face, second: skin.: .* no part of the first faces the second$",
        deck.read_text(),
    )
    fill(deck, "P", min="1", max="9")
    for region in ("pin", "plate", "base"):
        fill(deck, region, young_modulus="70e3", poisson_ratio="0.3")
    lines = deck.read_text().replace("boundary: FILL_IN, pressure", "boundary: end, pressure").splitlines()
    lines = [line for line in lines if "of the body pin" not in line]
    text = "\n".join(lines)
    for boundary in ("face", "bottom"):
        text = text.replace("boundary: FILL_IN", f"boundary: {boundary}", 1)
    deck.write_text(text)
    signorom("check", deck, folder=tmp_path)


@pytest.mark.parametrize("n_dim", [2, 3])
def test_filled_in_deck_runs(signorom, tmp_path, n_dim):
    """From a mesh to a judged model in five answers, on two ranks."""
    stacked_blocks("Q4" if n_dim == 2 else "H8", n_dim).write(tmp_path / "part.msh")
    signorom("init", "part.msh", folder=tmp_path, n_ranks=2)
    deck = tmp_path / "part.yaml"
    fill(deck, "P", min="10", max="90")
    for region in ("lower", "upper"):
        fill(deck, region, young_modulus="70e3", poisson_ratio="0.3")
    text = deck.read_text()
    for boundary in ("bottom", "left", "top"):  # a support for each body, a load
        text = text.replace("boundary: FILL_IN", f"boundary: {boundary}", 1)
    # its nodes must be free to carry the contact forces
    deck.write_text(text.replace("rim, displacement: {x: 0, y: 0}", "rim, displacement: {x: 0}"))
    assert "FILL_IN" not in re.sub("#.*", "", deck.read_text())
    signorom("check", deck, folder=tmp_path)
    signorom("run", deck, folder=tmp_path)
    assert (tmp_path / "results" / "part" / "model.h5").exists()


def test_a_single_body_touches_an_obstacle(signorom, tmp_path):
    """A column 1 high and wide, E = 100, on a rigid plane: P presses it down by P / 100, and the plane carries P.

    A point with the name of the top, whose corner it is, is no boundary of its own.
    """
    mesh = Mesh()
    names = {(1, 0): "bottom", (1, 1): "top", (0, 0): "left"}
    mesh.add_block("column", [np.array([0.0, 0.4, 1.0]), np.array([0.0, 0.3, 1.0])], "Q4", names)
    corner = int(np.argmax(mesh.coordinates[:, :2].sum(axis=1)))
    mesh.elements.append(("P1", "top", (corner,)))
    mesh.write(tmp_path / "part.msh")
    signorom("init", "part.msh", folder=tmp_path)
    deck = tmp_path / "part.yaml"
    assert deck.read_text().count("#   top: ") == 1
    fill(deck, "P", min="1", max="9")
    fill(deck, "column", young_modulus="100", poisson_ratio="0.0")
    text = deck.read_text()
    for old, new in (
        ("boundary: FILL_IN, displacement: {x: 0, y: 0}", "boundary: left, displacement: {x: 0}"),
        ("boundary: FILL_IN", "boundary: top"),
        ("first: FILL_IN", "first: bottom"),
        ("point: [FILL_IN, FILL_IN], normal: [FILL_IN, FILL_IN]", "point: [5, 0], normal: [0, 1]"),
    ):
        assert old in text
        text = text.replace(old, new)
    deck.write_text(text)
    signorom("solve", deck, "--at", "P=5", folder=tmp_path)
    fields = read_fields(tmp_path / "results" / "part" / "fields.h5")
    # rounding: the sum of forces is the load, the shortening that of a bar
    assert fields["multipliers_full_order"].sum() == pytest.approx(5, rel=1e-10)
    assert np.ptp(fields["displacement"][:, 1]) == pytest.approx(0.05, rel=1e-10)


def fill(deck, name, **values):
    """Values in the place of FILL_IN on the line of a parameter or material."""
    (line,) = re.findall(rf"(?m)^  {name}: .*$", deck.read_text())
    filled = line
    for key, value in values.items():
        filled = filled.replace(f"{key}: FILL_IN", f"{key}: {value}")
    assert "FILL_IN" not in filled
    deck.write_text(deck.read_text().replace(line, filled))


def test_places_are_named(signorom, tmp_path):
    """A deck that is not filled in: an error for each place, with its line and column."""
    signorom("init", copy_mesh("bracket", tmp_path), folder=tmp_path)
    deck = tmp_path / "bracket.yaml"
    done = signorom.run("check", deck, folder=tmp_path)
    assert done.returncode == 2
    places = re.sub("#.*", "", deck.read_text()).count("FILL_IN")
    assert done.stderr.count("is not filled in yet") == places
    lines = deck.read_text().splitlines()
    (line,) = [i for i, text in enumerate(lines, 1) if text.startswith("  block: ")]
    column = lines[line - 1].index("FILL_IN") + 1
    sentence = "error: materials.block.young_modulus is not filled in yet"
    assert f"bracket.yaml:{line}:{column}: {sentence}" in done.stderr


def test_names_that_yaml_reads_otherwise(signorom, tmp_path):
    """Regions and boundaries with blanks, colons and numbers as names stay what they are."""
    mesh = stacked_blocks("Q4", 2)
    mesh.write(tmp_path / "part.msh")
    text = (tmp_path / "part.msh").read_text()
    for old, new in {
        "lower": "the lower: part",
        "upper": "12",
        "lower_face": "a, b",
        "upper_face": "yes",
    }.items():
        text = text.replace(f'"{old}"', f'"{new}"')
    (tmp_path / "part.msh").write_text(text)
    signorom("init", "part.msh", folder=tmp_path)
    deck = yaml.safe_load((tmp_path / "part.yaml").read_text())
    assert deck["materials"]["12"]["regions"] == ["12"]
    assert deck["materials"]["the lower: part"]["regions"] == ["the lower: part"]
    assert {deck["contact"][0]["first"], deck["contact"][0]["second"]} == {"a, b", "yes"}


def test_refusals(signorom, tmp_path):
    """A deck that is there stays as it is; no mesh, a mesh without names, no file."""
    mesh = copy_mesh("shrink_fit", tmp_path)
    (tmp_path / "shrink_fit.yaml").write_text("mine\n")
    said = refuse(signorom, "init", mesh, folder=tmp_path)
    assert "shrink_fit.yaml: error: this deck exists already" in said
    assert (tmp_path / "shrink_fit.yaml").read_text() == "mine\n"
    (tmp_path / "text.msh").write_text("squeeze: 0.2\n")
    refuse(signorom, "init", "text.msh", folder=tmp_path, n_ranks=3)
    refuse(signorom, "init", "missing.msh", folder=tmp_path)
    said = refuse(signorom, "init", folder=tmp_path)
    assert "the command init needs a mesh (.msh)" in said
    assert not (tmp_path / "text.yaml").exists()
