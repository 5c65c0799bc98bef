# SPDX-License-Identifier: BSD-3-Clause
"""A depth buffer: which triangle is in front at each point of a picture, so that near parts hide far ones."""

from collections.abc import Iterator

import numpy as np

from signorom_post.arrays import BoolArray, FloatArray, IntArray

#: number of points of a picture along its longer side
RESOLUTION = 1400
#: number of points, of triangles with the box around them, that are looked at in one step
BLOCK = 1_000_000
#: a place counts as seen up to this depth behind the surface, as a share of the size of the picture
TOLERANCE = 0.005
#: a point up to this share outside of a triangle belongs to it: neighbors leave no gap
ROUNDING = 1e-9


class DepthBuffer:
    """A grid of points over the picture with the triangle that is in front at each of them."""

    def __init__(self, corners: FloatArray, resolution: int = RESOLUTION) -> None:
        """`corners`, shape (n, 3, 3): right, up, and towards the viewer, of the three corners of each triangle."""
        low = corners[..., :2].min(axis=(0, 1)) if len(corners) else np.zeros(2)
        high = corners[..., :2].max(axis=(0, 1)) if len(corners) else np.ones(2)
        self.size = float((high - low).max()) or 1.0
        self.step = self.size / resolution
        self.low = low - self.step
        self.shape = tuple((np.ceil((high - low) / self.step).astype(int) + 3)[::-1])
        self.depth = np.full(self.shape[0] * self.shape[1], -np.inf)
        #: triangle in front, from 0, -1 where there is none; shape (n_up * n_right)
        self.owner = np.full(len(self.depth), -1, dtype=np.int64)
        self._corners = corners
        for triangles, widths in self._batches():
            self._draw(triangles, widths)

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """Left, right, lower and upper end of the picture, as `Axes.imshow` takes them with `origin="lower"`."""
        high = self.low + self.step * np.array(self.shape[::-1])
        return (self.low[0], high[0], self.low[1], high[1])

    def _batches(self) -> Iterator[tuple[IntArray, IntArray]]:
        """Yields triangles of similar size, and the largest numbers of points along the boxes around them."""
        spans = np.ceil(np.ptp(self._corners[..., :2], axis=1) / self.step).astype(int) + 1
        kinds = np.ceil(np.log2(spans.max(axis=1))).astype(int)
        for kind in np.unique(kinds):
            chosen = np.flatnonzero(kinds == kind)
            n_points = len(chosen) * int(spans[chosen].max(axis=0).prod())
            for part in np.array_split(chosen, min(len(chosen), n_points // BLOCK + 1)):
                yield part, spans[part].max(axis=0)

    def _draw(self, triangles: IntArray, widths: IntArray) -> None:
        """Writes triangles into the buffer where they are in front of what is there."""
        a, b, c = ((self._corners[triangles, i, :2] - self.low) / self.step for i in range(3))
        start = np.floor(np.minimum(np.minimum(a, b), c)).astype(int)
        x = (start[:, :1] + np.arange(widths[0]))[:, None, :]
        y = (start[:, 1:] + np.arange(widths[1]))[:, :, None]
        # the middle of point i is at i + 1/2
        shares = _shares(a, b, c, x + 0.5, y + 0.5)
        which = np.nonzero((shares >= -ROUNDING).all(axis=0))
        depths = self._corners[triangles[which[0]], :, 2].T
        depth = (shares[(slice(None), *which)] * depths).sum(axis=0)
        self._keep_nearest((y * self.shape[1] + x)[which], depth, triangles[which[0]])

    def _keep_nearest(self, place: IntArray, depth: FloatArray, triangles: IntArray) -> None:
        is_near = depth > self.depth[place]
        place, depth, triangles = place[is_near], depth[is_near], triangles[is_near]
        # of equal places the last one stays: the nearest, and of equally near ones the first triangle
        order = np.lexsort((-triangles, depth))
        self.depth[place[order]] = depth[order]
        self.owner[place[order]] = triangles[order]

    def shares(self) -> tuple[IntArray, FloatArray]:
        """Returns the points with a triangle, and the shares of its corners there, shape (3, n), which sum up to 1."""
        places = np.flatnonzero(self.owner >= 0)
        y, x = np.divmod(places, self.shape[1])
        a, b, c = ((self._corners[self.owner[places], i, :2] - self.low) / self.step for i in range(3))
        shares = _shares(a, b, c, (x + 0.5)[:, None, None], (y + 0.5)[:, None, None])[:, :, 0, 0]
        return places, np.clip(shares, 0.0, 1.0)

    def sees(self, places: FloatArray) -> BoolArray:
        """Returns whether nothing hides each of `places`, shape (n, 3): right, up, and towards the viewer.

        A place outside of the picture is seen, and so is a place less than 0.5 % of the picture behind the surface.
        """
        x, y = np.floor((places[:, :2] - self.low) / self.step).astype(int).T
        is_outside = (x < 0) | (y < 0) | (x >= self.shape[1]) | (y >= self.shape[0])
        index = np.where(is_outside, 0, y * self.shape[1] + x)
        return is_outside | (places[:, 2] >= self.depth[index] - TOLERANCE * self.size)


def _shares(a: FloatArray, b: FloatArray, c: FloatArray, x: FloatArray, y: FloatArray) -> FloatArray:
    """Returns the shares of the corners at points, shape (3, n, n_y, n_x); -1 where a triangle is seen edge-on.

    `a`, `b`, `c`, shape (n, 2), are the corners; `x`, shape (n, 1, n_x), and `y`, shape (n, n_y, 1), are the points.
    """
    (ax, ay), (bx, by), (cx, cy) = (corner.T[:, :, None, None] for corner in (a, b, c))
    area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
    is_thin = np.abs(area) < 1e-12
    safe = np.where(is_thin, 1.0, area)
    second = ((x - ax) * (cy - ay) - (cx - ax) * (y - ay)) / safe
    third = ((bx - ax) * (y - ay) - (x - ax) * (by - ay)) / safe
    shares = np.stack([1.0 - second - third, second, third])
    return np.where(is_thin, -1.0, shares)
