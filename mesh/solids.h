/* Solid elements of meshes: their nodes, edges and faces, and how they are cut into tetrahedra.
 *
 * An element of any kind is cut by cones from its vertex of the smallest number: over each face
 * without that vertex, which is cut by a diagonal from its own smallest vertex where it has four.
 * Faces with the smallest vertex get their diagonal from there too, so the diagonal of a face
 * depends on the numbers of its corners alone, and neighbours agree. Dompierre, Labbé, Vallet,
 * Camarero 1999, How to subdivide pyramids, prisms and hexahedra into tetrahedra, 8th International
 * Meshing Roundtable, 195-204.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_SOLIDS_H
#define THRUM_MESH_SOLIDS_H

#include <stdbool.h>
#include <stdint.h>

/* Nodes stand in the order of Abaqus and VTK, which is the same: corners, then middle nodes. */
typedef enum thrum_solid {
  THRUM_SOLID_TET,
  THRUM_SOLID_PYRAMID,
  THRUM_SOLID_WEDGE,
  THRUM_SOLID_HEXAHEDRON,
  THRUM_SOLID_KINDS
} thrum_solid;

enum { THRUM_SOLID_NODES_MAX = 20, THRUM_SOLID_TETS_MAX = 6 };

typedef struct thrum_solid_shape {
  const char *name; /* plural, for messages */
  int corners, edges, faces;
  int edge[12][2]; /* the corners of each; middle node `corners + e` lies on edge e */
  int face[6][4];  /* the corners of each, counterclockwise from outside; -1: a triangle */
} thrum_solid_shape;

extern const thrum_solid_shape thrum_solid_shapes[THRUM_SOLID_KINDS];

/* Cuts an element whose corners have these numbers; fills in the corners of its tets, each a place
 * among the element's own, wound as the element is. Returns how many tets there are, at most
 * THRUM_SOLID_TETS_MAX; corners that come twice give tets with a vertex twice. */
int thrum_solid_cut(thrum_solid kind, const int64_t *numbers, int tets[THRUM_SOLID_TETS_MAX][4]);

/* The edge between two corners; -1 where there is none. */
int thrum_solid_edge(thrum_solid kind, int from, int to);

/* The face that two corners are a diagonal of; -1: they are one through the element. */
int thrum_solid_diagonal(thrum_solid kind, int from, int to);

/* Is an edge one of a face's, or, where `face` is -1, any edge of the element? */
bool thrum_solid_around(thrum_solid kind, int face, int edge);

#endif
