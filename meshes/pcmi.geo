// SPDX-License-Identifier: BSD-3-Clause
// Section of half a fuel pellet and its cladding: x is the radius, y the axis, y = 0 the middle of the pellet. Q8 whose nodes do not
// match across the gap.
// Rebuild: gmsh -2 -format msh41 pcmi.geo -o pcmi.msh

fuel_radius = 4.1; // [mm]
gap = 0.03; // [mm] in the mesh; the deck has its own
thickness = 0.57; // [mm] of the cladding
height = 6; // [mm]
DefineConstant[n_fuel = 8]; // cells along the radius
DefineConstant[n_cladding = 3];
DefineConstant[n_axial_fuel = 16];
DefineConstant[n_axial_cladding = 12];

For body In {0:1}
  first = 1 + 10 * body;
  inner = body * (fuel_radius + gap);
  outer = fuel_radius + body * (gap + thickness);
  Point(first) = {inner, 0, 0};
  Point(first + 1) = {outer, 0, 0};
  Point(first + 2) = {outer, height, 0};
  Point(first + 3) = {inner, height, 0};
  For i In {0:3}
    Line(first + i) = {first + i, first + (i + 1) % 4};
  EndFor
  Transfinite Curve {first, first + 2} = 1 + n_fuel + body * (n_cladding - n_fuel);
  Transfinite Curve {first + 1, first + 3} = 1 + n_axial_fuel + body * (n_axial_cladding - n_axial_fuel);
  Curve Loop(1 + body) = {first:first + 3};
  Plane Surface(1 + body) = {1 + body};
  Transfinite Surface {1 + body};
  Recombine Surface {1 + body};
EndFor

Physical Surface("fuel", 1) = {1};
Physical Surface("cladding", 2) = {2};
Physical Curve("axis", 3) = {4};
Physical Curve("bottom", 4) = {1, 11};
Physical Curve("cladding_top", 5) = {13};
Physical Curve("fuel_surface", 6) = {2};
Physical Curve("cladding_inside", 7) = {14};
Physical Curve("cladding_outside", 8) = {12};

Mesh.ElementOrder = 2;
Mesh.SecondOrderIncomplete = 1;
