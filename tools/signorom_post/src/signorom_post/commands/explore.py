# SPDX-License-Identifier: BSD-3-Clause
"""The command `signorom-post explore`: a model in a browser, with sliders, pictures and curves."""

import argparse
import asyncio
import secrets
from importlib.util import find_spec
from pathlib import Path

from signorom_post.answer import ModelError
from signorom_post.arguments import at_least
from signorom_post.errors import InputError
from signorom_post.library import LibraryError

NAME = "signorom-post explore"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments of `signorom-post explore` to its parser."""
    parser.add_argument(
        "results", metavar="RESULTS_DIR|MODEL", type=Path, help="results folder, or its model.h5"
    )
    parser.add_argument(
        "--port", metavar="N", type=at_least(0), default=0, help="port of the page; default: a free one"
    )


def run(options: argparse.Namespace) -> int:
    """Serves the page, and prints its address, until the user stops it, which raises KeyboardInterrupt.

    InputError if trame or VTK are missing, if the model or the online library cannot be used, or if the port is taken.
    """
    missing = [name for name in ("trame", "trame_vtk", "vtk") if find_spec(name) is None]
    if missing:
        raise InputError(
            NAME,
            f"{', '.join(missing)} not installed; hint: in the Python environment of signorom-post: "
            "pip install 'tools/signorom_post[explore]'",
        )
    from signorom_post.explore.exploration import Exploration
    from signorom_post.explore.page import Page, serve

    path = options.results / "model.h5" if options.results.is_dir() else options.results
    try:
        exploration = Exploration(path)
    except ModelError as error:
        raise InputError(path, error.sentence) from error
    except LibraryError as error:
        raise InputError(NAME, str(error)) from error

    def announce(address: str) -> None:
        options.log.result(address)
        options.log.note("Open this address in a browser on this machine. Ctrl-C ends the exploration.")

    try:
        asyncio.run(serve(Page(exploration), secrets.token_urlsafe(24), options.port, announce))
    except OSError as error:
        raise InputError(
            NAME, f"port {options.port} cannot be used ({error.strerror}); leave --port out"
        ) from error
    finally:
        exploration.close()
    return 0
