// SPDX-License-Identifier: BSD-3-Clause
// A block of hexahedra, on which a rigid sphere of the deck leaves its mark.
// Rebuild: gmsh -3 -format msh41 indenter.geo -o indenter.msh

width = 27; // [mm] along x
depth = 21; // [mm] along y
height = 7.5; // [mm], below z = 0
n_x = 36; // cells
n_y = 28;
n_z = 5;

Point(1) = {0, 0, -height};
Point(2) = {width, 0, -height};
Point(3) = {width, depth, -height};
Point(4) = {0, depth, -height};
For i In {1:4}
  Line(i) = {i, i % 4 + 1};
EndFor
Transfinite Curve {1, 3} = n_x + 1;
Transfinite Curve {2, 4} = n_y + 1;
Curve Loop(1) = {1:4};
Plane Surface(1) = {1};
Transfinite Surface {1};
Recombine Surface {1};
out[] = Extrude {0, 0, height} { Surface{1}; Layers{n_z}; Recombine; };

Physical Volume("block", 1) = {out[1]};
Physical Surface("base", 2) = {1};
Physical Surface("face", 3) = {out[0]};
