# SPDX-License-Identifier: BSD-3-Clause
"""How much displacements are magnified, and what the figure says about it."""

import math

import numpy as np

from signorom_post.arrays import FloatArray, format_number
from signorom_post.readers.fields import FieldPoint

#: displacements below this share of the size of the mesh are drawn larger than they are
VISIBLE_SHARE = 0.02
#: [characters] a title that is longer has a line per parameter
LONGEST_TITLE = 24


def deformed_title(point: FieldPoint, scale: float) -> str:
    """The point, and by how much its displacement is magnified."""
    lines = [*point.label.split(", ")] if len(point.label) > LONGEST_TITLE else [point.label]
    lines[-1] += f"  (displacement x {format_number(scale)})" if scale != 1 else ""
    return "\n".join(lines)


def magnification(displacement: FloatArray, size: float) -> float:
    """1 where displacements, shape (n_nodes, 3), are visible; else 1, 2 or 5 times a power of ten."""
    largest = float(np.abs(displacement).max(initial=0.0))
    if largest == 0.0 or largest >= VISIBLE_SHARE * size:
        return 1.0
    wanted = 2.0 * VISIBLE_SHARE * size / largest
    power = 10.0 ** math.floor(math.log10(wanted))
    return max(step * power for step in (1.0, 2.0, 5.0) if step * power <= wanted * (1 + 1e-12))
