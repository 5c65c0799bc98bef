#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Bounds of all shipped decks against true errors: 10 000 random points each, 200 above 500 contacts.

    build/venv/bin/python tests/verification/certificates.py            # all decks: about an hour
    build/venv/bin/python tests/verification/certificates.py bracket    # one

Samples and trains each deck of input/ that can be trained, then prints the tables of check_certificate. Ends with 1
where a bound lies below an error.
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "support"))
from program import ENVIRONMENT  # noqa: E402


def table_of(deck, build, n_points, folder):
    """What check_certificate says of a deck's model, or why there is none; and whether no bound was too small."""
    content = yaml.safe_load(deck.read_text())
    if "training" not in content:
        return "no training section", True
    content["mesh"]["file"] = str((deck.parent / content["mesh"]["file"]).resolve())
    text = yaml.safe_dump(content, sort_keys=False)
    (folder / deck.name).write_text(text)
    for command in ("sample", "train"):
        done = subprocess.run(
            [build / "signorom", command, deck.name],
            cwd=folder,
            env=ENVIRONMENT,
            capture_output=True,
            text=True,
        )
        if done.returncode:
            return done.stderr.strip().splitlines()[0], True
    model = folder / "results" / deck.stem / "model.h5"
    done = subprocess.run(
        [build / "tests" / "check_certificate", model, str(n_points), "1"], capture_output=True, text=True
    )
    return (done.stdout + done.stderr).strip(), done.returncode == 0


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
    arguments = parser.parse_args()
    build = arguments.build.resolve()
    large = {"flange", "indenter"}
    is_good = True
    for deck in sorted((ROOT / "input").glob("*.yaml")):
        if arguments.decks and deck.stem not in arguments.decks:
            continue
        with tempfile.TemporaryDirectory() as folder:
            n_points = min(arguments.points, 200) if deck.stem in large else arguments.points
            text, is_right = table_of(deck, build, n_points, Path(folder))
        print(f"{deck.stem}\n{text}\n", flush=True)
        is_good = is_good and is_right
    return 0 if is_good else 1


if __name__ == "__main__":
    sys.exit(main())
