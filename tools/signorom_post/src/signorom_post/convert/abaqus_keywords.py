# SPDX-License-Identifier: BSD-3-Clause
"""The keywords of an Abaqus or CalculiX deck with their data lines; files that it includes are read in place."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from signorom_post.convert.source import TextLines
from signorom_post.errors import InputError

MAX_INCLUDES = 20


@dataclass
class Keyword:
    """A keyword line, such as `*NSET, NSET=top`, and the data lines below it."""

    #: in capitals, with single blanks: `SOLID SECTION`
    name: str
    #: names in capitals -> values as written, empty for a name alone
    parameters: dict[str, str]
    text: TextLines
    #: from 0
    i_line: int
    #: (line from 0, words) of each data line
    data: list[tuple[int, list[str]]] = field(default_factory=list)
    #: where the data lines stand, if this is another file (INPUT=...)
    data_text: TextLines | None = None

    def error(self, sentence: str, i_line: int | None = None) -> InputError:
        """Returns an InputError at this keyword, or at one of its data lines."""
        if i_line is None:
            return self.text.error(self.i_line, sentence)
        return (self.data_text or self.text).error(i_line, sentence)

    def need(self, name: str) -> str:
        """Returns the value of a parameter; InputError if it is not given."""
        if not self.parameters.get(name):
            raise self.error(f"*{self.name} needs {name}=...")
        return self.parameters[name]

    def whole_number(self, word: str, i_line: int) -> int:
        """Converts a word to a whole number; InputError if it is none."""
        try:
            return int(word)
        except ValueError:
            raise self.error(f"'{word}' is not a whole number", i_line) from None

    def number(self, word: str, i_line: int) -> float:
        """Converts a word to a number, also with Fortran's exponent D; an empty word is 0. InputError if it is none."""
        try:
            return float(re.sub("[dD]", "e", word)) if word else 0.0
        except ValueError:
            raise self.error(f"'{word}' is not a number", i_line) from None


def read_keywords(path: Path, depth: int = 0) -> Iterator[Keyword]:
    """Yields the keywords of a file in their order, those of included files in the place of *INCLUDE.

    Lines before the first keyword count as comments. InputError: a file that cannot be read or is not a text, files that
    include each other.
    """
    text = TextLines(path)
    current: Keyword | None = None
    lines = iter(enumerate(text.lines))
    for i_line, line in lines:
        stripped = line.strip()
        if not stripped or stripped.startswith("**"):
            continue
        if not stripped.startswith("*"):
            if current is not None:
                current.data.append((i_line, _words(stripped)))
            continue
        if current is not None:
            yield from _with_includes(current, depth)
        while stripped.endswith(","):
            stripped += next(lines, (0, ""))[1].strip() or " "
        current = _keyword(stripped, text, i_line)
    if current is not None:
        yield from _with_includes(current, depth)


def _with_includes(keyword: Keyword, depth: int) -> Iterator[Keyword]:
    """Yields the keyword, with the data lines of another file if it names one, or the keywords that it includes."""
    if keyword.name == "INCLUDE":
        if depth >= MAX_INCLUDES:
            raise keyword.error(
                f"more than {MAX_INCLUDES} files include each other; does one include itself?"
            )
        yield from read_keywords(_other_file(keyword), depth + 1)
        return
    if keyword.parameters.get("INPUT") and keyword.name in ("NODE", "ELEMENT", "NSET", "ELSET"):
        keyword.data_text = TextLines(_other_file(keyword))
        lines = [(i, line.strip()) for i, line in enumerate(keyword.data_text.lines)]
        keyword.data = [(i, _words(line)) for i, line in lines if line and not line.startswith("*")]
    yield keyword


def _other_file(keyword: Keyword) -> Path:
    """Returns the path of the file that a keyword names; InputError if it is not there."""
    name = keyword.need("INPUT").strip("\"'")
    path = keyword.text.path.parent / name
    if not path.is_file():
        raise keyword.error(
            f"*{keyword.name} names the file '{name}', which is not in the folder {path.parent}"
        )
    return path


def _keyword(line: str, text: TextLines, i_line: int) -> Keyword:
    words = _words(line[1:])
    parameters = {}
    for word in words[1:]:
        name, _, value = word.partition("=")
        if name.strip():
            parameters[name.strip().upper()] = value.strip()
    return Keyword(" ".join(words[0].upper().split()), parameters, text, i_line)


def _words(line: str) -> list[str]:
    """Returns the words of a line between commas; a comma between double quotes belongs to its word."""
    words = re.findall(r'(?:"[^"]*"|[^,"])+|(?<=,)(?=,)|^(?=,)|"', line) if '"' in line else line.split(",")
    words = [word.strip() for word in words]
    while len(words) > 1 and not words[-1]:
        words.pop()
    return words
