# SPDX-License-Identifier: BSD-3-Clause
"""Self checks of friction_blocks.py: blocks whose stress is uniform, blocks turned as a whole, balances.

Two blocks without lateral strain (nu = 0) are pressed together by a stroke and moved along each other: a spring and a
slider. With shear stress q on their sides the stress is uniform: in each block q = G (U - s) / H along each tangent, s
the slip, limited to |q| <= f p; a node carries its share of the surface.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).resolve().parents[1] / "support"))

from block_meshes import Mesh, consistent_areas
from coulomb_steps import SLIPS, check
from friction_blocks import Blocks, dissipation_of

YOUNG, HEIGHT, FRICTION = 300.0, 1.6, 0.35
SHEAR = YOUNG / 2
TIMES = np.arange(9)
STROKE = np.array([0, 1, 2, 2, 2, 1.5, 1.5, 2.5, 1.0]) * 0.01
MOVES = np.array([[0, 1, 3, 9, -4, -6, 5, 2, 8], [0, 1, -2, 5, 6, -1, -1, -7, 0]]) * 4e-3


def blocks(n_dim):
    """Two blocks of one height that touch at 0; faces are named by axis and side."""
    across = [np.array([0.0, 0.3, 0.55, 1.0]), np.array([0.0, 0.5, 0.7])][: n_dim - 1]
    mesh, up = Mesh(), n_dim - 1
    for name, heights in (
        ("lower", [-HEIGHT / 2, -0.3, 0.0]),
        ("upper", [0.0, 0.2, 0.5, HEIGHT / 2]),
    ):
        faces = {(axis, side): f"side_{axis}_{side}" for axis in range(up) for side in range(2)}
        faces |= {(up, side): f"{name}_{side}" for side in range(2)}
        element = "Q4" if n_dim == 2 else "H8"
        mesh.add_block(name, [*across, np.array(heights)], element, faces, moved=0.2, seed=len(name))
    return mesh


def uniform_stress(n_dim):
    """Shear stress (n_times, n_dim - 1) by hand: a spring, and a slider that gives way at f p."""
    slip, found = np.zeros(n_dim - 1), []
    for stroke, *move in zip(STROKE, *MOVES[: n_dim - 1], strict=True):
        limit = FRICTION * YOUNG * stroke / HEIGHT
        q = SHEAR * (np.array(move) - slip) / HEIGHT
        size = np.linalg.norm(q)
        if size > limit:
            q *= limit / size
            slip = np.array(move) - HEIGHT * q / SHEAR
        found.append(q)
    return np.array(found)


def table_of(values):
    """Text of a deck's table."""
    return f"{{time: {TIMES.tolist()}, value: {np.asarray(values).tolist()}}}"


def check_uniform(folder, n_dim, model):
    """Forces at all times, with reversals and turns of the direction."""
    mesh = blocks(n_dim)
    mesh.write(folder / "uniform.msh")
    stress = uniform_stress(n_dim)
    up, axes = "yz"[n_dim - 2], "xy"[: n_dim - 1]
    tables = [f"    push: {table_of(STROKE)}"]
    tables += [f"    move_{axis}: {table_of(MOVES[i])}" for i, axis in enumerate(axes)]
    tables += [f"    shear_{axis}: {table_of(stress[:, i])}" for i, axis in enumerate(axes)]
    loads = [
        f"  - {{boundary: side_{i}_{side}, traction: {{{up}: {'-' * (1 - side)}shear_{axis}}}}}"
        for i, axis in enumerate(axes)
        for side in range(2)
    ]
    moved = ", ".join(f"{axis}: move_{axis}" for axis in axes)
    held = ", ".join(f"{axis}: 0" for axis in axes + up)
    (folder / "uniform.yaml").write_text(f"""mesh: {{file: uniform.msh, model: {model}}}
parameters: {{f: {{min: 0.1, max: 1}}}}
history:
  tables:
{chr(10).join(tables)}
  steps: [{{until: 8, increments: 8}}]
materials: {{all: {{regions: [lower, upper], young_modulus: {YOUNG}, poisson_ratio: 0}}}}
boundary_conditions:
  - {{boundary: lower_0, displacement: {{{held}}}}}
  - {{boundary: upper_1, displacement: {{{moved}, {up}: -push}}}}
loads:
{chr(10).join(loads)}
contact: [{{first: lower_1, second: upper_0, friction: f}}]
output: {{points: [{{f: {FRICTION}}}]}}
""")
    history = Blocks(folder / "uniform.yaml").history()
    areas = consistent_areas(mesh, "lower_1")[history.numbers - 1]
    pressure = YOUNG * STROKE[1:] / HEIGHT
    largest = pressure.max() * areas.max()
    text = f"uniform stress, {model}"
    check(f"{text}: lambda", history.normal / largest, np.outer(pressure, areas) / largest, 1e-11)
    # the upper block's face looks down: on it acts -q along x, -q along y; tangents are -x, or x and y
    signs = np.array([1.0]) if n_dim == 2 else np.array([-1.0, -1.0])
    expected = signs * stress[1:, None, :] * areas[:, None]
    check(f"{text}: tau", history.tangential / largest, expected / largest, 1e-11)
    assert 2 <= (history.states[:, 0] == SLIPS).sum() < len(history.times)


def check_turned(folder):
    """A block that a rough floor holds alone, and the same turned by 30 degrees: forces balance and are the same."""
    angle = np.pi / 6
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    times = np.arange(6)
    normal, along = np.array([0, 4, 4, 5, 3, 4.0]), np.array([0, 1.0, 1.4, -1.2, -0.5, 1.5])
    histories = []
    for turned in (False, True):
        mesh = blocks(2)
        load = np.array([along, -normal])
        if turned:
            mesh.coordinates[:, :2] = mesh.coordinates[:, :2] @ turn.T
            load = turn @ load
        mesh.write(folder / "turned.msh")
        (folder / "turned.yaml").write_text(f"""mesh: {{file: turned.msh, model: plane_strain}}
parameters: {{f: {{min: 0.1, max: 1}}}}
history:
  tables:
    load_x: {{time: {times.tolist()}, value: {load[0].tolist()}}}
    load_y: {{time: {times.tolist()}, value: {load[1].tolist()}}}
  steps: [{{until: 5, increments: 10}}]
materials: {{all: {{regions: [lower, upper], young_modulus: {YOUNG}, poisson_ratio: 0.3}}}}
boundary_conditions: [{{boundary: lower_0, displacement: {{x: 0, y: 0}}}}]
loads: [{{boundary: upper_1, traction: {{x: load_x, y: load_y}}}}]
contact: [{{first: lower_1, second: upper_0, friction: f}}]
""")
        histories.append(Blocks(folder / "turned.yaml", {"f": 0.5}).history())
    first, second = histories
    times = first.times
    check("block on a floor: N", first.normal.sum(axis=1), np.interp(times, range(6), normal), 1e-10)
    check("block on a floor: T", first.tangential.sum(axis=(1, 2)), np.interp(times, range(6), along), 1e-10)
    check("block on a floor, turned: N", second.normal, first.normal, 1e-10)
    check("block on a floor, turned: T", second.tangential, first.tangential, 1e-10)
    assert (first.states == SLIPS).any(axis=1).sum() >= 3
    lost = dissipation_of(first)
    assert lost.max() > 0
    assert lost.min() >= -1e-10 * lost.max()


def check_all():
    """All of them."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for n_dim, model in ((2, "plane_strain"), (2, "plane_stress"), (3, "solid")):
            check_uniform(folder, n_dim, model)
        check_turned(folder)


if __name__ == "__main__":
    check_all()
