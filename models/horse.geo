// A standing horse, 2.4 m from muzzle to tail, 1.5 m at the withers, held at its four hooves and
// loaded at the end of its nose. Torso and neck, head, mane, ears, tail and legs are lofts through
// oval sections, joined into one solid.
// Lengths in metres, x forward, y left, z up.
//
// SPDX-License-Identifier: Apache-2.0
SetFactory("OpenCASCADE");

// Oval section about (x, y, z) for a loft that runs in the direction (cos turn, 0, sin turn):
// half-width b along y, half-height c across. A closed cubic B-spline through eight control
// points, which it would cut short by `shrink`; it starts, and the loft has its seam, at the
// bottom (seam = 0) or the top (seam = 4).
seam = 0;
shrink = (4 + 2 * Cos(Pi / 4)) / 6;
Macro Section
  ring() = {};
  For k In {seam - 1 : seam + 6}
    side = b / shrink * Sin(Pi * k / 4);
    up = -c / shrink * Cos(Pi * k / 4);
    point = newp;
    Point(point) = {x - up * Sin(turn), y + side, z + up * Cos(turn)};
    ring() += point;
  EndFor
  curve = newl;
  BSpline(curve) = {ring(), ring(0)};
  wire = newll;
  Wire(wire) = {curve};
  wires() += wire;
Return

// Loft through the sections made since the last one.
Macro Loft
  part = newv;
  ThruSections(part) = {wires()};
  parts() += part;
  wires() = {};
Return

parts() = {};
wires() = {};

// Torso and neck, from the croup to the poll.
y = 0;
turn = 0;
x = -0.91; z = 1.20; b = 0.09; c = 0.11; Call Section;
x = -0.82; z = 1.19; b = 0.20; c = 0.23; Call Section;
x = -0.60; z = 1.18; b = 0.265; c = 0.31; Call Section;
x = -0.30; z = 1.15; b = 0.25; c = 0.285; Call Section;
x = 0.00; z = 1.12; b = 0.265; c = 0.305; Call Section;
x = 0.30; z = 1.13; b = 0.25; c = 0.335; Call Section;
x = 0.52; z = 1.20; b = 0.235; c = 0.33; turn = 0.35; Call Section;
x = 0.69; z = 1.36; b = 0.17; c = 0.27; turn = 0.75; Call Section;
x = 0.82; z = 1.54; b = 0.115; c = 0.20; turn = 0.95; Call Section;
x = 0.93; z = 1.71; b = 0.095; c = 0.15; turn = 0.95; Call Section;
x = 1.03; z = 1.80; b = 0.07; c = 0.08; turn = 0.8; Call Section;
Call Loft;

// Head, from the poll down to the nose; its end face carries the load.
turn = -0.82;
seam = 4;
x = 0.985; z = 1.905; b = 0.035; c = 0.04; Call Section;
x = 1.01; z = 1.85; b = 0.095; c = 0.125; Call Section;
x = 1.08; z = 1.77; b = 0.105; c = 0.150; Call Section;
x = 1.20; z = 1.64; b = 0.075; c = 0.105; Call Section;
x = 1.31; z = 1.525; b = 0.068; c = 0.080; Call Section;
x = 1.375; z = 1.46; b = 0.066; c = 0.072; Call Section;
x = 1.41; z = 1.42; b = 0.045; c = 0.05; Call Section;
Call Loft;
seam = 0;

// Mane, along the crest of the neck.
turn = 0.75;
x = 0.45; z = 1.49; b = 0.04; c = 0.04; Call Section;
x = 0.54; z = 1.59; b = 0.04; c = 0.07; Call Section;
x = 0.66; z = 1.70; b = 0.04; c = 0.09; turn = 0.9; Call Section;
x = 0.79; z = 1.84; b = 0.04; c = 0.09; Call Section;
x = 0.90; z = 1.90; b = 0.038; c = 0.09; turn = 0.5; Call Section;
x = 1.02; z = 1.86; b = 0.025; c = 0.025; turn = -0.5; Call Section;
Call Loft;

// Ears.
turn = Pi / 2;
For s In {-1 : 1 : 2}
  y = 0.055 * s;
  x = 1.00; z = 1.82; b = 0.025; c = 0.04; Call Section;
  y = 0.08 * s;
  x = 0.985; z = 1.95; b = 0.032; c = 0.045; Call Section;
  y = 0.095 * s;
  x = 0.975; z = 2.07; b = 0.016; c = 0.02; Call Section;
  Call Loft;
EndFor

// Tail.
y = 0;
x = -0.80; z = 1.28; b = 0.055; c = 0.055; turn = 2.9; Call Section;
x = -0.95; z = 1.28; b = 0.055; c = 0.055; turn = 3.5; Call Section;
x = -1.04; z = 1.17; b = 0.07; c = 0.07; turn = 4.3; Call Section;
x = -1.07; z = 0.95; b = 0.08; c = 0.09; turn = 4.65; Call Section;
x = -1.07; z = 0.70; b = 0.065; c = 0.07; turn = 4.75; Call Section;
x = -1.06; z = 0.52; b = 0.03; c = 0.03; turn = 4.75; Call Section;
Call Loft;

// Legs, fore and hind, from inside the torso to the hooves on z = 0.
turn = -Pi / 2;
For s In {-1 : 1 : 2}
  y = 0.10 * s;
  x = 0.42; z = 1.15; b = 0.06; c = 0.10; Call Section;
  y = 0.14 * s;
  x = 0.46; z = 0.88; b = 0.075; c = 0.12; Call Section;
  y = 0.15 * s;
  x = 0.50; z = 0.62; b = 0.072; c = 0.08; Call Section;
  x = 0.51; z = 0.48; b = 0.068; c = 0.072; Call Section;
  x = 0.50; z = 0.36; b = 0.058; c = 0.06; Call Section;
  x = 0.49; z = 0.20; b = 0.058; c = 0.06; Call Section;
  x = 0.51; z = 0.10; b = 0.062; c = 0.066; Call Section;
  x = 0.545; z = 0.0; b = 0.085; c = 0.095; Call Section;
  Call Loft;
  x = -0.60; z = 1.16; b = 0.10; c = 0.22; Call Section;
  x = -0.60; z = 0.95; b = 0.105; c = 0.20; Call Section;
  x = -0.65; z = 0.75; b = 0.09; c = 0.13; Call Section;
  x = -0.73; z = 0.56; b = 0.072; c = 0.085; Call Section;
  x = -0.73; z = 0.44; b = 0.062; c = 0.068; Call Section;
  x = -0.70; z = 0.22; b = 0.058; c = 0.06; Call Section;
  x = -0.68; z = 0.10; b = 0.062; c = 0.066; Call Section;
  x = -0.645; z = 0.0; b = 0.085; c = 0.095; Call Section;
  Call Loft;
EndFor

body() = BooleanUnion { Volume{parts(0)}; Delete; }{ Volume{parts({1 : #parts() - 1})}; Delete; };

Mesh.MeshSizeFromCurvature = 6;
Mesh.MeshSizeMin = 0.075;
Mesh.MeshSizeMax = 0.14;
Mesh.Optimize = 1;
Mesh.OptimizeThreshold = 0.5;

Physical Volume("body") = body();
e = 1e-4;
Physical Surface("fixed") = Surface In BoundingBox {-2, -1, -e, 2, 1, e};
nose() = Surface In BoundingBox {1.3, -0.1, 1.3, 1.5, 0.1, 1.5};
Physical Surface("nose") = nose();
Physical Surface("load") = nose();
