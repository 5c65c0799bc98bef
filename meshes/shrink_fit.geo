// SPDX-License-Identifier: BSD-3-Clause
// Section of two rings that overlap by 0.0025 mm of the radius: x is the radius, y the axis.
// Rebuild: gmsh -2 -format msh41 shrink_fit.geo -o shrink_fit.msh

overlap = 0.0025; // [mm]
height = 2; // [mm]
DefineConstant[n_radial = 40]; // cells of each ring
n_axial = 3;

For ring In {0:1}
  first = 1 + 10 * ring;
  inner = 10 + 10 * ring;
  outer = 20 + overlap + (10 - overlap) * ring;
  Point(first) = {inner, 0, 0};
  Point(first + 1) = {outer, 0, 0};
  Point(first + 2) = {outer, height, 0};
  Point(first + 3) = {inner, height, 0};
  For i In {0:3}
    Line(first + i) = {first + i, first + (i + 1) % 4};
  EndFor
  Transfinite Curve {first, first + 2} = n_radial + 1;
  Transfinite Curve {first + 1, first + 3} = n_axial + 1;
  Curve Loop(1 + ring) = {first:first + 3};
  Plane Surface(1 + ring) = {1 + ring};
  Transfinite Surface {1 + ring};
  Recombine Surface {1 + ring};
EndFor

Physical Surface("inner_ring", 1) = {1};
Physical Surface("outer_ring", 2) = {2};
Physical Curve("bottom", 3) = {1, 11};
Physical Curve("top", 4) = {3, 13};
Physical Curve("bore", 7) = {4};
Physical Curve("rim", 8) = {12};
Physical Curve("inner_face", 5) = {2};
Physical Curve("outer_face", 6) = {14};
