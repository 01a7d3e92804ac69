/* The tetrahedron that a point lies in, or the one nearest to it, by a tree of boxes.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_TET_TREE_H
#define THRUM_MESH_TET_TREE_H

#include <stdint.h>

#include "thrum/status.h"

typedef struct thrum_tet_tree thrum_tet_tree;

/* Makes a tree of tetrahedra with positive volume; vertices (x 3) and tets (tet_count x 4, 1 to
 * 2^31 - 1) are the caller's and must outlive the tree. Cost: n log n, about 60 bytes a
 * tetrahedron. */
thrum_status thrum_tet_tree_make(const double *vertices, const int32_t *tets, int64_t tet_count,
                                 thrum_tet_tree **tree, thrum_error *error);
void thrum_tet_tree_free(thrum_tet_tree *tree); /* NULL is fine */

typedef struct thrum_tet_place {
  int32_t tet;
  double weights[4]; /* barycentric coordinates of the point in it, sum 1; negative: outside */
  double distance;   /* to it [m]; 0 inside */
} thrum_tet_place;

/* Where a finite point is. Of tetrahedra that are equally near, as at a corner of the surface, the
 * one whose weights are least negative: where least is extrapolated. At just a corner its weights
 * are just 0 and 1. Any thread. Cost: about log n. */
thrum_tet_place thrum_tet_tree_find(const thrum_tet_tree *tree, const double point[3]);

#endif
