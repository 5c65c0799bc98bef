# SPDX-License-Identifier: BSD-3-Clause
"""Multigrid on quadratic elements, whose first coarse level are the linear elements with the same corners; models by
eliminations, without a factor.
"""

import csv
import re
import subprocess

import h5py
import numpy as np
import pytest
import yaml

from block_meshes import LINEAR, Mesh
from program import kill, wait_until
from results import read_fields

# iterations of conjugate gradients for each active set, over those of linear elements with as many nodes
LARGEST_RATIO = 1.6
# conjugate gradients stop at 1e-12 of the energy
SAME_FORCES = 1e-8
DECK = """\
title: Two blocks
mesh: {{file: blocks.msh, model: solid}}
parameters: {{P: {{min: 0.5e6, max: 2.0e6, unit: Pa}}}}
materials: {{steel: {{regions: [lower, upper], young_modulus: 210.0e9, poisson_ratio: 0.3}}}}
boundary_conditions:
  - {{boundary: bottom, displacement: {{x: 0, y: 0, z: 0}}}}
  - {{boundary: left, displacement: {{x: 0}}}}
  - {{boundary: front, displacement: {{y: 0}}}}
loads:
  - {{boundary: top, pressure: P}}
contact:
  - {{first: lower_face, second: upper_face, direction: [0, 0, 1], initial_gap: "6e-5 * (x^2 + y^2)"}}
solver: {{type: {solver}}}
output: {{points: [{{P: 1.0e6}}], fields: [contact]}}
"""


def write_part(folder, element, n_side, n_high):
    """Two blocks, 1 wide and 0.5 high; cells along the sides and the height of each."""
    mesh = Mesh()
    across = np.linspace(0, 1, n_side + 1)
    for region, low, faces in (
        ("lower", -0.5, {(2, 0): "bottom", (2, 1): "lower_face"}),
        ("upper", 0.0, {(2, 0): "upper_face", (2, 1): "top"}),
    ):
        lines = [across, across, np.linspace(low, low + 0.5, n_high + 1)]
        sides = {(0, 0): "left", (1, 0): "front"}
        mesh.add_block(region, lines, LINEAR.get(element, element), faces | sides)
    if element in LINEAR:
        mesh.make_quadratic(element)
    mesh.write(folder / "blocks.msh")
    return len(mesh.coordinates)


def solve(signorom, folder, solver, n_ranks=1):
    """Iterations per active set, and contact forces."""
    (folder / "blocks.yaml").write_text(DECK.format(solver=solver))
    signorom("solve", "blocks.yaml", folder=folder, n_ranks=n_ranks)
    results = folder / "results" / "blocks"
    point = yaml.safe_load((results / "report.yaml").read_text())["points"]["1"]
    forces = read_fields(results / "fields.h5")["multipliers_full_order"]
    return point["linear_iterations"] / point["iterations"], forces


@pytest.mark.parametrize(
    ("element", "n_quadratic", "n_linear"), [("T10", (5, 3), (10, 6)), ("H20", (6, 4), (10, 6))]
)
def test_quadratic_elements(signorom, tmp_path, element, n_quadratic, n_linear):
    """Few more iterations than linear elements need, on any number of ranks; forces of a factorization."""
    linear, quadratic = tmp_path / "linear", tmp_path / "quadratic"
    linear.mkdir()
    quadratic.mkdir()
    n_nodes = write_part(linear, LINEAR[element], *n_linear), write_part(quadratic, element, *n_quadratic)
    assert abs(n_nodes[1] / n_nodes[0] - 1) < 0.2
    multigrid = "active_set, linear: gamg"
    per_set, _ = solve(signorom, linear, multigrid)
    _, expected = solve(signorom, quadratic, "condensed")
    for n_ranks in (1, 2, 4):
        found, forces = solve(signorom, quadratic, multigrid, n_ranks)
        assert found <= LARGEST_RATIO * per_set, (n_ranks, found, per_set)
        np.testing.assert_allclose(forces, expected, atol=SAME_FORCES * expected.max())


def test_bad_bounds(signorom, tmp_path):
    """Where the bounds of Chebyshev's smoother are far too small for the matrices, they are estimated anew."""
    write_part(tmp_path, "H8", 10, 6)
    (tmp_path / "blocks.yaml").write_text(DECK.format(solver="active_set, linear: gamg"))
    option = "-active_set_mg_levels_ksp_chebyshev_esteig_steps"
    forces, words = [], []
    for steps in ("10", "1"):
        words.append(
            signorom(
                "solve", "blocks.yaml", option, steps, "-active_set_ksp_converged_reason", folder=tmp_path
            )
        )
        forces.append(read_fields(tmp_path / "results" / "blocks" / "fields.h5")["multipliers_full_order"])
    assert [text.count("did not converge") for text in words] == [0, 1]
    np.testing.assert_allclose(forces[1], forces[0], atol=SAME_FORCES * forces[0].max())


def test_model_without_a_factor(signorom, tmp_path):
    """W by elimination, displacements by modes that multigrid solves for: exact forces, errors that answers tell."""
    write_part(tmp_path, "H8", 6, 3)
    text = DECK.format(solver="linear: gamg").replace("solver: {type: ", "solver: {")
    text = text.replace("output:", "training: {sobol: 6}\ntest: {latin_hypercube: 3}\noutput:")
    # [MB] W has room, the displacements of all nodes under each contact force have not
    text += "reduction: {max_full_order_size: 0.2}\n"
    (tmp_path / "blocks.yaml").write_text(text)
    words = signorom("run", "blocks.yaml", folder=tmp_path, n_ranks=2)
    assert "solver: condensed, gamg" in words
    assert re.search(r"displacements by \d+ modes", words)
    assert "trained condensed model of 49 contact rows" in words
    with (tmp_path / "results" / "blocks" / "validation.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 3
    for row in rows:
        assert float(row["e_lambda_all"]) < SAME_FORCES
        assert float(row["error_bound"]) < SAME_FORCES
        error, bound = float(row["e_u_energy"]), float(row["displacement_bound"])
        assert error < 1.01 * bound + SAME_FORCES


def write_study(folder, n_side, n_high, reduction, training="sobol: 3"):
    """A model without a factor, and its mesh."""
    n_nodes = write_part(folder, "H8", n_side, n_high)
    text = DECK.format(solver="condensed, linear: gamg").replace(", fields: [contact]", "")
    text = text.replace("output:", f"training: {{{training}}}\ntest: {{latin_hypercube: 2}}\noutput:")
    (folder / "blocks.yaml").write_text(text + f"reduction: {{{reduction}}}\n")
    return n_nodes


def displacements(folder):
    """Of the model, where they come from, and of the full order, at the output point."""
    with h5py.File(folder / "results" / "blocks" / "fields.h5") as file:
        point = file["points/0001"]
        names = "displacement_reduced", "displacement_reduced_source", "displacement"
        return tuple(point[name][()] if name in point else None for name in names)


@pytest.fixture(scope="module")
def reference(signorom, tmp_path_factory):
    """Displacements by active sets and factors."""
    folder = tmp_path_factory.mktemp("reference")
    write_part(folder, "H8", 8, 4)
    text = DECK.format(solver="active_set, linear: cholesky").replace(", fields: [contact]", "")
    (folder / "blocks.yaml").write_text(text)
    signorom("solve", "blocks.yaml", folder=folder)
    return displacements(folder)[2]


@pytest.mark.parametrize(("elsewhere", "n_ranks"), [("none", 1), ("modes", 2)])
def test_named_boundaries_are_exact(signorom, tmp_path, reference, elsewhere, n_ranks):
    """Their dofs stay beside the contacts in the elimination; the upper block hangs on contact alone."""
    write_study(tmp_path, 8, 4, f"displacement: {{boundaries: [top, lower_face], elsewhere: {elsewhere}}}")
    said = signorom("run", "blocks.yaml", folder=tmp_path, n_ranks=n_ranks)
    # 81 nodes of each, of which 9 + 9 dofs of the planes of symmetry are held
    assert (
        "note: exact displacements of top, lower_face come with the elimination of the others: 450 dofs"
        in said
    )
    reduced, source, full = displacements(tmp_path)
    size = abs(reference).max()
    np.testing.assert_allclose(full, reference, atol=SAME_FORCES * size)
    is_exact = source == 2
    assert is_exact.sum() == 2 * 81
    np.testing.assert_allclose(reduced[is_exact], reference[is_exact], atol=SAME_FORCES * size)
    if elsewhere == "none":
        assert np.isnan(reduced[~is_exact]).all()
    else:
        np.testing.assert_allclose(reduced[~is_exact], reference[~is_exact], atol=0.01 * size)
    with (tmp_path / "results" / "blocks" / "validation.csv").open(newline="") as file:
        assert all(float(row["e_u"]) < SAME_FORCES or elsewhere == "modes" for row in csv.DictReader(file))


KEPT = "the matrix of all contacts comes from results/blocks/compliance.h5"


def test_killed_run_keeps_the_elimination(signorom, tmp_path):
    """A run that is killed behind it, and commands on the same problem; fewer boundaries take a part."""
    write_study(tmp_path, 8, 4, "displacement: {boundaries: [top, lower_face]}", training="sobol: 300")
    kept = tmp_path / "results" / "blocks" / "compliance.h5"
    process = signorom.start("run", "blocks.yaml", folder=tmp_path)
    wait_until(kept.exists, process)
    kill(process)
    assert not (tmp_path / "results" / "blocks" / "model.h5").exists()
    content = kept.read_bytes()
    deck = tmp_path / "blocks.yaml"
    deck.write_text(deck.read_text().replace("sobol: 300", "sobol: 3"))
    assert KEPT in signorom("run", deck.name, folder=tmp_path)
    reduced, source, full = displacements(tmp_path)
    np.testing.assert_allclose(reduced[source == 2], full[source == 2], atol=SAME_FORCES * abs(full).max())
    assert kept.read_bytes() == content
    deck.write_text(deck.read_text().replace("top, lower_face", "lower_face"))
    assert KEPT in signorom("train", deck.name, folder=tmp_path, n_ranks=2)
    assert kept.read_bytes() == content
    # more than it has
    deck.write_text(deck.read_text().replace("[lower_face]", "[lower_face, upper_face]"))
    assert KEPT not in signorom("train", deck.name, folder=tmp_path)
    assert kept.read_bytes() != content


def test_kept_elimination_that_does_not_fit(signorom, tmp_path):
    """Of another material: made anew without a word. Damaged: with a warning."""
    write_study(tmp_path, 6, 3, "displacement: none")
    deck = tmp_path / "blocks.yaml"
    kept = tmp_path / "results" / "blocks" / "compliance.h5"
    signorom("solve", deck.name, folder=tmp_path)
    first = displacements(tmp_path)[2]
    deck.write_text(deck.read_text().replace("210.0e9", "105.0e9").replace("6e-5 *", "12e-5 *"))
    done = signorom.run("solve", deck.name, folder=tmp_path)
    assert (done.returncode, KEPT in done.stdout, done.stderr) == (0, False, "")
    # half the stiffness, twice the gap: the same contact, twice the displacement
    second = displacements(tmp_path)[2]
    np.testing.assert_allclose(second, 2 * first, atol=SAME_FORCES * abs(second).max())
    content = bytearray(kept.read_bytes())
    content[len(content) // 2] ^= 1
    kept.write_bytes(content)
    done = signorom.run("solve", deck.name, folder=tmp_path)
    assert (done.returncode, KEPT in done.stdout) == (0, False)
    assert re.search(
        "warning: the displacements are eliminated again: results/blocks/compliance.h5", done.stderr
    )
    np.testing.assert_allclose(displacements(tmp_path)[2], second, atol=SAME_FORCES * abs(second).max())


def test_boundaries_without_room(signorom, tmp_path):
    """60 % of 2 GB have room for all contacts, and not for the dofs of large surfaces beside them."""
    write_study(tmp_path, 24, 12, "displacement: {boundaries: [top, left, front, upper_face, lower_face]}")
    done = subprocess.run(
        ["bash", "-c", 'ulimit -v 2000000; exec "$0" check blocks.yaml', signorom.executable],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )
    assert "# solver: condensed, gamg" in done.stdout
    assert "exact displacements of" not in done.stdout
    assert re.search(
        r"warning: displacements of top, left, front, upper_face, lower_face are not exact, but by modes: to eliminate "
        r"their \d+ dofs beside 625 contact forces takes \S+ GB, and there is room for 1.2 GB",
        done.stderr,
    )


@pytest.mark.parametrize(
    ("n_side", "reduction", "found"),
    [
        (9, "displacement: auto", "exact at all nodes"),
        (10, "displacement: auto", "by [0-9]+ modes"),
        (10, "displacement_tolerance: 0", "exact at all nodes"),
    ],
)
def test_solutions_by_multigrid_are_few(signorom, tmp_path, n_side, reduction, found):
    """Modes where there are more than 100 contacts, although all responses are small; not if the deck wants no error."""
    write_study(tmp_path, n_side, 2, reduction)
    signorom("run", "blocks.yaml", folder=tmp_path)
    assert re.search(found, signorom("describe", "results/blocks/model.h5", folder=tmp_path))
