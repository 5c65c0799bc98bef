# SPDX-License-Identifier: BSD-3-Clause
"""Imposed strains in decks: fields from files, what is refused of them, every kind of model, check --fields."""

import struct

import h5py
import numpy as np
import pytest
import yaml

from block_meshes import stacked_blocks
from results import read_fields, read_snapshots, read_table
from runs import refuse

# The same problem in another form: nothing but rounding and the solver's tolerance may differ.
SAME = 1e-9
FIELD = "{region: lower, field: {file: %s, name: rise}, factor: heat / 300, reference: 0}"
EXPRESSION = '{region: lower, temperature: "heat / 300 * (10 + 200 * x - 30 * y)", reference: 0}'
SWELLING = '{region: upper, strain: {xx: "1e-4 * heat * y", yy: 2e-3, xy: "1e-6 * heat"}}'


def rise(x, y):
    """What EXPRESSION has at 300 degrees."""
    return 10 + 200 * x - 30 * y


@pytest.fixture
def mesh(tmp_path):
    """Two blocks, the upper one a little above the lower one, in blocks.msh."""
    blocks = stacked_blocks("mixed", 2)
    blocks.coordinates[blocks.nodes_of("upper"), 1] += 0.01
    blocks.write(tmp_path / "blocks.msh")
    return blocks


def write_deck(folder, *strains, model="plane_strain", young_modulus="2.0e6", more=""):
    """A deck of the blocks, pressed together by a pressure on the upper one, which only contact holds."""
    axes = "rz" if model == "axisymmetric" else "xy"
    entries = "".join(f"  - {strain}\n" for strain in strains)
    (folder / "hot.yaml").write_text(
        f"mesh: {{file: blocks.msh, model: {model}}}\n"
        "parameters: {heat: {min: 0, max: 400}, press: {min: 1e3, max: 2e4}}\n"
        "materials:\n"
        f"  block: {{regions: [lower, upper], young_modulus: {young_modulus}, poisson_ratio: 0.3,"
        " thermal_expansion: 1.0e-4}\n"
        "boundary_conditions:\n"
        f"  - {{boundary: bottom, displacement: {{{axes[1]}: 0}}}}\n"
        f"  - {{boundary: left, displacement: {{{axes[0]}: 0}}}}\n"
        "loads:\n  - {boundary: top, pressure: press}\n"
        f"imposed_strains:\n{entries}"
        "contact:\n  - {first: lower_face, second: upper_face, direction: [0, 1]}\n"
        "output: {points: [{heat: 300, press: 1e4}]}\n"
        f"{more}"
    )
    return folder / "hot.yaml"


def node_data(name, tags, values, header="2.2 0 8", binary=False):
    """A gmsh file with a field, and another one before it."""
    text = f"$MeshFormat\n{header}\n".encode()
    text += struct.pack("<i", 1) + b"\n" if binary else b""
    text += b"$EndMeshFormat\n"
    for title, numbers in (("other", np.zeros(len(tags))), (name, values)):
        text += f'$NodeData\n1\n"{title}"\n1\n0.0\n3\n0\n1\n{len(tags)}\n'.encode()
        if binary:
            text += b"".join(struct.pack("<id", *row) for row in zip(tags, numbers, strict=True)) + b"\n"
        else:
            text += "".join(
                f"{tag} {value!r}\n" for tag, value in zip(tags, numbers.tolist(), strict=True)
            ).encode()
        text += b"$EndNodeData\n"
    return text


def write_field(path, mesh, binary=False, header="4.1 0 8"):
    """The linear field of EXPRESSION at the nodes, in an order of its own."""
    order = np.random.default_rng(5).permutation(len(mesh.coordinates))
    tags, values = (order + 1).tolist(), rise(*mesh.coordinates[order, :2].T)
    if path.suffix == ".h5":
        with h5py.File(path, "w") as file:
            file["node_tags"], file["rise"] = np.array(tags, dtype=np.int32), values
    else:
        path.write_bytes(node_data("rise", tags, values, "4.1 1 8" if binary else header, binary))


def solve(signorom, deck, n_ranks=1):
    """Fields of the output point."""
    signorom("solve", deck, folder=deck.parent, n_ranks=n_ranks)
    return read_fields(deck.parent / "results" / "hot" / "fields.h5")


@pytest.mark.parametrize(
    ("name", "binary"), [("t22.msh", False), ("t.msh", False), ("t.msh", True), ("t.h5", False)]
)
@pytest.mark.parametrize("n_ranks", [1, 3])
def test_field_is_an_expression(signorom, tmp_path, mesh, name, binary, n_ranks):
    """A linear temperature from each kind of file, in an order of its own, beside a swelling."""
    expected = solve(signorom, write_deck(tmp_path, EXPRESSION, SWELLING))
    write_field(tmp_path / name, mesh, binary, "2.2 0 8" if "22" in name else "4.1 0 8")
    found = solve(signorom, write_deck(tmp_path, FIELD % name, SWELLING), n_ranks)
    for key in ("displacement", "stress", "stress_smoothed", "multipliers_full_order", "imposed_strain"):
        np.testing.assert_allclose(
            found[key], expected[key], rtol=0, atol=SAME * np.abs(expected[key]).max(), err_msg=key
        )


def test_entries_add_up(signorom, tmp_path, mesh):
    """A field of strains, and the same temperature in two parts, are the temperature as one."""
    expected = solve(signorom, write_deck(tmp_path, EXPRESSION))
    halves = [
        f'{{region: lower, temperature: "heat / 300 * ({part})", reference: 0}}'
        for part in ("10", "200 * x - 30 * y")
    ]
    found = solve(signorom, write_deck(tmp_path, *halves))
    np.testing.assert_allclose(
        found["stress"], expected["stress"], atol=SAME * np.abs(expected["stress"]).max()
    )
    write_field(tmp_path / "t.h5", mesh)
    strain = "{region: lower, field: {file: t.h5, name: rise, quantity: strain}, factor: 1e-4 * heat / 300}"
    found = solve(signorom, write_deck(tmp_path, strain))
    np.testing.assert_allclose(
        found["stress"], expected["stress"], atol=SAME * np.abs(expected["stress"]).max()
    )


def hole(mesh):
    """Values at all nodes but one of the lower block."""
    nodes = np.delete(np.arange(len(mesh.coordinates)), mesh.nodes_of("lower")[3])
    return (nodes + 1).tolist(), np.ones(len(nodes))


def other_mesh(mesh):
    """Values at one node too many."""
    return list(range(1, len(mesh.coordinates) + 2)), np.ones(len(mesh.coordinates) + 1)


def no_number(mesh):
    """No number at a node of the lower block."""
    values = np.ones(len(mesh.coordinates))
    values[mesh.nodes_of("lower")[2]] = np.nan
    return list(range(1, len(values) + 1)), values


@pytest.mark.parametrize(("command", "n_ranks"), [("check", 1), ("solve", 3)])
@pytest.mark.parametrize(
    ("values", "name", "message"),
    [
        (hole, "rise", "the field 'rise' has no value at node 4 of the region 'lower' ("),
        (other_mesh, "rise", "which no cell of a named region has: does the field belong to another mesh? ("),
        (no_number, "rise", "the field 'rise' is not finite at node 3 of the region 'lower' ("),
        (
            no_number,
            "temperature",
            "the field file 't.msh' has no $NodeData 'rise'; it has other, temperature",
        ),
    ],
)
def test_bad_fields_are_refused(signorom, tmp_path, mesh, values, name, message, command, n_ranks):
    (tmp_path / "t.msh").write_bytes(node_data(name, *values(mesh)))
    write_deck(tmp_path, FIELD % "t.msh")
    words = refuse(signorom, command, "hot.yaml", folder=tmp_path, n_ranks=n_ranks)
    assert words.startswith("hot.yaml:11:48: error: the field ")
    assert message in words


def test_mesh_beside_a_field_is_compared(signorom, tmp_path, mesh):
    """gmsh writes the mesh into the file of a field: a field of another mesh has the same node numbers."""
    nodes = len(mesh.coordinates)
    data = node_data("rise", range(1, nodes + 1), np.ones(nodes)).decode().split("$EndMeshFormat\n")[1]
    write_deck(tmp_path, FIELD % "t.msh")
    mesh.write(tmp_path / "t.msh")
    with (tmp_path / "t.msh").open("a") as file:
        file.write(data)
    signorom("check", "hot.yaml", folder=tmp_path)
    mesh.coordinates[2, 0] += 0.01
    mesh.write(tmp_path / "t.msh")
    with (tmp_path / "t.msh").open("a") as file:
        file.write(data)
    words = refuse(signorom, "check", "hot.yaml", folder=tmp_path)
    assert words.startswith(
        "hot.yaml:11:48: error: the field 'rise' belongs to another mesh: node 3 lies at ("
    )


def test_cut_file_is_refused(signorom, tmp_path, mesh):
    """By its own line."""
    write_field(tmp_path / "t.msh", mesh)
    text = (tmp_path / "t.msh").read_text()
    (tmp_path / "t.msh").write_text(text[: len(text) - 40])
    write_deck(tmp_path, FIELD % "t.msh")
    words = refuse(signorom, "check", "hot.yaml", folder=tmp_path)
    assert "t.msh:" in words
    assert "the file ends inside $NodeData" in words


def test_other_field_is_another_study(signorom, tmp_path, mesh):
    """The provenance of snapshots holds the values of the field."""
    write_field(tmp_path / "t.h5", mesh)
    write_deck(tmp_path, FIELD % "t.h5", more="training: {sobol: 3}\n")
    signorom("sample", "hot.yaml", folder=tmp_path)
    with h5py.File(tmp_path / "t.h5", "r+") as file:
        file["rise"][7] += 1e-3
    words = refuse(signorom, "sample", "hot.yaml", folder=tmp_path)
    assert "these snapshots belong to another deck, mesh or field file" in words


@pytest.mark.parametrize("method", ["condensed", "hhr"])
@pytest.mark.parametrize("model", ["plane_strain", "plane_stress", "axisymmetric"])
def test_reduced_models(signorom, tmp_path, mesh, method, model):
    """Errors at points of their own. Heat moves the upper block, which contact alone holds."""
    mesh.coordinates[:, 0] += 1.0
    mesh.write(tmp_path / "blocks.msh")
    strain = '{region: upper, strain: "1e-6 * heat * (1 + y)"}'
    expression = EXPRESSION.replace("x", "r").replace("y", "z") if model == "axisymmetric" else EXPRESSION
    strain = strain.replace("y)", "z)") if model == "axisymmetric" else strain
    # as the message about equations that do not determine the modes says
    zones = "[auto, lower_face, upper_face]"
    more = "training: {sobol: 24}\ntest: {sobol: 6, seed: 3}\n"
    more += f"reduction: {{method: {method}, zones_of_interest: {zones}}}\n"
    write_deck(tmp_path, expression, strain, model=model, more=more)
    signorom("run", "hot.yaml", folder=tmp_path, n_ranks=2)
    table = read_table(tmp_path / "results" / "hot" / "validation.csv")
    for name in ("e_u", "e_lambda_all", "e_energy_relative", "e_energy_rid_relative"):
        if method == "hhr" or "rid" not in name:
            assert max(table[name]) < 1e-6, name
    if model == "plane_strain":
        # the contact opens where the blocks bend
        assert min(table["n_active_full_order"]) < max(table["n_active_full_order"])


@pytest.mark.usefixtures("mesh")
def test_constants_of_heated_bodies_as_parameters(signorom, tmp_path):
    """A hyper-reduced model of a block that heat moves freely, with elastic constants that follow the heat.

    Solutions at training points are combinations of all modes, so they are the answers there.
    """
    zones = "[auto, lower_face, upper_face]"
    more = "training: {sobol: 24}\ntest: {sobol: 24}\n"
    more += f"reduction: {{method: hhr, zones_of_interest: {zones}, max_full_order_size: 0, pod_tolerance: 1e-20}}\n"
    deck = write_deck(tmp_path, EXPRESSION, SWELLING, young_modulus='"4e6 - 5e3 * heat"', more=more)
    deck.write_text(deck.read_text().replace("poisson_ratio: 0.3", "poisson_ratio: 0.25 + heat / 4000"))
    signorom("run", "hot.yaml", folder=tmp_path, n_ranks=2)
    table = read_table(tmp_path / "results" / "hot" / "validation.csv")
    assert max(table["e_u"]) < 1e-8
    assert max(table["e_lambda_all"]) < 1e-6


@pytest.mark.usefixtures("mesh")
@pytest.mark.parametrize(
    ("constants", "at_point"),
    [(("1e6 + heat * 1e4", "0.3"), ("4e6", "0.3")), (("2.0e6", "0.2 + heat / 2000"), ("2.0e6", "0.35"))],
)
def test_moduli_may_be_expressions(signorom, tmp_path, constants, at_point):
    """E or nu at 300 degrees as an expression and as a number."""
    fields = []
    for young_modulus, poisson_ratio in (constants, at_point):
        deck = write_deck(tmp_path, EXPRESSION, SWELLING, young_modulus=young_modulus)
        deck.write_text(deck.read_text().replace("poisson_ratio: 0.3", f"poisson_ratio: {poisson_ratio}"))
        fields.append(solve(signorom, deck))
    for key in ("displacement", "stress", "multipliers_full_order"):
        np.testing.assert_allclose(fields[0][key], fields[1][key], atol=SAME * np.abs(fields[1][key]).max())


@pytest.mark.parametrize("linear", ["cholesky", "gamg"])
@pytest.mark.parametrize("n_ranks", [1, 3])
def test_solvers_and_ranks(signorom, tmp_path, linear, n_ranks):
    """Blocks in space by multigrid and by factors, on one and three ranks."""
    stacked_blocks("H8", 3).write(tmp_path / "blocks.msh")
    strain = '{region: lower, temperature: "heat * (x - y * z)", reference: 0}'
    expected = None
    for solver in ("condensed", "active_set"):
        deck = write_deck(
            tmp_path, strain, model="solid", more="training: {sobol: 3}\nreduction: {method: hhr}\n"
        )
        held = "  - {boundary: left, displacement: {x: 0}}\n  - {boundary: front, displacement: {y: 0}}\n"
        text = deck.read_text().replace("bottom, displacement: {y: 0}", "bottom, displacement: {z: 0}")
        text = text.replace("  - {boundary: left, displacement: {x: 0}}\n", held).replace(
            "[0, 1]", "[0, 0, 1]"
        )
        method = "cholesky" if solver == "condensed" else linear
        deck.write_text(f"{text}solver: {{type: {solver}, linear: {method}}}\n")
        signorom("sample", deck, folder=tmp_path, n_ranks=n_ranks if solver == "active_set" else 1)
        found = read_snapshots(tmp_path / "results" / "hot" / "snapshots.h5")
        (tmp_path / "results" / "hot" / "snapshots.h5").unlink()
        expected = expected or found
        for key in ("multipliers", "displacement"):
            np.testing.assert_allclose(
                found[key], expected[key], rtol=0, atol=1e-8 * np.abs(expected[key]).max()
            )


def test_check_shows_the_strains(signorom, tmp_path, mesh):
    """check.h5 has the strain of each cell; the loads are those of the loads section alone."""
    write_deck(tmp_path, "{region: lower, temperature: heat, reference: 100}", SWELLING)
    signorom("check", "hot.yaml", "--fields", "--at", "heat=300,press=1e4", folder=tmp_path)
    fields = read_fields(tmp_path / "results" / "hot" / "check.h5")
    cells = [name for kind, name, _ in mesh.elements if name in ("lower", "upper")]
    strain = fields["imposed_strain"][: len(cells)]
    lower = np.array(cells) == "lower"
    np.testing.assert_allclose(
        strain[lower], np.tile([0.02, 0.02, 0.02, 0, 0, 0], (lower.sum(), 1)), rtol=1e-12
    )
    np.testing.assert_allclose(
        strain[~lower][:, [1, 3]], np.tile([2e-3, 3e-4], ((~lower).sum(), 1)), rtol=1e-12
    )
    np.testing.assert_allclose(fields["imposed_strain"][len(cells) :], 0)
    loaded = np.flatnonzero(np.abs(fields["load"]).max(axis=1))
    np.testing.assert_array_equal(loaded, mesh.nodes_of("top"))


ON_ITS_BED = """\
title: A block that nothing but contact holds in height
units: {length: m, force: N}
mesh: {file: blocks.msh, model: solid}
parameters:
  T: {min: 200.0, max: 500.0, unit: K}
  E: {min: 1.0e11, max: 2.5e11, unit: Pa}
materials:
  bed: {regions: [lower], young_modulus: E, poisson_ratio: 0.3, thermal_expansion: 1.2e-5}
  block: {regions: [upper], young_modulus: 0.37 * E, poisson_ratio: 0.33, thermal_expansion: 2.3e-5}
boundary_conditions:
  - {boundary: bottom, displacement: {x: 0, y: 0, z: 0}}
  - {boundary: left, displacement: {x: 0}}
  - {boundary: front, displacement: {y: 0}}
imposed_strains:
  - {region: lower, temperature: T, reference: 293.15}
  - {region: upper, temperature: T, reference: 293.15}
contact: [{first: lower_face, second: upper_face}]
"""


@pytest.mark.parametrize("solver", ["active_set", "condensed"])
def test_no_load_at_the_reference_temperature(signorom, tmp_path, solver):
    """Heat less its reference leaves rounding: no load, so the free block stays; one warning says that it is free."""
    mesh = stacked_blocks("H8", 3)
    mesh.coordinates *= 1e-3
    mesh.write(tmp_path / "blocks.msh")
    deck = tmp_path / "heated.yaml"
    points = ", ".join(f"{{T: 293.15, E: {modulus}}}" for modulus in (1.1e11, 1.7e11, 2.3e11))
    deck.write_text(ON_ITS_BED + f"solver: {{type: {solver}}}\noutput: {{points: [{points}]}}\n")
    done = signorom.run("solve", deck.name, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stderr.count("warning") == 1
    assert "no contact force holds the body 'upper' (translation in z)" in done.stderr
    report = yaml.safe_load((tmp_path / "results" / "heated" / "report.yaml").read_text())
    for point in report["points"].values():
        assert point["status"] == "converged"
        # 1e-12 of E alpha T on a square millimeter
        assert abs(point["contact_force"]) <= 1e-12 * 1.0e11 * 1.2e-5 * 293.15 * 1e-6
