// A Valentine heart, 1.2 m wide and 1 m high, standing on its tip: two mirrored lofts along x that
// share the oval in the middle plane. Held at the tip, cut flat; loaded at the side of one lobe.
// Lengths in metres, z up.
//
// SPDX-License-Identifier: Apache-2.0
SetFactory("OpenCASCADE");

// Oval in the plane x = side * out: from z = low to z = high, b thick to either side of y = 0. A
// closed cubic B-spline through eight control points, which it would cut short by `shrink`.
shrink = (4 + 2 * Cos(Pi / 4)) / 6;
Macro Section
  ring() = {};
  For k In {-1 : 6}
    point = newp;
    Point(point) = {side * out, b / shrink * Sin(Pi * k / 4),
                    (low + high) / 2 - (high - low) / 2 / shrink * Cos(Pi * k / 4)};
    ring() += point;
  EndFor
  curve = newl;
  BSpline(curve) = {ring(), ring(0)};
  wire = newll;
  Wire(wire) = {curve};
  wires() += wire;
Return

halves() = {};
For side In {-1 : 1 : 2}
  wires() = {};
  out = 0.00; low = 0.00; high = 0.76; b = 0.24; Call Section;
  out = 0.12; low = 0.09; high = 0.92; b = 0.25; Call Section;
  out = 0.26; low = 0.22; high = 1.00; b = 0.25; Call Section;
  out = 0.40; low = 0.36; high = 0.98; b = 0.225; Call Section;
  out = 0.51; low = 0.51; high = 0.90; b = 0.17; Call Section;
  out = 0.58; low = 0.66; high = 0.80; b = 0.08; Call Section;
  part = newv;
  ThruSections(part) = {wires()};
  halves() += part;
EndFor
whole() = BooleanUnion { Volume{halves(0)}; Delete; }{ Volume{halves(1)}; Delete; };

// Cut the tip flat, to stand on.
foot = 0.06;
knife = newv;
Box(knife) = {-1, -1, -1, 2, 2, 1 + foot};
body() = BooleanDifference { Volume{whole()}; Delete; }{ Volume{knife}; Delete; };

Mesh.MeshSizeFromCurvature = 12;
Mesh.MeshSizeMin = 0.07;
Mesh.MeshSizeMax = 0.1;
Mesh.Optimize = 1;
Mesh.OptimizeThreshold = 0.5;

Physical Volume("body") = body();
e = 1e-4;
Physical Surface("fixed") = Surface In BoundingBox {-1, -1, foot - e, 1, 1, foot + e};
lobe() = Surface In BoundingBox {0.58 - 1e-3, -1, 0, 1, 1, 1};
Physical Surface("lobe") = lobe();
Physical Surface("load") = lobe();
