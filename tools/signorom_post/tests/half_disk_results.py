# SPDX-License-Identifier: BSD-3-Clause
"""A results folder in the program's layout, made without the program: two half disks as fans of triangles.

The fields are formulas that look like contact (they satisfy no equation of elasticity), so that a test can
compare what a reader or a figure shows with the formula.
`python half_disk_results.py DIR` writes a finer one to look at.
"""

import sys
from pathlib import Path

import h5py
import numpy as np

GAP = 0.1
TRAINING = np.round(np.linspace(0.15, 0.45, 31), 10)
POINTS = (0.2, 0.3, 0.4)
TOLERANCE = 1.0e-8
SINGULAR_VALUES = 3.0 * 10.0 ** (-0.5 * np.arange(31))
#: l for these singular values: the tail after l modes is 10**-l up to the cut end of the series
N_MODES = 9
DECK = """title: Two half disks pressed together
mesh: {file: half_disks.msh, model: plane_strain, length_unit: m}
"""


class HalfDisks:
    """The mesh, all indices 0-based: node 0 of each body is its center, then ring after ring."""

    def __init__(self, n_rings: int = 4, n_sectors: int = 12) -> None:
        self.n_rings, self.n_sectors = n_rings, n_sectors
        angles = np.linspace(0.0, np.pi, n_sectors + 1)
        rings = [np.zeros((1, 2))]
        rings += [
            r / n_rings * np.column_stack([np.cos(angles), np.sin(angles)]) for r in range(1, n_rings + 1)
        ]
        disk = np.vstack(rings) - [0.0, 1.0 + GAP / 2]
        self.n_half = len(disk)
        self.coordinates = np.zeros((2 * self.n_half, 3))
        self.coordinates[: self.n_half, :2] = disk
        self.coordinates[self.n_half :, :2] = disk * [1.0, -1.0]
        lower = self._triangles()
        self.cells = np.vstack([lower, lower[:, ::-1] + self.n_half])
        # the corners of the arc are prescribed on both sides: inert, no pair
        self.first_nodes = np.arange(self._node(n_rings, 1), self._node(n_rings, n_sectors))
        self.second_nodes = self.first_nodes + self.n_half

    def _node(self, ring: int, sector: int) -> int:
        return 0 if ring == 0 else 1 + (ring - 1) * (self.n_sectors + 1) + sector

    def _triangles(self) -> np.ndarray:
        cells = []
        for ring in range(1, self.n_rings + 1):
            for s in range(self.n_sectors):
                outer, next_outer = self._node(ring, s), self._node(ring, s + 1)
                inner, next_inner = self._node(ring - 1, s), self._node(ring - 1, s + 1)
                cells.append((inner, outer, next_outer))
                if ring > 1:
                    cells.append((inner, next_outer, next_inner))
        return np.array(cells)

    @property
    def n_nodes(self) -> int:
        return 2 * self.n_half

    @property
    def n_pairs(self) -> int:
        return len(self.first_nodes)

    def displacement(self, squeeze: float) -> np.ndarray:
        """The bases move by squeeze, the arcs at most to y = 0; shape (n_nodes, 3)."""
        x, y = self.coordinates[: self.n_half, :2].T
        arc = np.sqrt(np.maximum(1.0 - x**2, 0.0)) - (1.0 + GAP / 2)
        held = np.maximum(arc + squeeze, 0.0)
        depth = np.divide(
            y + 1 + GAP / 2, arc + 1 + GAP / 2, out=np.zeros_like(y), where=np.abs(x) < 1 - 1e-12
        )
        u = np.zeros((self.n_nodes, 3))
        u[: self.n_half, 0] = 0.35 * x * held * depth * (1 - depth) * 2
        u[: self.n_half, 1] = squeeze - held * depth**2
        u[self.n_half :] = u[: self.n_half] * [1.0, -1.0, 1.0]
        return u

    def multipliers(self, squeeze: float) -> np.ndarray:
        """A half ellipse over the part of the arc that would penetrate, shape (n_pairs)."""
        x = self.coordinates[self.first_nodes, 0]
        half_width_squared = max(1.0 - (1.0 + GAP / 2 - squeeze) ** 2, 0.0)
        return 2.0 * squeeze * np.sqrt(np.maximum(half_width_squared - x**2, 0.0))

    @property
    def reduced_rows(self) -> np.ndarray:
        """Every fourth pair, 0-based."""
        return np.arange(1, self.n_pairs, 4)

    @property
    def reduced_cells(self) -> np.ndarray:
        """Cells that touch a pair of the domain, 0-based."""
        nodes = np.concatenate([self.first_nodes[self.reduced_rows], self.second_nodes[self.reduced_rows]])
        return np.flatnonzero(np.isin(self.cells, nodes).any(axis=1))


def reduced_multipliers(disks: HalfDisks, squeeze: float) -> np.ndarray:
    """Full-order ones, 2 % larger on the domain and 5 % smaller elsewhere."""
    values = 0.95 * disks.multipliers(squeeze)
    values[disks.reduced_rows] *= 1.02 / 0.95
    return values


def write_dataset(
    group: h5py.Group, name: str, values: object, unit: str = "", description: str = ""
) -> None:
    dataset = group.create_dataset(name, data=values)
    dataset.attrs["unit"] = unit
    dataset.attrs["description"] = description


def write_fields(path: Path, disks: HalfDisks, points: tuple[float, ...] = POINTS) -> None:
    with h5py.File(path, "w") as file:
        file.attrs["format"] = "signorom fields"
        file.attrs["format_version"] = 3
        write_dataset(file, "mesh/coordinates", disks.coordinates, "m")
        write_dataset(file, "mesh/topology", disks.cells)
        write_dataset(file, "mesh/cell_types", np.full(len(disks.cells), 4))
        for side, nodes in (("first", disks.first_nodes), ("second", disks.second_nodes)):
            write_dataset(file, f"contact/{side}/starts", np.arange(disks.n_pairs + 1))
            write_dataset(file, f"contact/{side}/nodes", nodes + 1)
            write_dataset(file, f"contact/{side}/weights", np.ones(disks.n_pairs))
        write_dataset(file, "contact/areas", np.full(disks.n_pairs, np.pi / disks.n_sectors), "m")
        for number, squeeze in enumerate(points, start=1):
            write_point(file.create_group(f"points/{number:04d}"), disks, squeeze)


def write_point(group: h5py.Group, disks: HalfDisks, squeeze: float) -> None:
    group.attrs["label"] = f"squeeze = {squeeze}"
    group.attrs["parameter_names"] = "squeeze"
    group.attrs["parameters"] = [squeeze]
    force = disks.multipliers(squeeze)
    pressure = np.zeros(disks.n_nodes)
    pressure[disks.first_nodes] = pressure[disks.second_nodes] = force / (np.pi / disks.n_sectors)
    is_reduced = np.isin(np.arange(len(disks.cells)), disks.reduced_cells)
    write_dataset(group, "displacement", disks.displacement(squeeze), "m")
    write_dataset(group, "displacement_reduced", disks.displacement(squeeze), "m")
    write_dataset(group, "contact_pressure", pressure, "N/m2")
    write_dataset(group, "reduced_domain", is_reduced.astype(np.int32))
    has_row = np.isin(np.arange(disks.n_pairs), disks.reduced_rows)
    write_dataset(group, "rows_in_reduced_domain", has_row.astype(np.int32))
    write_dataset(group, "multipliers_full_order", force, "N/m")
    write_dataset(group, "multipliers_reduced", reduced_multipliers(disks, squeeze), "N/m")


def write_snapshots(path: Path, disks: HalfDisks) -> None:
    with h5py.File(path, "w") as file:
        file.attrs["format"] = "signorom snapshots"
        file.attrs["format_version"] = 2
        file.attrs["provenance"] = "0123456789abcdef"
        m = len(TRAINING)
        file["parameter_names"] = ["squeeze"]
        write_dataset(file, "parameters", TRAINING[:, None])
        write_dataset(file, "displacement", [disks.displacement(s)[:, :2].ravel() for s in TRAINING], "m")
        write_dataset(file, "multipliers", [disks.multipliers(s) for s in TRAINING], "N/m")
        write_dataset(file, "iterations", np.full(m, 4))
        write_dataset(file, "reasons", np.ones(m, dtype=int))
        write_dataset(file, "residuals", np.full((m, 4), 1e-14))
        write_dataset(file, "seconds", np.full(m, 1e-3), "s")
        file["term_texts"] = ["1", "squeeze"]
        write_dataset(file, "free_response", np.zeros((2, 2 * disks.n_nodes)), "m")


def write_model(path: Path, disks: HalfDisks, n_clusters: int = 1) -> None:
    with h5py.File(path, "w") as file:
        file.attrs["format"] = "signorom model"
        file.attrs["format_version"] = 6
        file["deck"] = DECK
        file["title"] = "Two half disks pressed together"
        file["units/length"], file["units/force"] = "m", "N"
        file["parameters/names"], file["parameters/units"] = ["squeeze"], ["m"]
        file["parameters/minimum"], file["parameters/maximum"] = [0.15], [0.45]
        file["parameters/training_points"] = TRAINING[:, None]
        write_dataset(file, "reduction/pod_tolerance", TOLERANCE, "1")
        for number in range(1, n_clusters + 1):
            write_cluster(file.create_group(f"clusters/{number}"), disks)


def write_cluster(group: h5py.Group, disks: HalfDisks) -> None:
    group.attrs["kind"] = "hhr"
    group.attrs["condition_number"] = 3.217
    group.attrs["rank"] = len(disks.reduced_rows)
    group.attrs["stiffness_condition"] = 412.0
    # prescribed values take one mode of nine
    write_dataset(group, "basis", np.zeros((N_MODES - 1, 2 * disks.n_nodes)))
    group["singular_values"] = SINGULAR_VALUES
    group["seed_nodes"] = disks.first_nodes[disks.reduced_rows] + 1
    group["facing_nodes"] = disks.second_nodes[disks.reduced_rows] + 1
    group["cells"] = disks.reduced_cells + 1
    group["contact_rows"] = disks.reduced_rows + 1
    group["training_points"] = np.arange(1, len(TRAINING) + 1)


def validation_rows(n_points: int = 101) -> list[dict[str, object]]:
    """Errors with the size of the paper's; a quarter of the active pairs lies on the RID."""
    rows = []
    for squeeze in np.linspace(0.15, 0.45, n_points):
        n_active = 2 * int(12 * np.sqrt(max(squeeze - GAP / 2, 0.0)))
        bump = 1.5 + np.sin(40.0 * squeeze) + 0.3 * np.cos(211.0 * squeeze)
        rows.append(
            {
                "squeeze": f"{squeeze:.10g}",
                "cluster": 1,
                "e_u": 1e-4 * bump,
                "e_lambda_rid": 5e-4 * bump,
                "e_lambda_all": 9e-4 * bump**1.5,
                "e_energy": 2e-5 * bump * squeeze,
                "e_energy_rid": 4e-6 * bump * squeeze,
                "e_energy_relative": 1e-5 * bump,
                "e_energy_rid_relative": 1e-5 * bump,
                "n_active": n_active // 4,
                "n_active_full_order": n_active,
                "solver": "active_set",
                "full_order": "converged",
            }
        )
    return rows


def write_validation(path: Path, rows: list[dict[str, object]]) -> None:
    lines = [",".join(rows[0])] + [",".join(str(value) for value in row.values()) for row in rows]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


#: per hat: pair, node, columns, rank, kappa, ratio of the singular values, condition of the stiffness
HISTORY = (
    (0, 0, 9, 2, "inf", 900.0, 410.0),
    (5, 61, 10, 3, 40.0, 40.0, 420.0),
    (2, 58, 11, 3, 8.0, 8.0, 430.0),
    (9, 65, 12, 3, 1.2, 1.2, 440.0),
)
HISTORY_HEADER = "cluster,hat,pair,node,n_columns,rank,condition_number,singular_ratio,stiffness_condition"


def write_enrichment(
    path: Path, history: tuple[tuple[object, ...], ...] = HISTORY, n_clusters: int = 1
) -> None:
    lines = [HISTORY_HEADER]
    for cluster in range(1, n_clusters + 1):
        lines += [",".join(map(str, (cluster, hat, *entry))) for hat, entry in enumerate(history)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


REPORT = """version:
  signorom: "0.1.0"
deck: {title: Two half disks pressed together}
sizes: {n_nodes: 678, n_dofs: 1356, n_multipliers: 53, n_inert_pairs: 2, inert_pairs: ["1 - 56", "55 - 110"]}
reduction: {n_modes: 9, n_contact_rows: 8, n_cells: 50, condition_number: 3.2171, stiffness_condition: 1.5e+8,
  rank: 8, warnings: []}
iterations: {median: 4}
errors:
  n_points: 101
  e_u: {min: 1.0e-5, median: 8.1e-5, p95: 2.1e-4, max: 3.4e-4}
  e_lambda_rid: {min: 1.0e-4, median: 2.7e-4, p95: 1.2e-3, max: .inf, infinite: 1, no_contact: 0,
    largest_at: ["squeeze = 0.156 m: 1.6E-02", "squeeze = 0.2 m: 9.1E-03"]}
times:
  sample_per_point: {min: 1.7e-4, median: 2.11e-4, p95: 3.0e-4, max: 0.00198}
  train: 61.5
  query: 21.3e-6
speed_up: {over_refactored: 1520.4, over_condensed: 31.2}
"""


def write_results(folder: Path, n_rings: int = 4, n_sectors: int = 12) -> HalfDisks:
    """All files of a results folder."""
    disks = HalfDisks(n_rings, n_sectors)
    folder.mkdir(parents=True, exist_ok=True)
    write_fields(folder / "fields.h5", disks)
    write_snapshots(folder / "snapshots.h5", disks)
    write_model(folder / "model.h5", disks)
    write_validation(folder / "validation.csv", validation_rows())
    write_enrichment(folder / "enrichment.csv")
    (folder / "report.yaml").write_text(REPORT, encoding="utf-8")
    return disks


if __name__ == "__main__":
    write_results(Path(sys.argv[1]), n_rings=12, n_sectors=54)
