// SPDX-License-Identifier: BSD-3-Clause
// Half of two equal blocks on top of each other, behind the plane of symmetry y = 0; they touch at z = 0.
// Rebuild: gmsh -3 -format msh41 blocks.geo -o blocks.msh

width = 20; // [mm] along x
depth = 10; // [mm] along y, of the half
height = 10; // [mm] of each block
n_x = 10; // cells of each block
n_y = 5;
n_z = 5;

// Each block has points, lines and faces of its own at z = 0, so that the contact can open.
For i In {0:1}
  k = 100 * i; // corners k + 1 to k + 4 below, k + 5 to k + 8 above
  For j In {0:1}
    z = (i + j - 1) * height;
    p = k + 4 * j;
    Point(p + 1) = {-width / 2, 0, z};
    Point(p + 2) = {width / 2, 0, z};
    Point(p + 3) = {width / 2, depth, z};
    Point(p + 4) = {-width / 2, depth, z};
    Line(p + 1) = {p + 1, p + 2};
    Line(p + 2) = {p + 2, p + 3};
    Line(p + 3) = {p + 3, p + 4};
    Line(p + 4) = {p + 4, p + 1};
    Transfinite Curve {p + 1, p + 3} = n_x + 1;
    Transfinite Curve {p + 2, p + 4} = n_y + 1;
    Curve Loop(p + 1) = {p + 1:p + 4};
    Plane Surface(p + 1) = {p + 1};
  EndFor
  For j In {1:4}
    Line(k + 10 + j) = {k + j, k + 4 + j};
    Transfinite Curve {k + 10 + j} = n_z + 1;
  EndFor
  For j In {1:4}
    next = j % 4 + 1;
    Curve Loop(k + 10 + j) = {k + j, k + 10 + next, -(k + 4 + j), -(k + 10 + j)};
    Plane Surface(k + 10 + j) = {k + 10 + j};
  EndFor
  faces[] = {k + 1, k + 5, k + 11, k + 12, k + 13, k + 14};
  Transfinite Surface {faces[]};
  Recombine Surface {faces[]};
  Surface Loop(i + 1) = {faces[]};
  Volume(i + 1) = {i + 1};
  Transfinite Volume {i + 1};
EndFor

Physical Volume("lower", 1) = {1};
Physical Volume("upper", 2) = {2};
Physical Surface("base", 3) = {1};
Physical Surface("lower_face", 4) = {5};
Physical Surface("upper_face", 5) = {101};
Physical Surface("top", 6) = {105};
Physical Surface("front", 7) = {11, 111};
// one corner of each block, to hold it along x
Physical Point("corners", 8) = {1, 101};
