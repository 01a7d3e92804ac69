/* BFGS: an inverse Jacobian H that learns from each iteration of a quasi-Newton solve.
 *
 * With s the step and y the change of the residual along it, u = H y,
 *   H+ = H + (1 + y u / s y) s s^T / s y - (s u^T + u s^T) / s y = H + s w^T + w s^T,
 *   w = 1/2 (s y + y u) / (s y)^2 s - u / s y,
 * the symmetric H+ nearest to H, in the metric of the Jacobian, with H+ y = s. It stays positive
 * definite where s y > 0. The Jacobian changes little from one step to the next, and the change
 * matters only along the few directions that the solves take: so H serves many steps without a new
 * tangent.
 * Cost: n^2 products to apply, 4 n more a pair; 2 n^2 a pair to fold them into H after the step.
 * Source: Broyden 1970, doi:10.1093/imamat/6.1.76; Fletcher 1970, doi:10.1093/comjnl/13.3.317.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "core/linear_algebra/secant.h"

#include <math.h>
#include <string.h>

#include "core/base/lane_sums.h"

/* y += (s w^T + w s^T) x */
static void add_pair(int32_t n, const double *s, const double *w, const double *x,
                     double *restrict y) {
  const double along_s = thrum_sum_of(n, w, x, NULL), along_w = thrum_sum_of(n, s, x, NULL);
  for (int32_t i = 0; i < n; i++)
    y[i] += along_s * s[i] + along_w * w[i];
}

void thrum_secant_apply(const thrum_secant *h, const double *x, double *y) {
  h->by->product(h->n, h->n, h->base, x, y);
  for (int32_t k = 0; k < h->count; k++) {
    const double *s = h->pairs + 2 * k * h->stride;
    add_pair(h->n, s, s + h->stride, x, y);
  }
}

void thrum_secant_learn(thrum_secant *h, const double *step, const double *change,
                        const double *residual, double *image) {
  const int32_t n = h->n;
  if (h->count == THRUM_SECANT_PAIRS)
    return;
  double *restrict s = h->pairs + 2 * h->count * h->stride, *restrict w = s + h->stride;

  // H y is H of the residual after, less that of the one before
  for (int32_t i = 0; i < n; i++)
    w[i] = image[i] + step[i];

  // the pair, where the step had a positive curvature
  const double curvature = thrum_sum_of(n, step, change, NULL);
  const double through = thrum_sum_of(n, change, w, NULL);
  const double along = 0.5 * (curvature + through) / (curvature * curvature);
  const double across = 1.0 / curvature;
  if (!(curvature > 0.0) || !isfinite(along) || !isfinite(across)) {
    memset(w, 0, (size_t)n * sizeof *w);
    return;
  }

  // s is taken over only now: a pair of zeros changes nothing
  for (int32_t i = 0; i < n; i++) {
    s[i] = step[i];
    w[i] = along * step[i] - across * w[i];
  }
  h->count++;
  add_pair(n, s, w, residual, image);
}

void thrum_secant_fold(const thrum_kernel *by, const double *pairs, int64_t stride, int32_t n,
                       int32_t count, double *base) {
  const double *s = pairs, *w = s + stride;
  const thrum_two corrections = {s, w, w, s, count, 2 * stride};
  if (count > 0)
    by->rank_two(n, false, &corrections, base);
}
