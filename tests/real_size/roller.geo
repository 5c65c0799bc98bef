// SPDX-License-Identifier: BSD-3-Clause
// A rail on its bed, in the plane; the roller that runs along it is an obstacle of the deck. T6; the nodes do not match.
// gmsh -2 -format msh41 roller.geo -o roller.msh

SetFactory("OpenCASCADE");
half = 120; // [mm] half of the rail's length
h = DefineNumber[0.8, Name "h"]; // edges of the rail's top

Rectangle(1) = {-half, 0, 0, 2 * half, 30};
Rectangle(2) = {-half - 40, -60, 0, 2 * half + 80, 60};
// pockets leave ribs under the top
Rectangle(3) = {-half + 12, 7, 0, half - 30, 15};
Rectangle(4) = {18, 7, 0, half - 30, 15};
BooleanDifference(5) = { Surface{1}; Delete; }{ Surface{3, 4}; Delete; };

e = 0.01;
Physical Surface("rail") = {5};
Physical Surface("bed") = {2};
Physical Curve("rail_top") = Curve In BoundingBox{-half - e, 30 - e, -e, half + e, 30 + e, e};
foot() = Curve In BoundingBox{-half - e, -e, -e, half + e, e, e};
Physical Curve("rail_foot") = foot();
Physical Point("rail_corner") = Point In BoundingBox{-half - e, -e, -e, -half + e, e, e};
bed_top() = Curve In BoundingBox{-half - 40 - e, -e, -e, half + 40 + e, e, e};
bed_top() -= foot();
Physical Curve("bed_top") = bed_top();
Physical Curve("bed_bottom") = Curve In BoundingBox{-half - 40 - e, -60 - e, -e, half + 40 + e, -60 + e, e};

Field[1] = MathEval;
Field[1].F = Sprintf("%g + 0.03 * abs(y - 30)", h);
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Mesh.ElementOrder = 2;
