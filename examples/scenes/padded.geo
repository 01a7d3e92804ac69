// A stiff block on a soft pad, two regions of one mesh: 0.2 m wide, the pad 0.06 m thick below the
// origin, the block 0.12 m above it. The mesh beside it is made by models/generate.sh.
// Lengths in metres, z up.
//
// SPDX-License-Identifier: Apache-2.0
SetFactory("OpenCASCADE");

Box(1) = {-0.1, -0.1, -0.06, 0.2, 0.2, 0.06};
Box(2) = {-0.1, -0.1, 0, 0.2, 0.2, 0.12};
parts() = BooleanFragments { Volume{1}; Delete; }{ Volume{2}; Delete; };

Mesh.MeshSizeMin = 0.05;
Mesh.MeshSizeMax = 0.06;
Mesh.Optimize = 1;

// regions are numbered in the order in which their tetrahedra stand in the file
Physical Volume("pad") = {1};
Physical Volume("block") = {2};
