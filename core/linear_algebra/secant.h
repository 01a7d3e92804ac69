/* The inverse Jacobian of a solve, kept up to date by the solve itself; private to libthrum; see
 * secant.c. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_LINEAR_ALGEBRA_SECANT_H
#define THRUM_CORE_LINEAR_ALGEBRA_SECANT_H

#include <stdbool.h>
#include <stdint.h>

#include "core/polynomial/kernel_private.h"

/* Most corrections that a step can learn; later ones are left out. */
#define THRUM_SECANT_PAIRS 8

/* H = base + sum_k (s_k w_k^T + w_k s_k^T). */
typedef struct thrum_secant {
  const thrum_kernel *by;
  const double *base; /* n x n, symmetric */
  double *pairs;      /* s_0, w_0, s_1, w_1 ..: vectors of n, `stride` apart */
  int64_t stride;
  int32_t n;
  int32_t count; /* of pairs */
} thrum_secant;

/* y = H x; both n, no overlap. */
void thrum_secant_apply(const thrum_secant *h, const double *x, double *y);

/* Learns that the residual changed by `change` along `step`, and updates image = H residual. `step`
 * must be -H times the residual before, and `residual` is the one after. Does nothing where the
 * curvature along the step is not positive, or when there is no room. All of length n. */
void thrum_secant_learn(thrum_secant *h, const double *step, const double *change,
                        const double *residual, double *image);

/* base += the pairs; base is n x n. */
void thrum_secant_fold(const thrum_kernel *by, const double *pairs, int64_t stride, int32_t n,
                       int32_t count, double *base);

#endif
