# SPDX-License-Identifier: BSD-3-Clause
"""Plants the errors of planted.py in a copy of the tree, one by one, and lists what the tests do not catch."""

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from planted import PLANTED, Planted

ROOT = Path(__file__).resolve().parents[2]
BUILD_LIMIT = 3600  # s


class Tree:
    """A copy of the tracked files, as they are now, with a build of its own; the tree of the user is never touched."""

    def __init__(self, folder: Path) -> None:
        self.root = folder / "tree"
        self.build_folder = self.root / "build" / "mutation"
        tracked = subprocess.run(
            ["git", "ls-files", "-z"], cwd=ROOT, check=True, capture_output=True, text=True
        ).stdout
        for name in filter(None, tracked.split("\0")):
            self.copy(name)
        self.root.joinpath("build").mkdir(exist_ok=True)
        environment = self.root / "build" / "venv"
        if not environment.exists() and (ROOT / "build" / "venv").exists():
            environment.symlink_to(ROOT / "build" / "venv")
        # the Python tool of the copy, not the one that is installed
        self.environment = os.environ | {"PYTHONPATH": str(self.root / "tools" / "signorom_post" / "src")}

    def copy(self, name: str) -> None:
        """One file, where it differs: what did not change is not compiled again."""
        source, target = ROOT / name, self.root / name
        if not source.exists():
            return
        target.parent.mkdir(parents=True, exist_ok=True)
        if not target.exists() or target.read_bytes() != source.read_bytes():
            shutil.copy(source, target)

    def run(self, command: list[str], limit: float) -> subprocess.CompletedProcess:
        return subprocess.run(
            command,
            cwd=self.root,
            env=self.environment,
            timeout=limit,
            capture_output=True,
            text=True,
            errors="replace",
            check=False,
        )

    def configure(self) -> None:
        done = self.run(
            [
                *("cmake", "-G", "Ninja", "-S", ".", "-B", str(self.build_folder)),
                *("-DCMAKE_BUILD_TYPE=Debug", "-DSIG_BUILD_TESTS=ON"),
            ],
            BUILD_LIMIT,
        )
        if done.returncode != 0:
            sys.exit(done.stderr)

    def build(self, targets: list[str]) -> bool:
        done = self.run(["cmake", "--build", str(self.build_folder), "--target", *targets], BUILD_LIMIT)
        if done.returncode != 0:
            print(done.stdout[-2000:], flush=True)
        return done.returncode == 0

    def failed_tests(self, pattern: str) -> list[str] | None:
        """Names of failed tests among those that fit; None where no test fits."""
        done = self.run(
            ["ctest", "--test-dir", str(self.build_folder), "-R", pattern, "--no-tests=error"], BUILD_LIMIT
        )
        if "No tests were found" in done.stdout + done.stderr:
            return None
        return re.findall(r"^\s*\d+ - (\S+) \(", done.stdout, re.MULTILINE)


def test_stages(planted: Planted) -> list[tuple[list[str], str]]:
    """Targets to build and tests to run, quick ones first."""
    own = ([f"unit_{planted.layer}"], rf"^unit\.{planted.layer}\.")
    if planted.layer == "python":
        own = ([], "^python")
    if not planted.further:
        return [own]
    # tests of the program also load the library for C, which keeps an error of before if it is not built again, and unit
    # tests of another layer may not be built at all
    layers = sorted(set(re.findall(r"unit\.(\w+)", planted.further)))
    targets = ["signorom", "signorom_online", *(f"unit_{layer}" for layer in layers)]
    return [own, (targets, f"^({planted.further})")]


def try_stage(tree: Tree, targets: list[str], pattern: str) -> list[str] | str:
    """Names of failed tests, or why none could be run."""
    if targets and not tree.build(targets):
        return "NOT APPLIED: it does not compile"
    failed = tree.failed_tests(pattern)
    return f"NOT APPLIED: no test {pattern}" if failed is None else failed


def not_applied(root: Path, planted: Planted) -> str:
    """Why an error cannot be planted; empty where it can."""
    path = root / planted.file
    if not path.is_file():
        return "NOT APPLIED: there is no such file"
    count = path.read_text().count(planted.old)
    return "" if count == 1 else f"NOT APPLIED: the text stands {count} times in the file"


def check() -> int:
    """Whether every error can still be planted, without a build."""
    problems = [
        f"{planted.file}: {planted.why}\n    {why}"
        for planted in PLANTED
        if (why := not_applied(ROOT, planted))
    ]
    print(*problems, sep="\n", end="\n" if problems else "")
    return 1 if problems else 0


def try_planted(tree: Tree, planted: Planted, known: dict[str, list[str]]) -> str:
    """What caught the error; `SURVIVED`, or why it could not be tried.

    `known` keeps, by their pattern, the tests that fail without an error: they catch nothing.
    """
    if why := not_applied(tree.root, planted):
        return why
    path = tree.root / planted.file
    text = path.read_text()
    for targets, pattern in test_stages(planted):
        if pattern not in known:
            known[pattern] = try_stage(tree, targets, pattern)
        if isinstance(known[pattern], str):
            return known[pattern]
        try:
            path.write_text(text.replace(planted.old, planted.new))
            failed = try_stage(tree, targets, pattern)
        finally:
            path.write_text(text)
        if isinstance(failed, str):
            return failed
        caught = [name for name in failed if name not in known[pattern]]
        if caught:
            return ", ".join(caught)
    return "SURVIVED"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="", help="regular expression of files to plant errors in")
    parser.add_argument(
        "--folder", type=Path, help="for the copy and its build, kept (default: a temporary one)"
    )
    parser.add_argument("--check", action="store_true", help="only look whether each can still be planted")
    options = parser.parse_args()
    if options.check:
        return check()
    folder = options.folder or Path(tempfile.mkdtemp(prefix="mutation"))
    survivors = 0
    known: dict[str, list[str]] = {}
    try:
        tree = Tree(folder.resolve())
        tree.configure()
        for planted in PLANTED:
            if not re.search(options.only, planted.file):
                continue
            start = time.monotonic()
            outcome = try_planted(tree, planted, known)
            survivors += outcome.startswith(("SURVIVED", "NOT APPLIED"))
            print(
                f"{planted.file}: {planted.why}\n    {outcome} ({time.monotonic() - start:.0f} s)", flush=True
            )
    finally:
        if options.folder is None:
            shutil.rmtree(folder)
    print(f"{survivors} of the errors survived or could not be planted")
    return 1 if survivors else 0


if __name__ == "__main__":
    sys.exit(main())
