#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The way of a command through the source: which procedures run, and how often a reader changes the folder.

    cmake --build --preset release
    tools/walk.py solve input/hertz_cylinder.yaml
    tools/walk.py --stops predict results/bracket/model.h5 --at P=1,bolt=10

Valgrind's callgrind counts the calls of the release build, so that the figures are those of what runs and not of what
could run. Only procedures in src count. Their calls are walked from main, depth first, in the order of the source. A
stop is a procedure that calls at least two procedures of other files; those of the utilities (base, dense, elements,
files, parallel) are left out, as nobody follows them to understand a command. Inlined procedures are not seen.
"""

import argparse
import re
import subprocess
import sys
import tempfile
from collections import defaultdict
from itertools import pairwise
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
UTILITIES = {"base", "dense", "elements", "files", "parallel"}
ENTRY = re.compile(r"(cfi|cfl|cfn|fi|fe|fl|fn|calls)=(.*)")
NAME = re.compile(r"\((\d+)\)(?: (.*))?")


def trace(program, arguments, folder):
    """Runs the program below callgrind, and returns the lines of what it counted."""
    out = folder / "callgrind.out"
    command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={out}", str(program), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode not in (0, 3) or not out.exists():
        sys.exit(f"{' '.join(command)} ended with {done.returncode}: {done.stderr[-2000:]}")
    return out.read_text().splitlines()


def place_of(file):
    """Folder and file below src, or None."""
    _, found, inside = file.rpartition("/src/")
    return inside if found and Path(ROOT / "src" / inside).exists() else None


def read_calls(lines):
    """Calls of each procedure, by the line of the source: {caller: [(line, callee)]}; a procedure is (file, name)."""
    known = {"file": {}, "name": {}}

    def expand(kind, text):
        number, name = NAME.match(text).groups()
        if name is not None:
            known[kind][number] = name
        return known[kind][number]

    calls = defaultdict(set)
    file = own = callee_file = callee = None
    is_call = False
    line = 0
    for text in lines:
        entry = ENTRY.match(text)
        if entry:
            key, value = entry.groups()
            if key in ("fl", "fi", "fe"):
                file = expand("file", value)
                if key == "fl":
                    own = file
            elif key == "fn":
                caller = (own, expand("name", value))
                callee_file = None
            elif key in ("cfi", "cfl"):
                callee_file = expand("file", value)
            elif key == "cfn":
                callee = (callee_file or file, expand("name", value))
            else:
                is_call = True
        elif text and (text[0].isdigit() or text[0] in "+-*"):
            first = text.split()[0]
            line = line if first == "*" else line + int(first) if first[0] in "+-" else int(first)
            if is_call:
                calls[caller].add((line, callee))
                callee_file = None
                is_call = False
    return with_files(calls)


def with_files(calls):
    """The same calls, where procedures of ours have their files also behind lines of which Valgrind knows none (???)."""
    procedures = set(calls) | {callee for found in calls.values() for _, callee in found}
    files = {name: file for file, name in procedures if file != "???" and name.startswith(("sig_", "__sig_"))}

    def located(procedure):
        file, name = procedure
        return (files.get(name, file) if file == "???" else file, name)

    found = defaultdict(set)
    for caller, callees in calls.items():
        found[located(caller)] |= {(line, located(callee)) for line, callee in callees}
    return found


def inside_source(calls):
    """The calls between procedures of src; what runs between them elsewhere is skipped."""
    places = {p: place_of(p[0] or "") for p in set(calls) | {c for found in calls.values() for _, c in found}}

    def targets(caller, seen):
        for line, callee in sorted(calls.get(caller, ()), key=lambda call: (call[0], call[1][1])):
            if places[callee]:
                yield line, (places[callee], callee[1])
            elif callee not in seen:
                seen.add(callee)
                yield from ((line, found) for _, found in targets(callee, seen))

    kept = {}
    for caller in calls:
        if places[caller]:
            kept[places[caller], caller[1]] = list(
                dict.fromkeys(found for _, found in targets(caller, set()))
            )
    return kept


def folder_of(procedure):
    """First folder below src."""
    return procedure[0].split("/")[0] if "/" in procedure[0] else "."


def walk(calls):
    """Procedures in the order in which a reader meets them, depth first from main."""
    start = next(p for p in calls if p[0].startswith("main."))
    order, stack, seen = [], [start], set()
    while stack:
        procedure = stack.pop()
        if procedure in seen:
            continue
        seen.add(procedure)
        order.append(procedure)
        stack += [found for found in reversed(calls.get(procedure, [])) if found not in seen]
    return order


def is_stop(procedure, calls):
    """Whether a reader stops here to choose where to go on."""
    if folder_of(procedure) in UTILITIES:
        return False
    others = [c for c in calls.get(procedure, []) if c[0] != procedure[0] and folder_of(c) not in UTILITIES]
    return len(others) > 1


def main():
    """Traces one command."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--stops", action="store_true", help="list the stops")
    parser.add_argument("--program", type=Path, default=ROOT / "build" / "release" / "signorom")
    parser.add_argument(
        "arguments", nargs=argparse.REMAINDER, help="command of the program, and its arguments"
    )
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        calls = inside_source(read_calls(trace(options.program, options.arguments, Path(folder))))
    order = walk(calls)
    edges = [(p, c) for p in order for c in calls.get(p, [])]
    away = sum(folder_of(p) != folder_of(c) for p, c in edges)
    stops = [p for p in order if is_stop(p, calls)]
    changes = sum(folder_of(a) != folder_of(b) for a, b in pairwise(stops))
    files = {file for file, _ in order}
    print(f"{len(order)} procedures of {len(files)} files; {len(edges)} call edges, {away} to another folder")
    print(f"{len(stops)} stops in {len({p[0] for p in stops})} files, {changes} changes of folder")
    for file, name in stops if options.stops else ():
        print(f"  {file}: {re.sub('^__sig_.*_MOD_', '', name)}")


if __name__ == "__main__":
    main()
