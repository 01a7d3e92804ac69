// An open basket, 0.7 m across and 0.7 m high: a base, ten stakes, two hoops and a handle with a
// grip. Held at its base, loaded at the grip.
// Lengths in metres, z up.
//
// SPDX-License-Identifier: Apache-2.0
SetFactory("OpenCASCADE");

base = 0.22;   // radius of the base
rim = 0.32;    // radius of the rim
height = 0.36; // of the rim
cane = 0.028;  // radius of hoops and handle
stakes = 10;

Cylinder(1) = {0, 0, 0, 0, 0, 0.06, base + 0.05};
parts() = {};

// Stakes, leaning outward from the base to the rim; the handle stands between two of them.
tilt = Atan2(rim - base, height - 0.03);
For k In {0 : stakes - 1}
  part = newv;
  Cylinder(part) = {0, 0, 0, 0, 0, (height - 0.03) / Cos(tilt), 0.023};
  Rotate {{0, 0, 1}, {0, 0, 0}, Pi / 2} { Volume{part}; } // the seam out of the hoops' way
  Rotate {{0, 1, 0}, {0, 0, 0}, tilt} { Volume{part}; }
  Translate {base, 0, 0.03} { Volume{part}; }
  Rotate {{0, 0, 1}, {0, 0, 0}, 2 * Pi * (k + 0.5) / stakes} { Volume{part}; }
  parts() += part;
EndFor

// Hoops: half-way up, and the rim.
part = newv;
Torus(part) = {0, 0, height * 0.55, base + (rim - base) * (height * 0.55 - 0.03) / (height - 0.03), cane};
parts() += part;
part = newv;
Torus(part) = {0, 0, height, rim, 1.15 * cane};
parts() += part;

// Handle: a quarter ring from either side of the rim to the grip.
arm = 0.24;
For s In {0 : 1}
  part = newv;
  Torus(part) = {0, 0, 0, arm, cane, Pi / 2};
  Rotate {{1, 0, 0}, {0, 0, 0}, Pi / 2} { Volume{part}; }
  Translate {rim - arm, 0, height} { Volume{part}; }
  Rotate {{0, 0, 1}, {0, 0, 0}, s * Pi} { Volume{part}; }
  parts() += part;
EndFor
part = newv;
Cylinder(part) = {-(rim - arm), 0, height + arm, 2 * (rim - arm), 0, 0, 1.6 * cane};
parts() += part;

body() = BooleanUnion { Volume{1}; Delete; }{ Volume{parts()}; Delete; };

Mesh.MeshSizeFromCurvature = 5;
Mesh.MeshSizeMin = 0.044;
Mesh.MeshSizeMax = 0.09;
Mesh.Optimize = 1;
Mesh.OptimizeThreshold = 0.5;

Physical Volume("body") = body();
e = 1e-4;
Physical Surface("fixed") = Surface In BoundingBox {-1, -1, -e, 1, 1, e};
grip() = Surface In BoundingBox {-0.1, -0.1, height + arm - 0.1, 0.1, 0.1, 1};
Physical Surface("handle") = grip();
Physical Surface("load") = grip();
