# SPDX-License-Identifier: BSD-3-Clause
"""Case b by `signorom-post paper`: what does not depend on choices of ours agrees with the paper or agreed limits."""

import csv
import subprocess
import sys

import pytest

from program import ENVIRONMENT, ROOT

#: the entries that need few models: the reduced domains, contact forces with all hats, the decay of the modes; and three
#: clusters, on a map that is coarser than the paper's
ENTRIES = ["fig09", "fig14", "fig16", "fig18", "--map", "25"]
#: judged numbers: of the first three entries; l-bar of three clusters, the maps at kappa_max = 10 and 1
N_JUDGED = 7 + 3 + 3 + 2
SOURCE = "Le Berre et al. 2022"


def run_paper(output):
    """Rows of the summary of these entries."""
    command = [sys.executable, "-m", "signorom_post", "paper", "--output", str(output), "--only", *ENTRIES]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=800, check=False)
    assert done.returncode == 0, done.stderr
    with (output / "summary.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def record(figures, row):
    """A range around the paper's number, or a limit above it."""
    paper, ours, low, high = (float(row[name]) for name in ("paper", "ours", "allowed_min", "allowed_max"))
    text = f"{row['where']}: {row['quantity']}"
    if low == 0.0:
        source = "agreed limit" if "agreed" in row["remark"] else SOURCE
        figures.at_most("pellet and cladding", text, ours, high, source)
    else:
        figures.compare("pellet and cladding", text, ours, paper, high - paper, SOURCE, kind="absolute")


@pytest.mark.slow
def test_case_b_agrees_with_the_paper(signorom, figures, tmp_path, monkeypatch):
    """36 modes, the contact pairs of the domains within 6, dual errors with all hats at most 1.3 times the paper's.

    With three clusters: bases within 8 of the paper's, and maps as agreed on.
    """
    environment = {"SIGNOROM_EXECUTABLE": str(signorom.executable), **ENVIRONMENT}
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    judged = [row for row in run_paper(tmp_path) if row["verdict"] != "-"]
    assert len(judged) == N_JUDGED
    for row in judged:
        record(figures, row)
    for name in ("fig09a", "fig09b", "fig14", "fig16", "fig18"):
        assert (tmp_path / f"{name}.png").stat().st_size > 10_000
