#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""House rules that no linter knows (CONTRIBUTING.md has the reasons).

Fails on a missing SPDX line, and in Fortran on: `use` without `only` (petsc, slepc and the test frameworks apart), a
local ierr, a PETSc macro behind a one-line if, a PETSc macro on several lines, a stop outside main, a procedure for C
outside of its homes, a C procedure with two interfaces in src, a line over 132 characters that has no PETSc macro.
Tests may have a local ierr, stop and bind(c).
"""

import re
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
MAX_LINE = 132
FORTRAN = {".f90", ".F90", ".pf"}
SOURCES = FORTRAN | {".c", ".h"}
MACRO = r"(?:PetscCall\w*|SlepcCall\w*|SETERR\w*|CHKERR\w*|SIG_CHECK\w*)\s*\("
STRING = re.compile(r"'(?:[^']|'')*'|\"(?:[^\"]|\"\")*\"")
FREE_USES = re.compile(r"^\s*use\s+(petsc|slepc|funit|pfunit)\s*$", re.IGNORECASE)
BIND = re.compile(r"\b(?:function|subroutine)\s+(\w+)\b.*\bbind\s*\(\s*c\b", re.IGNORECASE)


@dataclass
class Finding:
    """A line of a file, from 1, and what is wrong there."""

    path: Path
    line: int
    text: str

    def __str__(self):
        return f"{self.path.relative_to(ROOT)}:{self.line}: {self.text}"


def code_of(line):
    """Returns the line with empty texts and without its comment."""
    return STRING.sub("''", line).split("!")[0].rstrip()


def has(pattern, code):
    """Returns whether the regular expression is found in the code; capital and small letters are the same."""
    return re.search(pattern, code, re.IGNORECASE) is not None


def line_findings(path, code, line):
    """Yields a sentence for each rule that a line of Fortran breaks.

    `line` is the line as it stands in the file `path`, and `code` what code_of makes of it.
    """
    is_test = "tests" in path.relative_to(ROOT).parts
    if (
        has(r"^\s*use\b(?!.*\bonly\s*:)", code)
        and not FREE_USES.match(code)
        and not has(r"^\s*use\s*=", code)
    ):
        yield "use without only"
    if (
        has(r"^\s*(PetscErrorCode|integer)\b(?!.*\bintent\b)[^:]*::(.*\W)?ierr\b", code)
        and path.name != "main.F90"
        and not is_test
    ):
        yield "a local ierr; it must be a dummy that is passed up"
    if has(rf"^\s*if\s*\(.*\)\s*{MACRO}", code):
        yield "a PETSc macro behind a one-line if: only its first statement is conditional"
    if has(MACRO, code) and code.endswith("&"):
        yield "a PETSc macro must stay on one line"
    if has(r"(^|\)|;)\s*(error\s+)?stop\b(?!\s*[=(%])", code) and path.name != "main.F90" and not is_test:
        yield "stop outside main"
    if len(line) > MAX_LINE and not has(MACRO, code):
        yield f"{len(line)} characters; {MAX_LINE} are allowed"


def statements(lines):
    """Yields the number of its first line, from 1, and the text of each statement, without comments and marks."""
    text, first = "", 1
    for number, line in enumerate(lines, start=1):
        code = code_of(line)
        first = first if text else number
        text += code.strip().strip("&")
        if not code.endswith("&"):
            yield first, text
            text = ""


def check_interfaces(path, lines, homes):
    """Yields the findings about procedures of C and procedures for C in one file of src.

    `homes` has the place of each interface of a C procedure that was found before; those of this file are added. A
    procedure for C stands in online/c_api_*.f90, or is a callback: `lint: callback` in its line.
    """
    is_interface = False
    for number, code in statements(lines):
        if has(r"^\s*(abstract\s+)?interface\b", code):
            is_interface = True
        elif has(r"^\s*end\s+interface\b", code):
            is_interface = False
        found = BIND.search(code)
        if found and is_interface:
            name = found[1].lower()
            if name in homes:
                yield Finding(path, number, f"a second interface of {name}; the first: {homes[name]}")
            homes.setdefault(name, f"{path.relative_to(ROOT)}:{number}")
        elif found and not path.name.startswith("c_api_") and "lint: callback" not in lines[number - 1]:
            yield Finding(
                path, number, "a procedure for C outside of its homes (online/c_api_*.f90, callbacks)"
            )


def check_fortran(path, lines):
    """Yields the findings in the lines of one Fortran file."""
    for number, line in enumerate(lines, start=1):
        for text in line_findings(path, code_of(line), line):
            yield Finding(path, number, text)


def source_files():
    """Yields the paths of all files of src, include, tests and tools that are source, scripts or build files."""
    for folder in ("src", "include", "tests", "tools"):
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix in SOURCES | {".py", ".sh", ".cmake", ".inc"} or path.name == "CMakeLists.txt":
                yield path


def main():
    """Checks all files and prints the findings. The exit code is 1 if there are findings, else 0."""
    findings, homes = [], {}
    for path in source_files():
        lines = path.read_text(encoding="utf-8").splitlines()
        if not any("SPDX-License-Identifier: BSD-3-Clause" in line for line in lines[:3]):
            findings.append(Finding(path, 1, "no SPDX line at the top"))
        if path.suffix in FORTRAN:
            findings.extend(check_fortran(path, lines))
            if path.relative_to(ROOT).parts[0] == "src":
                findings.extend(check_interfaces(path, lines, homes))
    for finding in findings:
        print(finding)
    sys.exit(1 if findings else 0)


if __name__ == "__main__":
    main()
