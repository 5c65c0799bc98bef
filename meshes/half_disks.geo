// SPDX-License-Identifier: BSD-3-Clause
// Two half disks that face each other (case a); the upper mesh is the exact mirror of the lower one in y = 0.
// Rebuild: gmsh -2 -format msh41 half_disks.geo -o half_disks.msh

radius = 1.0; // [m]
gap = 0.1; // [m] between the arcs at x = 0
n_arc = 55; // equally spaced nodes on each arc, with its two corners
n_base = 37; // nodes on each flat edge, with the same two corners
// Edge length grows linearly with the distance from the boundary; this rate gives the paper's 339 nodes per half disk with
// gmsh 4.8.4.
growth = 0.1895;

y_base = -gap / 2 - radius; // flat edge of the lower half disk
arc_size = Pi * radius / (n_arc - 1);

// Nodes of the arcs are points: gmsh spaces the nodes of a circle to 1e-8 only, so pairs would not face each other exactly.
For side In {0:1}
  sign = 1 - 2 * side; // lower: 1, upper: -1
  first = 1 + 1000 * side;
  For i In {0:n_arc - 1}
    angle = Pi * i / (n_arc - 1);
    Point(first + i) = {radius * Cos(angle), sign * (y_base + radius * Sin(angle)), 0};
  EndFor
  For i In {0:n_arc - 2}
    Line(first + i) = {first + i, first + i + 1};
  EndFor
  Line(first + n_arc) = {first + n_arc - 1, first};
  Transfinite Curve {first:first + n_arc - 2} = 2;
  Transfinite Curve {first + n_arc} = n_base;
  Curve Loop(1 + side) = {first:first + n_arc - 2, first + n_arc};
  Plane Surface(1 + side) = {1 + side};
EndFor
// Errors only: a gmsh without ANN warns once per curve of a copied surface; the copy is right all the same.
General.Verbosity = 1;
Periodic Surface {2} = {1} Affine {1, 0, 0, 0,  0, -1, 0, 0,  0, 0, 1, 0,  0, 0, 0, 1};
ReverseMesh Surface {2};

Field[1] = MathEval; // distance from the arc of the lower half disk
Field[1].F = Sprintf("%g + %g * (%g - sqrt(x^2 + (y + %g)^2))", arc_size, growth, radius, -y_base);
Field[2] = MathEval; // distance from its flat edge
Field[2].F = Sprintf("%g + %g * (y + %g)", arc_size, growth, -y_base);
Field[3] = Min;
Field[3].FieldsList = {1, 2};
Background Field = 3;
Mesh.CharacteristicLengthExtendFromBoundary = 0;
Mesh.CharacteristicLengthFromPoints = 0;
Mesh.Algorithm = 6; // frontal Delaunay, gmsh's own choice; given here so that no personal setting changes the mesh

Physical Surface("lower", 1) = {1};
Physical Surface("upper", 2) = {2};
Physical Curve("lower_base", 3) = {1 + n_arc};
Physical Curve("upper_base", 4) = {1001 + n_arc};
Physical Curve("lower_arc", 5) = {1:n_arc - 1};
Physical Curve("upper_arc", 6) = {1001:1000 + n_arc - 1};
