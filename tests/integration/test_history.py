# SPDX-License-Identifier: BSD-3-Clause
"""Decks with a history: states at many times, of which each is that of a point with the same values."""

import numpy as np
import pytest

from block_meshes import stacked_blocks
from results import read_fields, read_table
from runs import refuse

# The blocks are 1 wide, nu = 0: the contact force is the pressure, and the upper block is pressed together by P / E.
MODULUS = 2.0e6
DECK = f"""title: A block under a pressure that comes and goes
units: {{length: m, force: N, time: h}}
mesh: {{file: part.msh, model: plane_strain}}
parameters: {{P: {{min: 1, max: 9, unit: Pa}}, late: {{min: 0, max: 1, unit: h}}}}
history:
  tables:
    load: {{time: [0, "1 + late", 3], value: [0, P, "-P / 2"]}}
  steps:
    - {{until: 2, increments: 4}}
    - {{until: 4, increments: 3, growth: 4}}
materials: {{all: {{regions: [lower, upper], young_modulus: {MODULUS}, poisson_ratio: 0}}}}
boundary_conditions:
  - {{boundary: bottom, displacement: {{x: 0, y: 0}}}}
  - {{boundary: left, displacement: {{x: 0}}}}
loads: [{{boundary: top, pressure: "load + 5 * time"}}]
contact: [{{first: lower_face, second: upper_face}}]
training: {{grid: {{P: 3, late: 2}}}}
test: {{sobol: 3, seed: 1}}
reduction: {{fields: true}}
output: {{points: [{{P: 4, late: 0.5}}, {{P: 2, late: 0}}]}}
"""
# growth 4 over 3 increments: the factor is 2, the increments are 2/7, 4/7 and 8/7
TIMES = [0.5, 1, 1.5, 2, 2 + 2 / 7, 2 + 6 / 7, 4]


def load_at(time, p, late):
    """The table `load`."""
    return np.interp(time, [0, 1 + late, 3], [0, p, -p / 2])


def write_deck(folder, **changes):
    """Mesh and deck, with texts replaced."""
    folder.mkdir(exist_ok=True)
    stacked_blocks("Q4", 2).write(folder / "part.msh")
    text = DECK
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    (folder / "part.yaml").write_text(text)
    return folder / "part.yaml"


@pytest.fixture(scope="module")
def results(signorom, tmp_path_factory):
    """Results of `run` on one rank."""
    folder = tmp_path_factory.mktemp("history")
    signorom("run", write_deck(folder), folder=folder)
    return folder / "results" / "part"


@pytest.mark.parametrize("n_ranks", [1, 2, 3])
def test_predict(signorom, tmp_path, results, n_ranks):
    """A row per time: the time, the table, and the force, which is the pressure where it presses."""
    if n_ranks > 1:
        signorom("run", write_deck(tmp_path), folder=tmp_path, n_ranks=n_ranks)
        results = tmp_path / "results" / "part"
    (tmp_path / "points.csv").write_text("late,P\n0.3,7\n0,2.5\n")
    signorom("predict", results / "model.h5", "--points", "points.csv", "--output", "t.csv", folder=tmp_path)
    table = read_table(tmp_path / "t.csv")
    assert table["time"] == pytest.approx(TIMES * 2, rel=1e-14)
    for start, (p, late) in [(0, (7, 0.3)), (7, (2.5, 0))]:
        rows = slice(start, start + 7)
        assert list(table["P"][rows]) == [p] * 7
        assert table["load"][rows] == pytest.approx(load_at(np.array(TIMES), p, late), rel=1e-13)
        pressure = load_at(np.array(TIMES), p, late) + 5 * np.array(TIMES)
        assert table["contact_force"][rows] == pytest.approx(pressure, rel=1e-10)
    assert set(table["status"]) == {"answered"}


def test_validation_and_snapshots(results):
    """Snapshots and test points are states: 6 points and 3 points at 7 times."""
    table = read_table(results / "validation.csv")
    assert len(table["time"]) == 3 * len(TIMES)
    assert max(table["e_lambda_all"]) < 1e-10
    assert max(table["e_u_energy_relative"]) < 1e-10
    report = (results / "report.yaml").read_text()
    assert "n_points: 42" in report


def test_fields_have_real_times(results):
    """ParaView's times are those of the first point, then those of the second one behind them."""
    xdmf = (results / "fields.xdmf").read_text()
    times = [float(line.split('"')[1]) for line in xdmf.splitlines() if "<Time Value" in line]
    assert times == pytest.approx(TIMES + [4 + time for time in TIMES], rel=1e-13)
    for k, time in enumerate(TIMES):
        fields = read_fields(results / "fields.h5", k + 1)
        down = -fields["displacement"][:, 1].min()
        # both blocks are 1 high
        assert down == pytest.approx(2 * (load_at(time, 4, 0.5) + 5 * time) / MODULUS, rel=1e-9)


@pytest.mark.parametrize(
    "changes",
    [
        {"young_modulus: 2000000.0": "young_modulus: 250000.0 * (8 - late)"},
        {"reduction: {fields: true}": "reduction: {method: hhr, enrichment: {type: none}}"},
        {"reduction: {fields: true}": "solver: {type: active_set}"},
    ],
    ids=["interpolated", "hhr", "active_set"],
)
def test_other_models(signorom, tmp_path, changes):
    """The same answers where the stiffness varies, of hyper-reduction, and of another solver."""
    deck = write_deck(tmp_path, **changes)
    signorom("run", deck, folder=tmp_path)
    model = tmp_path / "results" / "part" / "model.h5"
    signorom("predict", model, "--at", "P=6,late=0.2", "--output", "t.csv", folder=tmp_path)
    table = read_table(tmp_path / "t.csv")
    wanted = load_at(np.array(TIMES), 6, 0.2) + 5 * np.array(TIMES)
    assert table["contact_force"] == pytest.approx(wanted, rel=1e-6)


def test_table_from_a_file(signorom, tmp_path, results):
    """The nodes of a table may stand in a CSV file, whose faults are named with their places."""
    (tmp_path / "load.csv").write_text("value,time\n0,0\n4,1.5\n-2,3\n")
    changes = {'{time: [0, "1 + late", 3], value: [0, P, "-P / 2"]}': "{file: load.csv}"}
    deck = write_deck(tmp_path, **changes)
    signorom("solve", deck, "--at", "P=1,late=1", folder=tmp_path)
    for k in range(len(TIMES)):
        there = read_fields(tmp_path / "results" / "part" / "fields.h5", k + 1)["displacement"]
        assert there == pytest.approx(
            read_fields(results / "fields.h5", k + 1)["displacement"], rel=1e-9, abs=1e-18
        )
    (tmp_path / "load.csv").write_text("value,time\n0,0\n4,\n")
    assert "load.csv:3:3: error: '' is not a number" in refuse(signorom, "check", deck, folder=tmp_path)
    (tmp_path / "load.csv").write_text("value,time\n0,0\n4,2\n4,1\n")
    assert "history.tables.load has the times 2.0, 1.0" in refuse(signorom, "check", deck, folder=tmp_path)
    (tmp_path / "load.csv").write_text("value,time\n0,0\n4,1\n")
    assert "the table 'load' ends at 1.0" in signorom.run("solve", deck, folder=tmp_path).stderr


def test_table_of_forces(results):
    """`solve` and `run` write a row per state with the columns of predict."""
    table = read_table(results / "history.csv")
    assert table["time"] == pytest.approx(TIMES * 2, rel=1e-14)
    assert set(table["status"]) == {"converged"}
    for start, (p, late) in [(0, (4, 0.5)), (7, (2, 0))]:
        rows = slice(start, start + 7)
        forces = load_at(np.array(TIMES), p, late) + 5 * np.array(TIMES)
        assert table["contact_force"][rows] == pytest.approx(forces, rel=1e-9)
        # no friction, nu = 0: the block is pressed down onto the first surface
        assert table["contact_1_force_y"][rows] == pytest.approx(-forces, rel=1e-9)


def test_other_history(signorom, tmp_path, results):
    """--history replaces times and tables of the deck; its faults are named."""
    path = tmp_path / "measured.csv"
    path.write_text("load,time\n2,0.3\n-1,3.5\n7,9\n")
    command = ["predict", results / "model.h5", "--at", "P=5,late=0", "--history", "measured.csv"]
    signorom(*command, "--output", "t.csv", folder=tmp_path)
    table = read_table(tmp_path / "t.csv")
    assert list(table["time"]) == [0.3, 3.5, 9]
    assert list(table["load"]) == [2, -1, 7]
    assert table["contact_force"] == pytest.approx([2 + 1.5, -1 + 17.5, 7 + 45], rel=1e-10)
    for text, said in [
        ("time\n1\n", "there is no column for"),
        ("load,time\n2,1\n2,1\n", "ascend"),
        ("load,time\n2,0\n", "ascend"),
        ("load,time\n2,x\n", "measured.csv:2:3: error: 'x' is not a number"),
    ]:
        path.write_text(text)
        assert said in refuse(signorom, *command, folder=tmp_path)


def answer_at(model, time):
    """The answer at a time of the history with P = 7, late = 0.3."""
    return model.start(P=7, late=0.3).advance(time)


def test_python(post, results):
    """States, answers with a time axis, and one time after the other, also with measured tables."""
    with post.Model(results / "model.h5") as model:
        assert [parameter.name for parameter in model.parameters] == ["P", "late", "time", "load"]
        assert model.times == pytest.approx(TIMES, rel=1e-14)
        points = np.array([[7, 0.3], [2.5, 0]])
        answers = model.query_history(points)
        assert answers.multipliers.shape[:2] == (2, len(TIMES))
        assert answers.points.shape == (2, len(TIMES), 4)
        for (p, late), forces, states in zip(points, answers.contact_force, answers.points, strict=True):
            loads = load_at(np.array(TIMES), p, late)
            assert states[:, 3] == pytest.approx(loads, rel=1e-13)
            assert forces == pytest.approx(loads + 5 * np.array(TIMES), rel=1e-10)
        with model.start(P=7, late=0.3) as history:
            for k, time in enumerate(TIMES):
                answer = history.advance(time)
                assert answer.multipliers == pytest.approx(answers.multipliers[0, k], rel=1e-14)
                assert answer.point["load"] == pytest.approx(answers.points[0, k, 3], rel=1e-14)
            with pytest.raises(ValueError, match="is not later than 4"):
                history.advance(4)
            with pytest.raises(TypeError, match="give a value for each table or for none: load"):
                history.advance(5, pull=1)
            with pytest.warns(post.ExtrapolationWarning):
                assert history.advance(4.5, load=-3).multipliers.sum() == pytest.approx(-3 + 22.5, rel=1e-10)
            # force = load + 5 t; load = P (1 - 1.5 (t - 1.3) / 1.7) behind the node at 1 + late = 1.3 h
            gradient = answer_at(model, 2.0).gradient
            along = dict(zip(gradient.parameters, gradient.multipliers.sum(axis=1), strict=True))
            share = (2.0 - 1.3) / 1.7
            slope = -1.5 * 7 / 1.7
            assert along["P"] == pytest.approx(1 - 1.5 * share, rel=1e-7)
            assert along["time"] == pytest.approx(slope + 5, rel=1e-7)
            # a later peak shifts the node at 1.3 h: d share / d late = (share - 1) / 1.7
            assert along["late"] == pytest.approx(-7 * 1.5 * (share - 1) / 1.7, rel=1e-6)
            assert along["load"] == pytest.approx(1, rel=1e-9)
            partial = model.query(**answer_at(model, 2.0).point).gradient
            assert partial.multipliers.sum(axis=1) == pytest.approx([0, 0, 5, 1], abs=1e-8)
        with pytest.raises(ValueError, match="the history is closed"):
            history.advance(6)
        with pytest.raises(TypeError, match="unknown parameter 'time'"):
            model.start(P=7, late=0.3, time=1)


def test_more_points(signorom, tmp_path):
    """States that are there are not solved again."""
    deck = write_deck(tmp_path, **{"grid: {P: 3, late: 2}": "grid: {P: 2, late: 2}"})
    signorom("sample", deck, folder=tmp_path)
    deck = write_deck(tmp_path)
    assert "sampled 42 points (28 were there)" in signorom("sample", deck, folder=tmp_path)


def test_prescribed_time_is_no_parameter(signorom, tmp_path, results):
    """--at gives the point; the times follow from the deck."""
    said = refuse(signorom, "predict", results / "model.h5", "--at", "P=2,late=0,time=1", folder=tmp_path)
    assert "unknown parameter 'time' in --at; the parameters are P, late" in said


def test_history_of_a_model_without_one(signorom, post, tmp_path):
    """--history needs a model with times, and goes with predict only."""
    deck = tmp_path / "part.yaml"
    write_deck(tmp_path)
    text = DECK[: DECK.index("history:")] + DECK[DECK.index("materials:") :]
    deck.write_text(text.replace('"load + 5 * time"', '"P + late"'))
    signorom("sample", deck, folder=tmp_path)
    signorom("train", deck, folder=tmp_path)
    (tmp_path / "h.csv").write_text("time\n1\n")
    model = tmp_path / "results" / "part" / "model.h5"
    command = ["predict", model, "--at", "P=2,late=0", "--history", "h.csv"]
    assert "the model has no history: its deck has no times" in refuse(signorom, *command, folder=tmp_path)
    said = refuse(signorom, "solve", deck, "--history", "h.csv", folder=tmp_path)
    assert "--history goes with predict, not with solve" in said
    with post.Model(model) as opened, pytest.raises(post.NoHistoryError):
        opened.start(P=2, late=0)
