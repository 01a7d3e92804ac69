/* Is a triangle surface one that a body can be meshed in: closed, every edge shared by two
 * triangles that go round the same way?
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_SURFACE_CHECK_H
#define THRUM_MESH_SURFACE_CHECK_H

#include "mesh/surface_mesh.h"

/* A kind of fault: how often, and the first triangle and edge where it is. */
typedef struct thrum_surface_fault {
  int64_t count;
  int64_t triangle; /* 0-based; -1: none */
  int32_t edge[2];  /* vertices; of triangles, two of their corners */
} thrum_surface_fault;

typedef struct thrum_surface_checked {
  thrum_surface_fault flat;      /* triangles with a corner twice, or without area */
  thrum_surface_fault twice;     /* triangles of the same three corners as another */
  thrum_surface_fault open;      /* edges of one triangle */
  thrum_surface_fault crowded;   /* edges of three or more */
  thrum_surface_fault turned;    /* edges whose two triangles go round opposite ways */
  int64_t shells;                /* parts that no shared edge joins */
  double volume;                 /* enclosed, of the winding as it is [m^3]; negative: inside out */
  double edge_mean;              /* [m] */
  double box_min[3], box_max[3]; /* of the corners [m] */
} thrum_surface_checked;

/* Looks at a surface. Cost: n log n. */
thrum_status thrum_surface_check(const thrum_surface_mesh *surface, thrum_surface_checked *checked,
                                 thrum_error *error);

/* Has a triangle a corner twice, or no area beside its longest side? */
bool thrum_surface_is_flat(const thrum_surface_mesh *surface, int64_t triangle);

/* THRUM_OK when a body can be meshed in it; else the worst fault in one line, `path` with its line,
 * how often, and where: THRUM_BAD_VALUE. Turned triangles are no fault here: meshers do not mind.
 */
thrum_status thrum_surface_meshable(const thrum_surface_mesh *surface,
                                    const thrum_surface_checked *checked, const char *path,
                                    thrum_error *error);

/* Refuses a fault in such a line: what it is, how often, and where the first one is. */
thrum_status thrum_surface_refuse(const thrum_surface_mesh *surface,
                                  const thrum_surface_fault *fault, const char *path,
                                  const char *what, thrum_error *error);

/* A point inside each cavity: each shell that encloses a volume of the other sign than all
 * together, as its triangles go round the other way. *points: *count x 3, malloc'ed. Of a surface
 * without faults whose triangles are not turned. */
thrum_status thrum_surface_cavities(const thrum_surface_mesh *surface, double **points,
                                    int64_t *count, thrum_error *error);

#endif
