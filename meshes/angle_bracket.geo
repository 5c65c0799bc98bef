// SPDX-License-Identifier: BSD-3-Clause
// Half of an angle bracket whose foot a bolt presses on a plate; y = 0 is a plane of symmetry. Second-order tetrahedra (T10); the
// nodes of the foot and of the plate do not match.
// Rebuild: gmsh -3 -format msh41 angle_bracket.geo -o angle_bracket.msh

SetFactory("OpenCASCADE");

// [mm] the foot lies on z = 0
length = 40;
half_width = 12;
foot = 8; // thickness
wall = 8;
height = 34;
bolt = 25; // x of its axis
hole = 5; // radius
seat = 9; // outer radius of the bolt's seat, a boss of 1 mm
fillet = 5;
plate = 9; // thickness
DefineConstant[h_foot = 4]; // edges
DefineConstant[h_plate = 5.5];
h_far = 8;
e = 1e-3;

Box(1) = {0, 0, 0, length, half_width, foot};
Box(2) = {0, 0, 0, wall, half_width, height};
Cylinder(3) = {bolt, 0, 0, 0, 0, foot + 1, seat, Pi};
solid() = BooleanUnion{ Volume{1}; Delete; }{ Volume{2, 3}; Delete; };
corner() = Curve In BoundingBox{wall - e, -e, foot - e, wall + e, half_width + e, foot + e};
round() = Fillet{solid(0)}{corner(0)}{fillet};
Cylinder(15) = {bolt, 0, -1, 0, 0, foot + 3, hole, Pi};
bracket() = BooleanDifference{ Volume{round(0)}; Delete; }{ Volume{15}; Delete; };
Box(17) = {-8, 0, -plate, length + 16, half_width + 7, plate};
Cylinder(18) = {bolt, 0, -plate - 1, 0, 0, plate + 2, hole, Pi};
plates() = BooleanDifference{ Volume{17}; Delete; }{ Volume{18}; Delete; };

foot_face() = Surface In BoundingBox{-e, -e, -e, length + e, half_width + e, e};
plate_face() = Surface In BoundingBox{-8 - e, -e, -e, length + 8 + e, half_width + 7 + e, e};
plate_face() -= {foot_face()};
bolt_seat() = Surface In BoundingBox{bolt - seat - e, -e, foot + 1 - e, bolt + seat + e, seat + e, foot + 1 + e};
wall_top() = Surface In BoundingBox{-e, -e, height - e, wall + e, half_width + e, height + e};
base() = Surface In BoundingBox{-8 - e, -e, -plate - e, length + 8 + e, half_width + 7 + e, -plate + e};
symmetry() = Surface In BoundingBox{-8 - e, -e, -plate - e, length + 8 + e, e, height + e};
pin() = Point In BoundingBox{-e, -e, -e, e, e, e};

Physical Volume("bracket", 1) = {bracket()};
Physical Volume("plate", 2) = {plates()};
Physical Surface("foot_face", 3) = {foot_face()};
Physical Surface("plate_face", 4) = {plate_face()};
Physical Surface("bolt_seat", 5) = {bolt_seat()};
Physical Surface("wall_top", 6) = {wall_top()};
Physical Surface("base", 7) = {base()};
Physical Surface("symmetry", 8) = {symmetry()};
Physical Point("pin", 9) = {pin()};

// finest at the foot, coarser away from it and in the plate
Characteristic Length{ PointsOf{ Volume{bracket(0), plates(0)}; } } = h_far;
Characteristic Length{ PointsOf{ Volume{plates(0)}; } } = h_plate;
Characteristic Length{ PointsOf{ Surface{foot_face()}; } } = h_foot;
Characteristic Length{ PointsOf{ Surface{base()}; } } = h_far;
Mesh.CharacteristicLengthFromCurvature = 1; // or arcs fold the cells beside them
Mesh.MinimumElementsPerTwoPi = 16;
Mesh.Algorithm3D = 1;
Mesh.ElementOrder = 2;
Mesh.SecondOrderIncomplete = 1;
