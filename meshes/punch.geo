// SPDX-License-Identifier: BSD-3-Clause
// Flat rigid punch (one layer of cells, all of whose nodes are prescribed) on a block, right of the plane of symmetry x = 0.
// Rebuild: gmsh -2 -format msh41 punch.geo -o punch.msh

DefineConstant[n_face = 16]; // edges under the half punch
half_width = 1; // [m]
size = 100; // [m] width and depth of the block
growth = 3 / n_face; // edge length per distance from the punch: all of the mesh is refined

step = half_width / n_face;
Point(1) = {0, 0, 0};
Point(2) = {half_width, 0, 0};
Point(3) = {size, 0, 0};
Point(4) = {size, -size, 0};
Point(5) = {0, -size, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 5};
Line(5) = {5, 1};
Curve Loop(1) = {1:5};
Plane Surface(1) = {-1};

Point(11) = {0, 0, 0};
Point(12) = {half_width, 0, 0};
Point(13) = {half_width, step, 0};
Point(14) = {0, step, 0};
Line(11) = {11, 12};
Line(12) = {12, 13};
Line(13) = {13, 14};
Line(14) = {14, 11};
Curve Loop(2) = {11:14};
Plane Surface(2) = {2};

Transfinite Curve {1, 11, 13} = n_face + 1;
Transfinite Curve {12, 14} = 2;
Transfinite Surface {2};

Field[1] = MathEval; // distance from the punch
Field[1].F = Sprintf("%g + %g * sqrt(max(0, x - %g)^2 + y^2)", step, growth, half_width);
Background Field = 1;
Mesh.CharacteristicLengthExtendFromBoundary = 0;
Mesh.CharacteristicLengthFromPoints = 0;
Mesh.Algorithm = 6;

Physical Surface("block", 1) = {1};
Physical Surface("punch", 2) = {2};
Physical Curve("block_face", 3) = {1};
Physical Curve("block_middle", 4) = {5};
Physical Curve("block_base", 5) = {4};
Physical Curve("punch_face", 6) = {11};
Physical Curve("punch_nodes", 7) = {11:14};
