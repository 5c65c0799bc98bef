// SPDX-License-Identifier: BSD-3-Clause
// A lug with a bush pressed into its eye and a pin in the bush, in the plane. T6; no nodes match.
// gmsh -2 -format msh41 lug.geo -o lug.msh

SetFactory("OpenCASCADE");
pin = 10; // [mm] radius; bush and eye have the radii that follow
bush = 14;
eye = 28;
h = DefineNumber[0.27, Name "h"]; // edges of the bore of the bush; 1.3 times as long around it

// the eye at the origin, its shank down to y = -90
Disk(1) = {0, 0, 0, eye};
Rectangle(2) = {-22, -90, 0, 44, 90};
BooleanUnion(3) = { Surface{1}; Delete; }{ Surface{2}; Delete; };
Disk(4) = {0, 0, 0, bush};
BooleanDifference(5) = { Surface{3}; Delete; }{ Surface{4}; Delete; };
Disk(6) = {0, 0, 0, bush};
Disk(7) = {0, 0, 0, pin};
BooleanDifference(8) = { Surface{6}; Delete; }{ Surface{7}; Delete; };
Disk(9) = {0, 0, 0, pin};

e = 0.01;
Physical Surface("lug") = {5};
Physical Surface("bush") = {8};
Physical Surface("pin") = {9};
shank() = Curve In BoundingBox{-22 - e, -90 - e, -e, 22 + e, -90 + e, e};
Physical Curve("shank_end") = shank();
pin_face() = Abs(Boundary{ Surface{9}; });
Physical Curve("pin_face") = pin_face();
// both boundaries of the ring and of the eye lie around the origin
bush_sides() = Abs(Boundary{ Surface{8}; });
bush_bore() = {};
bush_outside() = {};
For i In {0:#bush_sides() - 1}
  box() = BoundingBox Curve{ bush_sides(i) };
  If(box(3) < pin + 1)
    bush_bore() += bush_sides(i);
  Else
    bush_outside() += bush_sides(i);
  EndIf
EndFor
eye_sides() = Abs(Boundary{ Surface{5}; });
eye_bore() = {};
For i In {0:#eye_sides() - 1}
  box() = BoundingBox Curve{ eye_sides(i) };
  If(box(3) < bush + 1 && box(1) > -bush - 1)
    eye_bore() += eye_sides(i);
  EndIf
EndFor
Physical Curve("bush_bore") = bush_bore();
Physical Curve("bush_outside") = bush_outside();
Physical Curve("eye_bore") = eye_bore();

// a field for each body, so that no nodes match: growing with the distance from its contacts
Field[1] = MathEval;
Field[1].F = Sprintf("%g + 0.08 * abs(sqrt(x^2 + y^2) - %g)", h, pin);
Field[2] = MathEval;
Field[2].F = Sprintf("%g + 0.08 * abs(sqrt(x^2 + y^2) - %g)", 1.3 * h, bush);
Field[3] = Min;
Field[3].FieldsList = {1, 2};
Field[4] = MathEval;
Field[4].F = Sprintf("%g + 0.08 * abs(sqrt(x^2 + y^2) - %g)", 1.21 * h, pin);
Field[5] = MathEval;
Field[5].F = Sprintf("%g + 0.08 * abs(sqrt(x^2 + y^2) - %g)", 1.63 * h, bush);
Field[6] = Restrict;
Field[6].InField = 3;
Field[6].SurfacesList = {8};
Field[6].CurvesList = {bush_sides()};
Field[7] = Restrict;
Field[7].InField = 4;
Field[7].SurfacesList = {9};
Field[7].CurvesList = {pin_face()};
Field[8] = Restrict;
Field[8].InField = 5;
Field[8].SurfacesList = {5};
Field[8].CurvesList = {eye_sides()};
Field[9] = Min;
Field[9].FieldsList = {6, 7, 8};
Background Field = 9;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Mesh.ElementOrder = 2;
