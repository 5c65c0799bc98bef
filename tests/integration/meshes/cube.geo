// SPDX-License-Identifier: BSD-3-Clause
// A unit cube of T4, which a plane model must refuse. Rebuild: ./make_meshes.sh
Point(1) = {0, 0, 0, 1};
Extrude {1, 0, 0} { Point{1}; }
Extrude {0, 1, 0} { Curve{1}; }
Extrude {0, 0, 1} { Surface{5}; }
Mesh.CharacteristicLengthMin = 1;
Physical Volume("lower", 1) = {1};
Physical Surface("bottom", 2) = {5};
