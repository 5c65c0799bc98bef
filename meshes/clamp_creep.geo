// SPDX-License-Identifier: BSD-3-Clause
// A quarter of a bolt that clamps two flanges: planes of symmetry are x = 0, y = 0, and z = 0 between the flanges, so that only the
// upper flange is meshed. H20; nodes of bolt and flange do not match under the head.
// Rebuild: gmsh -3 -format msh41 clamp_creep.geo -o clamp_creep.msh

// [mm] x = y = 0 is the axis of the bolt
core = 2.2; // half of the square in the middle of the shank
shank = 5; // radius
hole = 5.5; // radius
head = 8; // radius
outside = 16; // radius of the flange
thickness = 8; // of the flange
head_height = 5;
DefineConstant[n_bolt = 2]; // edges around an eighth of the shank
DefineConstant[n_flange = 3]; // edges around an eighth of the hole
DefineConstant[n_axial = 2]; // edges through the flange
s = Sqrt(0.5);
e = 1e-3;
away = 100; // the flange is drawn that far from the bolt, because gmsh unites what coincides

// the shank: a square in the middle, and a ring around it
Point(1) = {0, 0, 0};
Point(2) = {core, 0, 0};
Point(3) = {0.9 * core, 0.9 * core, 0};
Point(4) = {0, core, 0};
Point(5) = {shank, 0, 0};
Point(6) = {s * shank, s * shank, 0};
Point(7) = {0, shank, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Line(5) = {2, 5};
Line(6) = {3, 6};
Line(7) = {4, 7};
Circle(8) = {5, 1, 6};
Circle(9) = {6, 1, 7};
Curve Loop(1) = {1:4};
Curve Loop(2) = {5, 8, -6, -2};
Curve Loop(3) = {6, 9, -7, -3};
// what makes the head wider
Point(10) = {0, 0, thickness};
Point(11) = {shank, 0, thickness};
Point(12) = {s * shank, s * shank, thickness};
Point(13) = {0, shank, thickness};
Point(14) = {head, 0, thickness};
Point(15) = {s * head, s * head, thickness};
Point(16) = {0, head, thickness};
Line(11) = {11, 14};
Line(12) = {12, 15};
Line(13) = {13, 16};
Circle(14) = {11, 10, 12};
Circle(15) = {12, 10, 13};
Circle(16) = {14, 10, 15};
Circle(17) = {15, 10, 16};
Curve Loop(11) = {11, 16, -12, -14};
Curve Loop(12) = {12, 17, -13, -15};
// the flange: the ring under the head, and the rest
Point(20) = {0, 0, away};
Point(21) = {hole, 0, away};
Point(22) = {s * hole, s * hole, away};
Point(23) = {0, hole, away};
Point(24) = {head, 0, away};
Point(25) = {s * head, s * head, away};
Point(26) = {0, head, away};
Point(27) = {outside, 0, away};
Point(28) = {s * outside, s * outside, away};
Point(29) = {0, outside, away};
Circle(21) = {21, 20, 22};
Circle(22) = {22, 20, 23};
Circle(23) = {24, 20, 25};
Circle(24) = {25, 20, 26};
Circle(25) = {27, 20, 28};
Circle(26) = {28, 20, 29};
Line(27) = {21, 24};
Line(28) = {22, 25};
Line(29) = {23, 26};
Line(30) = {24, 27};
Line(31) = {25, 28};
Line(32) = {26, 29};
Curve Loop(21) = {27, 23, -28, -21};
Curve Loop(22) = {28, 24, -29, -22};
Curve Loop(23) = {30, 25, -31, -23};
Curve Loop(24) = {31, 26, -32, -24};
pieces() = {1:3, 11, 12, 21:24};
For i In {0:#pieces() - 1}
  Plane Surface(pieces(i)) = {pieces(i)};
EndFor
Transfinite Curve {1:4, 8, 9, 14:17} = n_bolt + 1;
Transfinite Curve {5:7} = 1 + 1;
Transfinite Curve {11:13} = 2 + 1;
Transfinite Curve {21:26} = n_flange + 1;
Transfinite Curve {27:29} = 2 + 1;
Transfinite Curve {30:32} = 2 + 1 Using Progression 1.5;
Transfinite Surface {pieces()};
Recombine Surface {pieces()};

Extrude {0, 0, thickness} { Surface{21:24}; Layers{n_axial}; Recombine; }
flange() = Volume{:};
below() = Extrude {0, 0, thickness} { Surface{1:3}; Layers{n_axial}; Recombine; };
Extrude {0, 0, head_height} { Surface{below(0), below(6), below(12), 11, 12}; Layers{2}; Recombine; }
bolt() = Volume{:};
bolt() -= {flange()};
Geometry.AutoCoherence = 0;
Translate {0, 0, -away} { Volume{flange()}; }

// of each body the faces of all its pieces
flange_faces() = Abs(Boundary{ Volume{flange()}; });
bolt_faces() = Abs(Boundary{ Volume{bolt()}; });
x_faces() = Surface In BoundingBox{-e, -e, -e, e, outside + e, thickness + head_height + e};
y_faces() = Surface In BoundingBox{-e, -e, -e, outside + e, e, thickness + head_height + e};
cut() = Surface In BoundingBox{-e, -e, -e, shank + e, shank + e, e};
cut() -= {flange_faces()};
flange_face() = Surface In BoundingBox{-e, -e, -e, outside + e, outside + e, e};
flange_face() -= {bolt_faces()};
under_head() = Surface In BoundingBox{-e, -e, thickness - e, head + e, head + e, thickness + e};
flange_seat() = under_head();
flange_seat() -= {bolt_faces()};
bolt_seat() = under_head();
bolt_seat() -= {flange_faces()};
bolt_seat() -= {Surface In BoundingBox{-e, -e, thickness - e, shank + e, shank + e, thickness + e}};

Physical Volume("bolt", 1) = {bolt()};
Physical Volume("flange", 2) = {flange()};
Physical Surface("x_symmetry", 3) = {x_faces()};
Physical Surface("y_symmetry", 4) = {y_faces()};
Physical Surface("bolt_middle", 5) = {cut()};
Physical Surface("flange_face", 6) = {flange_face()};
Physical Surface("flange_seat", 7) = {flange_seat()};
Physical Surface("bolt_seat", 8) = {bolt_seat()};

Mesh.ElementOrder = 2;
Mesh.SecondOrderIncomplete = 1;
