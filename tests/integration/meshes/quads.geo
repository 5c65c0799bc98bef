// SPDX-License-Identifier: BSD-3-Clause
// A rectangle 2 by 1 of 4 by 2 Q4 in two regions that share the line x = 1. Rebuild: ./make_meshes.sh
Point(1) = {0, 0, 0};
Point(2) = {1, 0, 0};
Point(3) = {2, 0, 0};
Point(4) = {2, 1, 0};
Point(5) = {1, 1, 0};
Point(6) = {0, 1, 0};
Line(1) = {1, 2};
Line(2) = {2, 5};
Line(3) = {5, 6};
Line(4) = {6, 1};
Line(5) = {2, 3};
Line(6) = {3, 4};
Line(7) = {4, 5};
Curve Loop(1) = {1, 2, 3, 4};
Curve Loop(2) = {5, 6, 7, -2};
Plane Surface(1) = {1};
Plane Surface(2) = {2};
Transfinite Curve {1:7} = 3;
Transfinite Surface {1, 2};
Recombine Surface {1, 2};
Physical Surface("left half", 1) = {1};
Physical Surface("right half", 2) = {2};
Physical Surface("all", 3) = {1, 2};
Physical Curve("middle", 1) = {2};
