# SPDX-License-Identifier: BSD-3-Clause
"""Rigid obstacles: two mirror half disks touch as each of them touches the plane between them."""

import h5py
import numpy as np
import pytest
import yaml

from block_meshes import stacked_blocks
from results import read_fields, read_snapshots
from runs import check_reduced_model, results_of, write_deck

PAIRS = "  - {first: lower_arc, second: upper_arc, direction: [0, 1]}"
# The mirror plane of the disks is y = 0; planes that come closer in place of disks that do.
PLANES = "\n".join(
    f"  - {{first: {name}, obstacle: {{type: half_space, point: [0, {place}], normal: [0, {normal}]}}}}"
    for name, place, normal in (("lower_arc", "-squeeze", -1), ("upper_arc", "squeeze", 1))
)
MOVING_PLANES = {"y: squeeze}": "y: 0}", "y: -squeeze}": "y: 0}", PAIRS: PLANES}
# Mirror images to rounding, which the stiffness magnifies.
MIRROR = 1e-9


@pytest.fixture(scope="module")
def pressed(signorom, tmp_path_factory):
    """Snapshots of the two disks."""
    folder = results_of(signorom, tmp_path_factory.mktemp("pressed"), "sample", {})
    return read_snapshots(folder / "snapshots.h5")


@pytest.fixture(scope="module")
def planes(signorom, tmp_path_factory):
    """Results of the disks between the two planes."""
    return results_of(signorom, tmp_path_factory.mktemp("planes"), "run", MOVING_PLANES)


def test_plane_between_mirror_images(pressed, planes):
    """The forces of the pairs, on each disk."""
    found = read_snapshots(planes / "snapshots.h5")["multipliers"]
    with h5py.File(planes / "fields.h5") as file:
        first_nodes, second_nodes = (file[f"contact/{side}/nodes"][()] for side in ("first", "second"))
        assert (file["contact/second/starts"][()] == 0).all()
        y = file["mesh/coordinates"][()][first_nodes - 1, 1]
    assert second_nodes.size == 0
    n_pairs = pressed["multipliers"].shape[1]
    limit = MIRROR * pressed["multipliers"].max()
    for is_side in (y < 0, y > 0):
        assert is_side.sum() == n_pairs
        forces = np.sort(found[:, is_side], axis=1)
        np.testing.assert_allclose(forces, np.sort(pressed["multipliers"], axis=1), rtol=0, atol=limit)


def test_obstacles_add_to_the_balance(planes):
    """Supports and obstacles balance each other; the planes move by one term each."""
    report = yaml.safe_load((planes / "report.yaml").read_text())
    assert report["residuals"]["force_balance"] < 1e-10
    assert report["sizes"]["inert_pairs"]
    assert all(name.endswith(" - obstacle") for name in report["sizes"]["inert_pairs"])
    with h5py.File(planes / "model.h5") as file:
        assert file["contact/gap"].shape[0] == 3
        assert file["contact/second/tags"].size == 0


def test_gap_field_is_the_distance_to_the_plane(planes):
    """Of the deformed arcs, NaN elsewhere."""
    with h5py.File(planes / "fields.h5") as file:
        y = file["mesh/coordinates"][()][:, 1]
    for point, squeeze in ((1, 0.2), (2, 0.4)):
        fields = read_fields(planes / "fields.h5", point)
        is_there = np.isfinite(fields["gap"])
        distance = np.abs(y + fields["displacement"][:, 1]) - squeeze
        np.testing.assert_allclose(fields["gap"][is_there], distance[is_there], rtol=0, atol=1e-12)
        assert (fields["contact_pressure"] > 0).any()
        assert not (fields["contact_pressure"][~is_there] > 0).any()


def test_reduced_model_follows_the_planes(signorom, planes, tmp_path):
    """Sampled, trained, validated and asked without mesh and deck."""
    check_reduced_model(signorom, planes, tmp_path)


@pytest.mark.parametrize(
    ("n_ranks", "solver", "tolerance"),
    [(2, "condensed", 1e-10), (4, "condensed", 1e-10), (3, "active_set", 1e-8), (1, "snesvi", 1e-8)],
)
def test_same_on_ranks_and_by_solvers(signorom, tmp_path, planes, n_ranks, solver, tolerance):
    """Rows of one node are as good as rows of two."""
    changes = {
        **MOVING_PLANES,
        "type: condensed": f"type: {solver}",
        "squeeze: 15}}": "squeeze: 15}, groups: 1}",
    }
    found = read_snapshots(
        results_of(signorom, tmp_path, "sample", changes, n_ranks=n_ranks) / "snapshots.h5"
    )
    expected = read_snapshots(planes / "snapshots.h5")
    for name in ("multipliers", "displacement"):
        limit = tolerance * np.abs(expected[name]).max()
        np.testing.assert_allclose(found[name], expected[name], rtol=0, atol=limit)


def test_plane_into_prescribed_nodes_is_refused(signorom, tmp_path):
    """The corners of the disks cannot give way."""
    changes = {**MOVING_PLANES, PAIRS: PLANES.replace("-squeeze", "-3*squeeze")}
    done = signorom.run("sample", write_deck("small_disks", tmp_path, **changes), folder=tmp_path)
    assert done.returncode == 2
    assert "the prescribed displacements and the gap press node" in done.stderr
    assert "into the obstacle" in done.stderr


def test_nodes_and_gaps_are_told_before_solving(signorom, tmp_path):
    """1.05 - sqrt(1 - x^2) less a squeeze from 0.15 to 0.45."""
    deck = write_deck("small_disks", tmp_path, **MOVING_PLANES)
    checked = signorom("check", deck, folder=tmp_path)
    for i, name in enumerate(("lower_arc", "upper_arc"), 1):
        assert (
            f"# contact[{i}]: {name} - rigid half_space, 15 nodes (2 inert), gaps -0.4 to 0.9 m\n" in checked
        )


@pytest.mark.parametrize(
    ("direction", "angle"), [([0, 1], None), ([0.3, 1], None), ([1, 1], 45), ([2, 1], 63)]
)
def test_direction_far_from_the_normals_is_noted(signorom, tmp_path, direction, angle):
    """The normal of the top is y; atan(0.3) is 17 degrees and atan(2) is 63."""
    stacked_blocks("Q4", 2).write(tmp_path / "blocks.msh")
    (tmp_path / "ball.yaml").write_text(
        "mesh: {file: blocks.msh, model: plane_strain}\nparameters: {depth: {min: 0, max: 0.1}}\n"
        "materials: {all: {regions: [lower, upper], young_modulus: 1, poisson_ratio: 0}}\n"
        "boundary_conditions:\n  - {boundary: bottom, displacement: {x: 0, y: 0}}\n"
        "  - {boundary: left, displacement: {x: 0, y: 0}}\ncontact:\n  - {first: top, obstacle: "
        f"{{type: sphere, center: [0.5, 3 - depth], radius: 2}}, direction: {direction}}}\n"
    )
    done = signorom.run("check", "ball.yaml", folder=tmp_path)
    assert done.returncode == 0
    note = f"note: contact[1]: the direction is {angle} degrees or more from the normals of 'top'"
    assert (note in done.stdout) == (angle is not None)
    assert ("the direction is" in done.stdout) == (angle is not None)


def test_sphere_with_long_expressions(signorom, tmp_path):
    """Its gap is a text that contains them twice; of one that is too long a sentence says so."""
    obstacle = "{{type: sphere, center: [{x}, 9 - squeeze], radius: 8}}"
    sphere = f"  - {{{{first: lower_arc, obstacle: {obstacle}, direction: [3, 4]}}}}"
    for n_zeros, exit_code in ((400, 0), (490, 2)):
        planes = PLANES.splitlines()
        planes[0] = sphere.format(x='"squeeze' + "+0" * n_zeros + '"')
        deck = write_deck("small_disks", tmp_path, **{**MOVING_PLANES, PAIRS: "\n".join(planes)})
        done = signorom.run("sample", deck, folder=tmp_path)
        assert done.returncode == exit_code, done.stderr
    assert "the expressions of this obstacle are too long" in done.stderr
