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

enum {
  THRUM_SOLID_NODES_MAX = 20,
  THRUM_SOLID_TETS_MAX = 6,
  THRUM_SOLID_MIDDLE_TETS_MAX = 22 /* of a hexahedron with middle nodes */
};

/* How a solid that is kept strains. Solid-shells have their thickness from the nodes of the first
 * half of their corners to those of the second. */
typedef enum thrum_solid_form {
  THRUM_FORM_TET4,
  THRUM_FORM_TET10,
  THRUM_FORM_WEDGE6,
  THRUM_FORM_WEDGE15,
  THRUM_FORM_HEX8,
  THRUM_FORM_HEX20,
  THRUM_FORM_SHELL6, /* a wedge that is thin */
  THRUM_FORM_SHELL8, /* a hexahedron that is thin */
  THRUM_FORM_MEAN10, /* a tetrahedron of ten nodes whose change of volume is one */
  THRUM_FORMS
} thrum_solid_form;

typedef struct thrum_solid_form_shape {
  const char *name; /* plural, for messages */
  thrum_solid kind;
  int nodes;
} thrum_solid_form_shape;

extern const thrum_solid_form_shape thrum_solid_forms[THRUM_FORMS];

/* The form of a solid that is not thin. */
thrum_solid_form thrum_solid_form_of(thrum_solid kind, bool quadratic);

typedef struct thrum_solid_topology {
  const char *name; /* plural, for messages */
  int corners, edges, faces;
  int edge[12][2]; /* the corners of each; middle node `corners + e` lies on edge e */
  int face[6][4];  /* the corners of each, counterclockwise from outside; -1: a triangle */
} thrum_solid_topology;

extern const thrum_solid_topology thrum_solid_shapes[THRUM_SOLID_KINDS];

/* How many solids there are of each form, such as "100 solid-shell hexahedra", in words. */
typedef struct thrum_solid_words {
  char text[320];
} thrum_solid_words;
thrum_solid_words thrum_solid_count_words(const uint8_t *forms, int64_t count);

/* The least scaled Jacobian at the corners of a solid with these places of all vertices: the volume
 * that the three unit edges at a corner span, over that of the regular element; 1 for a box, 0
 * where it is flat, below 0 inside out. It does not mind how thin an element is. */
double thrum_solid_shape_measure(thrum_solid kind, const double *vertices, const int32_t *nodes);

/* Cuts an element whose corners have these numbers; fills in the corners of its tets, each a place
 * among the element's own, wound as the element is. Returns how many tets there are, at most
 * THRUM_SOLID_TETS_MAX; corners that come twice give tets with a vertex twice. */
int thrum_solid_cut(thrum_solid kind, const int64_t *numbers, int tets[THRUM_SOLID_TETS_MAX][4]);

/* Cuts an element with middle nodes, of which all become corners of tets: a tet at each corner, and
 * what is left by cones from the middle node of the smallest number, by the same rule. `numbers`
 * are those of all nodes. */
int thrum_solid_cut_middles(thrum_solid kind, const int64_t *numbers,
                            int tets[THRUM_SOLID_MIDDLE_TETS_MAX][4]);

/* The node that takes the place of node n where an element is reflected: its top and its base
 * change places, or it goes round the other way where it has no top. */
int thrum_solid_mirrored(thrum_solid kind, int n);

/* The edge between two corners; -1 where there is none. */
int thrum_solid_edge(thrum_solid kind, int from, int to);

/* The face that two corners are a diagonal of; -1: they are one through the element. */
int thrum_solid_diagonal(thrum_solid kind, int from, int to);

/* Is an edge one of a face's, or, where `face` is -1, any edge of the element? */
bool thrum_solid_around(thrum_solid kind, int face, int edge);

#endif
