// SPDX-License-Identifier: BSD-3-Clause
// Section of a shaft in a hub, x the radius and y the axis; they touch at the radius of 10 mm. Q8, whose nodes do not match.
// Rebuild: gmsh -2 -format msh41 press_fit_pull.geo -o press_fit_pull.msh

radius = 10; // [mm] of the shaft and of the bore
outside = 25; // radius of the hub
seat = 13; // inner radius of the ring on which the puller rests
length = 30; // of the hub, and of the shaft inside of it
beyond = 10; // length of the shaft outside of the hub
DefineConstant[n_shaft = 24]; // edges of the shaft inside of the hub
DefineConstant[n_hub = 30];

Point(1) = {0, 0, 0};
Point(2) = {radius, 0, 0};
Point(3) = {radius, length, 0};
Point(4) = {radius, length + beyond, 0};
Point(5) = {0, length + beyond, 0};
Point(6) = {0, length, 0};
Point(11) = {radius, 0, 0};
Point(12) = {outside, 0, 0};
Point(13) = {outside, length, 0};
Point(14) = {radius, length, 0};
Point(15) = {seat, length, 0};
Point(16) = {seat, 0, 0};

Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 5};
Line(5) = {5, 6};
Line(6) = {6, 1};
Line(7) = {3, 6};
Line(11) = {16, 12};
Line(12) = {12, 13};
Line(13) = {13, 15};
Line(14) = {14, 11};
Line(15) = {15, 14};
Line(16) = {16, 15};
Line(17) = {11, 16};

Curve Loop(1) = {1, 2, 7, 6};
Curve Loop(2) = {3, 4, 5, -7};
Curve Loop(3) = {11, 12, 13, -16};
Curve Loop(4) = {17, 16, 15, 14};
For i In {1:4}
  Plane Surface(i) = {i};
EndFor
// cells are smaller beside the contact and towards the ends of the hub
Transfinite Curve {1, -7, -4} = 8 + 1 Using Progression 0.9;
Transfinite Curve {2, -6} = n_shaft + 1 Using Bump 0.3;
Transfinite Curve {3, -5} = 8 + 1 Using Progression 1.2;
Transfinite Curve {17, -15} = 3 + 1;
Transfinite Curve {11, -13} = 6 + 1 Using Progression 1.2;
Transfinite Curve {12, 14, 16} = n_hub + 1 Using Bump 0.3;
Transfinite Surface {1:4};
Recombine Surface {1:4};
Mesh.ElementOrder = 2;
Mesh.SecondOrderIncomplete = 1;

Physical Surface("shaft", 1) = {1, 2};
Physical Surface("hub", 2) = {3, 4};
Physical Curve("axis", 3) = {5, 6};
Physical Curve("shaft_end", 4) = {4};
Physical Curve("shaft_face", 5) = {2};
Physical Curve("hub_bore", 6) = {14};
Physical Curve("hub_seat", 7) = {13};
