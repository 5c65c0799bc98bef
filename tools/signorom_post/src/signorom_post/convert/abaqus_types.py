# SPDX-License-Identifier: BSD-3-Clause
"""The types of elements of Abaqus and CalculiX."""

import re

#: a pattern, whose group is the number of nodes, and the dimension
TYPES = [
    (re.compile(r"(?:DC|AC|C|F)3D(4|5|6|8|10|13|15|20|27)[A-Z]*"), 3),
    (re.compile(r"(?:CPEG|CPE|CPS|CAXA|CAX|CGAX|DCAX|DC2D|AC2D|ACAX)(3|4|6|8)[A-Z0-9]*"), 2),
    (re.compile(r"(?:DS|STRI|S|M3D|SFM3D|R3D)(3|4|6|8|9)(?:5|[A-Z][A-Z0-9]*)?"), 2),
    (re.compile(r"(?:T2D|T3D|DC1D|R2D|RAX|SAX|MAX)(2|3)[A-Z]*"), 1),
]
#: beams and pipes: the second digit is their order
BEAM = re.compile(r"(?:B|PIPE)[23]([12])[A-Z]*")


def dimension_and_nodes(label: str) -> tuple[int, int] | None:
    """Returns the dimension and the number of nodes of a type in capitals, such as C3D10M; None if it is not known."""
    if label == "STRI65":
        return 2, 6
    for pattern, n_dim in TYPES:
        if match := pattern.fullmatch(label):
            return n_dim, int(match[1])
    match = BEAM.fullmatch(label)
    return (1, int(match[1]) + 1) if match else None
