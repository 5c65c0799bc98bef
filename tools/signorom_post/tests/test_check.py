# SPDX-License-Identifier: BSD-3-Clause
"""`signorom-post check`: what the pictures of a set-up show, on files made without the program."""

from pathlib import Path

import h5py
import numpy as np
import pytest
from matplotlib import colormaps
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.quiver import Quiver
from pictures import check_picture, lines_of

from signorom_post.arrays import Quantity
from signorom_post.cli import main
from signorom_post.mesh import Mesh
from signorom_post.plots.check_bodies import check_bodies
from signorom_post.plots.check_contact import check_contact
from signorom_post.plots.loads import load_arrows
from signorom_post.plots.surface import view
from signorom_post.readers.check import CELL_FIELDS, NODE_NUMBERS, NODE_VECTORS, CheckFile, read_check
from signorom_post.style import SEQUENTIAL, styled

GAP, PUSH = 0.1, 3.0
XDMF = {("point", 1): 1, ("line", 2): 2, ("quad", 4): 5, ("box", 8): 9}


def grid(n: int, n_dim: int, floor: float) -> tuple[np.ndarray, np.ndarray]:
    """Nodes of a unit square or cube of n cells along each side, and their numbers by position."""
    line = np.linspace(0.0, 1.0, n + 1)
    lines = [line] * (n_dim - 1) + [floor + line]
    points = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, n_dim)
    return np.pad(points, ((0, 0), (0, 3 - n_dim))), np.arange(len(points)).reshape((n + 1,) * n_dim)


def boxes(numbers: np.ndarray) -> list[list[int]]:
    """Cells of a grid of one to three dimensions, corners in gmsh's order."""
    corners = {1: [(0,), (1,)], 2: [(0, 0), (1, 0), (1, 1), (0, 1)]}
    corners[3] = [(*corner, k) for k in (0, 1) for corner in corners[2]]
    steps = np.ndindex(*(n - 1 for n in numbers.shape))
    return [[int(numbers[tuple(np.add(i, c))]) for c in corners[numbers.ndim]] for i in steps]


class Setup:
    """Two blocks, the upper one GAP above the lower one; the bottom held, a force PUSH on each node of the top.

    The last node of the lower face has no row. Each other one faces the node above it and, with a quarter, the
    first node there.
    """

    def __init__(self, n_dim: int, n: int = 3) -> None:
        self.n_dim = n_dim
        below, lower = grid(n, n_dim, -1.0)
        above, upper = grid(n, n_dim, GAP)
        self.points = np.vstack([below, above])
        upper = upper + len(below)
        self.first, self.second = lower[..., -1].ravel(), upper[..., 0].ravel()
        self.bottom, self.top = lower[..., 0].ravel(), upper[..., -1].ravel()
        self.owners = self.first[:-1]
        names = {1: "line", 2: "quad", 3: "box"}
        rows = []
        for numbers, region in ((lower, 1), (upper, 2)):
            rows += [
                (names[n_dim], cell, {"kind": 1, "material": 1, "region": region}) for cell in boxes(numbers)
            ]
        faces = (lower[..., 0], lower[..., -1], upper[..., 0], upper[..., -1])
        for i, face in enumerate(faces, start=1):
            rows += [(names[n_dim - 1], cell, {"kind": 2, "boundary": i}) for cell in boxes(face)]
        rows += [("point", [int(self.first[0])], {"kind": 2, "boundary": 5})]
        for i, face in enumerate(faces[1:3], start=1):
            rows += [(names[n_dim - 1], cell, {"kind": 3, "contact": 1, "side": i}) for cell in boxes(face)]
        for a, b in zip(self.owners, self.second, strict=False):
            rows += [("line", [a, b], {"kind": 4, "contact": 1, "share": 0.75})]
            rows += [("line", [a, self.second[0]], {"kind": 4, "contact": 1, "share": 0.25})]
        self.rows = rows

    def fields(self) -> dict[str, np.ndarray]:
        """By name."""
        n = len(self.points)
        fields = {
            name: np.array([row[2].get(name, 0) for row in self.rows], dtype=float) for name in CELL_FIELDS
        }
        fields |= {name: np.zeros((n, 3)) for name in NODE_VECTORS} | {
            name: np.zeros(n) for name in NODE_NUMBERS
        }
        up = self.n_dim - 1
        fields["prescribed"][self.bottom, : self.n_dim] = 1
        fields["load"][self.top, up] = -PUSH
        fields["contact_normal"][self.owners, up] = 1
        fields["contact_side"][self.owners], fields["contact_side"][self.second] = 1, 2
        fields["contact_row"][self.owners] = 1
        fields["contact_row"][self.owners[0]] = 2
        fields["contact_entry"][[*self.owners, *self.second]] = 1
        fields["gap"] += np.nan
        fields["gap"][self.owners] = GAP + self.points[self.owners, 0]
        fields["contact_area"][self.owners] = 0.5
        fields["n_partners"][self.owners] = 2
        return fields

    def write(self, folder: Path) -> Path:
        """As the program does."""
        folder.mkdir(parents=True, exist_ok=True)
        flat = []
        for name, nodes, _ in self.rows:
            flat += [XDMF[name, len(nodes)], *([len(nodes)] if name in ("point", "line") else []), *nodes]
        with h5py.File(folder / "check.h5", "w") as file:
            file.attrs["format"], file.attrs["format_version"] = "signorom fields", np.int32(3)
            file["mesh/coordinates"], file["mesh/topology"] = self.points, np.array(flat, dtype=np.int32)
            file["mesh/coordinates"].attrs["unit"] = "mm"
            for name, values in self.fields().items():
                file[f"points/0001/{name}"] = values
            file["points/0001"].attrs["label"] = "push = 3 N"
            file["points/0001/load"].attrs["unit"] = "N"
            names = {"model": ["solid" if self.n_dim == 3 else "plane_strain"], "materials": ["steel"]}
            names |= {"regions": ["lower", "upper"], "contacts": ["lower_face - upper_face"]}
            names["boundaries"] = ["bottom", "lower_face", "upper_face", "top", "pin"]
            for name, texts in names.items():
                file[f"check/{name}"] = np.array(texts, dtype="S")
        return folder / "check.h5"


@pytest.fixture(params=[2, 3])
def setup(request: pytest.FixtureRequest) -> Setup:
    return Setup(request.param)


def collections(figure, kind: type, gid: str) -> list:
    return [
        item
        for axes in figure.axes
        for item in axes.collections
        if isinstance(item, kind) and item.get_gid() == gid
    ]


def flat(setup: Setup, places: np.ndarray) -> np.ndarray:
    """Where places, or directions, are in the first picture."""
    return places[:, :2] if setup.n_dim == 2 else places @ view()[:2].T


def test_bodies_with_supports_and_loads(setup: Setup, tmp_path: Path) -> None:
    check = read_check(setup.write(tmp_path))
    with styled():
        figure = check_bodies(check)
        check_picture(figure, tmp_path / "bodies.png")
    legend = (figure.legends or [figure.axes[0].get_legend()])[0]
    texts = [text.get_text() for text in legend.get_texts()]
    n_face = len(setup.top)
    zeros = ", ".join("0" for _ in range(setup.n_dim - 1))
    assert f"loads of facets, sum ({zeros}, {-PUSH * n_face:g}) N" in texts
    assert f"$u_x$ = 0, {n_face} nodes" in texts
    assert [text for text in texts if text[0].isdigit()] == [
        "1  bottom",
        "2  lower_face",
        "3  upper_face",
        "4  top",
        "5  pin",
    ]
    # the top is seen from above, and its loads end there, in the middles of its facets
    loads = next(item for item in collections(figure, Quiver, "load") if len(item.U))
    assert loads.pivot == "tip"
    middles = [setup.points[nodes].mean(axis=0) for _, nodes, told in setup.rows if told.get("boundary") == 4]
    np.testing.assert_allclose(
        np.sort(loads.get_offsets(), axis=0), np.sort(flat(setup, np.array(middles)), axis=0)
    )
    down = flat(setup, -np.eye(3)[setup.n_dim - 1 : setup.n_dim])[0]
    assert np.all(np.column_stack([loads.U, loads.V]) @ down > 0)
    marks = [line.get_xydata() for axes in figure.axes for line in lines_of(axes, "support 0")]
    held = {tuple(np.round(place, 9)) for place in flat(setup, setup.points[setup.bottom])}
    assert {tuple(np.round(place, 9)) for place in marks[0]} <= held
    if setup.n_dim == 2:
        assert len(marks[0]) == n_face
    else:
        # from below the whole bottom is seen
        assert len(marks[1]) == n_face


def quadratic_edges(pressures: list[float]) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
    """Edges of three nodes and length 2 along x, and the nodal forces of a pressure on each: 1/6, 4/6, 1/6 of it."""
    n = len(pressures)
    points = np.zeros((2 * n + 1, 3))
    points[:, 0] = np.arange(2 * n + 1)
    edges = [np.array([2 * i, 2 * i + 1, 2 * i + 2]) for i in range(n)]
    forces = np.zeros_like(points)
    for edge, pressure in zip(edges, pressures, strict=True):
        forces[edge, 1] -= 2 * pressure * np.array([1, 4, 1]) / 6
    return points, forces, edges


def check_of(points: np.ndarray, forces: np.ndarray, edges: list[np.ndarray]) -> CheckFile:
    """A set-up with nothing but boundary facets and loads."""
    fields = {"kind": Quantity(np.full(len(edges), 2.0)), "load": Quantity(forces)}
    return CheckFile(Path("check.h5"), Mesh(points, [], 2), "", edges, fields, {})


def test_arrows_of_a_pressure_on_quadratic_edges_are_equal() -> None:
    """Its nodal forces alternate; a facet's force is pressure times length, and unloaded facets have none."""
    points, forces, edges = quadratic_edges([5.0, 5.0, 5.0, 0.0, 0.0])
    arrows = load_arrows(check_of(points, forces, edges), np.zeros_like(points))
    np.testing.assert_allclose(arrows.places[:, 0], [1, 3, 5])
    # the node at the end of the load is not shared with the facet beside it
    np.testing.assert_allclose(arrows.vectors[:, 1], [-10.0, -10.0, -10.0])


def test_no_arrow_of_a_window_points_against_the_load() -> None:
    """A window ends at a fifth of an edge: the last node's force, the integral of N, points outwards."""
    points, forces, edges = quadratic_edges([5.0, 0.0])
    cut = 0.2
    x = cut * (np.arange(1000) + 0.5) / 1000
    shapes = np.array([(1 - x) * (1 - 2 * x), 4 * x * (1 - x), x * (2 * x - 1)])
    forces[edges[1], 1] -= 2 * 5.0 * cut * shapes.mean(axis=1)
    assert forces[4, 1] > 0
    arrows = load_arrows(check_of(points, forces, edges), np.zeros_like(points))
    assert (arrows.vectors[:, 1] < 0).all()
    np.testing.assert_allclose(arrows.vectors.sum(axis=0), [0.0, -2 * 5.0 * (1 + cut), 0.0], rtol=1e-6)


def test_force_of_a_point_stays_at_its_node() -> None:
    points, forces, edges = quadratic_edges([0.0, 0.0])
    forces[2, 1] = -7.0
    arrows = load_arrows(check_of(points, forces, edges), np.zeros_like(points))
    np.testing.assert_allclose(arrows.places, points[2:3])
    np.testing.assert_allclose(arrows.vectors, forces[2:3])


def test_numbers_of_boundaries_stand_apart(tmp_path: Path) -> None:
    """Both sides of a wall thinner than the number: the second one moves along the wall."""
    setup = Setup(2)
    setup.points[:, 1] = np.where(setup.points[:, 1] > 0, GAP, setup.points[:, 1])
    setup.points[setup.top, 1] = GAP + 0.06
    with styled():
        figure = check_bodies(read_check(setup.write(tmp_path)))
    places = [text.get_position() for text in figure.axes[0].texts]
    distances = [np.linalg.norm(np.subtract(a, b)) for i, a in enumerate(places) for b in places[:i]]
    assert min(distances) > 0.06


def test_contact_with_gaps_normals_and_partners(setup: Setup, tmp_path: Path) -> None:
    check = read_check(setup.write(tmp_path))
    with styled():
        figure = check_contact(check, 1)
        check_picture(figure, tmp_path / "contact.png")
    title = figure.axes[0].get_title("left") if setup.n_dim == 2 else figure.get_suptitle()
    assert title == "contact 1: lower_face - upper_face"
    gaps = setup.fields()["gap"]
    expected = [np.nanmean(gaps[nodes]) for _, nodes, labels in setup.rows if labels.get("side") == 1]
    if setup.n_dim == 2:
        (surface,) = collections(figure, LineCollection, "first")
        np.testing.assert_allclose(surface.get_array(), expected)
    else:
        # the gap is GAP + x: three colors along x, those of the middles of the facets
        (image,) = [image for image in figure.axes[1].images if image.get_gid() == "first"]
        middle = np.asarray(image.get_array())[image.get_array().shape[0] // 6]
        shares = np.array([1 / 6, 1 / 2, 5 / 6])
        colors = middle[(len(middle) * shares).astype(int)]
        norm = Normalize(gaps[setup.owners].min(), gaps[setup.owners].max())
        np.testing.assert_allclose(colors, colormaps[SEQUENTIAL](norm(GAP + shares)), atol=1e-12)
    (normals,) = collections(figure, Quiver, "normals")
    places = {tuple(np.round(place, 9)) for place in flat(setup, setup.points[setup.owners])}
    assert {tuple(np.round(place, 9)) for place in normals.get_offsets()} == places
    up = flat(setup, np.eye(3)[setup.n_dim - 1 : setup.n_dim])[0]
    directions = np.column_stack([normals.U, normals.V])
    np.testing.assert_allclose(
        directions / np.linalg.norm(directions, axis=1)[:, None],
        [up / np.linalg.norm(up)] * len(places),
        atol=1e-12,
    )
    (links,) = collections(figure, LineCollection, "links")
    assert len(links.get_segments()) == 2 * len(setup.owners)
    shown = {
        gid: next(line.get_xydata() for axes in figure.axes for line in lines_of(axes, gid))
        for gid in ("alone", "inert")
    }
    plane = setup.points[:, :2]
    np.testing.assert_allclose(shown["alone"], plane[setup.first[-1:]])
    np.testing.assert_allclose(shown["inert"], plane[setup.owners[:1]])
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    assert "nodes that face nothing: 1" in texts
    assert "up to 2 partners of a node" in texts


@pytest.mark.parametrize(
    ("n_dim", "kind"), [(2, "folder"), (2, "check.h5"), (2, "check.xdmf"), (3, "folder")]
)
def test_command_writes_pictures(
    n_dim: int, kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Setup(n_dim).write(tmp_path)
    (tmp_path / "check.xdmf").write_text("")
    assert main(["check", str(tmp_path if kind == "folder" else tmp_path / kind)]) == 0
    expected = [tmp_path / "figures" / name for name in ("check_bodies.png", "check_contact_1.png")]
    assert capsys.readouterr().out.splitlines() == [str(path) for path in expected]
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in expected)


def test_two_runs_write_the_same_bytes(setup: Setup, tmp_path: Path) -> None:
    path = setup.write(tmp_path)
    for run in ("a", "b"):
        assert main(["check", str(path), "--output", str(tmp_path / run), "--format", "svg"]) == 0
    for picture in (tmp_path / "a").iterdir():
        assert picture.read_bytes() == (tmp_path / "b" / picture.name).read_bytes()


def test_obstacle_and_constant_gap(tmp_path: Path) -> None:
    """Without a second surface there are no lines; one gap everywhere needs no scale."""
    setup = Setup(2)
    path = setup.write(tmp_path)
    with h5py.File(path, "r+") as file:
        point = file["points/0001"]
        is_other = (point["kind"][()] == 4) | (point["side"][()] == 2)
        point["contact"][is_other] = 0
        point["side"][is_other] = 0
        point["n_partners"][...] = 0
        point["gap"][setup.owners] = 0.25
    with styled():
        figure = check_contact(read_check(path), 1)
        check_picture(figure, tmp_path / "contact.png")
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    assert "second surface" not in texts
    assert "rigid obstacle" in texts
    assert "gap everywhere 0.25" in texts
    assert len(figure.axes) == 1


def rename(path: Path, old: str, new: str | None) -> None:
    with h5py.File(path, "r+") as file:
        if new is not None:
            file[new] = file[old]
        del file[old]


def shorten(path: Path) -> None:
    with h5py.File(path, "r+") as file:
        values = file["points/0001/gap"][:-1]
        del file["points/0001/gap"]
        file["points/0001/gap"] = values


def relabel(path: Path, name: str) -> None:
    with h5py.File(path, "r+") as file:
        file[f"points/0001/{name}"][...] = 0


def set_type(path: Path) -> None:
    with h5py.File(path, "r+") as file:
        file["mesh/topology"][0] = 77


@pytest.mark.parametrize(
    ("damage", "sentence"),
    [
        (Path.unlink, "there is no such file; `signorom check DECK --fields` writes one"),
        (lambda path: path.write_text("no"), "this is not an HDF5 file, or it is damaged"),
        (
            lambda path: rename(path, "check", None),
            "the file has no set-up of a deck; `signorom check DECK --fields`",
        ),
        (lambda path: rename(path, "points/0001/load", None), "dataset '/points/0001/load' is missing"),
        (lambda path: rename(path, "check/regions", None), "dataset '/check/regions' is missing"),
        (shorten, "'/points/0001/gap' has the shape (31,); (32,) is needed"),
        (lambda path: relabel(path, "side"), "contact 1 has no first surface"),
        (set_type, "'/mesh/topology' has the cell type 77; known are [1, 2, 4,"),
    ],
)
def test_unusable_file_ends_with_a_sentence(
    damage, sentence: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = Setup(2).write(tmp_path)
    damage(path)
    assert main(["check", str(tmp_path)]) == 2
    captured = capsys.readouterr()
    assert captured.err.startswith(f"{path}: error: {sentence}")
    assert captured.out == ""
    assert not (tmp_path / "figures").exists()
