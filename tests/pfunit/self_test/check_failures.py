#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Runs a .pf program that fails on purpose and compares what it prints with the `! fails:` lines of the file."""

import re
import subprocess
import sys
from pathlib import Path

MARK = "! fails: "


def expected_failures(pf_file):
    """Line number of each assertion that must fail -> start of its text."""
    lines = pf_file.read_text(encoding="utf-8").splitlines()
    return {number + 1: line.split(MARK)[1] for number, line in enumerate(lines, start=1) if MARK in line}


def printed_failures(pf_file, text):
    """Line number of each failure that was printed -> its text."""
    pattern = re.compile(rf"^\S*{re.escape(pf_file.name)}:(\d+): (.*)$", re.MULTILINE)
    return {int(number): text for number, text in pattern.findall(text)}


def main():
    """Arguments: the .pf file, the count line that the program must end with, the command."""
    pf_file, summary, command = Path(sys.argv[1]), sys.argv[2], sys.argv[3:]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    print(result.stdout, result.stderr, sep="\n")
    expected, printed = expected_failures(pf_file), printed_failures(pf_file, result.stderr)
    complaints = [
        f"line {number} did not fail with '{text}'"
        for number, text in expected.items()
        if not printed.get(number, "").startswith(text)
    ]
    complaints += [
        f"line {number} failed: {text}" for number, text in printed.items() if number not in expected
    ]
    if result.returncode == 0:
        complaints.append("the exit code is 0")
    if summary not in result.stdout:
        complaints.append(f"the summary is not '{summary}'")
    sys.exit("\n".join(complaints) or 0)


if __name__ == "__main__":
    main()
