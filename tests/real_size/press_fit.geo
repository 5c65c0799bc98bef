// SPDX-License-Identifier: BSD-3-Clause
// Half of a hub on a shaft that stands out of it, in space. T10; the nodes do not match.
// gmsh -3 -format msh41 press_fit.geo -o press_fit.msh

SetFactory("OpenCASCADE");
radius = 20; // [mm] of the shaft, along z
h = DefineNumber[4.9, Name "h"]; // edges of the bore

Cylinder(1) = {0, 0, -35, 0, 0, 110, radius, Pi};
Cylinder(2) = {0, 0, 0, 0, 0, 36, 42, Pi};
Cylinder(3) = {0, 0, 0, 0, 0, 36, radius, Pi};
BooleanDifference(4) = { Volume{2}; Delete; }{ Volume{3}; Delete; };

e = 0.01;
Physical Volume("shaft") = {1};
Physical Volume("hub") = {4};
Physical Surface("symmetry") = Surface In BoundingBox{-50, -e, -50, 50, e, 100};
Physical Surface("clamped_end") = Surface In BoundingBox{-50, -e, -35 - e, 50, 50, -35 + e};
Physical Surface("free_end") = Surface In BoundingBox{-50, -e, 75 - e, 50, 50, 75 + e};
Physical Surface("hub_back") = Surface In BoundingBox{-50, -e, -e, 50, 50, e};
hub() = Abs(Boundary{ Volume{4}; });
hub_edges() = Abs(Boundary{ Surface{hub()}; });
shaft() = Abs(Boundary{ Volume{1}; });
shaft_edges() = Abs(Boundary{ Surface{shaft()}; });
For i In {0:#hub() - 1}
  box() = BoundingBox Surface{ hub(i) };
  If(box(5) - box(2) > 35 && box(4) > 1 && box(3) < radius + 1)
    Physical Surface("bore") = {hub(i)};
  EndIf
EndFor
For i In {0:#shaft() - 1}
  box() = BoundingBox Surface{ shaft(i) };
  If(box(5) - box(2) > 100 && box(4) > 1)
    Physical Surface("shaft_side") = {shaft(i)};
  EndIf
EndFor

// finer where the hub ends, with other sizes in each body
Field[1] = MathEval;
Field[1].F = Sprintf("min(%g, 0.55 * %g + 0.10 * min(abs(z), abs(z - 36))) + 0.045 * abs(sqrt(x^2 + y^2) - %g)", h, h, radius);
Field[2] = MathEval;
Field[2].F = Sprintf("1.15 * min(%g + 0.06 * max(0, max(-z, z - 36)), 0.55 * %g + 0.10 * min(abs(z), abs(z - 36))) + 0.045 * abs(sqrt(x^2 + y^2) - %g)", h, h, radius);
Field[3] = Restrict;
Field[3].InField = 1;
Field[3].VolumesList = {4};
Field[3].SurfacesList = {hub()};
Field[3].CurvesList = {hub_edges()};
Field[4] = Restrict;
Field[4].InField = 2;
Field[4].VolumesList = {1};
Field[4].SurfacesList = {shaft()};
Field[4].CurvesList = {shaft_edges()};
Field[5] = Min;
Field[5].FieldsList = {3, 4};
Background Field = 5;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Mesh.ElementOrder = 2;
Mesh.HighOrderOptimize = 1;
