// An arch bridge, 6 m long and 0.8 m wide: a deck on columns on an arch. Held at the feet of the
// arch and at both ends of the deck, loaded on a patch in the middle of the deck.
// Lengths in metres, x along the deck, z up.
//
// SPDX-License-Identifier: Apache-2.0
SetFactory("OpenCASCADE");

span = 2.4;     // half-distance of the feet, inside
rise = 0.82;    // of the arch, inside
rib = 0.18;     // its thickness
width = 0.6;    // of arch and columns
deck = 1.2;     // height of the underside of the deck
slab = 0.18;    // thickness of the deck

inner = (span * span + rise * rise) / (2 * rise);
outer = inner + rib;
low = rise - inner; // the arch is round about (0, 0, low)
foot = Sqrt(outer * outer - low * low);

// Arch: its side view, extruded across.
y = -width / 2;
Point(1) = {0, y, low};
Point(2) = {-span, y, 0};
Point(3) = {0, y, rise};
Point(4) = {span, y, 0};
Point(5) = {foot, y, 0};
Point(6) = {0, y, rise + rib};
Point(7) = {-foot, y, 0};
Circle(1) = {2, 1, 3};
Circle(2) = {3, 1, 4};
Line(3) = {4, 5};
Circle(4) = {5, 1, 6};
Circle(5) = {6, 1, 7};
Line(6) = {7, 2};
Curve Loop(1) = {1, 2, 3, 4, 5, 6};
Plane Surface(1) = {1};
arch() = Extrude {0, width, 0} { Surface{1}; };
parts() = {arch(1)};

// Columns: middle, then pairs; each starts inside the rib.
part = newv;
Box(part) = {-0.2, y, rise + 0.09, 0.4, width, deck + 0.09 - rise - 0.09};
parts() += part;
For s In {-1 : 1 : 2}
  For k In {1 : 2}
    x = 0.96 * k;
    z = Sqrt((outer - rib / 2) * (outer - rib / 2) - x * x) + low;
    part = newv;
    Box(part) = {s * x - 0.11, y, z, 0.22, width, deck + 0.09 - z};
    parts() += part;
  EndFor
EndFor

// Deck, and on it the patch that carries the load.
part = newv;
Box(part) = {-3, -0.4, deck, 6, 0.8, slab};
parts() += part;

whole() = BooleanUnion { Volume{parts(0)}; Delete; }{ Volume{parts({1 : #parts() - 1})}; Delete; };
patch = news;
Rectangle(patch) = {-0.2, -0.2, deck + slab, 0.4, 0.4};
body() = BooleanFragments { Volume{whole()}; Delete; }{ Surface{patch}; Delete; };

Mesh.MeshSizeMin = 0.1;
Mesh.MeshSizeMax = 0.2;
Mesh.Optimize = 1;
Mesh.OptimizeThreshold = 0.5;

e = 1e-4;
all() = Volume In BoundingBox {-4, -4, -4, 4, 4, 4};
Physical Volume("body") = all();
held() = Surface In BoundingBox {-4, -4, -e, 4, 4, e};
held() += Surface In BoundingBox {-3 - e, -4, -e, -3 + e, 4, 4};
held() += Surface In BoundingBox {3 - e, -4, -e, 3 + e, 4, 4};
Physical Surface("fixed") = held();
middle() = Surface In BoundingBox {-0.2 - e, -0.2 - e, deck + slab - e, 0.2 + e, 0.2 + e, 2};
Physical Surface("deck") = middle();
Physical Surface("load") = middle();
