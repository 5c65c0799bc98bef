// SPDX-License-Identifier: BSD-3-Clause
// Half of a lap joint of two plates and a bolt, behind the plane of symmetry y = 0. The plates touch at z = 0; the thread of the bolt
// sits in the hole of the lower plate, and the hole of the upper one is wider. Each body is drawn in the plane and extruded along z
// (H8); nodes of the bodies do not match.
// Rebuild: gmsh -3 -format msh41 bolted_joint.geo -o bolted_joint.msh

// [mm] x = y = 0 is the axis of the bolt
lap = 10; // half of the length over which the plates lie on each other
reach = 22; // of each plate from the axis to its far end
half_width = 9;
thickness = 5; // of each plate
shank = 3; // radius
hole = 3.5; // radius, in the upper plate
head = 6; // radius
head_height = 4;
DefineConstant[h_lower = 3]; // edges at the far ends and corners
DefineConstant[h_upper = 2.6];
DefineConstant[n_lower = 6]; // edges around half of the hole
DefineConstant[n_upper = 10];
DefineConstant[n_bolt = 8];
e = 1e-3;
away = 100; // bodies are drawn that far from each other, because gmsh unites what coincides

// the lower plate: around its hole up to x = -lap, and the rest
z = -thickness;
Point(1) = {0, 0, z};
Point(2) = {shank, 0, z, 1.6};
Point(3) = {0, shank, z, 1.6};
Point(4) = {-shank, 0, z, 1.6};
Point(5) = {lap, 0, z, h_lower};
Point(6) = {lap, half_width, z, h_lower};
Point(7) = {-lap, half_width, z, h_lower};
Point(8) = {-lap, 0, z, h_lower};
Point(9) = {-reach, half_width, z, h_lower};
Point(10) = {-reach, 0, z, h_lower};
Circle(1) = {2, 1, 3};
Circle(2) = {3, 1, 4};
Line(3) = {4, 8};
Line(4) = {8, 7};
Line(5) = {7, 6};
Line(6) = {6, 5};
Line(7) = {5, 2};
Line(8) = {8, 10};
Line(9) = {10, 9};
Line(10) = {9, 7};
Curve Loop(1) = {1:7};
Curve Loop(2) = {8, 9, 10, -4};
Plane Surface(1) = {1};
Plane Surface(2) = {2};
Transfinite Curve {1, 2} = n_lower / 2 + 1;

// the upper plate: the ring under the head, around it, and the rest
z = away;
Point(21) = {0, 0, z};
Point(22) = {hole, 0, z};
Point(23) = {0, hole, z};
Point(24) = {-hole, 0, z};
Point(25) = {head, 0, z};
Point(26) = {0, head, z};
Point(27) = {-head, 0, z};
Point(28) = {lap, 0, z, h_upper};
Point(29) = {lap, half_width, z, h_upper};
Point(30) = {-lap, half_width, z, h_upper};
Point(31) = {-lap, 0, z, h_upper};
Point(32) = {reach, half_width, z, h_upper};
Point(33) = {reach, 0, z, h_upper};
Circle(21) = {22, 21, 23};
Circle(22) = {23, 21, 24};
Circle(23) = {25, 21, 26};
Circle(24) = {26, 21, 27};
Line(25) = {22, 25};
Line(26) = {23, 26};
Line(27) = {24, 27};
Line(28) = {27, 31};
Line(29) = {31, 30};
Line(30) = {30, 29};
Line(31) = {29, 28};
Line(32) = {28, 25};
Line(33) = {28, 33};
Line(34) = {33, 32};
Line(35) = {32, 29};
Curve Loop(21) = {21, 26, -23, -25};
Curve Loop(22) = {22, 27, -24, -26};
Curve Loop(23) = {23, 24, 28:32};
Curve Loop(24) = {33:35, 31};
For i In {21:24}
  Plane Surface(i) = {i};
EndFor
Transfinite Curve {21:24} = n_upper / 2 + 1;
Transfinite Curve {25:27} = 2;
Transfinite Surface {21, 22};

// the bolt: its shank and the ring that makes the head wider
z = 2 * away;
Point(41) = {0, 0, z};
Point(42) = {shank, 0, z};
Point(43) = {0, shank, z};
Point(44) = {-shank, 0, z};
Circle(41) = {42, 41, 43};
Circle(42) = {43, 41, 44};
Line(43) = {44, 41};
Line(44) = {41, 42};
Curve Loop(41) = {41:44};
Plane Surface(41) = {41};
Transfinite Curve {41, 42} = n_bolt / 2 + 1;
Transfinite Curve {43, 44} = 3;
z = 2 * away + 2 * thickness;
Point(51) = {0, 0, z};
Point(52) = {shank, 0, z};
Point(53) = {0, shank, z};
Point(54) = {-shank, 0, z};
Point(55) = {head, 0, z};
Point(56) = {0, head, z};
Point(57) = {-head, 0, z};
Circle(51) = {52, 51, 53};
Circle(52) = {53, 51, 54};
Circle(53) = {55, 51, 56};
Circle(54) = {56, 51, 57};
Line(55) = {52, 55};
Line(56) = {53, 56};
Line(57) = {54, 57};
Curve Loop(51) = {51, 56, -53, -55};
Curve Loop(52) = {52, 57, -54, -56};
Plane Surface(51) = {51};
Plane Surface(52) = {52};
Transfinite Curve {51:54} = n_bolt / 2 + 1;
Transfinite Curve {55:57} = 3;
Transfinite Surface {51, 52};

Recombine Surface{:};
Extrude {0, 0, thickness} { Surface{1, 2}; Layers{2}; Recombine; }
lower() = Volume{:};
Extrude {0, 0, thickness} { Surface{21:24}; Layers{2}; Recombine; }
upper() = Volume{:};
upper() -= {lower()};
below() = Extrude {0, 0, thickness} { Surface{41}; Layers{2}; Recombine; };
above() = Extrude {0, 0, thickness} { Surface{below(0)}; Layers{2}; Recombine; };
Extrude {0, 0, head_height} { Surface{above(0), 51, 52}; Layers{2}; Recombine; }
bolt() = Volume{:};
bolt() -= {lower(), upper()};
Geometry.AutoCoherence = 0;
Translate {0, 0, -away} { Volume{upper()}; }
Translate {0, 0, -2 * away - thickness} { Volume{bolt()}; }

// of each body the faces of all its pieces
lower_faces() = Abs(Boundary{ Volume{lower()}; });
upper_faces() = Abs(Boundary{ Volume{upper()}; });
bolt_faces() = Abs(Boundary{ Volume{bolt()}; });

lower_end() = Surface In BoundingBox{-reach - e, -e, -thickness - e, -reach + e, half_width + e, e};
upper_end() = Surface In BoundingBox{reach - e, -e, -e, reach + e, half_width + e, thickness + e};
symmetry() = Surface In BoundingBox{-reach - e, -e, -thickness - e, reach + e, e, thickness + head_height + e};
between() = Surface In BoundingBox{-lap - e, -e, -e, lap + e, half_width + e, e};
lower_face() = between();
lower_face() -= {upper_faces(), bolt_faces()};
upper_face() = between();
upper_face() -= {lower_faces(), bolt_faces()};
under_head() = Surface In BoundingBox{-head - e, -e, thickness - e, head + e, head + e, thickness + e};
upper_seat() = under_head();
upper_seat() -= {bolt_faces()};
bolt_seat() = under_head();
bolt_seat() -= {upper_faces()};
bolt_seat() -= {Surface In BoundingBox{-shank - e, -e, thickness - e, shank + e, shank + e, thickness + e}};
inside() = Surface In BoundingBox{-shank - e, -e, -thickness - e, shank + e, shank + e, e};
inside() -= {symmetry()};
inside() -= {Surface In BoundingBox{-shank - e, -e, -e, shank + e, shank + e, e}};
inside() -= {Surface In BoundingBox{-shank - e, -e, -thickness - e, shank + e, shank + e, -thickness + e}};
thread() = inside();
thread() -= {lower_faces()};
lower_hole() = inside();
lower_hole() -= {bolt_faces()};

Physical Volume("lower", 1) = {lower()};
Physical Volume("upper", 2) = {upper()};
Physical Volume("bolt", 3) = {bolt()};
Physical Surface("lower_face", 4) = {lower_face()};
Physical Surface("upper_face", 5) = {upper_face()};
Physical Surface("upper_seat", 6) = {upper_seat()};
Physical Surface("bolt_seat", 7) = {bolt_seat()};
Physical Surface("thread", 8) = {thread()};
Physical Surface("lower_hole", 9) = {lower_hole()};
Physical Surface("lower_end", 10) = {lower_end()};
Physical Surface("upper_end", 11) = {upper_end()};
Physical Surface("symmetry", 12) = {symmetry()};
