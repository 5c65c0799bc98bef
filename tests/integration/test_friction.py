# SPDX-License-Identifier: BSD-3-Clause
"""Decks with friction and tied surfaces through all commands. Forces of other programs: tests/verification."""

import re

import h5py
import numpy as np
import pytest
import yaml

from block_meshes import Mesh, stacked_blocks
from results import read_fields, read_table
from runs import refuse

# The blocks are 1 wide and 1 high each; tests with a known answer prescribe forces, so that only their sums count.
DECK = """title: A block that is pressed and sheared
units: {length: m, force: N, time: h}
mesh: {file: part.msh, model: plane_strain}
parameters: {P: {min: 1, max: 9, unit: Pa}, mu: {min: 0.3, max: 1}}
history:
  tables:
    load: {time: [0, 1, 4], value: [0, P, P]}
    shear: {time: [0, 1, 2, 3, 4], value: [0, 0, "0.25 * P", "-0.25 * P", 0]}
  steps:
    - {until: 1, increments: 2}
    - {until: 4, increments: 6}
materials: {all: {regions: [lower, upper], young_modulus: 2.0e6, poisson_ratio: 0.3}}
boundary_conditions: [{boundary: bottom, displacement: {x: 0, y: 0}}]
loads: [{boundary: top, pressure: load}, {boundary: top, traction: {x: shear}}]
contact: [{first: lower_face, second: upper_face, friction: mu}]
training: {grid: {P: 2, mu: 2}}
test: {sobol: 2, seed: 1}
reduction: {fields: true}
output: {points: [{P: 4, mu: 0.8}, {P: 4, mu: 0.3}]}
"""
TIMES = np.arange(0.5, 4.1, 0.5)
SHEAR = np.interp(TIMES, [0, 1, 2, 3, 4], [0, 0, 1, -1, 0])


def write_deck(folder, n_dim=2, **changes):
    """Mesh and deck, with texts replaced."""
    folder.mkdir(exist_ok=True)
    stacked_blocks("Q4" if n_dim == 2 else "H8", n_dim).write(folder / "part.msh")
    text = (
        DECK
        if n_dim == 2
        else DECK.replace("plane_strain", "solid").replace("{x: 0, y: 0}", "{x: 0, y: 0, z: 0}")
    )
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    (folder / "part.yaml").write_text(text)
    return folder / "part.yaml"


def forces_of(table, row, kind):
    """Forces lambda_k or tau_k of a row of a table."""
    return np.array([values[row] for name, values in table.items() if name.startswith(f"{kind}_")])


@pytest.fixture(scope="module")
def results(signorom, tmp_path_factory):
    """Results of `run` on one rank."""
    folder = tmp_path_factory.mktemp("friction")
    signorom("run", write_deck(folder), folder=folder)
    return folder / "results" / "part"


def test_history(results):
    """Sums of forces are those of the loads, and no contact has more friction than it may."""
    table = read_table(results / "history.csv")
    assert set(table["status"]) == {"converged"}
    for row, (mu, time) in enumerate(zip(table["mu"], table["time"], strict=True)):
        normal, tangential = forces_of(table, row, "lambda"), forces_of(table, row, "tau")
        assert normal.sum() == pytest.approx(4 * min(time, 1), rel=1e-10)
        assert tangential.sum() == pytest.approx(SHEAR[np.isclose(TIMES, time)][0], abs=1e-10)
        assert (np.abs(tangential) <= mu * normal * (1 + 1e-10) + 1e-12).all()
        # the resultant is that of friction and pressure, on the lower block
        assert table["contact_1_force_x"][row] == pytest.approx(tangential.sum(), abs=1e-10)
        assert table["contact_1_force_y"][row] == pytest.approx(-normal.sum(), rel=1e-10)
    # with mu = 0.3 something slips and stays behind: the unloaded state is another one than after pressing
    with_slip = [row for row, mu in enumerate(table["mu"]) if mu == 0.3]
    pressed, unloaded = (forces_of(table, with_slip[k], "tau") for k in (1, 7))
    assert np.abs(pressed - unloaded).max() > 0.05


def test_model_is_exact(signorom, tmp_path, results):
    """The model answers the states of the full order, also at times of a file."""
    table = read_table(results / "validation.csv")
    assert max(table["e_lambda_all"]) < 1e-12
    assert max(table["e_u_energy_relative"]) < 1e-10
    signorom("predict", results / "model.h5", "--at", "P=4,mu=0.3", "--output", "t.csv", folder=tmp_path)
    answers, wanted = read_table(tmp_path / "t.csv"), read_table(results / "history.csv")
    assert max(answers["error_bound"]) < 1e-12
    for row in range(len(TIMES)):
        for kind in ("lambda", "tau"):
            assert forces_of(answers, row, kind) == pytest.approx(forces_of(wanted, row + 8, kind), abs=1e-11)
    # a deck with these tables says the same
    (tmp_path / "h.csv").write_text("time,load,shear\n0.5,3,0\n0.75,3,0.8\n2,3,-0.7\n")
    command = ["predict", results / "model.h5", "--at", "P=5,mu=0.35", "--history", "h.csv"]
    signorom(*command, "--output", "t.csv", folder=tmp_path)
    tables = {
        "[0, 1, 4], value: [0, P, P]": "[0.5, 2], value: [3, 3]",
        '[0, 1, 2, 3, 4], value: [0, 0, "0.25 * P", "-0.25 * P", 0]': "[0.5, 0.75, 2], value: [0, 0.8, -0.7]",
        "{until: 1, increments: 2}": "{until: 0.5, increments: 1}\n    - {until: 0.75, increments: 1}",
        "{until: 4, increments: 6}": "{until: 2, increments: 1}",
    }
    signorom("solve", write_deck(tmp_path, **tables), "--at", "P=5,mu=0.35", folder=tmp_path)
    answers = read_table(tmp_path / "t.csv")
    wanted = read_table(tmp_path / "results" / "part" / "history.csv")
    for row in range(3):
        assert forces_of(answers, row, "tau") == pytest.approx(forces_of(wanted, row, "tau"), abs=1e-11)


def test_error_without_friction(signorom, tmp_path):
    """Where the coefficient is 0, contacts slip freely, and the answer has no error for it."""
    changes = {
        "mu: {min: 0.3, max: 1}": "mu: {min: 0, max: 1}",
        '"0.25 * P", "-0.25 * P", 0]': "0, 0, 0]",
        "boundary_conditions: [": "boundary_conditions: [{boundary: left, displacement: {x: 0}}, ",
    }
    signorom("sample", write_deck(tmp_path, **changes), folder=tmp_path)
    signorom("train", tmp_path / "part.yaml", folder=tmp_path)
    model = tmp_path / "results" / "part" / "model.h5"
    signorom("predict", model, "--at", "P=4,mu=0", "--output", "t.csv", folder=tmp_path)
    assert max(read_table(tmp_path / "t.csv")["error_bound"]) < 1e-12


@pytest.mark.parametrize("n_ranks", [2, 3])
def test_ranks(signorom, tmp_path, results, n_ranks):
    """Whole histories go to groups of ranks, and all say the same."""
    signorom("run", write_deck(tmp_path), folder=tmp_path, n_ranks=n_ranks)
    there = tmp_path / "results" / "part"
    for name in ("history.csv", "validation.csv"):
        one, other = read_table(results / name), read_table(there / name)
        assert one.keys() == other.keys()
    for row in range(16):
        for kind in ("lambda", "tau"):
            mine = forces_of(read_table(there / "history.csv"), row, kind)
            assert mine == pytest.approx(forces_of(read_table(results / "history.csv"), row, kind), abs=1e-10)


def test_histories_are_sampled_whole(signorom, tmp_path):
    """A point that is added brings its whole history; those that are there stay."""
    signorom(
        "sample", write_deck(tmp_path, **{"grid: {P: 2, mu: 2}": "grid: {P: 2, mu: 3}"}), folder=tmp_path
    )
    assert "sampled 32 points (32 were there)" in signorom("sample", write_deck(tmp_path), folder=tmp_path)


@pytest.mark.parametrize("solver", ["condensed", "condensed, linear: gamg", "active_set"])
@pytest.mark.parametrize(("share", "slides"), [(0.299, False), (0.301, True)])
def test_sliding(signorom, tmp_path, share, slides, solver):
    """A low block slides as soon as the shear is more than mu P, and not before."""
    shear = f'"{share} * P"'
    changes = {
        "training:": f"solver: {{type: {solver}}}\ntraining:",
        '"0.25 * P", "-0.25 * P", 0]': f"{shear}, 0, 0]",
        "output: {points: [{P: 4, mu: 0.8}, ": "output: {points: [",
    }
    deck = write_deck(tmp_path, **changes)
    done = signorom.run("solve", deck, folder=tmp_path)
    assert done.returncode == (3 if slides else 0)
    if slides:
        assert "time = 2.0 h" in done.stderr
        assert (
            "a body slides, because friction cannot hold it against the loads; it moves: 'upper'"
            in done.stderr
        )
        assert "nor has this history a solution at its 4 later times" in done.stderr
        status = read_table(tmp_path / "results" / "part" / "history.csv")["status"]
        assert [text == "converged" for text in status] == [True] * 3 + [False] * 5


def test_lost_histories(signorom, tmp_path):
    """A history without an answer is one line of the training, with the time from which it is lost."""
    changes = {'"0.25 * P", "-0.25 * P", 0]': '"0.301 * P", 0, 0]'}
    done = signorom.run("run", write_deck(tmp_path, **changes), folder=tmp_path)
    assert done.returncode == 3
    lines = [line for line in done.stderr.splitlines() if "training without" in line]
    assert [line.split(":")[1] for line in lines] == [
        f" training without P = {p} Pa, mu = 0.3 from time = 2.0 h on (5 of 8 states)" for p in (1.0, 9.0)
    ]
    assert all("a body slides, because friction cannot hold it" in line for line in lines)
    assert (
        "10 of the points did not converge (where a state of a history fails, its later ones do, too)"
        in done.stderr
    )


@pytest.mark.parametrize("has_moved_end", [False, True])
def test_full_slip(signorom, tmp_path, has_moved_end):
    """Drawn far by its top, a block slips everywhere: friction is mu times pressure, and turns with the motion.

    With the left end of the upper block moved along and that of the lower one held, nodes there slip, too: prescribed
    displacements along the surfaces do not make a plane of symmetry.
    """
    ends = "{boundary: left, displacement: {x: 0}}, {boundary: upper_left, displacement: {x: 1e-3 * shear}}, "
    changes = {
        "loads: [{boundary: top, pressure: load}, {boundary: top, traction: {x: shear}}]": "",
        "boundary_conditions: [": (
            f"boundary_conditions: [{ends if has_moved_end else ''}"
            "{boundary: top, displacement: {x: 1e-3 * shear, y: -1e-6 * load}}, "
        ),
        "mu: {min: 0.3, max: 1}": "mu: {min: 0.05, max: 1}",
        "{P: 4, mu: 0.3}": "{P: 4, mu: 0.1}",
    }
    deck = write_deck(tmp_path, **changes)
    mesh = stacked_blocks("Q4", 2)
    mesh.elements = [
        (kind, "upper_left" if name == "left" and mesh.coordinates[nodes, 1].mean() > 0 else name, nodes)
        for kind, name, nodes in mesh.elements
    ]
    # upper edges that are shorter at the ends, so that the rows there have free nodes, too
    face = mesh.coordinates[mesh.nodes_of("upper_face")]
    mesh.coordinates[mesh.nodes_of("upper_face"), 0] -= 0.3 * face[:, 0] * (1 - face[:, 0])
    mesh.write(tmp_path / "part.msh")
    signorom("solve", deck, folder=tmp_path)
    table = read_table(tmp_path / "results" / "part" / "history.csv")
    for row in range(8 + 3, 16):
        normal, tangential = forces_of(table, row, "lambda"), forces_of(table, row, "tau")
        sign = 1 if table["time"][row] <= 2 or table["time"][row] > 3 else -1
        assert tangential == pytest.approx(sign * 0.1 * normal, rel=1e-9)


def test_space(signorom, tmp_path):
    """Two tangential forces of each contact, with their directions."""
    changes = {
        "traction: {x: shear}": "traction: {x: shear, y: 0.5 * shear}",
        "test: {sobol: 2, seed: 1}\n": "",
    }
    signorom("run", write_deck(tmp_path, 3, **changes), folder=tmp_path)
    there = tmp_path / "results" / "part"
    table = read_table(there / "history.csv")
    assert any(name.endswith("_2") for name in table if name.startswith("tau_"))
    for row in range(16):
        first, second = ("contact_1_force_" + axis for axis in "xy")
        wanted = np.interp(table["time"][row], TIMES, SHEAR)
        assert [table[first][row], table[second][row]] == pytest.approx([wanted, 0.5 * wanted], abs=1e-9)
    signorom("predict", there / "model.h5", "--at", "P=4,mu=0.3", "--output", "t.csv", folder=tmp_path)
    answers = read_table(tmp_path / "t.csv")
    for row in range(8):
        assert forces_of(answers, row, "tau") == pytest.approx(forces_of(table, row + 8, "tau"), abs=1e-10)


def test_python(post, results):
    """One time after the other, arrays, and no answer of a state alone."""
    table = read_table(results / "history.csv")
    wanted = [
        np.concatenate([forces_of(table, row, kind) for kind in ("lambda", "tau")]) for row in range(8, 16)
    ]
    with post.Model(results / "model.h5") as model:
        n = len(wanted[0]) // 2
        assert list(model.force_contacts) == list(range(n)) * 2
        # on the lower block, whose normal points up: pressure downwards, friction as the shear of the upper block
        assert model.force_directions == pytest.approx(np.repeat([[0, -1], [1, 0]], n, axis=0))
        assert (model.contact_areas[n:] == 0).all()
        sides = model.contact_sides
        assert list(sides[0].tags) == list(sides[0].tags[:n]) * 2
        assert model.query_history(np.array([[4, 0.3]])).multipliers[0] == pytest.approx(
            np.array(wanted), abs=1e-11
        )
        with model.start(P=4, mu=0.3) as history:
            for time, forces in zip(TIMES, wanted, strict=True):
                answer = history.advance(time)
                assert answer.multipliers == pytest.approx(forces, abs=1e-11)
        state = {"P": 4, "mu": 0.3, "time": 1, "load": 4, "shear": 0}
        with pytest.raises(post.NoAnswerError, match="the model remembers"):
            model.query(**state)


def test_memory(post, results):
    """What a history remembers goes to another context, and damaged numbers are refused."""
    from signorom_post.library import BAD_ARGUMENT, NO_ANSWER, OK, doubles, ints, text_of

    with post.Model(results / "model.h5") as model:
        library, n = model._library, np.zeros(1, dtype=np.intc)
        forces = [np.zeros(len(model.contact_areas)) for _ in range(3)]
        with model._handles.model() as handle:
            assert library.signorom_get_memory_size(handle, ints(n)) == OK
        memory = np.zeros(n[0])
        with model._handles.context() as context, model._handles.context() as other:
            assert library.signorom_start(context, doubles(np.array([4, 0.3]))) == OK
            for time in TIMES[:4]:
                assert library.signorom_advance(context, time, None, None) == OK
            assert library.signorom_get_memory(context, doubles(memory)) == OK
            for one, found in ((context, forces[0]), (other, forces[1]), (context, forces[2])):
                assert library.signorom_set_memory(one, doubles(memory)) == OK
                assert library.signorom_get_multipliers(one, doubles(found)) == BAD_ARGUMENT
                assert library.signorom_advance(one, TIMES[3], None, None) == BAD_ARGUMENT
                assert library.signorom_advance(one, TIMES[4], None, None) == OK
                assert library.signorom_get_multipliers(one, doubles(found)) == OK
            assert (forces[0] == forces[1]).all()
            assert (forces[0] == forces[2]).all()
            # a shear that nothing holds: there is nothing to go on from, but there is before it
            assert library.signorom_advance(context, 9.0, doubles(np.array([4.0, 9.0])), None) == NO_ANSWER
            assert library.signorom_get_memory(context, doubles(memory.copy())) == BAD_ARGUMENT
            assert "nothing to go on from" in text_of(library.signorom_message(context))
            for place, value in ((-1, 7.0), (-1, 0.5), (3, 0.5), (5, np.nan), (0, -1.0)):
                damaged = memory.copy()
                damaged[place] = value
                assert library.signorom_set_memory(context, doubles(damaged)) == BAD_ARGUMENT
                assert "not possible" in text_of(library.signorom_message(context))
                assert library.signorom_advance(context, TIMES[4], None, None) == BAD_ARGUMENT
            assert library.signorom_set_memory(context, doubles(memory)) == OK


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        (
            {"reduction: {fields: true}": "solver: {type: snesvi}"},
            "snesvi solves neither friction nor tied contacts; solver.type must be condensed, active_set or auto",
        ),
        (
            {"reduction: {fields: true}": "reduction: {method: hhr}"},
            "hyper-reduction solves for a part of the contacts",
        ),
        (
            {"reduction: {fields: true}": "clusters: {number: 2, method: irregular}"},
            "clusters are those of hyper-reduction",
        ),
        (
            {
                "reduction: {fields: true}": "solver: {type: active_set}",
                "friction: mu": "friction: mu, initial_gap: 0.01",
            },
            "contact alone holds 'upper' (translation in x, translation in y, rotation), with a clearance at P = ",
        ),
        ({"friction: mu": "friction: mu - 1"}, "it must be at least 0"),
        ({"friction: mu": "friction: 1 / (mu - 0.3)"}, "which is not finite at"),
        ({"friction: mu": "friction: mu, tied: true"}, "and tied exclude each other"),
        ({"friction: mu": "initial_gap: 0.01, tied: true"}, "and tied exclude each other"),
    ],
    ids=["snesvi", "hhr", "clusters", "clearance", "negative", "nan", "tied", "tied gap"],
)
def test_refusals(signorom, tmp_path, changes, said):
    """Exit code 2 and a sentence with its place before anything is solved."""
    message = refuse(signorom, "check", write_deck(tmp_path, **changes), folder=tmp_path)
    assert said in message
    assert re.search(r"part\.yaml:[1-9]\d*:[1-9]\d*: ", message)


def test_contacts_without_free_nodes(signorom, tmp_path):
    """A node of the first surface that is held along the tangent: active_set is refused, and auto does not take it."""
    mesh = Mesh()
    lower = {(1, 0): "bottom", (1, 1): "lower_face", (0, 0): "left"}
    mesh.add_block("lower", [np.linspace(0, 1, 5), np.linspace(-1, 0, 5)], "Q4", lower)
    upper = {(1, 0): "upper_face", (1, 1): "top"}
    mesh.add_block("upper", [np.linspace(0, 1, 4), np.linspace(0, 1, 4)], "Q4", upper)
    held = "{boundary: bottom, displacement: {y: 0}}, {boundary: left, displacement: {x: 0}}"
    changes = {"{boundary: bottom, displacement: {x: 0, y: 0}}": held}
    write_deck(tmp_path, **changes, **{"reduction:": "solver: {type: active_set}\nreduction:"})
    mesh.write(tmp_path / "part.msh")
    said = refuse(signorom, "solve", "part.yaml", folder=tmp_path)
    assert re.search(
        r"part\.yaml:\d+:\d+: error: active_set needs, at each contact with friction or a tie", said
    )
    assert "solver.type must be condensed or auto" in said
    # the corner of the lower block is at x = 0, y = 0
    owner = int(re.search(r"contact\[1\] \(lower_face - upper_face\) has none at node (\d+)", said)[1])
    assert np.abs(mesh.coordinates[owner - 1]).max() == 0
    write_deck(tmp_path, **changes)
    mesh.write(tmp_path / "part.msh")
    signorom("solve", "part.yaml", folder=tmp_path)
    assert set(read_table(tmp_path / "results" / "part" / "history.csv")["status"]) == {"converged"}


def test_refused_models_name_the_contact(signorom, tmp_path):
    """The place of a refusal of a model is that of the coefficient of friction, or of a tied contact's first surface."""
    for friction, key in (("friction: mu", "friction: "), ("tied: true", "first: ")):
        deck = write_deck(
            tmp_path, **{"reduction: {fields: true}": "reduction: {method: hhr}", "friction: mu": friction}
        )
        lines = deck.read_text().splitlines()
        line = next(i for i, text in enumerate(lines) if friction in text and key in text)
        column = lines[line].index(key) + len(key)
        assert f"part.yaml:{line + 1}:{column + 1}: " in refuse(signorom, "check", deck, folder=tmp_path)


def test_warnings(signorom, tmp_path):
    """`check` names large coefficients, loads that begin with a jump, and turns inside of a step."""
    changes = {
        "mu: {min: 0.3, max: 1}": "mu: {min: 0.3, max: 2}",
        "[0, P, P]": "[1, P, P]",
        "increments: 6": "increments: 4",
    }
    said = signorom.run("check", write_deck(tmp_path, **changes), folder=tmp_path).stderr
    assert "contact[1] (lower_face - upper_face): the coefficient of friction is up to 2.0 at " in said
    assert "loads are not 0 at the time 0 (" in said
    assert "the table 'shear' turns round at the time 2.0, inside of a step" in said
    assert "warning" not in signorom.run("check", write_deck(tmp_path), folder=tmp_path).stderr


def test_warnings_between_the_points(signorom, tmp_path):
    """Coefficients count in the whole box, and overlaps as loads do, if there is friction in the first state."""
    deck = write_deck(tmp_path, **{"mu: {min: 0.3, max: 1}": "mu: {min: 0.3, max: 1.5}"})
    inside = yaml.safe_load(deck.read_text())
    inside["training"] = {"file": "points.csv"}
    del inside["test"]
    (tmp_path / "points.csv").write_text("P,mu\n4,0.8\n")
    inside["contact"][0]["initial_gap"] = -1e-6
    deck.write_text(yaml.safe_dump(inside, sort_keys=False))
    said = signorom.run("check", deck, folder=tmp_path).stderr
    assert "the coefficient of friction is up to 1.5 at " in said
    assert "overlaps of contact[1] are not 0 at the time 0 (P = 4.0 Pa, mu = 0.8)" in said
    inside["contact"][0]["friction"] = "time > 1 ? mu / 2 : 0"
    deck.write_text(yaml.safe_dump(inside, sort_keys=False))
    assert "not 0 at the time 0" not in signorom.run("check", deck, folder=tmp_path).stderr


def test_friction_that_is_missing(signorom, tmp_path):
    """Without friction nothing holds the upper block along x, and `check` says so."""
    changes = {
        "friction: mu": "friction: 0",
        "traction: {x: shear}}": "pressure: shear}",
        ", mu: {min: 0.3, max: 1}": "",
        "grid: {P: 2, mu: 2}": "grid: {P: 2}",
        "[{P: 4, mu: 0.8}, {P: 4, mu: 0.3}]": "[{P: 4}]",
    }
    deck = write_deck(tmp_path, **changes)
    said = signorom.run("check", deck, folder=tmp_path).stderr
    assert "the coefficient of friction is 0 at P = 1.0 Pa, time = 0.5 h" in said
    assert "and nothing else holds 'upper' (translation in x): with a load" in said
    # its loads do no work on this motion: the forces are those of a deck without the key
    signorom("solve", deck, folder=tmp_path)
    found = read_table(tmp_path / "results" / "part" / "history.csv")
    text = deck.read_text()
    deck.write_text(text.replace(", friction: 0", ""))
    signorom("solve", deck, folder=tmp_path)
    wanted = read_table(tmp_path / "results" / "part" / "history.csv")
    names = [name for name in wanted if name.startswith("lambda_")]
    assert names
    for name in names:
        np.testing.assert_allclose(found[name], wanted[name], rtol=1e-9)
        assert np.abs(found[name.replace("lambda", "tau")]).max() == 0
    # the block is held: nothing to say
    deck.write_text(text)
    support = "boundary_conditions: [{boundary: left, displacement: {x: 0}}, "
    deck.write_text(deck.read_text().replace("boundary_conditions: [", support))
    assert "coefficient of friction" not in signorom.run("check", deck, folder=tmp_path).stderr


def test_units(signorom, tmp_path, results):
    """In mm and MPa the forces are the same; the mesh is in m."""
    changes = {
        "units: {length: m,": "units: {length: mm,",
        "{file: part.msh,": "{file: part.msh, length_unit: m,",
        # per thickness of 1 mm, and stresses in N/mm^2: forces per thickness are those in m over 1000
        "young_modulus: 2.0e6": "young_modulus: 2.0",
        "pressure: load": "pressure: 1e-6 * load",
        "traction: {x: shear}": "traction: {x: 1e-6 * shear}",
    }
    signorom("solve", write_deck(tmp_path, **changes), folder=tmp_path)
    table, wanted = (
        read_table(tmp_path / "results" / "part" / "history.csv"),
        read_table(results / "history.csv"),
    )
    for row in range(16):
        for kind in ("lambda", "tau"):
            assert 1e3 * forces_of(table, row, kind) == pytest.approx(forces_of(wanted, row, kind), abs=1e-10)


@pytest.mark.parametrize("solver", ["condensed", "active_set"])
@pytest.mark.parametrize(("moved", "apart"), [(0.0, 0.0), (0.25, 0.0), (0.0, 1e-3), (0.25, 1e-3)])
def test_tied(signorom, tmp_path, moved, apart, solver):
    """Blocks whose nodes match or not hang together under a pull, as one bar of the height 2; nu = 0.

    Also where there is a gap between their meshes: tied, they do not close it.
    """
    changes = {
        "friction: mu": "tied: true",
        "poisson_ratio: 0.3": "poisson_ratio: 0",
        "pressure: load": "pressure: -load",
        ", {boundary: top, traction: {x: shear}}": "",
        "training:": f"solver: {{type: {solver}}}\ntraining:",
    }
    deck = write_deck(tmp_path, **changes)
    mesh = stacked_blocks("Q4", 2, moved=moved)
    mesh.coordinates[mesh.nodes_of("upper"), 1] += apart
    mesh.write(tmp_path / "part.msh")
    signorom("run", deck, folder=tmp_path)
    there = tmp_path / "results" / "part"
    fields = read_fields(there / "fields.h5", 8)
    assert fields["displacement"][:, 1].max() == pytest.approx(2 * 4 / 2.0e6, rel=1e-9)
    assert fields["stress"][:, 1] == pytest.approx(4, rel=1e-9)
    table = read_table(there / "history.csv")
    assert table["contact_force"][7] == pytest.approx(-4, rel=1e-9)
    # pulled or not, what is tied is closed
    assert table["contact_1_area"] == pytest.approx(np.ones(16), rel=1e-12)
    assert min(table["n_active"]) == max(table["n_active"]) > 0
    points = yaml.safe_load((there / "report.yaml").read_text())["points"]
    assert points["8"]["n_active"] == table["n_active"][7]
    assert points["8"]["contacts"]["1"]["area"] == pytest.approx(1, rel=1e-12)
    checked = read_table(there / "validation.csv")
    assert set(checked["n_active"]) == set(checked["n_active_full_order"]) == {table["n_active"][7]}
    with h5py.File(there / "contact.h5") as file:
        last = file["points"][max(file["points"])]
        assert set(last["status"][()]) == {4}
        assert set(last["contact_status"][()]) == {4}
    assert max(read_table(there / "validation.csv")["e_lambda_all"]) < 1e-10


@pytest.mark.parametrize("solver", ["condensed", "active_set"])
def test_tied_along_the_normal(signorom, tmp_path, solver):
    """Surfaces that only slip do not open under a pull, and no shear goes through."""
    changes = {
        "training:": f"solver: {{type: {solver}}}\ntraining:",
        "friction: mu": "tied: normal",
        "pressure: load": "pressure: -load",
        "{boundary: top, traction: {x: shear}}": "{region: upper, body_force: {x: 1e-3 * shear}}",
        "boundary_conditions: [": "boundary_conditions: [{boundary: left, displacement: {x: 0}}, ",
    }
    signorom("solve", write_deck(tmp_path, **changes), folder=tmp_path)
    table = read_table(tmp_path / "results" / "part" / "history.csv")
    assert set(table["status"]) == {"converged"}
    assert table["contact_1_force_y"][7] == pytest.approx(4, rel=1e-9)
    assert table["contact_1_force_x"][5] == pytest.approx(0, abs=1e-12)


def test_negative_friction_has_no_answer(signorom, results, tmp_path):
    """Outside of the box, where a coefficient is negative, the model does not answer as if there were none."""
    model = results / "model.h5"
    done = signorom.run("predict", model, "--at", "P=4,mu=-0.3", "--output", "t.csv", folder=tmp_path)
    assert done.returncode == 3
    assert "a coefficient of friction is negative" in (tmp_path / "t.csv").read_text()


def test_contact_force_is_that_of_normal_forces(post, results):
    """In Python as in the table of predict: friction is no part of it."""
    with post.Model(results / "model.h5") as model:
        histories = model.query_history(np.array([[4.0, 0.3]]))
        n_normal = np.sum(model.force_contacts == np.arange(len(model.force_contacts)))
        assert n_normal < len(model.force_contacts)
        wanted = histories.multipliers[..., :n_normal].sum(axis=-1)
        np.testing.assert_array_equal(histories.contact_force, wanted)
        with model.start(P=4.0, mu=0.3) as history:
            answer = history.advance(model.times[0])
        assert answer.contact_force == pytest.approx(answer.multipliers[:n_normal].sum(), rel=1e-14)
