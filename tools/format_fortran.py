#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""fprettify with the corrections that the house style needs; formats in place or, with --check, complains.

What fprettify gets wrong for us: it aligns continued lines to brackets and runs them over the line limit, and it
takes blanks away: around // beside a string, before .not. behind a comma, around * beside a bracket. And it takes
a procedure that is named open or close for the statement.
"""

import argparse
import difflib
import io
import multiprocessing
import re
import sys
from pathlib import Path

import fprettify

STRING_OR_COMMENT = re.compile(r"""('(?:[^']|'')*'|"(?:[^"]|"")*"|!.*)""")


def correct_code(code):
    """Returns a piece of code, without strings and comments, with the blanks that the house style needs."""
    code = re.sub(r"[ ]*//[ ]*", " // ", code)
    code = re.sub(r",\.(not|true|false)\.", r", .\1.", code)
    # procedures that are named like a statement: open, close, write
    return re.sub(r"((?:\bsubroutine|\bfunction|\bcall) +(?:\w+%)*\w+|%\w+) +\(", r"\1(", code)


def correct_line(old, new, is_continued):
    """Returns the line `new` of fprettify with our corrections; `old` is the line before it.

    A comment, a line of the preprocessor or one with @ stays as it was. A continued line keeps its old indentation.
    """
    if new.lstrip().startswith(("!", "#", "@")):
        return old
    pieces = STRING_OR_COMMENT.split(new)
    pieces[0::2] = [correct_code(piece) for piece in pieces[0::2]]
    text = "".join(pieces).strip()
    if re.sub(" *[*] *", "*", text) == re.sub(" *[*] *", "*", old.strip()):
        text = old.strip()
    indent = old if is_continued else new
    return indent[: len(indent) - len(indent.lstrip())] + text


def is_continuing(line):
    """Returns whether the statement goes on in the next line, that is, whether the code ends with &."""
    code = STRING_OR_COMMENT.sub(lambda match: "" if match.group().startswith("!") else "s", line)
    return code.rstrip().endswith("&")


def format_text(text, name):
    """Returns the text of a file in the house style; `name` is the name of the file in messages of fprettify."""
    # the limit is tools/check_style.py's business: PETSc calls are longer, and must not be wrapped
    source, target = io.StringIO(text), io.StringIO()
    fprettify.set_fprettify_logger(50)
    fprettify.reformat_ffile(
        source,
        target,
        impose_indent=True,
        indent_size=2,
        strict_indent=False,
        impose_whitespace=True,
        impose_replacements=True,
        cstyle=True,
        whitespace=3,
        llength=10000,
        orig_filename=name,
    )
    old, new = text.splitlines(), target.getvalue().splitlines()
    if len(old) != len(new):
        return "\n".join(new) + "\n"
    lines, is_continued = [], False
    for before, after in zip(old, new, strict=True):
        lines.append(correct_line(before.rstrip(), after, is_continued))
        if not before.lstrip().startswith(("!", "#")):
            is_continued = is_continuing(before)
    return "\n".join(lines) + "\n"


def format_file(path):
    """Returns the path, the text of the file, and this text in the house style."""
    text = path.read_text(encoding="utf-8")
    return path, text, format_text(text, str(path))


def main():
    """Formats the files of the command line; with --check prints the differences, with exit code 1 if there are any."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--check",
        action="store_true",
        help="change no file; print what would change, and exit with 1 if anything would",
    )
    parser.add_argument("files", nargs="+", type=Path)
    options = parser.parse_args()
    with multiprocessing.Pool() as pool:
        changed = [result for result in pool.map(format_file, options.files) if result[1] != result[2]]
    for path, old, new in changed:
        if options.check:
            sys.stdout.writelines(
                difflib.unified_diff(old.splitlines(True), new.splitlines(True), str(path), "formatted", n=0)
            )
        else:
            path.write_text(new, encoding="utf-8")
    sys.exit(1 if options.check and changed else 0)


if __name__ == "__main__":
    main()
