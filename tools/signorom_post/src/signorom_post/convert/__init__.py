# SPDX-License-Identifier: BSD-3-Clause
"""Meshes of other programs as gmsh's .msh, with the names of their sets."""
