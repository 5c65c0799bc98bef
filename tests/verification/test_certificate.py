# SPDX-License-Identifier: BSD-3-Clause
"""Bounds of answers, and of forces that were spoiled in three ways, against true errors at random points.

`tests/verification/certificates.py` does the same for every shipped deck at 10 000 points.
"""

import re
import subprocess

import pytest
import yaml

from program import find_program
from runs import INPUT

CHECK = find_program().executable.parent / "tests" / "check_certificate"
N_POINTS = 400
LINE = re.compile(r"^(.{24}) +(\d+) points +(\d+) violations(?: +\d+ errors, effectivity +([\d.]+))?", re.M)
# of the forces of a model, and of spoiled ones
LARGEST_MEDIAN = 2.0


@pytest.mark.parametrize("name", ["half_disks", "pellet_cladding_whole_edges", "bracket"])
def test_bound_is_never_below_the_error(signorom, tmp_path, name):
    deck = yaml.safe_load((INPUT / f"{name}.yaml").read_text())
    deck["mesh"]["file"] = str((INPUT / deck["mesh"]["file"]).resolve())
    (tmp_path / "deck.yaml").write_text(yaml.safe_dump(deck, sort_keys=False))
    signorom("sample", "deck.yaml", folder=tmp_path)
    signorom("train", "deck.yaml", folder=tmp_path)
    command = [CHECK, tmp_path / "results/deck/model.h5", str(N_POINTS), "3"]
    done = subprocess.run(command, capture_output=True, text=True)
    print(done.stdout)
    assert done.returncode == 0, done.stdout + done.stderr
    lines = LINE.findall(done.stdout)
    # where contact alone holds a body only its answers have a bound, and these are exact
    assert len(lines) == (1 if name == "bracket" else 4)
    for _, n_points, n_violations, median in lines:
        assert int(n_points) > 0.9 * N_POINTS  # without contact there is nothing to spoil
        assert int(n_violations) == 0
        assert bool(median) == (name != "bracket")
        assert not median or 1 <= float(median) <= LARGEST_MEDIAN
    assert "0 without an answer, 0 without a reference" in done.stdout
