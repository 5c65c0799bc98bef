// SPDX-License-Identifier: BSD-3-Clause
// Half of a cylinder of radius 50 mm (its lower half) on a block, right of the plane of symmetry x = 0.
// Rebuild: gmsh -2 -format msh41 hertz_cylinder.geo -o hertz_cylinder.msh

radius = 50; // [mm]
size = 100; // [mm] width and depth of the block, 16 contact half-widths
n_face = 48; // edges of each contact surface
step = 0.2; // [mm] along x: a / 31 at the full load
growth = 0.22; // edge length per distance from the contact

// Nodes of the contact surfaces are points, so that pairs face each other exactly.
For i In {0:n_face}
  x = i * step;
  Point(1 + i) = {x, radius - Sqrt(radius^2 - x^2), 0};
  Point(1001 + i) = {x, 0, 0};
EndFor
For i In {1:n_face}
  Line(i) = {i, i + 1};
  Line(1000 + i) = {1000 + i, 1001 + i};
EndFor
Transfinite Curve {1:n_face, 1001:1000 + n_face} = 2;

last = n_face + 1;
Point(500) = {0, radius, 0};
Point(501) = {radius, radius, 0};
Circle(500) = {last, 500, 501};
Line(501) = {501, 500};
Line(502) = {500, 1};
Curve Loop(1) = {1:n_face, 500, 501, 502};
Plane Surface(1) = {1};

Point(1500) = {size, 0, 0};
Point(1501) = {size, -size, 0};
Point(1502) = {0, -size, 0};
Line(1500) = {1000 + last, 1500};
Line(1501) = {1500, 1501};
Line(1502) = {1501, 1502};
Line(1503) = {1502, 1001};
Curve Loop(2) = {1001:1000 + n_face, 1500, 1501, 1502, 1503};
Plane Surface(2) = {-2};

Field[1] = MathEval; // distance from the middle of the contact beyond its end
Field[1].F = Sprintf("%g + %g * max(0, sqrt(x^2 + y^2) - %g)", step, growth, n_face * step);
Field[2] = MathEval; // distance from the surface below the contact
Field[2].F = Sprintf("%g + %g * abs(y)", step, growth);
Field[3] = Max;
Field[3].FieldsList = {1, 2};
Background Field = 3;
Mesh.CharacteristicLengthExtendFromBoundary = 0;
Mesh.CharacteristicLengthFromPoints = 0;
Mesh.Algorithm = 6;

Physical Surface("cylinder", 1) = {1};
Physical Surface("block", 2) = {2};
Physical Curve("cylinder_top", 3) = {501};
Physical Curve("cylinder_middle", 4) = {502};
Physical Curve("cylinder_face", 5) = {1:n_face};
Physical Curve("block_base", 6) = {1502};
Physical Curve("block_middle", 7) = {1503};
Physical Curve("block_face", 8) = {1001:1000 + n_face};
