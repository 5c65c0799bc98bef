# SPDX-License-Identifier: BSD-3-Clause
"""The command `signorom-post view`: draws the standard pictures by VTK, and writes a script for ParaView."""

import argparse
from pathlib import Path

from signorom_post.arguments import direction
from signorom_post.errors import InputError, writing
from signorom_post.figures import NotDrawableError, choose_point
from signorom_post.results import Results
from signorom_post.view import PICTURES, write_view


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments of `signorom-post view` to its parser."""
    parser.add_argument("results", metavar="RESULTS_DIR", type=Path, help="for instance results/half_disks")
    parser.add_argument("--output", metavar="DIR", type=Path, help="default: RESULTS_DIR/view")
    parser.add_argument(
        "--point", metavar="P", help="number (from 1) or label of the point; default: the middle one"
    )
    parser.add_argument(
        "--camera",
        metavar="X,Y,Z",
        type=direction,
        help="direction from bodies in space to the viewer, as --camera=1,-2,1; "
        "default: the corner that shows most of all bodies",
    )


def run(options: argparse.Namespace) -> int:
    """Draws the pictures of one point, writes the script, and prints the path of each file. Returns 0.

    InputError if the folder is missing, if fields.h5 is missing, damaged or without points, if VTK is missing, if the
    point of --point is unknown, if the point has no displacement, if a plane mesh gets --camera, or if a file cannot be
    written.
    """
    fields = Results(options.results).fields
    try:
        point = choose_point(fields, options.point)
    except NotDrawableError as error:
        raise InputError(fields.path, "there is no parameter point") from error
    output = options.output or options.results / "view"
    with writing("pictures", output):
        pictures = write_view(fields, point, output, options.camera)
        for path in options.log.follow("pictures", pictures, len(PICTURES) + 1):
            options.log.result(path)
    return 0
