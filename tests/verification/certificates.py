#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Bounds of all shipped decks against true errors: 10 000 random points each, 200 above 500 contacts.

    build/venv/bin/python tests/verification/certificates.py            # all decks: about an hour
    build/venv/bin/python tests/verification/certificates.py bracket    # one
    build/venv/bin/python tests/verification/certificates.py --hyper-reduced --without-matrix bracket

Samples and trains each deck of input/ that can be trained, then prints the tables of check_certificate: of the model
that the deck asks for, of a hyper-reduced one, or of one that is to have no room for the matrix of all contacts, which
then comes from a condensed model of the same snapshots. The Python tool must be on the path. Ends with 1 where a bound
lies below an error, or a deck could not be trained.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "support"))
from program import ENVIRONMENT  # noqa: E402


def table_of(deck, build, n_points, folder, arguments):
    """What check_certificate says of a deck's model, or why there is none; and whether no bound was too small."""
    content = yaml.safe_load(deck.read_text())
    if "training" not in content:
        return "no training section", True
    content["mesh"]["file"] = str((deck.parent / content["mesh"]["file"]).resolve())
    if arguments.hyper_reduced or arguments.without_matrix:
        content["reduction"] = content.get("reduction", {}) | {"method": "hhr"}
        content["certificate"] = {"max_error": 0.05}
    models = [folder / "model.h5"]
    steps = [("sample", content), ("train", content)]
    if arguments.without_matrix:
        # a stiffness that may not be factored is none that W comes from
        steps[1] = ("train", content | {"solver": {"linear": "gamg"}})
        whole = {key: value for key, value in content.items() if key != "clusters"}
        steps.append(("train", whole | {"reduction": {"method": "condensed"}}))
        models.append(folder / "condensed.h5")
    for i, (command, step) in enumerate(steps):
        (folder / "deck.yaml").write_text(yaml.safe_dump(step, sort_keys=False))
        said = run([build / "signorom", command, "deck.yaml"], folder)
        if said.returncode:
            return said.stderr.strip().splitlines()[0], False
        if i > 0:
            (folder / "results" / "deck" / "model.h5").rename(models[i - 1])
    said = run([build / "tests" / "check_certificate", models[0], str(n_points), "1", *models[1:]], folder)
    return (said.stdout + said.stderr).strip(), said.returncode == 0


def run(command, folder):
    """A finished process with what it said."""
    return subprocess.run(command, cwd=folder, env=os.environ | ENVIRONMENT, capture_output=True, text=True)


def main():
    """Print the table of each deck."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("decks", nargs="*", help="names in input/; default: all")
    parser.add_argument("--build", type=Path, default=ROOT / "build" / "release")
    parser.add_argument(
        "--points", type=int, default=10000, help="of a deck with up to 500 contacts; others get 200"
    )
    parser.add_argument(
        "--hyper-reduced", action="store_true", help="reduction.method: hhr, whatever the deck says"
    )
    parser.add_argument(
        "--without-matrix", action="store_true", help="such models without the matrix of all contacts"
    )
    arguments = parser.parse_args()
    build = arguments.build.resolve()
    large = {"flange", "indenter"}
    is_good = True
    for deck in sorted((ROOT / "input").glob("*.yaml")):
        if arguments.decks and deck.stem not in arguments.decks:
            continue
        with tempfile.TemporaryDirectory() as folder:
            n_points = min(arguments.points, 200) if deck.stem in large else arguments.points
            text, is_right = table_of(deck, build, n_points, Path(folder), arguments)
        print(f"{deck.stem}\n{text}\n", flush=True)
        is_good = is_good and is_right
    return 0 if is_good else 1


if __name__ == "__main__":
    sys.exit(main())
