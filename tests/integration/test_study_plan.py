# SPDX-License-Identifier: BSD-3-Clause
"""What the stages of a study will take, as `check` predicts it, and the models that the memory allows."""

import re
import subprocess

import numpy as np
import pytest

from block_meshes import Mesh
from runs import SOON, write_deck

N_CONTACTS = 3000  # W takes 72 MB: more than the 64 MB that were the limit for all models once
STRIP = """\
title: A strip on its bed
mesh: {{file: strip.msh, model: plane_strain}}
parameters: {{press: {{min: 1.0e-3, max: 2.0e-3, unit: m}}}}
materials:
  bed: {{regions: [lower, upper], young_modulus: 2.0e6, poisson_ratio: 0.3}}
boundary_conditions:
  - {{boundary: bottom, displacement: {{x: 0, y: 0}}}}
  - {{boundary: top, displacement: {{x: 0, y: -press}}}}
contact:
  - {{first: lower_face, second: upper_face, direction: [0, 1]}}
training: {{grid: {{press: 40}}}}
test: {{grid: {{press: 20}}}}
reduction: {{{reduction}}}
"""


@pytest.fixture(scope="module")
def strip(tmp_path_factory):
    """Folder with the mesh of a long strip on its bed."""
    folder = tmp_path_factory.mktemp("strip")
    across = np.linspace(0.0, 1.0, N_CONTACTS)
    mesh = Mesh()
    mesh.add_block("lower", [across, np.array([-0.001, 0.0])], "Q4", {(1, 0): "bottom", (1, 1): "lower_face"})
    mesh.add_block("upper", [across, np.array([0.0, 0.001])], "Q4", {(1, 0): "upper_face", (1, 1): "top"})
    mesh.write(folder / "strip.msh")
    return folder


def check_strip(signorom, folder, reduction, n_ranks=1):
    """What `check` says of the strip."""
    deck = folder / "strip.yaml"
    deck.write_text(STRIP.format(reduction=reduction))
    return signorom("check", deck.name, folder=folder, n_ranks=n_ranks)


def test_stages_have_time_and_memory(signorom, strip):
    said = check_strip(signorom, strip, "displacement: none")
    stage = r": (\d[\w. ]* (s|min|h)[\w ]*), \d[\d.]* (MB|GB)"
    assert re.search(
        "^# memory: solvers may take \\d[\\d.]* [MG]B on all ranks together$", said, re.MULTILINE
    )
    assert re.search(f"^# predicted: sampling of 40 points{stage}$", said, re.MULTILINE)
    assert re.search(f"^# predicted: training{stage}; model file of at most", said, re.MULTILINE)
    assert re.search(f"^# predicted: validation at 20 points{stage}$", said, re.MULTILINE)


def test_default_model_is_exact_beyond_the_old_limit(signorom, strip):
    """W and two terms, 8 bytes a number; two references at most fit into the 200 MB for transforms."""
    said = check_strip(signorom, strip, "displacement: none, max_transforms_size: 144")
    megabytes = 8e-6 * N_CONTACTS * (N_CONTACTS + 2) + 144
    assert f"model file of at most {megabytes:.0f} MB" in said
    assert "hyper-reduction" not in said


def test_limit_of_the_deck_counts(signorom, strip):
    """The hint says which kind of model there will be, and why."""
    said = check_strip(signorom, strip, "max_full_order_size: 64, displacement: none")
    assert "model file" not in said
    said = check_strip(signorom, strip, "max_full_order_size: 0")
    assert "# hyper-reduction (reduction.method: auto): the matrix of all contacts takes 72.0 MB" in said


def test_choice_is_the_same_on_two_ranks(signorom, strip):
    said = [check_strip(signorom, strip, "displacement: none", n) for n in (1, 2)]
    files = [re.search("model file of at most .*", text)[0] for text in said]
    assert files[0] == files[1]


def test_limit_of_the_process_counts(signorom, tmp_path):
    """60 % of 2 000 000 kB of address space."""
    deck = write_deck("small_disks", tmp_path)
    done = subprocess.run(
        ["bash", "-c", 'ulimit -v 2000000; exec "$0" check "$1"', signorom.executable, deck.name],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=SOON,
        check=True,
    )
    assert "# memory: solvers may take 1.2 GB on all ranks together" in done.stdout
