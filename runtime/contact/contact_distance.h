/* Distances between a vertex and a triangle and between two edges, now and on their way through a
 * step; private to the runtime. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_CONTACT_CONTACT_DISTANCE_H
#define THRUM_RUNTIME_CONTACT_CONTACT_DISTANCE_H

#include <stdbool.h>

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

/* How far the points of one side move against those of the other, at most [m]. */
double thrum_quad_motion(thrum_quad_kind kind, const thrum_quad *quad);

/* The share of the step after which the two are within `reach` [m] of each other; 2 where they are
 * not in this step. Never later: advances are limited, so of two that graze at this distance it is
 * a share before they are there, and a candidate more. */
double thrum_quad_meets(thrum_quad_kind kind, const thrum_quad *quad, double reach);

/* Is the point of a triangle that is closest to p inside it, on no edge and at no corner? */
bool thrum_triangle_is_over(const double p[3], const double a[3], const double b[3],
                            const double c[3]);

#endif
