// SPDX-License-Identifier: BSD-3-Clause
// Two bars in a row, 0.01 m apart, with unevenly spaced nodes on the faces.
// Rebuild: gmsh -2 -format msh41 bar_with_gap.geo -o bar_with_gap.msh

width = 0.4; // [m]
lower_height = 1.0; // [m]
upper_height = 0.5; // [m]
gap = 0.01; // [m]
n_face = 6;

Point(1) = {0, -lower_height, 0, 0.2};
Point(2) = {width, -lower_height, 0, 0.2};
Point(3) = {width, 0, 0, 0.1};
Point(4) = {0, 0, 0, 0.1};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};

Point(11) = {0, gap, 0, 0.1};
Point(12) = {width, gap, 0, 0.1};
Point(13) = {width, gap + upper_height, 0, 0.15};
Point(14) = {0, gap + upper_height, 0, 0.15};
Line(11) = {11, 12};
Line(12) = {12, 13};
Line(13) = {13, 14};
Line(14) = {14, 11};
Curve Loop(11) = {11, 12, 13, 14};
Plane Surface(11) = {11};

Transfinite Curve {3} = n_face Using Progression 1.3;
// Copies the nodes: two transfinite curves would agree to 1e-9 only.
Periodic Curve {11} = {-3} Translate {0, gap, 0};
Mesh.Algorithm = 5;

Physical Surface("lower", 1) = {1};
Physical Surface("upper", 2) = {11};
Physical Curve("lower_base", 3) = {1};
Physical Curve("upper_base", 4) = {13};
Physical Curve("lower_face", 5) = {3};
Physical Curve("upper_face", 6) = {11};
