# SPDX-License-Identifier: BSD-3-Clause
"""The command `signorom-post`: reads the command line and runs one of the commands."""

import argparse
import sys
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path

from signorom_post import __version__
from signorom_post.errors import InputError
from signorom_post.log import Log

EXIT_OK = 0
EXIT_USER_ERROR = 2
EXIT_STOPPED = 130

#: name of a command -> its module below signorom_post, and what it does. Only the module of the chosen command is
#: imported, because some need a second for matplotlib.
COMMANDS = {
    "figures": ("commands.figures", "draw every figure that the files in the folder allow"),
    "summary": ("commands.summary", "print a short table from report.yaml"),
    "report": ("commands.report", "write one HTML page: verdict, errors, pictures, deck, provenance"),
    "animation": ("commands.animation", "write a GIF or MP4 of the displaced bodies over the time"),
    "view": ("commands.view", "draw the standard pictures by VTK, and write a script for ParaView"),
    "explore": ("commands.explore", "show a model in a browser: sliders, pictures, curves, errors"),
    "convert": ("convert.command", "write a mesh of another program as .msh, with the names of its sets"),
    "check": ("commands.check", "draw the set-up that `signorom check DECK --fields` wrote"),
    "forest": ("commands.forest", "train the random forest that chooses the cluster of a point"),
    "verification": (
        "commands.verification",
        "draw and print the table of what the verification tests found",
    ),
    "fmu": ("commands.fmu", "write a model as an FMU (FMI 3.0) for system simulators"),
    "compare": ("compare.command", "print a table of models of one problem: sizes, times, errors"),
    "paper": ("paper.command", "run case b of the paper and compare its figures and numbers"),
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs one command of `arguments` (default: those of the process) and returns the exit code.

    0: success, or the reader of the output has left, as `| head` does. 1: a number of the verification lies outside of
    its limits, or is missing. 2: an InputError, a figure that failed, or a log that cannot be written. 130: the user
    stopped the command. For wrong arguments (2), --help and --version (0), argparse raises SystemExit.
    """
    words = sys.argv[1:] if arguments is None else arguments
    options = _parser(words).parse_args(words)
    try:
        options.log = Log(options.log_file)
    except InputError as error:
        print(error, file=sys.stderr)
        return EXIT_USER_ERROR
    code = _run(options)
    options.log.close()
    if options.log.failure:
        print(f"{options.log.path}: error: cannot write everything: {options.log.failure}", file=sys.stderr)
        code = code or EXIT_USER_ERROR
    return code


def _run(options: argparse.Namespace) -> int:
    try:
        return int(options.run(options))
    except InputError as error:
        options.log.note(error)
        return EXIT_USER_ERROR
    except KeyboardInterrupt:
        options.log.note("stopped; run the same command again")
        return EXIT_STOPPED
    except BrokenPipeError:  # the reader of a pipe has left, as `| head` does
        sys.stderr.close()
        return EXIT_OK


def _parser(words: Sequence[str]) -> argparse.ArgumentParser:
    """Returns a parser of the command line `words`, with the arguments of the first command that stands in them."""
    parser = argparse.ArgumentParser(
        prog="signorom-post", description="Figures and tables from the results folder of a Signorom deck."
    )
    parser.add_argument("--version", action="version", version=f"signorom-post {__version__}")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    chosen = next((word for word in words if word in COMMANDS), None)
    for name, (module_name, purpose) in COMMANDS.items():
        command = commands.add_parser(name, help=purpose)
        if name != chosen:
            continue
        module = import_module(f"signorom_post.{module_name}")
        module.add_arguments(command)
        command.add_argument(
            "--log",
            metavar="FILE",
            dest="log_file",
            type=Path,
            help="append all messages to a file, with dates",
        )
        command.set_defaults(run=module.run)
    return parser
