/* The memory of a skin, private to the runtime: one header, then arrays at offsets that follow from
 * the sizes in the header; no pointer is stored (thrum/contact_pairs.h).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_CONTACT_CONTACT_SKIN_H
#define THRUM_RUNTIME_CONTACT_CONTACT_SKIN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "core/base/vec3.h"
#include "thrum/contact_pairs.h"

#define THRUM_SKIN_LEAF 4 /* triangles of a leaf, at most */

/* A node of the tree: a sphere about its triangles, which moves with the mean of their vertices'
 * rows of U. Inner nodes have two children, leaves a few triangles. */
typedef struct thrum_skin_node {
  int32_t first, count; /* triangles, in the order of the skin */
  int32_t left, right;  /* -1: a leaf */
  double middle[3];     /* at rest [m] */
  double radius;        /* at rest [m] */
} thrum_skin_node;

/* An edge: its two vertices, and the third vertices of its triangles, -1 where there is none. */
typedef struct thrum_skin_edge {
  int32_t ends[2], opposite[2];
} thrum_skin_edge;

/* A triangle: its vertices and edges, and a bit for each of them that it has to try: three for
 * vertices, three for edges, so that each is tried by one triangle alone. Three more are for edges
 * that lie inside a flat face at rest. */
typedef struct thrum_skin_triangle {
  int32_t corners[3], edges[3];
  int32_t tried;
} thrum_skin_triangle;

#define THRUM_SKIN_FLAT 0.01    /* largest angle of two faces that count as one flat face [rad] */
#define THRUM_SKIN_FLATTER 0.25 /* of that angle: flat at rest, or so little bent since */

/* The first of the bits of edges, and of those of edges that are in a flat face at rest. */
enum { THRUM_SKIN_EDGE = 8, THRUM_SKIN_IN_FACE = 64 };

struct thrum_skin {
  uint64_t magic;
  uint64_t bytes;
  int64_t vertex_count, triangle_count, node_count;
  int64_t edge_count; /* in use; there is room for three a triangle */
  int64_t rank;
  int64_t own_known; /* 1: thrum_skin_prepare_own has filled own_gaps */
  uint64_t seal;     /* tells it from other skins: a checksum of what init has made */
  double diagonal;   /* of the box at rest [m] */
  double half[3];    /* how far any vertex is from the middle of the first node at rest [m] */
  double young;      /* largest Young's modulus of the model [Pa] */
};

/* X(type, name, count) */
#define THRUM_SKIN_ARRAYS(X)                                                                       \
  X(double, rest, vertex_count * 3)                 /* [m] */                                      \
  X(double, rows, vertex_count * 3 * rank)          /* of U */                                     \
  X(double, areas, vertex_count)                    /* a third of the triangles around [m^2] */    \
  X(thrum_skin_triangle, triangles, triangle_count) /* in the order of the tree */                 \
  X(thrum_skin_edge, edges, triangle_count * 3)                                                    \
  X(thrum_skin_node, nodes, node_count)                                                            \
  X(double, node_rows, node_count * 3 * rank) /* mean of the rows of U */                          \
  X(double, spreads, node_count *rank)        /* largest difference from it, by column */          \
  X(double, own_gaps, node_count) /* least distance at rest to what shares no vertex [m] */        \
  X(double, extents, rank)        /* largest displacement under a unit of q */                     \
  X(double, bends, rank) /* how far a unit of q turns flat faces against each other [rad/m] */     \
  X(double, tilts, rank) /* how far it turns or stretches a face at most [1/m] */                  \
  X(int32_t, ring_begins, vertex_count + 1) /* of each vertex among those below */                 \
  X(int32_t, rings, triangle_count * 6)     /* vertices that an edge joins to each */              \
  X(int32_t, heads, vertex_count)           /* lists of edges while the skin is made */            \
  X(int32_t, nexts, triangle_count * 3)

typedef struct thrum_skin_view {
#define X(type, name, count) type *name;
  THRUM_SKIN_ARRAYS(X)
#undef X
} thrum_skin_view;

/* Are the faces of the edge between two points, with these third points, one flat face: is the
 * angle between them below `angle` [rad]? across: their normals, of any length. |a + b| < f of two
 * unit vectors, where a product is below -1 + f^2/2; false of NaN. */
static inline bool thrum_faces_are_flat(const double first[3], const double second[3],
                                        const double *const thirds[2], double angle,
                                        double across[2][3]) {
  double along[3], squares[2];
  thrum_subtract3(second, first, along);
  for (int n = 0; n < 2; n++) {
    double way[3];
    thrum_subtract3(thirds[n], first, way);
    thrum_cross3(along, way, across[n]);
    squares[n] = thrum_dot3(across[n], across[n]);
  }
  const double both = squares[0] * squares[1], cosine = -thrum_dot3(across[0], across[1]);
  const double least = 1.0 - 0.5 * angle * angle;
  return cosine > 0.0 && cosine * cosine > least * least * both;
}

/* Pointers into the block. */
thrum_skin_view thrum_skin_view_of(const thrum_skin *skin);

#endif
