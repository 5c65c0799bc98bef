// SPDX-License-Identifier: BSD-3-Clause
// An unsymmetric bracket on two feet, beside a wall of the block below it; the three of them may touch.
// Rebuild: gmsh -2 -format msh41 bracket.geo -o bracket.msh

// [mm] foot 1 is flat, foot 2 has a crown of radius R, the wall is flat
foot_1_from = -18.2;
foot_1_to = -7.45;
n_foot_1 = 25; // edges
foot_2_from = 11.6;
n_foot_2 = 49;
step = 0.3; // of foot 2
crown = 17.7; // where the crown touches
R = 1130;
wall = -21.3;
stop_from = 3.35;
stop_to = 12.9;
n_stop = 19;
coarse = 3.1; // [mm] edges far from the contact

// Both sides of foot 2, point by point, so that they face each other exactly.
For i In {0:n_foot_2}
  x = foot_2_from + i * step;
  Point(100 + i) = {x, (x - crown)^2 / (2 * R), 0, step};
  Point(300 + i) = {x, 0, 0, step};
EndFor
For i In {1:n_foot_2}
  Line(100 + i) = {99 + i, 100 + i};
  Line(300 + i) = {299 + i, 300 + i};
EndFor
Transfinite Curve {101:100 + n_foot_2, 301:300 + n_foot_2} = 2;
last = 100 + n_foot_2;

// bracket, counterclockwise from foot 1
Point(1) = {foot_1_from, 0, 0, 0.5};
Point(2) = {foot_1_to, 0, 0, 0.5};
Point(3) = {-5.8, 1.7, 0, 1.3};
Point(4) = {9.9, 1.7, 0, 1.3};
Point(5) = {29.4, 2.2, 0, coarse};
Point(6) = {29.4, 8.3, 0, coarse};
Point(7) = {4.7, 9.6, 0, 2};
Point(8) = {-4.4, 9.6, 0, 2};
Point(9) = {-12.7, 14.1, 0, 2};
Point(10) = {-12.7, 26.9, 0, coarse};
Point(11) = {wall, 26.9, 0, coarse};
Point(12) = {wall, stop_to, 0, 0.6};
Point(13) = {wall, stop_from, 0, 0.6};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 100};
Line(5) = {last, 5};
Line(6) = {5, 6};
Line(7) = {6, 7};
Line(8) = {7, 8};
Line(9) = {8, 9};
Line(10) = {9, 10};
Line(11) = {10, 11};
Line(12) = {11, 12};
Line(13) = {12, 13};
Line(14) = {13, 1};
Curve Loop(1) = {1:4, 101:last, 5:14};
Plane Surface(1) = {1};

// block with its wall
Point(21) = {-36.8, -24.5, 0, coarse * 1.5};
Point(22) = {42.3, -24.5, 0, coarse * 1.5};
Point(23) = {42.3, 0, 0, coarse};
Point(24) = {foot_1_to, 0, 0, 0.5};
Point(25) = {foot_1_from, 0, 0, 0.5};
Point(26) = {wall, 0, 0, 1};
Point(27) = {wall, stop_from, 0, 0.6};
Point(28) = {wall, stop_to, 0, 0.6};
Point(29) = {wall, 15.2, 0, 1.3};
Point(30) = {-36.8, 15.2, 0, coarse};
Line(21) = {21, 22};
Line(22) = {22, 23};
Line(23) = {23, 300 + n_foot_2};
Line(24) = {300, 24};
Line(25) = {24, 25};
Line(26) = {25, 26};
Line(27) = {26, 27};
Line(28) = {27, 28};
Line(29) = {28, 29};
Line(30) = {29, 30};
Line(31) = {30, 21};
Curve Loop(2) = {21:23, -(300 + n_foot_2):-301, 24:31};
Plane Surface(2) = {2};

Transfinite Curve {1, 25} = n_foot_1 + 1;
Transfinite Curve {13, 28} = n_stop + 1;
Mesh.Algorithm = 6;

Physical Surface("bracket", 1) = {1};
Physical Surface("block", 2) = {2};
Physical Curve("bracket_foot_1", 3) = {1};
Physical Curve("bracket_foot_2", 4) = {101:last};
Physical Curve("bracket_stop", 5) = {13};
Physical Curve("block_foot_1", 6) = {25};
Physical Curve("block_foot_2", 7) = {301:300 + n_foot_2};
Physical Curve("block_wall", 8) = {28};
Physical Curve("bolt_seat", 9) = {8};
Physical Curve("shelf", 10) = {7};
Physical Curve("block_base", 11) = {21};
