# SPDX-License-Identifier: BSD-3-Clause
"""A square of panels for any number of parameters: pairs of them off the diagonal, single ones on it."""

from collections.abc import Iterator

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from signorom_post.style import new_figure


class PairPanels:
    """The panel in row i and column j has parameter j along x and, off the diagonal, parameter i along y."""

    def __init__(self, texts: list[str], diagonal_text: str) -> None:
        """Axis texts of the parameters, and of the diagonal's y axes."""
        self.n = len(texts)
        self.figure: Figure = new_figure(3.2 + 2.4 * (self.n - 0.5), 1.2 + 2.2 * (self.n - 0.3))
        self.axes = self.figure.subplots(self.n, self.n, sharex="col", squeeze=False)
        for i, j in self._places():
            panel = self.axes[i, j]
            if i == self.n - 1:
                panel.set_xlabel(texts[j])
            if i == j:
                panel.set_ylabel(diagonal_text)
                continue
            reference = self.axes[i, 0 if i else 1]
            if panel is reference:
                panel.set_ylabel(texts[i])
            else:
                panel.sharey(reference)
                panel.tick_params(labelleft=False)

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
        yield from ((j, i, self.axes[i, j]) for i, j in self._places() if i < j)
