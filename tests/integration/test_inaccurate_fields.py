# SPDX-License-Identifier: BSD-3-Clause
"""A model whose contact forces are right and whose displacements are not says so wherever it answers."""

import re
import warnings

import pytest

from results import read_table
from runs import write_deck

POINT = {"squeeze": 0.2, "nu": 0.3}
# no room for displacements other than modes, and few of these, because much error is allowed
CHANGES = {
    "max: 0.45, unit: m}}": "max: 0.45, unit: m}, nu: {min: 0.2, max: 0.45}}",
    "poisson_ratio: 0.35": "poisson_ratio: nu",
    "solver: {type: condensed}\n": "",
    "{grid: {squeeze: 15}}": "{sobol: 4}",
    "{grid: {squeeze: 7}}": "{sobol: 20, seed: 1}",
    "method: hhr, pod_tolerance: 1.0e-8": "max_full_order_size: 0.02, displacement_tolerance: 0.9, fields: true",
    "[{squeeze: 0.2}, {squeeze: 0.4}]": "[{squeeze: 0.2, nu: 0.3}]",
}


@pytest.fixture(scope="module")
def study(signorom, tmp_path_factory):
    """Folder of the results, and what `run` said."""
    folder = tmp_path_factory.mktemp("study")
    done = signorom.run("run", write_deck("small_disks", folder, **CHANGES), folder=folder)
    assert done.returncode == 0, done.stderr
    return folder / "results" / "small_disks", done.stdout + done.stderr


def test_two_sentences_are_said(study):
    results, said = study
    table = read_table(results / "validation.csv")
    assert table["e_lambda_all"].max() < 1e-5
    assert table["e_u_energy_relative"].max() > 0.01
    # a bound
    assert (table["displacement_bound"] >= table["e_u_energy_relative"]).all()
    assert "forces accepted: p95 of e_lambda_all is" in said
    assert "warning: fields NOT accepted: p95 of e_u_energy_relative is" in said
    assert "the verdict on the model does not count this" not in said


def test_predict_tells_the_largest_error(signorom, study):
    results, _ = study
    at = ",".join(f"{name}={value}" for name, value in POINT.items())
    done = signorom.run("predict", "model.h5", "--at", at, "--fields", "--output", "one.csv", folder=results)
    assert done.returncode == 0
    bound = read_table(results / "one.csv")["displacement_bound"][0]
    assert bound > 0.01
    told = re.search(
        r"may be above 1 % at 1 of 1 point with fields: .* the largest error is (\S+) at", done.stderr
    )
    assert float(told[1]) == pytest.approx(bound, rel=1e-6)
    assert "the validation of this model: NOT accepted: p95 of e_u_energy_relative is" in done.stderr


def test_python_tells_the_error_of_fields(post, study):
    results, _ = study
    with pytest.warns(post.NotAcceptedWarning, match="NOT accepted: p95 of e_u_energy_relative"):
        model = post.Model(results / "model.h5")
    with model:
        with pytest.warns(post.InaccurateFieldsWarning):
            fields = model.fields(**POINT)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            answer = model.query(**POINT)
            many = model.query_many([list(POINT.values())])
    assert fields.relative_displacement_bound > 0.01
    assert fields.relative_displacement_bound == answer.relative_displacement_bound
    assert many.relative_displacement_bound[0] == answer.relative_displacement_bound
