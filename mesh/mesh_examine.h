/* Measures what a mesh is like: pieces, surface, shape of its tets, and what is probably a mistake.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_MESH_EXAMINE_H
#define THRUM_MESH_MESH_EXAMINE_H

#include "mesh/mesh.h"

enum { THRUM_EXAMINE_BINS = 10, THRUM_EXAMINE_WORST = 5 };

typedef struct thrum_mesh_examined {
  double volume;                 /* [m^3] */
  double mass;                   /* [kg]; 0 without materials */
  double box_min[3], box_max[3]; /* [m] */
  double extent;                 /* longest side of the box [m] */
  double edge_min, edge_max;     /* shortest and longest edge of a tet [m] */
  double poisson_max;            /* largest nu; 0 without materials */

  double ratio_min, ratio_mean;          /* of the mean ratio, see model_quality.h; of solids of the
                                            scaled Jacobian, see solids.h */
  int64_t histogram[THRUM_EXAMINE_BINS]; /* elements with a ratio in [b, b + 1) / 10 */
  int64_t worst[THRUM_EXAMINE_WORST];    /* elements, the worst first; -1: there are fewer */
  double worst_ratio[THRUM_EXAMINE_WORST];

  int64_t pieces;              /* parts that no shared vertex joins */
  int64_t largest_piece;       /* tets of the largest */
  int64_t coincident_vertices; /* at just the place of another one */

  int64_t surface_triangles, surface_edges, surface_vertices;
  int64_t surfaces; /* parts of the surface that no shared edge joins */
  int64_t hinges;   /* edges of the surface with more than two triangles */
  int64_t genus;    /* holes through the body, of all surfaces; -1 where hinges are */
  int64_t interior_vertices;
  int64_t shallow_tets; /* with all four vertices on the surface */
  double cells_across;  /* over the thickness of the thinnest quarter, see mesh_thickness.h */
} thrum_mesh_examined;

/* Examines a clean mesh. Cost: linear in it, and n log n in its surface. */
thrum_status thrum_mesh_examine(const thrum_mesh *mesh, thrum_mesh_examined *examined,
                                thrum_error *error);

#endif
