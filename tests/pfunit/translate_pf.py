#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Turns a .pf file into Fortran: its module, and a program that runs its tests.

This serves the same .pf files as pFUnit 4 where pFUnit is not installed, and only a part of its language
(tests/pfunit/README.md). Every line stays one line, so messages of the compiler point to the right place.
"""

import argparse
import re
import sys
from dataclasses import dataclass, field
from pathlib import Path

ASSERTIONS = """
assertEqual assertNotEqual assertRelativelyEqual assertTrue assertFalse assertFail assertIsFinite assertIsNaN
assertLessThan assertLessThanOrEqual assertGreaterThan assertGreaterThanOrEqual
""".split()
NAME_OF = {name.lower(): name for name in ASSERTIONS}
MAX_NAME_LENGTH = 44  # pFUnit makes longer names from it, and a Fortran name has at most 63 characters
DIRECTIVE = re.compile(r"^\s*@(\w+)\s*(.*?)\s*$")
PROCEDURE = re.compile(r"^\s*subroutine\s+(\w+)\s*(?:\(\s*(\w*)\s*\))?\s*$", re.IGNORECASE)
MODULE = re.compile(r"^\s*module\s+(\w+)\s*(?:!.*)?$", re.IGNORECASE)
USE_PFUNIT = re.compile(r"^\s*use\s+pfunit\b", re.IGNORECASE)


class PfError(Exception):
    """A line that this subset does not know."""

    def __init__(self, line_number, text):
        super().__init__(text)
        self.line_number = line_number


@dataclass
class Test:
    """One test procedure."""

    name: str
    has_this: bool
    counts: list
    guard: str = ""
    is_disabled: bool = False


@dataclass
class PfFile:
    """What the walk over a .pf file collects."""

    file_name: str
    module: str = ""
    is_mpi: bool = False
    lines: list = field(default_factory=list)
    tests: list = field(default_factory=list)
    # (kind, has_this) -> procedure name; kind is before or after
    fixtures: dict = field(default_factory=dict)


def translate_assertion(pf, number, word, rest):
    """The call that stands in for an assertion, in one line."""
    is_collective = word.startswith("mpiassert")
    name = NAME_OF.get(word[3:] if is_collective else word)
    if name is None:
        raise PfError(number, f"@{word} is not in the subset; known: @" + ", @".join(sorted(ASSERTIONS)))
    if not (rest.startswith("(") and rest.endswith(")")):
        raise PfError(
            number, f"@{name} must open and close its parenthesis on one line, with nothing behind it"
        )
    place = f"location=SourceLocation('{pf.file_name}', {number})"
    if is_collective and not pf.is_mpi:
        raise PfError(number, f"@mpi{name[0].upper()}{name[1:]} needs 'use pfunit'")
    scope = "this%getMpiCommunicator()" if is_collective else ""
    return f"call {name}{rest[:-1]}, {place}); if (anyExceptions({scope})) return"


def read_options(number, rest):
    """Rank counts and preprocessor guard of `@test(...)`."""
    counts, guard = [], ""
    inside = rest[1:-1] if rest.startswith("(") and rest.endswith(")") else rest
    for match in re.finditer(r"(\w+)\s*=\s*(\[[^\]]*\]|\w+)", inside):
        key, value = match.group(1).lower(), match.group(2)
        if key == "npes":
            counts = [int(count) for count in re.findall(r"\d+", value)]
        elif key in ("ifdef", "ifndef"):
            guard = f"#{key} {value}"
        else:
            raise PfError(number, f"@test({key}=...) is not in the subset; known: npes, ifdef, ifndef")
    if inside.strip() and not (counts or guard):
        raise PfError(number, f"cannot read the options '{inside}' of @test")
    return counts, guard


class Walker:
    """Goes through the lines; remembers the directives that wait for their procedure."""

    def __init__(self, file_name):
        self.pf = PfFile(file_name)
        self.pending = {}

    def walk(self, text):
        """All lines of the file."""
        lines = text.splitlines()
        self.pf.is_mpi = any(USE_PFUNIT.match(line) for line in lines)
        for number, line in enumerate(lines, start=1):
            self.pf.lines.append(self.line(number, line))
        if self.pending:
            raise PfError(len(lines), "a directive at the end has no procedure")
        return self.pf

    def line(self, number, line):
        """The Fortran line for one .pf line."""
        match = DIRECTIVE.match(line)
        if match:
            return self.directive(number, line, match.group(1).lower(), match.group(2))
        if not self.pf.module and (module := MODULE.match(line)):
            self.pf.module = module.group(1)
        if self.pending and line.strip() and not line.lstrip().startswith("!"):
            self.procedure(number, line)
        return line

    def directive(self, number, line, word, rest):
        """An assertion becomes a call; the others become comments and wait for the next procedure."""
        if word.startswith(("assert", "mpiassert")):
            indent = line[: len(line) - len(line.lstrip())]
            return indent + translate_assertion(self.pf, number, word, rest)
        if word == "test":
            self.pending["test"] = read_options(number, rest)
        elif word in ("before", "after", "disable") and not rest:
            self.pending[word] = True
        else:
            raise PfError(
                number, f"@{word} is not in the subset; known: @test, @before, @after, @disable, assertions"
            )
        return "!" + line

    def procedure(self, number, line):
        """The procedure that the waiting directives speak of."""
        match = PROCEDURE.match(line)
        if not match:
            raise PfError(
                number, "after @test, @before or @after comes 'subroutine name()' or 'subroutine name(this)'"
            )
        name, has_this = match.group(1), bool(match.group(2))
        if has_this and not self.pf.is_mpi:
            raise PfError(number, f"{name} has an argument, so the file needs 'use pfunit'")
        for kind in ("before", "after"):
            if kind in self.pending:
                self.pf.fixtures[kind, has_this] = name
        if "test" in self.pending:
            self.test(number, name, has_this)
        self.pending = {}

    def test(self, number, name, has_this):
        """Adds a test."""
        counts, guard = self.pending["test"]
        if len(name) > MAX_NAME_LENGTH:
            raise PfError(
                number, f"the name {name} has {len(name)} characters; {MAX_NAME_LENGTH} are allowed"
            )
        if counts and not has_this:
            raise PfError(
                number, f"{name} names rank counts, so it needs 'class(MpiTestMethod), intent(inout) :: this'"
            )
        self.pf.tests.append(Test(name, has_this, counts, guard, "disable" in self.pending))


def fixture_arguments(pf, test):
    """`, before=..., after=...` of one test."""
    found = [(kind, pf.fixtures.get((kind, test.has_this))) for kind in ("before", "after")]
    return "".join(f", {kind}={name}" for kind, name in found if name)


def run_line(pf, test):
    """The line of the program that runs one test."""
    if test.is_disabled:
        return f"call runner%skip('{test.name}')"
    tail = f"{test.name}{fixture_arguments(pf, test)})"
    if not (pf.is_mpi and test.has_this):
        return f"call runner%run('{test.name}', {tail}"
    counts = ", ".join(str(count) for count in test.counts)
    return f"call runner%run_mpi('{test.name}', [integer :: {counts}], {tail}"


def program_lines(pf, extra_use, extra_initialize):
    """The program behind the module."""
    runner = ("pfunit_runner", "mpi_runner_t") if pf.is_mpi else ("funit_runner", "runner_t")
    yield f"program run_{pf.module}"
    if extra_use:
        yield f"  use {extra_use}, only: {extra_initialize}"
    yield f"  use {runner[0]}, only: {runner[1]}"
    yield f"  use {pf.module}"
    yield "  implicit none(type, external)"
    yield f"  type({runner[1]}) :: runner"
    if pf.is_mpi:
        yield "  call runner%start()"
    if extra_initialize:
        yield f"  call {extra_initialize}()"
    for test in pf.tests:
        if test.guard:
            yield test.guard
        yield "  " + run_line(pf, test)
        if test.guard:
            yield "#endif"
    yield "  call runner%finish()"
    yield f"end program run_{pf.module}"


def check_file(pf, stem):
    """What holds for the file as a whole."""
    if pf.module.lower() != stem.lower():
        raise PfError(1, f"the module is named '{pf.module}'; it must have the name of the file, '{stem}'")
    if not pf.tests:
        raise PfError(1, "the file has no @test")
    names = [test.name.lower() for test in pf.tests]
    for name in names:
        if names.count(name) > 1:
            raise PfError(1, f"two tests are named {name}")


def main():
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("source", type=Path)
    parser.add_argument("target", type=Path)
    parser.add_argument("--shown-name", help="name of the source in messages")
    parser.add_argument("--extra-use", default="", help="module with the start-up hook")
    parser.add_argument(
        "--extra-initialize", default="", help="subroutine of that module, called before the tests"
    )
    options = parser.parse_args()
    shown_name = options.shown_name or str(options.source)
    try:
        pf = Walker(shown_name).walk(options.source.read_text(encoding="utf-8"))
        check_file(pf, options.source.stem)
    except PfError as error:
        sys.exit(f"{shown_name}:{error.line_number}: error: {error}")
    head = [f'# 1 "{options.source}"']
    tail = program_lines(pf, options.extra_use, options.extra_initialize)
    options.target.write_text("\n".join([*head, *pf.lines, *tail]) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
