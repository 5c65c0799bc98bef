# SPDX-License-Identifier: BSD-3-Clause
"""D12: two rings of one material shrunk onto each other: pressure between them by Lamé.

Units: mm, N, MPa. Diameters 20-40.005 and 40-60 mm: interference 0.005 mm of the diameter, gap D = -0.0025 mm.
"""

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
