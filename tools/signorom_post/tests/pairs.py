# SPDX-License-Identifier: BSD-3-Clause
"""Contact rows of pairs of nodes, as the tests make them."""

import numpy as np

from signorom_post.arrays import FloatArray, IntArray
from signorom_post.contact import Contact, ContactSide


def contact_of_pairs(first: IntArray, second: IntArray, areas: FloatArray | None = None) -> Contact:
    """Rows of one node on either side."""
    starts = np.arange(len(first) + 1)
    sides = [ContactSide(starts, np.asarray(nodes), np.ones(len(first))) for nodes in (first, second)]
    return Contact(*sides, np.ones(len(first)) if areas is None else areas)
