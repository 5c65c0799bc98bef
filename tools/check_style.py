#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""House rules that no linter knows (CONTRIBUTING.md has the reasons).

Fails on a missing SPDX line, and in Fortran on: `use` without `only` (petsc, slepc and the test frameworks apart), a
local ierr, a PETSc macro behind a one-line if, a PETSc macro on several lines, a stop outside main, bind(c) outside its
homes, a line over 132 characters that has no PETSc macro. Tests may have a local ierr, stop and bind(c).
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
BIND_HOMES = re.compile(r"(_c_interfaces\.f90|/c_api_\w+\.f90|/petsc_support\.F90|include/signorom\.f90)$")


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
    name = path.as_posix()
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
    if has(r"\bbind\s*\(\s*c\b", code) and not (
        BIND_HOMES.search(name) or is_test or has(r"^\s*(type|enum)", code)
    ):
        yield "bind(c) outside its homes (<layer>_c_interfaces.f90, online/c_api_*.f90, include/signorom.f90, callbacks)"
    if len(line) > MAX_LINE and not has(MACRO, code):
        yield f"{len(line)} characters; {MAX_LINE} are allowed"


def check_fortran(path, lines):
    """Yields the findings in the lines of one Fortran file; bind(c) is allowed in a line with `lint: callback`."""
    for number, line in enumerate(lines, start=1):
        code = code_of(line)
        allowed = "lint: callback" in line  # a callback that C or PETSc calls is a home of bind(c)
        for text in line_findings(path, code, line):
            if not (allowed and text.startswith("bind(c)")):
                yield Finding(path, number, text)


def source_files():
    """Yields the paths of all files of src, include, tests and tools that are source, scripts or build files."""
    for folder in ("src", "include", "tests", "tools"):
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix in SOURCES | {".py", ".sh", ".cmake", ".inc"} or path.name == "CMakeLists.txt":
                yield path


def main():
    """Checks all files and prints the findings. The exit code is 1 if there are findings, else 0."""
    findings = []
    for path in source_files():
        lines = path.read_text(encoding="utf-8").splitlines()
        if not any("SPDX-License-Identifier: BSD-3-Clause" in line for line in lines[:3]):
            findings.append(Finding(path, 1, "no SPDX line at the top"))
        if path.suffix in FORTRAN:
            findings.extend(check_fortran(path, lines))
    for finding in findings:
        print(finding)
    sys.exit(1 if findings else 0)


if __name__ == "__main__":
    main()
