/* The passes over cubature points in plain C, and what a state asks of them when it is made
 * (runtime/polynomial/points.h). Every kernel has these passes from one source,
 * runtime/polynomial/kernel_points.inl; here a vector is eight numbers.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "runtime/base/fp_contract.h"

#include "runtime/polynomial/kernel_points.h"
#include "runtime/polynomial/points.h"

#include <math.h>

#include "runtime/base/lane_sums.h"

#define INLINE static inline
#define PASS static

typedef struct v8 {
  double lane[8];
} v8;

INLINE v8 v8_set1(double s) {
  const v8 v = {{s, s, s, s, s, s, s, s}};
  return v;
}

INLINE v8 v8_zero(void) {
  return v8_set1(0.0);
}

INLINE v8 v8_load(const double *p) {
  v8 v;
  for (int i = 0; i < 8; i++)
    v.lane[i] = p[i];
  return v;
}

INLINE void v8_store(double *p, v8 v) {
  for (int i = 0; i < 8; i++)
    p[i] = v.lane[i];
}

INLINE v8 v8_mul(v8 v, v8 w) {
  for (int i = 0; i < 8; i++)
    v.lane[i] *= w.lane[i];
  return v;
}

INLINE v8 v8_add(v8 v, v8 w) {
  for (int i = 0; i < 8; i++)
    v.lane[i] += w.lane[i];
  return v;
}

INLINE double v8_sum(v8 v) {
  return thrum_lanes_sum(v.lane);
}

INLINE v8 v8_two(double s, double t) {
  const v8 v = {{s, t, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0}};
  return v;
}

INLINE v8 v8_sums(v8 a, v8 b, v8 c, v8 d, v8 e, v8 f, v8 g, v8 h) {
  const v8 v = {
      {v8_sum(a), v8_sum(b), v8_sum(c), v8_sum(d), v8_sum(e), v8_sum(f), v8_sum(g), v8_sum(h)}};
  return v;
}

#include "runtime/polynomial/kernel_lanes.h"
// these need the lanes
#include "runtime/polynomial/kernel_points.inl"

const thrum_kernel thrum_points_reference = THRUM_POINTS_TABLE(THRUM_KERNEL_REFERENCE);

void thrum_points_along(const thrum_model *model, int64_t j, double *c3, double *c4) {
  // a coordinate at which the gradients are of order 1, so that all terms are of one size
  const int64_t r = model->rank;
  double most = 0, plus[THRUM_RANK_MAX] = {0}, minus[THRUM_RANK_MAX] = {0};
  double at[THRUM_RANK_MAX] = {0};
  for (int64_t k = 0; k < THRUM_POINT_ROWS * model->point_count; k++)
    most = fmax(most, fabs(model->point_gradients[k * r + j]));

  // what is even in q_j of the force is of degree 2, what is even in V of degree 4
  const double t = most > 0 ? 1.0 / most : 1.0;
  at[j] = t;
  const double forward = points_force(model, point_all(model), at, plus);
  at[j] = -t;
  const double backward = points_force(model, point_all(model), at, minus);
  for (int64_t s = 0; s < r; s++)
    c3[s] = 0.5 * (plus[s] + minus[s]) / (t * t);
  *c4 = 0.5 * (forward + backward) / (t * t * t * t);
}
