#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# Makes the test meshes again; those in invalid/ are valid ones with one thing broken.
set -eu
cd "$(dirname "$0")"
mesh() { gmsh -v 1 "$@"; }

mesh -2 -format msh41 two_blocks.geo -o two_blocks.msh
mesh -2 -format msh41 -bin two_blocks.geo -o two_blocks_v41_binary.msh
mesh -2 -format msh22 two_blocks.geo -o two_blocks_v22_ascii.msh
mesh -2 -format msh22 -bin two_blocks.geo -o two_blocks_v22_binary.msh
mesh -2 -part 2 -format msh22 two_blocks.geo -o two_blocks_v22_partitioned.msh
mesh -2 -format msh40 two_blocks.geo -o two_blocks_v40_ascii.msh
sed '/^\$PhysicalNames/,/^\$EndPhysicalNames/d' two_blocks.msh > two_blocks_without_names.msh
mesh -2 -format msh41 quads.geo -o quads.msh
mesh -2 -format msh22 quads.geo -o quads_v22_ascii.msh
mesh -3 -format msh41 cube.geo -o cube.msh
# Case a with few nodes.
sed 's/n_arc = 55/n_arc = 15/; s/n_base = 37/n_base = 9/' ../../../meshes/half_disks.geo > small_disks.tmp.geo
mesh -2 -format msh41 small_disks.tmp.geo -o small_disks.msh
rm small_disks.tmp.geo

mkdir -p invalid
mesh -2 -order 3 -format msh41 two_blocks.geo -o invalid/cubic.msh
mesh -2 -order 2 -format msh41 two_blocks.geo -o two_blocks_quadratic.msh
mesh -2 -part 2 -format msh41 two_blocks.geo -o invalid/partitioned.msh
head -c 2400 two_blocks.msh > invalid/truncated.msh
head -c 3000 two_blocks_v41_binary.msh > invalid/truncated_binary.msh
# Upper block moved by 0.1 in x: its nodes lie beside those of the lower one.
sed 's/= {0, y/= {0.1 * side, y/; s/= {1, y/= {1 + 0.1 * side, y/' two_blocks.geo > shifted.tmp.geo
mesh -2 -format msh41 shifted.tmp.geo -o invalid/not_facing.msh
rm shifted.tmp.geo
# The same blocks in the plane y = 0, and in the plane y = z, which is none of the three that a plane model takes.
sed 's/= {\([01]\), \(.*\), 0}/= {\1, 0, \2}/' two_blocks.geo > turned.tmp.geo
mesh -2 -format msh41 turned.tmp.geo -o two_blocks_turned.msh
sed 's/= {\([01]\), \(.*\), 0}/= {\1, \2, \2}/' two_blocks.geo > turned.tmp.geo
mesh -2 -format msh41 turned.tmp.geo -o invalid/not_in_plane.msh
rm turned.tmp.geo
