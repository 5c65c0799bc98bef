// SPDX-License-Identifier: BSD-3-Clause
// Two flat blocks, two rows of cells each, the upper one pushed by two stamps: every cell touches a named line, so that
// the lines as zones of interest make the reduced integration domain the whole mesh.
// Rebuild: gmsh -2 -format msh41 two_stamps.geo -o two_stamps.msh

width = 1.2; // [m]
height = 0.4; // [m] of each block
gap = 0.02; // [m]

Point(1) = {0, -height, 0};
Point(2) = {width, -height, 0};
Point(3) = {width, 0, 0};
Point(4) = {0, 0, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Transfinite Curve {1, 3} = 7;
Transfinite Curve {2, 4} = 3;
Transfinite Surface {1};

Point(11) = {0, gap, 0};
Point(12) = {width, gap, 0};
Point(13) = {width, gap + height, 0};
Point(14) = {2 * width / 3, gap + height, 0};
Point(15) = {width / 3, gap + height, 0};
Point(16) = {0, gap + height, 0};
Line(11) = {11, 12};
Line(12) = {12, 13};
Line(13) = {13, 14};
Line(14) = {14, 15};
Line(15) = {15, 16};
Line(16) = {16, 11};
Curve Loop(11) = {11, 12, 13, 14, 15, 16};
Plane Surface(11) = {11};
Transfinite Curve {11} = 7;
Transfinite Curve {13, 14, 15} = 3;
Transfinite Curve {12, 16} = 3;
Transfinite Surface {11} = {11, 12, 13, 16} Alternate;

Physical Surface("lower", 1) = {1};
Physical Surface("upper", 2) = {11};
Physical Curve("lower_base", 3) = {1};
Physical Curve("lower_face", 4) = {3};
Physical Curve("upper_face", 5) = {11};
Physical Curve("right_stamp", 6) = {13};
Physical Curve("between_stamps", 7) = {14};
Physical Curve("left_stamp", 8) = {15};
