# SPDX-License-Identifier: BSD-3-Clause
"""Reads what a Fortran module offers to others: its public names and the docstrings `!>` above them.

It knows the house style of CONTRIBUTING.md and nothing beyond: one module per file, `::` in each declaration,
a docstring above what it speaks of. A public name that it does not find is an error of the reader.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

PREFIX = r"(?:pure|elemental|impure|recursive|logical|integer|real|character|type)\b(?:\s*\([^'\"]*?\))?\s+"
PROCEDURE = re.compile(rf"^(?:{PREFIX})*(?:subroutine|function)\s+(?P<name>\w+)\b")
TYPE = re.compile(r"^type\s*(?:,[^:]*)?::\s*(\w+)$|^type\s+(\w+)$")
ENTITY = re.compile(r"^(?P<name>\w+)\s*(?P<shape>\(.*?\))?\s*(?P<value>=>?.*)?$")
BINDING = re.compile(r"^(procedure|generic)\b(\((?P<interface>\w+)\))?(?P<marks>[^:]*)::\s*(?P<names>.+)$")


@dataclass
class Statement:
    """A statement on one line without comments, and the lines of the docstring above it."""

    doc: list[str]
    code: str


@dataclass
class Variable:
    """An argument, a component or a constant."""

    name: str
    declaration: str
    doc: list[str]


@dataclass
class Procedure:
    """A subroutine or function, or its heading in an interface; a result is the last of the arguments."""

    name: str
    heading: str
    doc: list[str]
    arguments: list[Variable]


@dataclass
class Binding:
    """A type-bound procedure, and the name of the module procedure or, if it is deferred, of the interface behind it."""

    name: str
    target: str
    is_deferred: bool


@dataclass
class Type:
    """A derived type."""

    name: str
    heading: str
    doc: list[str]
    components: list[Variable] = field(default_factory=list)
    bindings: list[Binding] = field(default_factory=list)


@dataclass
class Generic:
    """Several procedures under one name."""

    name: str
    doc: list[str]
    procedures: list[str]


@dataclass
class Module:
    """The contents of one file. `constants` has all variables of the module."""

    path: Path
    name: str = ""
    doc: list[str] = field(default_factory=list)
    #: name of a module -> names that are used from it
    uses: dict[str, list[str]] = field(default_factory=dict)
    public: list[str] = field(default_factory=list)
    constants: dict[str, Variable] = field(default_factory=dict)
    types: dict[str, Type] = field(default_factory=dict)
    generics: dict[str, Generic] = field(default_factory=dict)
    procedures: dict[str, Procedure] = field(default_factory=dict)


def without_comment(line: str) -> str:
    """Returns the line without its comment; an exclamation mark within a text starts none."""
    quote = ""
    for i, character in enumerate(line):
        if quote:
            quote = "" if character == quote else quote
        elif character in "'\"":
            quote = character
        elif character == "!":
            return line[:i].rstrip()
    return line.rstrip()


def statements(text: str) -> Iterator[Statement]:
    """Yields the statements of a file, with continued lines joined; lines of the preprocessor are left out."""
    doc: list[str] = []
    code = ""
    for line in text.splitlines():
        stripped = line.strip()
        if stripped.startswith("!>") and not code:
            doc.append(stripped[2:].removeprefix(" "))
            continue
        part = without_comment(stripped)
        if not part or part.startswith("#"):
            doc = doc if code else []
            continue
        code += part.removeprefix("&").lstrip() if code else part
        if code.endswith("&"):
            code = code[:-1].rstrip() + " "
            continue
        yield Statement(doc, code)
        doc, code = [], ""


def split_list(text: str) -> list[str]:
    """Returns the parts of a text between commas that stand in no bracket and no quotes, but no empty parts."""
    parts, depth, quote = [""], 0, ""
    for character in text:
        if quote:
            quote = "" if character == quote else quote
        elif character in "'\"":
            quote = character
        depth += (character in "([") - (character in ")]")
        if character == "," and depth == 0 and not quote:
            parts.append("")
        else:
            parts[-1] += character
    return [part.strip() for part in parts if part.strip()]


def variables_of(statement: Statement) -> list[Variable]:
    """Returns the variables that a statement declares; none if it is no declaration."""
    left, colons, right = statement.code.partition("::")
    if not colons or re.match(r"^(use|public|private|import|procedure|generic|final)\b(?!\()", left):
        return []
    variables = []
    for entity in split_list(right):
        if match := ENTITY.match(entity):
            declaration = f"{left.strip()} :: {match['name']}{match['shape'] or ''}"
            if match["value"] and "parameter" in left:
                declaration += f" {match['value']}"
            variables.append(Variable(match["name"], declaration, statement.doc))
    return variables


class ModuleReader:
    """Reads the statements of one file, one after the other."""

    def __init__(self, path: Path, text: str) -> None:
        """Takes the text of the file `path`, divided into statements; `read` does the rest."""
        self.module = Module(path)
        self._statements = list(statements(text))
        self._next = 0

    def read(self) -> Module:
        """Returns the contents of the file; ValueError for a public name that it neither declares nor uses."""
        while self._next < len(self._statements):
            self._read_one(self._take())
        module = self.module
        used = {name for names in module.uses.values() for name in names}
        known = used.union(module.constants, module.types, module.generics, module.procedures)
        for name in module.public:
            if name not in known:
                raise ValueError(f"{module.path}: where is the public name {name}?")
        return module

    def _take(self) -> Statement:
        statement = self._statements[self._next]
        self._next += 1
        return statement

    def _until(self, end: str) -> Iterator[Statement]:
        """Yields the statements up to the one that matches the pattern, and passes over this one."""
        while not re.match(end, (statement := self._take()).code):
            yield statement

    def _read_one(self, statement: Statement) -> None:
        code, module = statement.code, self.module
        if match := re.match(r"^(?:module|program)\s+(\w+)$", code):
            module.name, module.doc = match[1], statement.doc
        elif match := re.match(r"^use\s*(?:,.*?::)?\s*(\w+)\s*,\s*only\s*:\s*(.*)$", code):
            module.uses[match[1]] = [name.split("=>")[0].strip() for name in split_list(match[2])]
        elif match := re.match(r"^public\s*::\s*(.*)$", code):
            module.public += split_list(match[1])
        elif match := re.match(r"^(?:abstract\s+)?interface\b\s*(.*)$", code):
            self._read_interface(match[1], statement.doc)
        elif re.match(r"^enum\b", code):
            self._read_constants(self._until("^end enum"))
        elif match := TYPE.match(code):
            self._read_type(match[1] or match[2], statement)
        elif not code.startswith("end") and PROCEDURE.match(code):
            self._read_procedure(statement)
        else:
            self._read_constants(iter([statement]))

    def _read_constants(self, declarations: Iterator[Statement]) -> None:
        for statement in declarations:
            for variable in variables_of(statement):
                self.module.constants[variable.name] = variable
                if re.search(r"\bpublic\b", statement.code.partition("::")[0]):
                    self.module.public.append(variable.name)

    def _read_interface(self, name: str, doc: list[str]) -> None:
        procedures = []
        for statement in self._until("^end interface"):
            if match := re.match(r"^(?:module )?procedure\b(?: *::)? *(.*)$", statement.code):
                procedures += split_list(match[1])
            elif PROCEDURE.match(statement.code):
                procedures.append(self._read_procedure(statement).name)
        if name:
            self.module.generics[name] = Generic(name, doc, procedures)

    def _read_type(self, name: str, statement: Statement) -> None:
        type_ = self.module.types[name] = Type(name, statement.code, statement.doc)
        for part in self._until("^end type"):
            binding = BINDING.match(part.code)
            if not binding:
                type_.components += variables_of(part)
            elif not re.search(r"\bprivate\b", binding["marks"]):
                is_deferred = "deferred" in binding["marks"]
                for name_and_target in split_list(binding["names"]):
                    name, _, target = (word.strip() for word in name_and_target.partition("=>"))
                    type_.bindings.append(Binding(name, binding["interface"] or target or name, is_deferred))

    def _read_procedure(self, statement: Statement) -> Procedure:
        """Returns and keeps a procedure with its arguments; what it does and what it contains is passed over."""
        match = PROCEDURE.match(statement.code)
        assert match
        names = re.search(rf"{match['name']}\s*\((.*?)\)", statement.code)
        result = re.search(r"result\s*\((\w+)\)", statement.code)
        wanted = split_list(names[1] if names else "") + ([result[1]] if result else [])
        declared: dict[str, Variable] = {}
        depth = 1
        while depth:
            inner = self._take()
            if re.match(r"^end\s*(subroutine|function)\b", inner.code):
                depth -= 1
            elif not inner.code.startswith("end") and PROCEDURE.match(inner.code):
                depth += 1
            elif depth == 1:
                declared.update({variable.name: variable for variable in variables_of(inner)})
        arguments = [
            declared[name] for name in wanted if name in declared
        ]  # a result may stand in the heading
        procedure = Procedure(match["name"], statement.code, statement.doc, arguments)
        self.module.procedures[procedure.name] = procedure
        return procedure


def read_modules(root: Path) -> list[Module]:
    """Returns the contents of all Fortran files below `root`, in the order of their paths, which count from `root`."""
    files = (path for path in sorted(root.rglob("*")) if path.suffix in (".f90", ".F90"))
    return [ModuleReader(path.relative_to(root), path.read_text(encoding="utf-8")).read() for path in files]
