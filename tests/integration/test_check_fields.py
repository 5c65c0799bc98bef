# SPDX-License-Identifier: BSD-3-Clause
"""`check --fields`: supports, loads and contact as they stand before anything is solved, against known ones."""

from dataclasses import dataclass

import h5py
import numpy as np
import pytest
from signorom_post.cli import main
from signorom_post.plots.check_bodies import check_bodies
from signorom_post.readers.check import read_check

from block_meshes import LINEAR, QUADRATIC, Mesh, consistent_areas
from decks import copy_deck, write_held_blocks
from program import ROOT
from runs import files_in, refuse, write_deck
from vtk_fields import read_with_vtk

BODY, BOUNDARY, SURFACE, LINK = 1, 2, 3, 4
# XDMF's numbers of cell types with their nodes; points and lines say how many they have
SIZES = {4: 3, 5: 4, 6: 4, 9: 8, 34: 3, 36: 6, 37: 8, 35: 9, 38: 10, 48: 20, 50: 27}
ROUNDING = 1e-12
ANGLE = np.pi / 6
CLEARANCE, SLOPE = 0.25, 0.1


@dataclass
class Setup:
    """check.h5; cells are lists of nodes from 0."""

    coordinates: np.ndarray
    cells: list
    fields: dict
    names: dict
    point: list

    def of(self, kind, **labels):
        """Indices of the cells of a kind, with such labels."""
        chosen = self.fields["kind"] == kind
        for name, value in labels.items():
            chosen &= self.fields[name] == value
        return np.flatnonzero(chosen)

    def nodes(self, cells):
        """Sorted nodes of some cells."""
        return np.unique(np.concatenate([self.cells[i] for i in cells]))


def read_setup(path):
    """The file, its cells taken apart."""
    with h5py.File(path) as file:
        flat, cells, start = file["mesh/topology"][()], [], 0
        while start < len(flat):
            is_short = flat[start] <= 2
            size = flat[start + 1] if is_short else SIZES[flat[start]]
            first = start + (2 if is_short else 1)
            cells.append(flat[first : first + size])
            start = first + size
        assert list(file["points"]) == ["0001"]
        point = file["points/0001"]
        names = {name: [text.decode() for text in values[()]] for name, values in file["check"].items()}
        fields = {name: values[()] for name, values in point.items()}
        assert all(values.attrs["unit"] and values.attrs["description"] for values in point.values())
        return Setup(file["mesh/coordinates"][()], cells, fields, names, list(point.attrs["parameters"]))


def checked(signorom, deck, *options, n_ranks=1):
    """What the command prints, and the file."""
    said = signorom("check", deck, "--fields", *options, folder=deck.parent, n_ranks=n_ranks)
    return said, read_setup(deck.parent / "results" / deck.stem / "check.h5")


def test_supports_and_pairs(signorom, tmp_path):
    """Half disks: bases held, arcs that face each other along y; their corners are prescribed on both sides."""
    said, setup = checked(signorom, write_deck("small_disks", tmp_path))
    assert "# boundaries: 1 lower_base, 2 upper_base, 3 lower_arc, 4 upper_arc\n" in said
    assert said.splitlines()[-1] == "# fields: results/small_disks/check.xdmf at squeeze = 0.3 m"
    x, y, _ = setup.coordinates.T
    is_base = np.isclose(abs(y), 1.05)
    assert setup.point == pytest.approx([0.3])
    np.testing.assert_array_equal(setup.fields["prescribed"], np.outer(is_base, [1, 1, 0]))
    expected = np.where(is_base, -0.3 * np.sign(y), 0)
    np.testing.assert_allclose(setup.fields["prescribed_displacement"][:, 1], expected, rtol=ROUNDING)
    assert not setup.fields["load"].any()
    assert setup.names["materials"] == ["disk"]
    assert setup.names["regions"] == ["lower", "upper"]
    assert setup.names["contacts"] == ["lower_arc - upper_arc"]
    for region, sign in ((1, -1), (2, 1)):
        assert (sign * y[setup.nodes(setup.of(BODY, region=region))] > 0).all()
    lower, upper = (setup.nodes(setup.of(SURFACE, contact=1, side=side)) for side in (1, 2))
    np.testing.assert_array_equal(lower, setup.nodes(setup.of(BOUNDARY, boundary=3)))
    np.testing.assert_array_equal(upper, setup.nodes(setup.of(BOUNDARY, boundary=4)))
    assert np.hypot(x[lower], y[lower] + 1.05) == pytest.approx(1)
    np.testing.assert_array_equal(
        setup.fields["contact_side"], np.isin(range(88), lower) + 2 * np.isin(range(88), upper)
    )
    np.testing.assert_array_equal(setup.fields["contact_row"][lower], np.where(is_base[lower], 2, 1))
    np.testing.assert_array_equal(setup.fields["contact_normal"][lower], [[0, 1, 0]] * 15)
    # the arcs are circles of radius 1 about the middles of the bases
    gap = 2 * (1.05 - np.sqrt(1 - np.minimum(x[lower] ** 2, 1)))
    np.testing.assert_allclose(setup.fields["gap"][lower], gap, rtol=0, atol=1e-7)
    links = [setup.cells[i] for i in setup.of(LINK)]
    np.testing.assert_array_equal(np.sort([link[0] for link in links]), lower)
    np.testing.assert_array_equal(np.sort([link[1] for link in links]), upper)
    assert all(abs(x[a] - x[b]) < ROUNDING for a, b in links)
    np.testing.assert_array_equal(setup.fields["n_partners"], setup.fields["contact_side"] == 1)


def test_pressure_in_the_round(signorom, tmp_path):
    """Pellet and cladding: the pressure up to h1 is cut exactly, so its sum is P1 times the cylinder of height h1."""
    deck = copy_deck(ROOT / "input" / "pellet_cladding.yaml", tmp_path)
    _, setup = checked(signorom, deck, "--at", "P1=100,h1=2.5")
    radius = 4.1 + 0.002 + 0.57
    load = setup.fields["load"]
    assert load[:, 0].sum() == pytest.approx(-100 * 2 * np.pi * radius * 2.5, rel=1e-12)
    assert not load[:, 1:].any()
    loaded = setup.coordinates[load[:, 0] != 0]
    assert loaded[:, 0] == pytest.approx(radius)
    assert loaded[:, 1].max() == pytest.approx(np.ceil(2.5 / 0.07) * 0.07)
    r, z, _ = setup.coordinates.T
    is_end = np.isclose(z, 0) | np.isclose(z, 7)
    np.testing.assert_array_equal(
        setup.fields["prescribed"].astype(bool), np.column_stack([np.isclose(r, 0), is_end, 0 * r])
    )
    first = setup.fields["contact_side"] == 1
    assert setup.fields["gap"][first] == pytest.approx(0.002, rel=1e-9)
    assert setup.fields["contact_area"][first].sum() == pytest.approx(2 * np.pi * 4.1 * 7, rel=1e-9)


def tilted_blocks(n_dim, elements):
    """Two blocks, one unit wide, whose faces do not match and open by CLEARANCE + SLOPE x, all turned by ANGLE."""
    mesh = Mesh()
    up = n_dim - 1
    for name, element, n, floor in zip(("lower", "upper"), elements, (3, 5), (-1.0, 0.0), strict=True):
        start, side = len(mesh.coordinates), int(floor < 0)
        faces = {(up, side): f"{name}_face", (up, 1 - side): "bottom" if side else "top"}
        lines = [np.linspace(0, 1, n + 1) ** 1.2] * up + [np.linspace(floor, floor + 1, 3)]
        mesh.add_block(name, lines, LINEAR.get(element, element), faces)
        if element in QUADRATIC:
            mesh.make_quadratic(element, [name, *faces.values()])
        if not side:
            block = np.arange(start, len(mesh.coordinates))
            block = block[mesh.coordinates[block, up] > -0.25]
            block = np.setdiff1d(block, mesh.nodes_of("lower_face"))
            mesh.coordinates[block, up] += CLEARANCE + SLOPE * mesh.coordinates[block, 0]
    cosine, sine = np.cos(ANGLE), np.sin(ANGLE)
    turned = np.eye(3)
    turned[np.ix_([up - 1, up], [up - 1, up])] = [[cosine, -sine], [sine, cosine]]
    flat = mesh.coordinates.copy()
    mesh.coordinates = flat @ turned.T
    return mesh, flat, turned[:, up]


def write_tilted_deck(folder, n_dim):
    """Bottom and top held, the surfaces tied by mortar."""
    contact = "contact: [{first: lower_face, second: upper_face}]"
    return write_held_blocks(folder / "tilted.yaml", n_dim, contact)


@pytest.mark.parametrize(
    ("n_dim", "elements"),
    [
        (2, ("Q4", "T3")),
        (2, ("T6", "Q8")),
        (3, ("H8", "T4")),
        (3, ("T4", "T10")),
        (3, ("H27", "H20")),
        (3, ("T10", "T10")),
        (3, ("H20", "T4")),
    ],
)
def test_mortar(signorom, tmp_path, n_dim, elements):
    """A linear gap between plane faces comes out exactly; shares add up to 1; areas by their formulas."""
    mesh, flat, normal = tilted_blocks(n_dim, elements)
    mesh.write(tmp_path / "blocks.msh")
    said, setup = checked(signorom, write_tilted_deck(tmp_path, n_dim))
    assert "mortar, because" in said
    np.testing.assert_allclose(setup.coordinates, mesh.coordinates, rtol=0, atol=ROUNDING)
    lower, upper = mesh.nodes_of("lower_face"), mesh.nodes_of("upper_face")
    has_row = setup.fields["contact_row"] == 1
    np.testing.assert_array_equal(np.flatnonzero(has_row), lower)
    np.testing.assert_array_equal(setup.fields["contact_side"][upper], 2)
    np.testing.assert_allclose(setup.fields["contact_normal"][lower], [normal] * len(lower), atol=ROUNDING)
    np.testing.assert_allclose(setup.fields["gap"][lower], CLEARANCE + SLOPE * flat[lower, 0], rtol=1e-9)
    found = setup.fields["contact_area"]
    assert found[lower].sum() == pytest.approx(1, rel=1e-9)
    assert found[upper].sum() == pytest.approx(1, rel=1e-9)
    # at corners of faces of six and eight nodes the integrals vanish or are negative: another basis stands there
    if elements[0] not in ("T10", "H20"):
        np.testing.assert_allclose(found[lower], consistent_areas(mesh, "lower_face")[lower], rtol=1e-9)
    links = setup.of(LINK)
    from_node, to_node = np.array([setup.cells[i] for i in links]).T
    assert set(to_node) <= set(upper)
    share = setup.fields["share"]
    assert not np.delete(share, links).any()
    n = len(flat)
    np.testing.assert_array_equal(setup.fields["n_partners"], np.bincount(from_node, minlength=n))
    largest = np.zeros(n)
    np.maximum.at(largest, from_node, share[links])
    np.testing.assert_array_equal(setup.fields["largest_share"], largest)
    np.testing.assert_allclose(np.bincount(from_node, share[links], n)[lower], 1, rtol=1e-10)


@pytest.mark.parametrize("first", ["lower_face", "upper_face"])
def test_normal_leaves_the_first_surface(signorom, tmp_path, first):
    """The normal points from the first surface to the second, whichever is which."""
    mesh = tilted_blocks(2, ("T3", "T3"))[0]
    mesh.write(tmp_path / "blocks.msh")
    deck = write_tilted_deck(tmp_path, 2)
    if first == "upper_face":
        text = deck.read_text().replace(
            "first: lower_face, second: upper_face", "first: upper_face, second: lower_face"
        )
        deck.write_text(text)
    _, setup = checked(signorom, deck)
    places = mesh.coordinates[mesh.nodes_of("upper_face")].mean(axis=0) - mesh.coordinates[
        mesh.nodes_of("lower_face")
    ].mean(axis=0)
    sense = 1 if first == "lower_face" else -1
    assert (sense * setup.fields["contact_normal"][mesh.nodes_of(first)] @ places > 0).all()
    assert setup.nodes(setup.of(SURFACE, side=1)).tolist() == mesh.nodes_of(first).tolist()


def test_obstacle_has_no_partners(signorom, tmp_path):
    """The rigid sphere is no surface of the mesh: normals and gaps, but no lines."""
    deck = copy_deck(ROOT / "input" / "indenter.yaml", tmp_path)
    _, setup = checked(signorom, deck, "--at", "depth=0.05,place_x=10,place_y=9")
    assert setup.of(LINK).size == setup.of(SURFACE, side=2).size == 0
    first = setup.fields["contact_row"] == 1
    assert first.sum() == setup.nodes(setup.of(SURFACE, side=1)).size == 1073
    np.testing.assert_array_equal(setup.fields["contact_normal"][first], [[0, 0, 1]] * 1073)
    # -depth below the lowest point of the sphere
    nearest = np.argmin(np.hypot(*(setup.coordinates[:, :2] - [10, 9]).T) + 1e3 * ~first)
    assert -0.05 <= setup.fields["gap"][nearest] < -0.04


def test_ranks_write_the_same(signorom, tmp_path):
    """Bytes do not depend on the number of ranks."""
    files = []
    for n_ranks in (1, 3):
        folder = tmp_path / str(n_ranks)
        folder.mkdir()
        mesh, _, _ = tilted_blocks(3, ("T4", "H8"))
        mesh.write(folder / "blocks.msh")
        checked(signorom, write_tilted_deck(folder, 3), n_ranks=n_ranks)
        files.append({path.name: data for path, data in files_in(folder / "results").items()})
    assert files[0].keys() == {"check.h5", "check.xdmf"}
    assert files[0] == files[1]


@pytest.mark.parametrize("elements", [("T6", "Q8"), ("Q9", "T3")])
def test_vtk_opens_it(signorom, tmp_path, elements):
    """Bodies, edges and lines in one grid."""
    mesh, _, _ = tilted_blocks(2, elements)
    mesh.write(tmp_path / "blocks.msh")
    _, setup = checked(signorom, write_tilted_deck(tmp_path, 2))
    (shown,) = read_with_vtk(tmp_path / "results" / "tilted" / "check.xdmf").values()
    assert shown.n_cells == len(setup.cells)
    assert shown.nodes.keys() | shown.cells.keys() == setup.fields.keys()
    for name, values in (shown.nodes | shown.cells).items():
        np.testing.assert_array_equal(values, setup.fields[name], err_msg=name)


@pytest.mark.parametrize("n_dim", [2, 3])
def test_pictures(signorom, tmp_path, capsys, n_dim):
    """The Python tool reads what the program writes."""
    mesh, _, _ = tilted_blocks(n_dim, {2: ("T6", "Q8"), 3: ("H8", "T10")}[n_dim])
    mesh.write(tmp_path / "blocks.msh")
    checked(signorom, write_tilted_deck(tmp_path, n_dim))
    folder = tmp_path / "results" / "tilted"
    assert main(["check", str(folder)]) == 0
    pictures = [folder / "figures" / f"check_{name}.png" for name in ("bodies", "contact_1")]
    assert capsys.readouterr().out.splitlines() == [str(picture) for picture in pictures]
    assert all(picture.stat().st_size > 10_000 for picture in pictures)
    # what stands at nodes in the middle of edges is drawn, too: every other node of the top, beside its corners
    n_top = len(mesh.nodes_of("top"))
    drawn = check_bodies(read_check(folder / "check.h5")).axes[0].collections
    n_arrows = sum(len(item.get_offsets()) for item in drawn if item.get_gid() == "prescribed_displacement")
    assert n_arrows == -(-n_top // max(1, n_top // 60))


@pytest.mark.parametrize("n_ranks", [1, 3])
def test_refused_contact_is_seen(signorom, tmp_path, n_ranks):
    """Surfaces beside each other: the error, and a picture in which every node of the first one faces nothing."""
    mesh, _, _ = tilted_blocks(2, ("T3", "T3"))
    upper = np.unique([node for _, name, nodes in mesh.elements if name == "upper" for node in nodes])
    mesh.coordinates[upper, 0] += 5
    mesh.write(tmp_path / "blocks.msh")
    done = signorom.run("check", write_tilted_deck(tmp_path, 2), "--fields", folder=tmp_path, n_ranks=n_ranks)
    assert done.returncode == 2
    assert "do not face each other" in done.stderr
    folder = tmp_path / "results" / "tilted"
    setup = read_setup(folder / "check.h5")
    assert np.flatnonzero(setup.fields["prescribed"][:, 0]).size == 4 + 6
    assert not setup.fields["contact_side"].any()
    assert np.isnan(setup.fields["gap"]).all()
    assert setup.of(LINK).size == 0
    np.testing.assert_array_equal(setup.nodes(setup.of(SURFACE, side=1)), mesh.nodes_of("lower_face"))
    assert main(["check", str(folder)]) == 0


def test_body_that_nothing_holds_is_seen(signorom, tmp_path):
    """The supports that are there, and the contact."""
    mesh, _, _ = tilted_blocks(2, ("T3", "T3"))
    mesh.write(tmp_path / "blocks.msh")
    deck = write_tilted_deck(tmp_path, 2)
    deck.write_text(
        "\n".join(line for line in deck.read_text().splitlines() if "boundary: top" not in line)
        + "\nsolver: {hold_unloaded_motions: false}\n"
    )
    done = signorom.run("check", deck, "--fields", folder=tmp_path)
    assert done.returncode == 2
    assert "nothing can hold the body 'upper'" in done.stderr
    setup = read_setup(tmp_path / "results" / "tilted" / "check.h5")
    assert np.flatnonzero(setup.fields["prescribed"][:, 0]).size == 4
    assert setup.of(LINK).size > 0


def test_nothing_is_written_unasked(signorom, tmp_path):
    """Neither without the option nor after an error."""
    deck = write_deck("small_disks", tmp_path)
    signorom("check", deck, folder=tmp_path)
    assert not (tmp_path / "results").exists()
    assert "unknown parameter 'sqeeze'" in refuse(
        signorom, "check", deck.name, "--fields", "--at", "sqeeze=1", folder=tmp_path
    )
