// SPDX-License-Identifier: BSD-3-Clause
// An unsymmetric saddle on two crowned feet, on a longer block: a section in x and y, drawn out along z; tetrahedra.
// Rebuild: gmsh -3 -format msh41 saddle.geo -o saddle.msh

// [mm] feet in the section: from, step, edges, where the crown touches, radius
foot_from[] = {-15.3, 6.4};
foot_step[] = {1.04, 1.02};
foot_edges[] = {8, 6};
crown[] = {-10.2, 9.1};
R[] = {390, 270};
// [mm] and layers along z: the saddle's two parts; the block is longer by `end`
part[] = {9.7, 15.4};
layers[] = {3, 6};
end = 6.1;
coarse = 9;

// Feet of the saddle (100, 200) and of the block (300, 400), point by point, so that they face each other exactly.
For f In {0:1}
  k = 100 + 100 * f;
  For i In {0:foot_edges[f]}
    x = foot_from[f] + i * foot_step[f];
    Point(k + i) = {x, (x - crown[f])^2 / (2 * R[f]), 0, foot_step[f]};
    Point(k + 200 + i) = {x, 0, 0, foot_step[f]};
  EndFor
  For i In {1:foot_edges[f]}
    Line(k + i) = {k + i - 1, k + i};
    Line(k + 200 + i) = {k + 199 + i, k + 200 + i};
  EndFor
  last[f] = k + foot_edges[f];
  Transfinite Curve {k + 1:last[f], k + 201:last[f] + 200} = 2;
EndFor

// saddle
Point(1) = {-3.4, 2.9, 0, 2};
Point(2) = {3.1, 3.3, 0, 4};
Point(3) = {15.2, 4.4, 0, 4};
Point(4) = {13.8, 9.2, 0, 4};
Point(5) = {4.3, 12.7, 0, 4};
Point(6) = {-5.9, 12.7, 0, 3};
Point(7) = {-17.1, 8.1, 0, 4};
Point(8) = {-17.1, 3.7, 0, 3};
Line(1) = {last[0], 1};
Line(2) = {1, 2};
Line(3) = {2, 200};
Line(4) = {last[1], 3};
Line(5) = {3, 4};
Line(6) = {4, 5};
Line(7) = {5, 6};
Line(8) = {6, 7};
Line(9) = {7, 8};
Line(10) = {8, 100};
Curve Loop(1) = {101:last[0], 1:3, 201:last[1], 4:10};
Plane Surface(1) = {1};

// block, from its foot 1 on
Point(21) = {22.4, 0, 0, coarse};
Point(22) = {22.4, -14.6, 0, coarse * 1.5};
Point(23) = {-25.7, -14.6, 0, coarse * 1.5};
Point(24) = {-25.7, 0, 0, coarse};
Line(20) = {last[0] + 200, 400};
Line(21) = {last[1] + 200, 21};
Line(22) = {21, 22};
Line(23) = {22, 23};
Line(24) = {23, 24};
Line(25) = {24, 300};
Curve Loop(2) = {301:last[0] + 200, 20, 401:last[1] + 200, 21:25};
Plane Surface(2) = {2};

// the sides of each drawn part follow the order of the curves in its loop
top = 1;
For p In {0:1}
  out[] = Extrude {0, 0, part[p]} { Surface{top}; Layers{layers[p]}; };
  top = out[0];
  saddle[] += out[1];
  n = foot_edges[0];
  foot_1[] += out[{2:n + 1}];
  foot_2[] += out[{n + 5:n + foot_edges[1] + 4}];
  n += foot_edges[1] + 4;
  shelf[] += out[n + 3];
  ridge[] += out[n + 4];
  flank[] += out[n + 5];
EndFor

bottom = 2;
steps[] = {-end, part[0], part[1], end};
counts[] = {1, layers[0], layers[1], 1};
For p In {0:3}
  If (p == 1)
    bottom = 2;
  EndIf
  out[] = Extrude {0, 0, steps[p]} { Surface{bottom}; Layers{counts[p]}; };
  bottom = out[0];
  block[] += out[1];
  n = foot_edges[0];
  If (p == 1 || p == 2)
    seat_1[] += out[{2:n + 1}];
    seat_2[] += out[{n + 3:n + foot_edges[1] + 2}];
  EndIf
  base[] += out[n + foot_edges[1] + 5];
EndFor

Physical Volume("saddle", 1) = {saddle[]};
Physical Volume("block", 2) = {block[]};
Physical Surface("saddle_foot_1", 3) = {foot_1[]};
Physical Surface("saddle_foot_2", 4) = {foot_2[]};
Physical Surface("block_foot_1", 5) = {seat_1[]};
Physical Surface("block_foot_2", 6) = {seat_2[]};
Physical Surface("bolt_seat", 7) = {ridge[0]};
Physical Surface("shelf", 8) = {shelf[]};
Physical Surface("flank", 9) = {flank[]};
Physical Surface("base", 10) = {base[]};
// two points on one line along z, to hold the saddle along x and z and about y
end_point() = PointsOf{ Surface{top}; };
Physical Point("pin", 11) = {5};
For i In {0:#end_point() - 1}
  c() = Point{end_point(i)};
  If (Abs(c(0) - 4.3) < 1e-6 && Abs(c(1) - 12.7) < 1e-6)
    Physical Point("pin_far", 12) = {end_point(i)};
  EndIf
EndFor
