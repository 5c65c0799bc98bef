# SPDX-License-Identifier: BSD-3-Clause
"""What the tests of figures look at."""

from pathlib import Path

import matplotlib.image
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from signorom_post.style import RESOLUTION, save


def lines_of(axes: Axes, gid: str) -> list[Line2D]:
    return [line for line in axes.lines if line.get_gid() == gid]


def check_picture(figure: Figure, path: Path) -> None:
    """The picture has the figure's size and enough ink on white."""
    save(figure, path)
    pixels = matplotlib.image.imread(path)
    width, height = (figure.get_size_inches() * RESOLUTION).astype(int)
    assert abs(pixels.shape[0] - height) <= 1
    assert abs(pixels.shape[1] - width) <= 1
    is_ink = pixels[..., :3].min(axis=2) < 0.9
    assert 0.01 < is_ink.mean() < 0.9
    assert not is_ink[0].any(), "something touches the upper edge"
    assert not is_ink[:, 0].any(), "something touches the left edge"
    assert not is_ink[:, -1].any(), "something touches the right edge"
