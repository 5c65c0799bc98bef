# SPDX-License-Identifier: BSD-3-Clause
"""Parts as users mesh them: second-order elements, nodes that do not match, all defaults, held by contact alone.

The answers of the default model against the full order that is not condensed, and against the equilibrium of the loads.
"""

import re

import numpy as np
import pytest
import yaml

from runs import INPUT, read_report, read_snapshots, read_table, write_input

SEED = 1495
SAME_SOLUTION = 1e-8
# active_set factors K anew in each step; --all-points asks at 100
N_POINTS = {"dovetail": 30, "angle_bracket": 3}
PROBLEM = {
    "dovetail": "blade root in its slot, Q8 on T6, mortar",
    "angle_bracket": "bracket pried off a plate, T10 on T10, mortar",
}


@pytest.fixture(scope="module", params=N_POINTS)
def part(request, signorom, tmp_path_factory):
    """Name of a deck, and the folder in which it ran."""
    folder = tmp_path_factory.mktemp(request.param)
    said = signorom("run", write_input(request.param, folder), folder=folder)
    assert "mortar, because" in said
    assert "accepted: " in said
    return request.param, folder


def draw_points(name, n):
    """Random points in the box of a deck, and the names of its parameters."""
    print("seed", SEED)
    ranges = yaml.safe_load((INPUT / f"{name}.yaml").read_text())["parameters"]
    ends = np.array([[entry["min"], entry["max"]] for entry in ranges.values()]).T
    return list(ranges), np.random.default_rng(SEED).uniform(*ends, (n, len(ranges)))


def predicted(signorom, folder, name):
    """Answers of the model at the points of points.csv."""
    model = folder / "results" / name / "model.h5"
    signorom("predict", model, "--points", "points.csv", "--output", "answers.csv", folder=folder)
    answers = read_table(folder / "answers.csv")
    assert set(answers["status"]) == {"answered"}
    return np.column_stack([values for column, values in answers.items() if column.startswith("lambda_")])


def solved(signorom, folder, name):
    """Forces by active_set at the same points."""
    below = folder / "active"
    below.mkdir(exist_ok=True)
    deck = write_input(name, below)
    text = re.sub(r"(?m)^training: .*$", "training: {file: ../points.csv}", deck.read_text())
    deck.write_text(f"{text}solver: {{type: active_set}}\n")
    signorom("sample", deck, folder=below)
    snapshots = read_snapshots(below / "results" / name / "snapshots.h5")
    assert (snapshots["reasons"] > 0).all()
    return snapshots["multipliers"]


def test_default_model_is_exact(signorom, part, figures, pytestconfig):
    """No key of solver or reduction in the deck: every point is answered, with the forces of the full order."""
    name, folder = part
    names, points = draw_points(name, 100 if pytestconfig.getoption("--all-points") else N_POINTS[name])
    lines = [",".join(names), *(",".join(map(repr, point)) for point in points.tolist())]
    (folder / "points.csv").write_text("\n".join([*lines, ""]))
    found, expected = predicted(signorom, folder, name), solved(signorom, folder, name)
    is_closed = expected > 1e-9 * expected.max(axis=1)[:, None]
    assert len(np.unique(is_closed, axis=0)) >= min(len(points), 4), "the contacts hardly change"
    worst = (np.linalg.norm(found - expected, axis=1) / np.linalg.norm(expected, axis=1)).max()
    quantity = f"forces of predict at {len(points)} points"
    figures.at_most(PROBLEM[name], quantity, worst, SAME_SOLUTION, "solver active_set")


def force_on_blade(speed, gas, **_):
    """[N/mm] By hand from meshes/dovetail.geo: gas on the straight side, the pull of the tip, the blade's own mass."""
    t = np.tan(np.pi / 8)
    across = gas * (18 - (4 - 6 + 2.5 * t))
    # neck, flanks (half width 4 - y from y = -8.5 to -2), foot; two fillets fill and two cut corners of 135 degrees
    area = 12 * 20 + (12.5 + 6) * 6.5 + 25 * 4.5 + 2 * (2.5**2 - 1.5**2) * (t - np.pi / 8)
    moment = 240 * 8 + (4 * 4 + 16 / 3) - (4 * 8.5**2 + 2 * 8.5**3 / 3) - 112.5 * 10.75
    return [across, 1e-4 * speed**2 * 12 + 8.2e-9 * speed**2 * (300 * area + moment)]


def force_on_bracket(bolt, pull, **_):
    """[N] By hand from meshes/angle_bracket.geo: half a ring from 5 to 9 mm under the bolt, 8 x 12 mm on the wall."""
    return [0, 0, 8 * 12 * pull - np.pi / 2 * (9**2 - 5**2) * bolt]


# resultant of the loads; edges of second order miss the arcs by about 1e-6, by 1e-5 on the ring
BY_HAND = {"dovetail": (force_on_blade, 1e-5), "angle_bracket": (force_on_bracket, 1e-4)}


def test_contacts_carry_the_loads(part, figures):
    """Resultants of all contacts against the loads, relative to their size."""
    name, folder = part
    (answer,) = read_report(folder, name)["points"].values()
    point = {
        key: float(value) for key, value in re.findall(r"(\w+) = (\S+)", answer["point"].replace(",", ""))
    }
    load, allowed = BY_HAND[name][0](**point), BY_HAND[name][1]
    carried = -sum(np.array(contact["force"]) for contact in answer["contacts"].values())
    worst = np.abs(carried - load).max() / np.linalg.norm(load)
    figures.at_most(PROBLEM[name], "forces of the contacts", worst, allowed, "equilibrium, by hand")
