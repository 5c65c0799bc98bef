# SPDX-License-Identifier: BSD-3-Clause
"""CPU time of each test of a preset, one after the other, and of groups of tests by their names.

usage: build/venv/bin/python tools/suite_times.py [--preset ci] [--only REGEX] [--group NAME=REGEX ...]

A test counts in the first group that fits. Times on a busy machine are up to a half longer.
"""

import argparse
import json
import re
import resource
import subprocess
import sys
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def cpu_time() -> float:
    """CPU time [s] of all children that have ended, with their children."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main() -> int:
    """Prints a line per test, longest first, then one per group; returns 1 if a test failed."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--preset", default="ci")
    parser.add_argument("--only", default="", help="regular expression of tests")
    parser.add_argument("--group", action="append", default=[], help="NAME=REGEX of tests")
    options = parser.parse_args()
    ctest = ["ctest", "--preset", options.preset, "-R", options.only]
    listed = subprocess.run(
        [*ctest, "--show-only=json-v1"], cwd=ROOT, check=True, capture_output=True, text=True
    )
    groups = [group.partition("=")[::2] for group in options.group] + [("others", "")]
    times: dict[str, float] = {}
    failed = []
    for test in json.loads(listed.stdout)["tests"]:
        name = test["name"]
        before = cpu_time()
        done = subprocess.run(
            ["ctest", "--preset", options.preset, "-R", f"^{re.escape(name)}$"],
            cwd=ROOT,
            stdout=subprocess.DEVNULL,
            check=False,
        )
        times[name] = cpu_time() - before
        failed += [name] * (done.returncode != 0)
    sums, counts = Counter(), Counter()
    for name, time in sorted(times.items(), key=lambda entry: -entry[1]):
        print(f"{time:8.1f} {name}")
        group = next(group for group, pattern in groups if re.search(pattern, name))
        sums[group] += time
        counts[group] += 1
    print()
    for group in sums:
        print(f"{sums[group]:8.1f} s  {counts[group]:4d} tests  {group}")
    print(f"{sum(sums.values()):8.1f} s  {len(times):4d} tests  all")
    print(*(f"failed: {name}" for name in failed), sep="\n", end="\n" if failed else "")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
