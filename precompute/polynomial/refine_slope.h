/* Slope of the error of the force by the gradients of cubature points, in single precision, design
 * 18 (18.8).
 *
 * A step of learning needs a direction, not its last digits, and products of matrices take half the
 * time in single precision. So that no number is far from 1, whatever the units of the body, points
 * and states are given in units of their own.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_POLYNOMIAL_REFINE_SLOPE_H
#define THRUM_PRECOMPUTE_POLYNOMIAL_REFINE_SLOPE_H

#include <stdint.h>

#include "runtime/material/material_law.h"

/* Points side by side: component c of the gradient at point p is row c count + p. */
typedef struct thrum_single_points {
  int64_t count, rank;
  const thrum_law *laws;    /* count; NULL: all Saint Venant-Kirchhoff's */
  const float *lambda, *mu; /* count: Lame's constants times the weights */
  const float *gradients;   /* 9 count x rank */
} thrum_single_points;

/* States, and what is not linear in their forces, as thrum_force_samples has them. */
typedef struct thrum_single_samples {
  int64_t count;
  const float *q, *force; /* count x rank */
  const float *scale;     /* count */
} thrum_single_samples;

/* Numbers of the scratch of so many states. */
int64_t thrum_refine_slope_work(int64_t points, int64_t rank, int64_t states);

/* slope (9 count x rank): the derivative of half the mean square of the relative error of the force
 * by the gradients. */
void thrum_refine_slope(const thrum_single_points *points, const thrum_single_samples *samples,
                        float *slope, float *work);

#endif
