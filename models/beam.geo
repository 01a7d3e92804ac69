// Cantilever beam, 1 m x 0.15 m x 0.15 m, clamped at x = 0 and loaded at its free end.
// A structured mesh: 20 x 3 x 3 cells of six tetrahedra, the beam of the built-in generator
// beam:20x3x3@1x0.15x0.15 with the diagonals as Gmsh lays them.
// Lengths in metres, z up.
//
// SPDX-License-Identifier: Apache-2.0
SetFactory("OpenCASCADE");

length = 1.0;
side = 0.15;
Box(1) = {0, -side / 2, -side / 2, length, side, side};

// Structured: 20 cells along x, 3 across.
Transfinite Curve {:} = 4;
e = 1e-6;
along() = {};
For c In {1 : 12}
  box() = BoundingBox Curve {c};
  If (box(3) - box(0) > length / 2)
    Transfinite Curve {c} = 21;
  EndIf
EndFor
Transfinite Surface {:};
Transfinite Volume {:};

Physical Volume("body") = {1};
Physical Surface("fixed") = Surface In BoundingBox {-e, -side, -side, e, side, side};
tip() = Surface In BoundingBox {length - e, -side, -side, length + e, side, side};
Physical Surface("tip") = tip();
Physical Surface("load") = tip();
