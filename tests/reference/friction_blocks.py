# SPDX-License-Identifier: BSD-3-Clause
"""Bodies of Q4 or H8 with Coulomb friction between nodes that face each other, or against rigid planes: a whole history.

Independent of the program: own reader of decks and meshes, own assembly, W = B K^-1 B' over normal and tangential rows,
and in each step a long block Gauss-Seidel (coulomb_steps.py) in place of Newton's method. Small decks only: matrices of
all contacts are dense, and sweeps are slow.

Bodies that contact alone holds are held by springs at all of their nodes, whose forces are taken away by a fixed-point
iteration (proximal point method): K + s I with the load F + s u, until u stays.

    python3 tests/reference/friction_blocks.py DECK [NAME=VALUE ...]      forces of all contacts, a line per time
    python3 tests/reference/friction_blocks.py                            self checks

Conventions: the normal n of a contact leads from its first side to the second one; tangents are (-n_y, n_x) in the
plane, in space the axis of the smallest component of n without its part along n, and n x t_1. lambda and tau are forces
on the second side, along n and along the tangents; s = t.(u_first - u_second).
"""

import itertools
import sys
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import scipy.sparse
import scipy.sparse.csgraph
import scipy.sparse.linalg
import scipy.spatial
import yaml

from coulomb_steps import Steps
from gmsh_ascii import physical_tags, sections_of

#: gmsh's types: number of nodes, dimension
KINDS = {15: (1, 0), 1: (2, 1), 3: (4, 2), 5: (8, 3)}
CORNERS = {
    1: np.array([[-1.0], [1]]),
    2: np.array([[-1.0, -1], [1, -1], [1, 1], [-1, 1]]),
    3: np.array(
        [[-1.0, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]]
    ),
}
# [-] motion that is still to come in the iteration of floating bodies, relative to the largest displacement
REACHED = 1e-13
MOST_ROUNDS = 2000
# [-] weight of the springs of floating bodies: their sum over the largest stiffness of a node
SPRINGS = 0.03


@dataclass
class Mesh:
    """Nodes of cells, 0-based in the file's order; groups by name: lists of cells and facets, arrays of nodes."""

    places: np.ndarray
    cells: np.ndarray
    cells_of: dict = field(default_factory=dict)
    facets_of: dict = field(default_factory=dict)

    def nodes_of(self, name):
        """Nodes of a group, ascending."""
        return np.unique(self.facets_of[name] if name in self.facets_of else self.cells[self.cells_of[name]])


def words_of(lines):
    """Numbers of each line."""
    return [[int(word) for word in line.split()] for line in lines]


def read_format_2(sections):
    """Tags, places and (dimension, physical tags, kind, nodes) of gmsh 2.2."""
    rows = [line.split() for line in sections["Nodes"][1:]]
    tags = [int(row[0]) for row in rows]
    places = [[float(word) for word in row[1:]] for row in rows]
    elements = []
    for row in words_of(sections["Elements"][1:]):
        kind, n_tags = row[1], row[2]
        elements.append((KINDS[kind][1], [row[3]], kind, row[3 + n_tags :]))
    return tags, places, elements


def read_format_4(sections):
    """As read_format_2, of gmsh 4.1."""
    groups = physical_tags(sections["Entities"])
    tags, places, elements = [], [], []
    lines = iter(sections["Nodes"])
    for _ in range(int(next(lines).split()[0])):
        n = int(next(lines).split()[3])
        tags += [int(next(lines)) for _ in range(n)]
        places += [[float(word) for word in next(lines).split()[:3]] for _ in range(n)]
    lines = iter(sections["Elements"])
    for _ in range(int(next(lines).split()[0])):
        dimension, entity, kind, n = (int(word) for word in next(lines).split())
        own = groups.get((dimension, entity), [])
        elements += [(dimension, own, kind, row[1:]) for row in words_of(itertools.islice(lines, n))]
    return tags, places, elements


def read_mesh(path, n_dim):
    """ASCII gmsh 2.2 or 4.1; nodes that no cell uses are dropped."""
    sections = sections_of(path)
    version, is_binary = sections["MeshFormat"][0].split()[:2]
    assert is_binary == "0"
    words = [line.split(maxsplit=2) for line in sections["PhysicalNames"][1:]]
    names = {(int(d), int(tag)): name.strip().strip('"') for d, tag, name in words}
    tags, places, elements = read_format_2(sections) if version == "2.2" else read_format_4(sections)
    used = {node for dimension, _, _, nodes in elements if dimension == n_dim for node in nodes}
    kept = [i for i, tag in enumerate(tags) if tag in used]
    number_of = {tags[i]: number for number, i in enumerate(kept)}
    mesh = Mesh(np.array(places)[kept][:, :n_dim], None)
    cells = []
    for dimension, own, _, nodes in elements:
        numbers = [number_of[node] for node in nodes if node in number_of]
        for name in (names[dimension, tag] for tag in own):
            if dimension == n_dim:
                mesh.cells_of.setdefault(name, []).append(len(cells))
            else:
                mesh.facets_of.setdefault(name, []).append(numbers)
        if dimension == n_dim:
            cells.append(numbers)
    mesh.cells = np.array(cells)
    return mesh


def gauss_points(n_dim):
    """Two points per direction; all weights are 1."""
    return np.array(list(itertools.product([-(3**-0.5), 3**-0.5], repeat=n_dim)))


def shapes(point):
    """Shape functions and their slopes (n_nodes, n_dim) of a segment, square or cube."""
    n_dim = len(point)
    factors = 1 + CORNERS[n_dim] * point
    slopes = np.empty((2**n_dim, n_dim))
    for i in range(n_dim):
        slopes[:, i] = CORNERS[n_dim][:, i] * np.delete(factors, i, axis=1).prod(axis=1) / 2**n_dim
    return factors.prod(axis=1) / 2**n_dim, slopes


def lame_constants(young, poisson, model):
    """Of the model: those of plane stress give sigma_zz = 0."""
    mu = young / (2 * (1 + poisson))
    lame = young * poisson / ((1 + poisson) * (1 - 2 * poisson))
    return (2 * lame * mu / (lame + 2 * mu) if model == "plane_stress" else lame), mu


def stiffness_of(mesh, young, poisson, model):
    """K; Young's modulus and Poisson's ratio of each cell.

    With d_a the gradient of shape function a, in axisymmetry with N_a / r added along r, a pair of nodes has
    lambda d_a d_b' + mu (g_b g_a' + g_a.g_b I), in axisymmetry 2 mu N_a N_b / r^2 along r besides.
    """
    n_dim = mesh.places.shape[1]
    lame, mu = lame_constants(young, poisson, model)
    corners = mesh.places[mesh.cells]
    blocks = 0
    for point in gauss_points(n_dim):
        values, slopes = shapes(point)
        jacobians = np.einsum("ai,caj->cij", slopes, corners)
        volume = np.linalg.det(jacobians)
        assert (volume > 0).all()
        gradients = np.einsum("cji,ai->caj", np.linalg.inv(jacobians), slopes)
        divergence = gradients.copy()
        if model == "axisymmetric":
            radius = corners[:, :, 0] @ values
            volume = volume * 2 * np.pi * radius
            divergence[:, :, 0] += values / radius[:, None]
        part = np.einsum("c,cai,cbj->caibj", volume * lame, divergence, divergence)
        part += np.einsum("c,caj,cbi->caibj", volume * mu, gradients, gradients)
        part += np.einsum("c,cak,cbk,ij->caibj", volume * mu, gradients, gradients, np.eye(n_dim))
        if model == "axisymmetric":
            part[:, :, 0, :, 0] += np.einsum("c,a,b->cab", 2 * volume * mu / radius**2, values, values)
        blocks = blocks + part
    dofs = (mesh.cells[:, :, None] * n_dim + np.arange(n_dim)).reshape(len(mesh.cells), -1)
    size = dofs.shape[1]
    rows, columns = np.repeat(dofs, size, axis=1).ravel(), np.tile(dofs, (1, size)).ravel()
    return scipy.sparse.csc_matrix((blocks.ravel(), (rows, columns)), shape=(mesh.places.size,) * 2)


def inner_place(mesh, nodes):
    """Middle of the cell behind a facet."""
    behind = np.isin(mesh.cells, nodes).sum(axis=1) == len(nodes)
    return mesh.places[mesh.cells[np.argmax(behind)]].mean(axis=0)


def area_vector(mesh, nodes):
    """Outward normal of a facet times its size."""
    x = mesh.places[nodes]
    if len(nodes) == 2:
        along = x[1] - x[0]
        vector = np.array([along[1], -along[0]])
    else:
        vector = np.cross(x[2] - x[0], x[3] - x[1]) / 2
    return vector if vector @ (x.mean(axis=0) - inner_place(mesh, nodes)) > 0 else -vector


def surface_load(mesh, name, density, model):
    """Nodal forces of a traction density(place, outward unit normal) on a surface; two Gauss points per direction."""
    forces = np.zeros(mesh.places.shape)
    for nodes in mesh.facets_of[name]:
        x, area = mesh.places[nodes], area_vector(mesh, nodes)
        for point in gauss_points(x.shape[1] - 1):
            values, slopes = shapes(point)
            sides = slopes.T @ x
            size = np.linalg.norm(sides[0]) if len(sides) == 1 else np.linalg.norm(np.cross(*sides))
            place = values @ x
            if model == "axisymmetric":
                size *= 2 * np.pi * place[0]
            forces[nodes] += size * np.outer(values, density(place, area / np.linalg.norm(area)))
    return forces


def body_load(mesh, name, density, model):
    """Nodal forces of a body force density(place) on a region."""
    forces = np.zeros(mesh.places.shape)
    for cell in mesh.cells_of[name]:
        nodes = mesh.cells[cell]
        x = mesh.places[nodes]
        for point in gauss_points(x.shape[1]):
            values, slopes = shapes(point)
            place = values @ x
            size = np.linalg.det(slopes.T @ x) * (2 * np.pi * place[0] if model == "axisymmetric" else 1)
            forces[nodes] += size * np.outer(values, density(place))
    return forces


def tangents_of(normal):
    """Tangents of a normal, in rows: head of this file."""
    if len(normal) == 2:
        return np.array([[-normal[1], normal[0]]])
    axis = np.eye(3)[np.flatnonzero(np.abs(normal) <= np.abs(normal).min() + 1e-8)[0]]
    first = axis - (axis @ normal) * normal
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(normal, first)])


def averaged_normals(mesh, name):
    """Outward normals of any length at the nodes of a surface: the sum of the area vectors around each."""
    sums = np.zeros(mesh.places.shape)
    for nodes in mesh.facets_of[name]:
        sums[nodes] += area_vector(mesh, nodes)
    return sums


def partners_of(mesh, first, second, normals):
    """Nodes of the second surface nearest to the line along the normal through each node of the first one."""
    found = []
    for node in first:
        away = mesh.places[second] - mesh.places[node]
        along = away @ normals[node]
        aside = np.linalg.norm(away - along[:, None] * normals[node], axis=1)
        found.append(second[np.argmin(aside)])
    assert len(set(found)) == len(found)
    return np.array(found)


class Names(dict):
    """Names that expressions may use."""

    def evaluate(self, value, **more):
        """Number of a deck's number or expression."""
        if not isinstance(value, str):
            return float(value)
        functions = {name: getattr(np, name) for name in ("sin", "cos", "exp", "sqrt", "abs")}
        functions |= {"min": min, "max": max, "_pi": np.pi}
        return float(eval(value.replace("^", "**"), {"__builtins__": {}}, {**functions, **self, **more}))


def times_of(steps):
    """Times of a deck's steps."""
    times, begin = [], 0.0
    for step in steps:
        n, growth = step["increments"], step.get("growth", 1)
        factor = growth ** (1 / (n - 1)) if n > 1 else 1.0
        shares = np.cumsum(factor ** np.arange(n))
        times += (begin + (step["until"] - begin) * shares / shares[-1]).tolist()
        begin = step["until"]
    return np.array(times)


@dataclass
class Row:
    """A contact: nodes of both sides (the second one None at a plane), normal, entry of the deck."""

    first: int
    second: int | None
    normal: np.ndarray
    entry: dict


@dataclass
class History:
    """What happens: (n_times, ...); contacts by the number (from 1) of their first node."""

    times: np.ndarray
    numbers: np.ndarray
    #: forces of contacts; tangential ones with one or two components, 0 where there is no row
    normal: np.ndarray
    tangential: np.ndarray
    slips: np.ndarray
    states: np.ndarray
    displacement: np.ndarray
    #: loads without reactions, and whether dofs are prescribed
    loads: np.ndarray
    n_sweeps: np.ndarray


class Blocks:
    """A deck at a point of its parameters."""

    def __init__(self, deck, point=None):
        """Deck: its path. Point: by default that of the deck's output."""
        path = Path(deck)
        self.deck = yaml.safe_load(path.read_text())
        point = self.deck.get("output", {}).get("points", [{}])[0] if point is None else point
        self.point = Names({name: float(value) for name, value in point.items()})
        self.model = self.deck["mesh"]["model"]
        self.n_dim = 3 if self.model == "solid" else 2
        self.mesh = read_mesh(path.parent / self.deck["mesh"]["file"], self.n_dim)
        self.axes = "rz" if self.model == "axisymmetric" else "xyz"[: self.n_dim]
        young, poisson = np.zeros((2, len(self.mesh.cells)))
        for material in self.deck["materials"].values():
            for region in material["regions"]:
                young[self.mesh.cells_of[region]] = self.point.evaluate(material["young_modulus"])
                poisson[self.mesh.cells_of[region]] = self.point.evaluate(material["poisson_ratio"])
        self.stiffness = stiffness_of(self.mesh, young, poisson, self.model)
        self.prescribed = self.collect_prescribed()
        self.make_rows()
        self.condense()

    def collect_prescribed(self):
        """Expression of each prescribed dof."""
        found = {}
        for entry in self.deck["boundary_conditions"]:
            for node in self.mesh.nodes_of(entry["boundary"]):
                for axis, value in entry["displacement"].items():
                    found[int(node) * self.n_dim + self.axes.index(axis)] = value
        return found

    def make_rows(self):
        """Contacts, ascending in their entry and first node; matrix of all rows, rows and f of each contact."""
        self.contacts = []
        for entry in self.deck["contact"]:
            nodes = self.mesh.nodes_of(entry["first"])
            normals = averaged_normals(self.mesh, entry["first"])
            if "obstacle" in entry:
                normals[:] = -np.array(entry["obstacle"]["normal"], float)
            elif "direction" in entry:
                normals[:] = entry["direction"]
            normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
            partners = [None] * len(nodes)
            if "second" in entry:
                partners = partners_of(self.mesh, nodes, self.mesh.nodes_of(entry["second"]), normals)
            self.contacts += [
                Row(int(i), partner, normals[i], entry) for i, partner in zip(nodes, partners, strict=True)
            ]
        is_free = np.ones(self.mesh.places.size, bool)
        is_free[list(self.prescribed)] = False
        self.free = np.flatnonzero(is_free)
        kept, self.rows, lines = [], [], []
        for row in self.contacts:
            own = [self.line_of(row, axis) for axis in (row.normal, *tangents_of(row.normal))]
            moves = [bool(np.abs(line[self.free]).max() > 0) for line in own]
            if not moves[0]:
                continue
            kept.append(row)
            numbers = [None] * self.n_dim
            for i, line in enumerate(own):
                if moves[i]:
                    numbers[i] = len(lines)
                    lines.append(line)
            self.rows.append(numbers)
        self.contacts = kept
        self.matrix = np.array(lines)
        self.friction = [self.point.evaluate(row.entry.get("friction", 0.0)) for row in kept]

    def line_of(self, row, axis):
        """Row of B along an axis."""
        line = np.zeros(self.mesh.places.size)
        line[self.n_dim * row.first :][: self.n_dim] = axis
        if row.second is not None:
            line[self.n_dim * row.second :][: self.n_dim] = -axis
        return line

    def condense(self):
        """Factor K, or K and the springs of floating bodies; W."""
        self.springs = self.springs_of_floating()
        held = (self.stiffness + scipy.sparse.diags(self.springs)).tocsc()
        self.solve_stiffness = scipy.sparse.linalg.splu(held[self.free][:, self.free].tocsc()).solve
        self.response = np.zeros((self.mesh.places.size, len(self.matrix)))
        self.response[self.free] = self.solve_stiffness(self.matrix[:, self.free].T)
        compliance = self.matrix @ self.response
        self.compliance = (compliance + compliance.T) / 2

    def springs_of_floating(self):
        """Spring of each dof: that of a body which prescribed displacements alone do not hold."""
        cells, n_nodes = self.mesh.cells, len(self.mesh.places)
        pairs = cells[:, [0] * (cells.shape[1] - 1)].ravel(), cells[:, 1:].ravel()
        graph = scipy.sparse.coo_matrix((np.ones(len(pairs[0])), pairs), shape=(n_nodes, n_nodes))
        n_bodies, body_of = scipy.sparse.csgraph.connected_components(graph, directed=False)
        springs = np.zeros(self.mesh.places.size)
        stiffest = self.stiffness.diagonal().max()
        for body in range(n_bodies):
            nodes = np.flatnonzero(body_of == body)
            motions = self.rigid_motions(nodes)
            held = [dof for dof in self.prescribed if body_of[dof // self.n_dim] == body]
            if np.linalg.matrix_rank(motions[held], tol=1e-9) < motions.shape[1]:
                dofs = (nodes[:, None] * self.n_dim + np.arange(self.n_dim)).ravel()
                springs[dofs] = SPRINGS * stiffest / len(nodes)
        return springs

    def rigid_motions(self, nodes):
        """Translations and rotations of some nodes, in columns."""
        places = self.mesh.places / np.abs(self.mesh.places).max()
        motions = []
        if self.model == "axisymmetric":
            kinds = [(None, 1)]
        else:
            kinds = [(None, i) for i in range(self.n_dim)]
            kinds += list(itertools.combinations(range(self.n_dim), 2))
        for i, j in kinds:
            motion = np.zeros(places.shape)
            motion[nodes, j] = 1 if i is None else places[nodes, i]
            if i is not None:
                motion[nodes, i] = -places[nodes, j]
            motions.append(motion.ravel())
        return np.array(motions).T

    def names_at(self, time):
        """Parameters, time and tables."""
        names = Names(self.point)
        for name, table in self.deck.get("history", {}).get("tables", {}).items():
            nodes = [[self.point.evaluate(value) for value in table[key]] for key in ("time", "value")]
            names[name] = float(np.interp(time, *nodes))
        names["time"] = time
        return names

    def at_place(self, names, value, place):
        """Value of an expression of coordinates."""
        return names.evaluate(value, **dict(zip(self.axes, place.tolist(), strict=True)))

    def loads_at(self, names):
        """Nodal forces of all loads."""
        forces = np.zeros(self.mesh.places.size)

        def vector(components, place):
            value = np.zeros(self.n_dim)
            for axis, text in components.items():
                value[self.axes.index(axis)] = self.at_place(names, text, place)
            return value

        for entry in self.deck.get("loads") or []:
            assert set(entry) <= {"boundary", "traction", "pressure", "region", "body_force"}
            if "region" in entry:
                load = body_load(
                    self.mesh, entry["region"], lambda x, e=entry: vector(e["body_force"], x), self.model
                )
            else:

                def density(place, outward, entry=entry):
                    value = vector(entry.get("traction", {}), place)
                    return value - self.at_place(names, entry.get("pressure", 0), place) * outward

                load = surface_load(self.mesh, entry["boundary"], density, self.model)
            forces += load.ravel()
        return forces

    def gaps_at(self, names):
        """Gaps of all contacts before anything moves."""
        gaps = []
        for row in self.contacts:
            place = self.mesh.places[row.first]
            if "obstacle" in row.entry:
                point = np.array([names.evaluate(value) for value in row.entry["obstacle"]["point"]])
                gaps.append(row.normal @ (point - place))
            elif "initial_gap" in row.entry:
                gaps.append(self.at_place(names, row.entry["initial_gap"], place))
            else:
                gaps.append(row.normal @ (self.mesh.places[row.second] - place))
        return np.array(gaps)

    def start(self):
        """The steps before the first time."""
        rows = [[i for i in numbers if i is not None] for numbers in self.rows]
        return Steps(self.compliance, rows, self.friction)

    def free_of(self, forces, prescribed):
        """Displacement without contact under nodal forces (springs included)."""
        u = np.zeros(self.mesh.places.size)
        for dof, value in prescribed.items():
            u[dof] = value
        load = forces - self.stiffness @ u - self.springs * u
        u[self.free] = self.solve_stiffness(load[self.free])
        return u

    def step(self, steps, time, before):
        """The next time: forces, states, slips, displacement, loads; `before`: displacement at the last time."""
        names = self.names_at(time)
        loads, gaps = self.loads_at(names), self.gaps_at(names)
        places = self.mesh.places
        prescribed = {
            dof: self.at_place(names, value, places[dof // self.n_dim])
            for dof, value in self.prescribed.items()
        }
        u, forces, n_sweeps = before, None, 0
        for _ in range(MOST_ROUNDS):
            without = self.free_of(loads + self.springs * u, prescribed)
            free = self.matrix @ without
            normals = [numbers[0] for numbers in self.rows]
            free[normals] = gaps - free[normals]
            forces, states = steps.solve(free, forces)
            n_sweeps += steps.n_sweeps
            following = without - self.response @ forces
            moved = np.abs((following - u)[self.springs > 0]).max(initial=0)
            u = following
            if moved <= REACHED * np.abs(u).max():
                break
        else:
            raise ArithmeticError(
                f"time {time}: bodies keep moving: no equilibrium, or friction near its limit"
            )
        slips = steps.accept(free, forces, states)
        return forces, states, slips, u, loads, n_sweeps

    def history(self):
        """All times of the deck."""
        times = times_of(self.deck["history"]["steps"])
        steps, u = self.start(), np.zeros(self.mesh.places.size)
        collected = []
        for time in times:
            collected.append(self.step(steps, time, u))
            u = collected[-1][3]
        forces, states, slips, displacement, loads, n_sweeps = (
            np.array(part) for part in zip(*collected, strict=True)
        )
        return History(
            times,
            np.array([row.first + 1 for row in self.contacts]),
            *(self.spread(forces, i) for i in range(2)),
            self.spread(slips, 1),
            states,
            displacement,
            loads,
            n_sweeps,
        )

    def spread(self, values, first):
        """Values of normal rows (first = 0), or of all tangential ones with 0 where there is none."""
        padded = np.pad(values, ((0, 0), (0, 1)))
        if first == 0:
            return padded[:, [numbers[0] for numbers in self.rows]]
        return padded[:, [[-1 if i is None else i for i in numbers[1:]] for numbers in self.rows]]


def dissipation_of(history):
    """Sum over the contacts of tau.slip, per time."""
    return np.sum(history.tangential * history.slips, axis=(1, 2))


def print_history(history):
    """A line per time: forces by node, n and then the tangents."""
    print("time", *(f"lambda_{k} tau_{k}" for k in history.numbers), sep="; ")
    for i, time in enumerate(history.times):
        parts = [
            " ".join(f"{value:.12g}" for value in (normal, *tangential))
            for normal, tangential in zip(history.normal[i], history.tangential[i], strict=True)
        ]
        print(f"{time:.12g}", *parts, sep="; ")


def main(arguments):
    """Forces of a deck, or the self checks."""
    if not arguments:
        from friction_blocks_checks import check_all

        check_all()
        return
    deck, *values = arguments
    point = {name: float(value) for name, value in (text.split("=") for text in values)} or None
    print_history(Blocks(deck, point).history())


if __name__ == "__main__":
    main(sys.argv[1:])
