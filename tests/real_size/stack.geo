// SPDX-License-Identifier: BSD-3-Clause
// Three blocks, one on another, in space. T10; no nodes match.
// gmsh -3 -format msh41 stack.geo -o stack.msh

SetFactory("OpenCASCADE");
h = DefineNumber[1.75, Name "h"]; // [mm] edges
Box(1) = {0, 0, 0, 28, 24, 13};
Box(2) = {0, 0, 13, 28, 24, 12};
Box(3) = {0, 0, 25, 28, 24, 14};

Physical Volume("base") = {1};
Physical Volume("middle") = {2};
Physical Volume("head") = {3};
Physical Surface("floor") = {5};
Physical Surface("base_top") = {6};
Physical Surface("middle_bottom") = {11};
Physical Surface("middle_top") = {12};
Physical Surface("head_bottom") = {17};
Physical Surface("head_top") = {18};
Physical Surface("sides") = {1, 7, 13};
Physical Surface("fronts") = {3, 9, 15};

Mesh.MeshSizeMin = h;
Mesh.MeshSizeMax = h;
Mesh.ElementOrder = 2;
