// SPDX-License-Identifier: BSD-3-Clause
// The root of a turbine blade in the slot of its disk: a dovetail whose two flanks at 45 degrees carry the pull. Second-order elements,
// Q8 in the blade and T6 in the disk; the nodes of the flanks do not match.
// Rebuild: gmsh -2 -format msh41 dovetail.geo -o dovetail.msh

SetFactory("Built-in");

// [mm] both flanks lie on x + y = seat, and mirrored
seat = 4;
neck = 6; // half width of the blade above its root
root = 12.5; // half width of the root
mouth = 6.8; // half width of the slot above
slot = 13.4; // and below
blade_top = 18;
blade_bottom = -13;
slot_bottom = -14.5;
half_sector = 30;
disk_bottom = -34;
DefineConstant[h_blade = 0.5]; // edges of the flanks
DefineConstant[h_disk = 0.8];
h_far = 3.5;

// A fillet between a wall at x = a and the flank ends t from the corner, t = radius tan(22.5 degrees).
r_neck = 2.5;
r_root = 1.5;
r_mouth = 1.5;
r_slot = 2;
t = Tan(Pi / 8);
q = t / Sqrt(2);

For s In {-1:1:2} // left, right
  k = 100 + 50 * (s + 1);
  // blade
  Point(k + 1) = {s * neck, blade_top, 0, 2};
  Point(k + 2) = {s * neck, seat - neck + r_neck * t, 0, h_blade};
  Point(k + 3) = {s * (neck + r_neck), seat - neck + r_neck * t, 0};
  Point(k + 4) = {s * (neck + r_neck * q), seat - neck - r_neck * q, 0, h_blade};
  Point(k + 5) = {s * (root - r_root * q), seat - root + r_root * q, 0, h_blade};
  Point(k + 6) = {s * (root - r_root), seat - root - r_root * t, 0};
  Point(k + 7) = {s * root, seat - root - r_root * t, 0, h_blade};
  Point(k + 8) = {s * root, blade_bottom, 0, 2};
  Line(k + 1) = {k + 1, k + 2};
  Circle(k + 2) = {k + 2, k + 3, k + 4};
  Line(k + 3) = {k + 4, k + 5};
  Circle(k + 4) = {k + 5, k + 6, k + 7};
  Line(k + 5) = {k + 7, k + 8};
  // disk
  Point(k + 11) = {s * half_sector, 0, 0, h_far};
  Point(k + 12) = {s * mouth, 0, 0, h_disk};
  Point(k + 13) = {s * mouth, seat - mouth + r_mouth * t, 0, h_disk};
  Point(k + 14) = {s * (mouth + r_mouth), seat - mouth + r_mouth * t, 0};
  Point(k + 15) = {s * (mouth + r_mouth * q), seat - mouth - r_mouth * q, 0, h_disk};
  Point(k + 16) = {s * (slot - r_slot * q), seat - slot + r_slot * q, 0, h_disk};
  Point(k + 17) = {s * (slot - r_slot), seat - slot - r_slot * t, 0};
  Point(k + 18) = {s * slot, seat - slot - r_slot * t, 0, h_disk};
  Point(k + 19) = {s * slot, slot_bottom, 0, 1.5};
  Point(k + 20) = {s * half_sector, disk_bottom, 0, h_far};
  Line(k + 11) = {k + 11, k + 12};
  Line(k + 12) = {k + 12, k + 13};
  Circle(k + 13) = {k + 13, k + 14, k + 15};
  Line(k + 14) = {k + 15, k + 16};
  Circle(k + 15) = {k + 16, k + 17, k + 18};
  Line(k + 16) = {k + 18, k + 19};
  Line(k + 17) = {k + 20, k + 11};
EndFor

// left is 100, right 200
Line(301) = {201, 101};
Line(302) = {108, 208};
Curve Loop(1) = {301, 101:105, 302, -205:-201};
Plane Surface(1) = {1};
Line(311) = {119, 219};
Line(312) = {120, 220};
Curve Loop(2) = {111:116, 311, -216:-211, -217, -312, 117};
Plane Surface(2) = {2};

Mesh.Algorithm = 6;
Mesh.RecombinationAlgorithm = 1;
Recombine Surface {1};
Mesh.ElementOrder = 2;
Mesh.SecondOrderIncomplete = 1;

Physical Surface("blade", 1) = {1};
Physical Surface("disk", 2) = {2};
Physical Curve("blade_left", 3) = {103};
Physical Curve("blade_right", 4) = {203};
Physical Curve("disk_left", 5) = {114};
Physical Curve("disk_right", 6) = {214};
Physical Curve("blade_top", 7) = {301};
Physical Curve("blade_side", 8) = {101};
Physical Curve("disk_sides", 9) = {117, 217};
Physical Curve("disk_base", 10) = {312};
