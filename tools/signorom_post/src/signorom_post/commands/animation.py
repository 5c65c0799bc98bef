# SPDX-License-Identifier: BSD-3-Clause
"""The command `signorom-post animation`: a field of the displaced bodies over the time as GIF or MP4."""

import argparse
from pathlib import Path

from signorom_post.errors import InputError, writing
from signorom_post.figures import NotDrawableError, axis_names, choose_point, history_of
from signorom_post.plots.animation import animate
from signorom_post.results import Results
from signorom_post.style import styled


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments of `signorom-post animation` to its parser."""
    parser.add_argument("results", metavar="RESULTS_DIR", type=Path, help="for instance results/half_disks")
    parser.add_argument(
        "--output",
        metavar="FILE",
        type=Path,
        help="ends in .gif, or .mp4 (needs ffmpeg); default: RESULTS_DIR/figures/animation.gif",
    )
    parser.add_argument(
        "--color",
        metavar="FIELD",
        default="displacement",
        help="field of nodes in fields.h5 whose size gives the colors, such as contact_pressure, von_mises_smoothed, "
        "tangential_traction, slip; default: displacement",
    )
    parser.add_argument(
        "--point",
        metavar="P",
        help="number (from 1) or label of a point; its history is shown; default: the first one. "
        "Without a history all points are shown",
    )
    parser.add_argument(
        "--rate", metavar="N", type=float, default=10.0, help="pictures in a second; default: 10"
    )


def run(options: argparse.Namespace) -> int:
    """Writes the animation and prints its path. Returns 0.

    InputError if fields.h5 is missing, damaged or without points or the field, if the point of --point is unknown, or
    if the file cannot be written.
    """
    if not 0.0 < options.rate <= 100.0:
        raise InputError("--rate", "a number above 0, up to 100, is needed")
    results = Results(options.results)
    fields = results.fields
    try:
        point = choose_point(fields, options.point or "1")
    except NotDrawableError as error:
        raise InputError(fields.path, "there is no parameter point") from error
    points = history_of(fields, point) if "time" in point.parameter_names else fields.points
    path = options.output or options.results / "figures" / "animation.gif"
    with writing("animation", path), styled():
        path.parent.mkdir(parents=True, exist_ok=True)
        pictures = animate(fields, points, options.color, path, options.rate, axis_names(results))
        for _ in options.log.follow("animation", pictures, len(points)):
            pass
    options.log.result(path)
    return 0
