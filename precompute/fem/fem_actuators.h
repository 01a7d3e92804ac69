/* What actuators do to the full-order body: their measures, and the gradients and tangents of
 * these, on all components of displacement (actuator.h, docs/actuation.md).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_FEM_FEM_ACTUATORS_H
#define THRUM_PRECOMPUTE_FEM_FEM_ACTUATORS_H

#include "mesh/actuator.h"
#include "precompute/fem/fem.h"

/* The points of a face at which volumes are taken, exact for faces of straight and curved edges:
 * shape functions and their slopes by both coordinates, and weights. */
enum { THRUM_FACE_POINTS = 6, THRUM_FACE_NODES = 6 };
typedef struct thrum_face_point {
  double weight, shape[THRUM_FACE_NODES], slope[THRUM_FACE_NODES][2];
} thrum_face_point;
int thrum_face_points(int nodes, thrum_face_point points[THRUM_FACE_POINTS]);

/* The measure m of an actuator at u (3 vertex_count), as thrum_acting_measure has it: the volume or
 * length beyond that at rest, that of a tendon negative, or the work of a strain of 1. Its gradient
 * times `by` is added to `gradient` (3 vertex_count; NULL: not wanted). */
double thrum_fem_actuator(const thrum_fem *fem, const thrum_actuator *actuator, const double *u,
                          double by, double *gradient);

/* Adds `by` times its second derivative at u to a matrix on the pattern of the stiffness: what is
 * between vertices that share no element, as of caps and tendons, is left out. */
void thrum_fem_actuator_stiffness(const thrum_fem *fem, const thrum_actuator *actuator,
                                  const double *u, double by, thrum_sparse *stiffness);

/* The volume of a surface or the length of a tendon at rest, where its measure is 0. */
double thrum_fem_actuator_rest(const thrum_fem *fem, const thrum_actuator *actuator);

/* What acts on a body: the levels of its actuators. */
struct thrum_fem_acting {
  int64_t count;
  const thrum_actuator *actuators;
  double *levels, *rest; /* count */
};

/* Adds the energy of fem->acting at u [J]; its forces, of all components, to `force` (NULL: not
 * wanted); and its tangent to `stiffness`. Both do nothing where nothing acts. */
double thrum_fem_acting_energy(const thrum_fem *fem, const double *u, double *force);
void thrum_fem_acting_stiffness(const thrum_fem *fem, const double *u, thrum_sparse *stiffness);

/* Adds what pushes and pulls at all vertices [N], held ones included: where a vertex is free, less
 * the gradient of that energy. At an edge that is held the volume of an open surface has another
 * gradient than what its pressure pushes. */
void thrum_fem_acting_loads(const thrum_fem *fem, const double *u, double *loads);

#endif
