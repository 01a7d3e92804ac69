/* Distances between a vertex and a triangle and between two edges, now and on their way through a
 * step; private to the runtime. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_CONTACT_CONTACT_DISTANCE_H
#define THRUM_RUNTIME_CONTACT_CONTACT_DISTANCE_H

#include <math.h>
#include <stdbool.h>

#define THRUM_MET 1e-3 /* thicknesses within which two places have met */

#include "core/base/vec3.h"

/* Four points: a vertex and a triangle's corners, or the ends of one edge and of another. */
typedef struct thrum_quad {
  const double *x[4]; /* at the start of the step [m] */
  const double *d[4]; /* displacement over it [m] */
} thrum_quad;

typedef enum thrum_quad_kind { THRUM_VERTEX_TRIANGLE = 0, THRUM_EDGE_EDGE = 1 } thrum_quad_kind;

/* The closest points at one time. */
typedef struct thrum_nearest {
  double weights[4]; /* of the four points; the first side's sum is 1, the second's too */
  double apart[3];   /* from the second side to the first [m] */
  double distance;   /* its length [m] */
  bool inside;       /* not on the rim of the triangle, not at an end of an edge */
} thrum_nearest;

/* The closest points at the share `time` of the step, in [0, 1]. */
thrum_nearest thrum_quad_nearest(thrum_quad_kind kind, const thrum_quad *quad, double time);

/* Weights of the corners a, b, c for the point of a triangle that is closest to p; is it inside, on
 * no edge and at no corner? */
bool thrum_triangle_closest(const double p[3], const double a[3], const double b[3],
                            const double c[3], double weights[3]);

/* A vertex and the point of a triangle with these weights, which is the closest one; x: the vertex
 * and the corners. */
static inline thrum_nearest thrum_vertex_nearest(const double *const x[4], const double weights[3],
                                                 bool inside) {
  thrum_nearest found = {.weights = {1.0, weights[0], weights[1], weights[2]}, .inside = inside};
  for (int axis = 0; axis < 3; axis++)
    found.apart[axis] =
        x[0][axis] - weights[0] * x[1][axis] - weights[1] * x[2][axis] - weights[2] * x[3][axis];
  found.distance = sqrt(thrum_dot3(found.apart, found.apart));
  return found;
}

/* How far the points of one side move against those of the other, at most [m]. */
double thrum_quad_motion(thrum_quad_kind kind, const thrum_quad *quad);

/* The share of the step after which the two are within `reach` [m] of each other; 2 where they are
 * not in this step. Never later: advances are limited, so of two that graze at this distance it is
 * a share before they are there, and a candidate more. */
double thrum_quad_meets(thrum_quad_kind kind, const thrum_quad *quad, double reach);

#endif
