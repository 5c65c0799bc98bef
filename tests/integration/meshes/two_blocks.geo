// SPDX-License-Identifier: BSD-3-Clause
// Two unit blocks of T3, one above the other with a small gap; facing nodes at the same x. Rebuild: ./make_meshes.sh

gap = 0.01; // [m]
n_face = 5; // nodes on each side of each block

For side In {0:1}
  first = 1 + 10 * side;
  y = side * (1 + gap);
  Point(first) = {0, y, 0};
  Point(first + 1) = {1, y, 0};
  Point(first + 2) = {1, y + 1, 0};
  Point(first + 3) = {0, y + 1, 0};
  Line(first) = {first, first + 1};
  Line(first + 1) = {first + 1, first + 2};
  Line(first + 2) = {first + 3, first + 2};
  Line(first + 3) = {first, first + 3};
  Curve Loop(first) = {first, first + 1, -(first + 2), -(first + 3)};
  Plane Surface(first) = {first};
  Transfinite Curve {first:first + 3} = n_face;
EndFor
Mesh.CharacteristicLengthFromPoints = 0;
Mesh.Algorithm = 5;

Physical Surface("lower", 1) = {1};
Physical Surface("upper", 2) = {11};
Physical Curve("bottom", 3) = {1};
Physical Curve("top", 4) = {13};
Physical Curve("lower_face", 5) = {3};
Physical Curve("upper_face", 6) = {11};
Physical Curve("left sides", 7) = {4, 14};
Physical Curve("faces", 10) = {3, 11}; // the same facets once more
Physical Point("bottom_left", 8) = {1};
Physical Point("top_left", 9) = {14};
