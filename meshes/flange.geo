// SPDX-License-Identifier: BSD-3-Clause
// Two plates on top of each other, which touch at z = 0 all over: a flange and the gasket below it; hexahedra.
// Rebuild: gmsh -3 -format msh41 flange.geo -o flange.msh

width = 130; // [mm] along x
depth = 110.25; // [mm] along y
bottom = -13.5; // [mm] of the gasket
top = 9.25; // [mm] of the flange
n_x = 52; // cells
n_y = 49;
n_gasket = 3;
n_flange = 2;

// Each plate has points, lines and faces of its own at z = 0, so that the contact can open.
For i In {0:1}
  k = 100 * i; // corners k + 1 to k + 4 below, k + 5 to k + 8 above
  n_z = i == 0 ? n_gasket : n_flange;
  For j In {0:1}
    z = i == 0 ? (1 - j) * bottom : j * top;
    p = k + 4 * j;
    Point(p + 1) = {0, 0, z};
    Point(p + 2) = {width, 0, z};
    Point(p + 3) = {width, depth, z};
    Point(p + 4) = {0, depth, z};
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

Physical Volume("gasket", 1) = {1};
Physical Volume("flange", 2) = {2};
Physical Surface("base", 3) = {1};
Physical Surface("gasket_face", 4) = {5};
Physical Surface("flange_face", 5) = {101};
Physical Surface("top", 6) = {105};
// two corners of the flange, to hold it along x and y and about z
Physical Point("pin", 7) = {101};
Physical Point("pin_far", 8) = {102};
