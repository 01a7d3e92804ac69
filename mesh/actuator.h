/* Actuators of a body by what they are on its mesh: surfaces whose volume a pressure works on,
 * regions that strain by themselves, tendons through points. What they add to the energy is in
 * thrum/actuation.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_ACTUATOR_H
#define THRUM_MESH_ACTUATOR_H

#include "mesh/mesh.h"
#include "thrum/model.h"

/* The surface of a chamber. A node is a vertex, or, from vertex_count on, one of the means: the
 * middle of a cap, and those of its edges. Its volume is the integral of
 * -sum_a weight_a (x_a - origin_a) n_a, n outwards of the body. */
typedef struct thrum_actuator_surface {
  int nodes; /* of a face: 3, or 6, corners first, then the middles of 01, 12, 20 */
  int64_t face_count;
  int32_t *faces; /* face_count x nodes */
  double weight[3], origin[3];
  int64_t mean_count, term_count;
  int64_t *mean_ends;  /* mean_count: end of its terms, each of which is a node before it */
  int32_t *mean_nodes; /* term_count, of equal weights */
} thrum_actuator_surface;

typedef struct thrum_actuator {
  thrum_actuator_kind kind;
  char *text;                     /* NAME=SPEC with the numbers of this mesh, owned */
  thrum_actuator_surface surface; /* of pressure and gas */
  double outside;                 /* of a gas: pressure outside [Pa] */
  int32_t region;                 /* of a strain; -1: all */
  double strain[3][3];
  int64_t guide_count; /* of a tendon */
  int32_t *guides;     /* vertices; -1: a place that does not move */
  double *places;      /* guide_count x 3, at rest [m] */
} thrum_actuator;

/* Reads NAME=SPEC:
 *
 *   chamber:GROUP[,cap]              a closed surface of the body, or one that caps close
 *   gas:GROUP[,cap][,outside=PA]     the same, shut; outside 101325 Pa unless said
 *   pressure:GROUP                   a surface whose edge is held
 *   muscle:REGION,dx,dy,dz           shortens along a direction by its level
 *   swell:REGION                     grows by its level, as by heat; all for REGION is the body
 *   eigenstrain:REGION,exx,eyy,ezz,eyz,exz,exy
 *   tendon:PLACE,PLACE,...           PLACE: vertex=N, near:X,Y,Z (a vertex) or at:X,Y,Z (fixed)
 *
 * `fixed` (vertex_count): bits 0, 1, 2 of x, y, z held. The faces of GROUP are those whose corners
 * are all in it. On failure *actuator is empty. */
thrum_status thrum_actuator_read(const thrum_mesh *mesh, const uint8_t *fixed, const char *text,
                                 thrum_actuator *actuator, thrum_error *error);
void thrum_actuator_free(thrum_actuator *actuator); /* leaves it empty */

/* The surface of a group: closed, closed by caps where `caps`, or with an edge that is held where
 * `open`. `spec` names it in messages. */
thrum_status thrum_actuator_find_surface(const thrum_mesh *mesh, const uint8_t *fixed,
                                         const thrum_group *group, bool caps, bool open,
                                         const char *spec, thrum_actuator_surface *surface,
                                         thrum_error *error);
void thrum_actuator_free_surface(thrum_actuator_surface *surface);

#endif
