# SPDX-License-Identifier: BSD-3-Clause
"""A square of panels for any number of parameters: pairs of them off the diagonal, single ones on it."""

from collections.abc import Iterator

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from signorom_post.style import new_figure


class PairPanels:
    """A panel and its mirror image in the diagonal show the same pair on the same axes.

    Row i and column j below the diagonal: parameter j along x and parameter i along y; above it i along x and j along y.
    """

    def __init__(self, texts: list[str], diagonal_text: str) -> None:
        """Axis texts of the parameters, and of the diagonal's y axes."""
        self.n = len(texts)
        self.figure: Figure = new_figure(3.2 + 2.5 * (self.n - 0.5), 1.2 + 2.4 * (self.n - 0.3))
        self.axes = self.figure.subplots(self.n, self.n, squeeze=False)
        for i, panel in self.diagonal():
            panel.set_xlabel(texts[i])
            panel.set_ylabel(diagonal_text)
        for x, y, panel in (*self.below(), *self.above()):
            panel.set_xlabel(texts[x])
            panel.set_ylabel(texts[y])
        for x, y, panel in self.above():
            panel.sharex(self.axes[y, x])
            panel.sharey(self.axes[y, x])
        for x, y, panel in self.below():
            if x > 0:
                panel.sharey(self.axes[y, 0])
            panel.sharex(self.axes[x, x])

    def _places(self) -> Iterator[tuple[int, int]]:
        yield from ((i, j) for i in range(self.n) for j in range(self.n))

    def diagonal(self) -> Iterator[tuple[int, Axes]]:
        """Number of the parameter and its panel."""
        yield from ((i, self.axes[i, i]) for i in range(self.n))

    def below(self) -> Iterator[tuple[int, int, Axes]]:
        """Numbers of the parameters along x and y, and their panel, below the diagonal."""
        yield from ((j, i, self.axes[i, j]) for i, j in self._places() if i > j)

    def above(self) -> Iterator[tuple[int, int, Axes]]:
        """The same above the diagonal."""
        yield from ((i, j, self.axes[i, j]) for i, j in self._places() if i < j)
