# SPDX-License-Identifier: BSD-3-Clause
"""A square of panels for any number of parameters: single parameters on the diagonal, pairs of them elsewhere."""

from collections.abc import Iterator

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from signorom_post.style import new_figure


class PairPanels:
    """A figure of n x n panels for n parameters.

    The panel in row i and column j below the diagonal (i > j) has parameter j along x and parameter i along y. Its
    mirror image in the diagonal has the same parameters along the same axes, so that two fields over one pair of
    parameters can be compared.
    """

    def __init__(self, texts: list[str], diagonal_text: str) -> None:
        """`texts` are the labels of the parameters, `diagonal_text` the label of y on the diagonal."""
        self.n = len(texts)
        self.figure: Figure = new_figure(3.2 + 2.5 * (self.n - 0.5), 1.2 + 2.4 * (self.n - 0.3))
        self.axes = self.figure.subplots(self.n, self.n, squeeze=False)
        for panel in self.axes.ravel():
            panel.xaxis.set_major_locator(MaxNLocator(3))
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
        """Yields the number of each parameter, from 0, and its panel on the diagonal."""
        yield from ((i, self.axes[i, i]) for i in range(self.n))

    def below(self) -> Iterator[tuple[int, int, Axes]]:
        """Yields, for each panel below the diagonal, the parameters along x and along y, from 0, and the panel."""
        yield from ((j, i, self.axes[i, j]) for i, j in self._places() if i > j)

    def above(self) -> Iterator[tuple[int, int, Axes]]:
        """Yields, for each panel above the diagonal, the parameters along x and along y, from 0, and the panel."""
        yield from ((i, j, self.axes[i, j]) for i, j in self._places() if i < j)
