# SPDX-License-Identifier: BSD-3-Clause
"""D12: two rings of one material shrunk onto each other: pressure between them by Lamé.

Units: mm, N, MPa. Diameters 20-40.005 and 40-60 mm: interference 0.005 mm of the diameter, gap D = -0.0025 mm.
"""

import numpy as np

from lame import ThickCylinder

YOUNG_MODULUS, POISSON_RATIO = 196e3, 0.3
INNER, MIDDLE, OUTER = 20.0, 40.0, 60.0
INTERFERENCE = 0.005


def pressure(ends):
    """p = (delta / d) E' / [(do^2 + d^2) / (do^2 - d^2) + (d^2 + di^2) / (d^2 - di^2)].

    Free ends: E' = E, 5.74 MPa; u_z = 0 (held): E' = E / (1 - nu^2), 6.31 MPa. Equal materials.
    """
    modulus = YOUNG_MODULUS if ends == "free" else YOUNG_MODULUS / (1 - POISSON_RATIO**2)
    outer_ring = (OUTER**2 + MIDDLE**2) / (OUTER**2 - MIDDLE**2)
    inner_ring = (MIDDLE**2 + INNER**2) / (MIDDLE**2 - INNER**2)
    return INTERFERENCE / MIDDLE * modulus / (outer_ring + inner_ring)


def force_of_meshes(ends):
    """Force per length around the contact where the meshes' own faces, at 20.0025 and 20 mm, meet: no 0.01 % between.

    Node-to-node contact carries one force on both sides, so the pressures are force / (2 pi r) of each side.
    """
    inner, middle, outer = INNER / 2, MIDDLE / 2, OUTER / 2
    face = middle + INTERFERENCE / 2

    def closed(force):
        """How far the faces move apart under a force per length."""
        pressures = [force / (2 * np.pi * r) for r in (face, middle)]
        rings = (
            ThickCylinder(YOUNG_MODULUS, POISSON_RATIO, inner, face, outer_pressure=pressures[0], ends=ends),
            ThickCylinder(
                YOUNG_MODULUS, POISSON_RATIO, middle, outer, inner_pressure=pressures[1], ends=ends
            ),
        )
        return rings[1].displacement(middle) - rings[0].displacement(face)

    return INTERFERENCE / 2 / closed(1.0)
