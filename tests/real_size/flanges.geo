// SPDX-License-Identifier: BSD-3-Clause
// A quarter of two flanges with necks and the gasket between them, in space. H8 and a few prisms in the flanges, prisms (W6) in the
// gasket; the nodes do not match.
// gmsh -3 -format msh41 flanges.geo -o flanges.msh

SetFactory("OpenCASCADE");
h = DefineNumber[2.2, Name "h"]; // edges in the plane
bore = 40; // [mm] radii
neck = 50;
rim = 92;
center = 72 / Sqrt(2); // of the bolt, along x and y
half = 1.5; // half of the gasket's thickness
plate = 22; // its thickness
tube = 30; // length of the neck above it

For side In {-1:1:2} // lower, upper
  z = side * half;
  k = newreg;
  Disk(k) = {0, 0, z, rim, rim};
  Disk(k + 1) = {0, 0, z, bore, bore};
  Rectangle(k + 2) = {0, 0, z, 100, 100};
  BooleanDifference(k + 3) = { Surface{k}; Delete; }{ Surface{k + 1}; Delete; };
  BooleanIntersection(k + 4) = { Surface{k + 3}; Delete; }{ Surface{k + 2}; Delete; };
  Disk(k + 5) = {center, center, z, 9, 9};
  BooleanDifference(k + 6) = { Surface{k + 4}; Delete; }{ Surface{k + 5}; Delete; };
  Disk(k + 7) = {center, center, z, 16, 16};
  Disk(k + 8) = {0, 0, z, neck, neck};
  BooleanIntersection(k + 9) = { Surface{k + 7}; Delete; }{ Surface{k + 6}; };
  BooleanIntersection(k + 10) = { Surface{k + 8}; Delete; }{ Surface{k + 6}; };
  parts() = BooleanFragments{ Surface{k + 6}; Delete; }{ Surface{k + 9, k + 10}; Delete; };
  MeshSize{ PointsOf{ Surface{parts()}; } } = h;
  Recombine Surface{ parts() };
  Extrude {0, 0, side * plate} { Surface{ parts() }; Layers{8}; Recombine; }
  roof() = Surface In BoundingBox{-1, -1, side * (half + plate) - 0.01, neck + 0.01, neck + 0.01, side * (half + plate) + 0.01};
  Extrude {0, 0, side * tube} { Surface{ roof() }; Layers{10}; Recombine; }
EndFor

Disk(1001) = {0, 0, -half, 60, 60};
Disk(1002) = {0, 0, -half, bore + 2, bore + 2};
Rectangle(1003) = {0, 0, -half, 100, 100};
BooleanDifference(1004) = { Surface{1001}; Delete; }{ Surface{1002}; Delete; };
BooleanIntersection(1005) = { Surface{1004}; Delete; }{ Surface{1003}; Delete; };
MeshSize{ PointsOf{ Surface{1005}; } } = 0.9 * h;
gasket() = Extrude {0, 0, 2 * half} { Surface{1005}; Layers{2}; };

e = 0.01;
far = 200;
top = half + plate;
Physical Volume("lower") = Volume In BoundingBox{-e, -e, -far, far, far, -half + e};
Physical Volume("upper") = Volume In BoundingBox{-e, -e, half - e, far, far, far};
Physical Volume("gasket") = Volume In BoundingBox{-e, -e, -half - e, far, far, half + e};
low() = Surface In BoundingBox{-e, -e, -half - e, far, far, -half + e};
low() -= {1005};
gasket_high() = {gasket(0)};
high() = Surface In BoundingBox{-e, -e, half - e, far, far, half + e};
high() -= gasket_high();
Physical Surface("lower_face") = low();
Physical Surface("gasket_low") = {1005};
Physical Surface("gasket_high") = gasket_high();
Physical Surface("upper_face") = high();
Physical Surface("bores") = Surface In BoundingBox{-e, -e, -far, bore + e, bore + e, far};
seat = 16 + e;
Physical Surface("lower_seat") = Surface In BoundingBox{center - seat, center - seat, -top - e, center + seat, center + seat, -top + e};
Physical Surface("upper_seat") = Surface In BoundingBox{center - seat, center - seat, top - e, center + seat, center + seat, top + e};
Physical Surface("lower_end") = Surface In BoundingBox{-e, -e, -top - tube - e, far, far, -top - tube + e};
Physical Surface("upper_end") = Surface In BoundingBox{-e, -e, top + tube - e, far, far, top + tube + e};
Physical Surface("plane_x") = Surface In BoundingBox{-e, -e, -far, e, far, far};
Physical Surface("plane_y") = Surface In BoundingBox{-e, -e, -far, far, e, far};
