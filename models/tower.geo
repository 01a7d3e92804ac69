// A lattice tower, 3 m tall on a base of 1.1 m: four tapering legs through two platforms to
// a gallery, and a mast on top. Held at its four feet, loaded at the tip of the mast.
// Lengths in metres, z up.
//
// SPDX-License-Identifier: Apache-2.0
SetFactory("OpenCASCADE");

// Square bar between two horizontal squares: side w about (x, y, z), w1 about (x1, y1, z1).
Macro Bar
  corner = newp;
  For k In {0 : 1}
    px = x + k * (x1 - x); py = y + k * (y1 - y); pz = z + k * (z1 - z); h = (w + k * (w1 - w)) / 2;
    Point(corner + 4 * k) = {px - h, py - h, pz};
    Point(corner + 4 * k + 1) = {px + h, py - h, pz};
    Point(corner + 4 * k + 2) = {px + h, py + h, pz};
    Point(corner + 4 * k + 3) = {px - h, py + h, pz};
    line = newl;
    For j In {0 : 3}
      Line(line + j) = {corner + 4 * k + j, corner + 4 * k + (j + 1) % 4};
    EndFor
    loop~{k} = newll;
    Wire(loop~{k}) = {line, line + 1, line + 2, line + 3};
  EndFor
  part = newv;
  Ruled ThruSections(part) = {loop_0, loop_1};
  parts() += part;
Return

// Half-distance of the legs from the axis at the levels of the feet, platforms and neck.
level() = {0, 0.55, 0.75, 1.35, 1.47, 2.40};
reach() = {0.46, 0.34, 0.305, 0.205, 0.185, 0.080};
thick() = {0.16, 0.14, 0.135, 0.12, 0.115, 0.09};

parts() = {};

// Legs.
For i In {0 : 4}
  If (i % 2 == 0)
  For sx In {-1 : 1 : 2}
    For sy In {-1 : 1 : 2}
      x = sx * reach(i); y = sy * reach(i); z = level(i); w = thick(i);
      x1 = sx * reach(i + 1); y1 = sy * reach(i + 1); z1 = level(i + 1); w1 = thick(i + 1);
      Call Bar;
    EndFor
  EndFor
  EndIf
EndFor

// Platforms, wider than the legs they rest on.
For i In {1 : 3 : 2}
  h = reach(i) + thick(i) / 2 + 0.05;
  part = newv;
  Box(part) = {-h, -h, level(i), 2 * h, 2 * h, level(i + 1) - level(i)};
  parts() += part;
EndFor

// Gallery and mast, whose end face carries the load.
part = newv;
Box(part) = {-0.20, -0.20, 2.30, 0.40, 0.40, 0.12};
parts() += part;
x = 0; y = 0; z = 2.42; w = 0.18; x1 = 0; y1 = 0; z1 = 3.0; w1 = 0.08; Call Bar;

body() = BooleanUnion { Volume{parts(0)}; Delete; }{ Volume{parts({1 : #parts() - 1})}; Delete; };

Mesh.MeshSizeMin = 0.06;
Mesh.MeshSizeMax = 0.12;
Mesh.Algorithm = 5;
Mesh.Optimize = 1;
Mesh.OptimizeThreshold = 0.5;

Physical Volume("body") = body();
e = 1e-4;
Physical Surface("fixed") = Surface In BoundingBox {-2, -2, -e, 2, 2, e};
tip() = Surface In BoundingBox {-2, -2, 3 - e, 2, 2, 3 + e};
Physical Surface("tip") = tip();
Physical Surface("load") = tip();
