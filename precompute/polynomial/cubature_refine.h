/* Cubature points whose gradients are learned, design 18.
 *
 * The points that the least squares choose are those of the mesh. What a model needs of a point is
 * its weight, its moduli and the gradient of each coordinate there, and V stays an energy of the
 * same form, with positive weights and an exact linear part, whatever these gradients are. So they
 * are moved to where the forces in states of training are best
 * (precompute/polynomial/soap.h).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_POLYNOMIAL_CUBATURE_REFINE_H
#define THRUM_PRECOMPUTE_POLYNOMIAL_CUBATURE_REFINE_H

#include "precompute/options/stage.h"
#include "runtime/material/material_law.h"

/* States of a step, and states to refine on for each point, eight forces for each number that is
 * learned; but as many as steps at least, so that none is seen more often than a step has states.
 */
enum { THRUM_REFINE_BATCH = 64, THRUM_REFINE_STATES = 72 };

/* States, in coordinates and forces in which the static response has the norm 1: q_i w_i and
 * R_i / w_i. */
typedef struct thrum_force_samples {
  int64_t count, rank;
  const double *q;     /* count x rank */
  const double *force; /* count x rank: what is not linear in the force, times `scale` */
  const double *scale; /* count: one over the norm of the whole force */
} thrum_force_samples;

/* Points; the gradients are those of the coordinates q_i w_i. */
typedef struct thrum_free_points {
  int64_t count, rank;
  const double *lambda, *mu; /* count: Lame's constants times the weights */
  double *gradients;         /* 9 count x rank: row 9 p + 3 a + b is du_a/dX_b at point p */
  const thrum_law *laws;     /* count; NULL: all Saint Venant-Kirchhoff's */
} thrum_free_points;

/* Numbers of the scratch of an objective of `states` states. */
int64_t thrum_refine_work(const thrum_free_points *points, int64_t states);

/* Half the mean square of the relative error of the force in `count` states from `first` on.
 * slope: its derivative by the gradients, 9 count x rank; NULL: not wanted. */
double thrum_refine_objective(const thrum_free_points *points, const thrum_force_samples *samples,
                              int64_t first, int64_t count, double *slope, double *work);

/* The relative rms error of the force in all samples. */
double thrum_refine_error(const thrum_free_points *points, const thrum_force_samples *samples,
                          double *work);

/* Moves the gradients to lower the error, which it never raises: where nothing is gained they stay
 * as they were, to the last bit. samples->count is a multiple of THRUM_REFINE_BATCH, at least one.
 * Progress is reported from `begin` to 1. */
thrum_status thrum_cubature_refine(const thrum_force_samples *samples, int64_t steps,
                                   thrum_free_points *points, const thrum_reporter *reporter,
                                   double begin, thrum_error *error);

#endif
