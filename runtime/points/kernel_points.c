/* The passes over cubature points in plain C, and what a state asks of them when it is made
 * (core/polynomial/points.h). Every kernel has these passes from one source,
 * runtime/points/kernel_points.inl; here a vector is eight numbers.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "core/polynomial/points.h"
#include "runtime/points/kernel_points.h"

#include <string.h>

#include "core/base/lane_sums.h"
#include "core/polynomial/packed.h"

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

INLINE v8 v8_load_single(const float *p) {
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

#include "core/polynomial/kernel_lanes.h"
// these need the lanes
#include "runtime/points/kernel_points.inl"

const thrum_kernel thrum_points_reference = THRUM_POINTS_TABLE(THRUM_KERNEL_REFERENCE);

/* The gradients of coordinate j at the points of block b, zero behind the last point. */
static v8_matrix gradients_of(const thrum_model *model, int64_t b, int64_t j) {
  v8_matrix g = {{{{0}}}};
  for (int64_t k = 0; k < 8 && 8 * b + k < model->point_count; k++)
    for (int64_t c = 0; c < THRUM_POINT_ROWS; c++)
      g.at[c].lane[k] =
          model->point_gradients[(THRUM_POINT_ROWS * (8 * b + k) + c) * model->rank + j];
  return g;
}

/* to (rank) += P : G_s at the points of block b. */
static void add_forces(const thrum_model *model, int64_t b, const v8_matrix *p, double *to) {
  for (int64_t k = 0; k < 8 && 8 * b + k < model->point_count; k++)
    for (int64_t c = 0; c < THRUM_POINT_ROWS; c++) {
      const double *row =
          model->point_gradients + (THRUM_POINT_ROWS * (8 * b + k) + c) * model->rank;
      for (int64_t s = 0; s < model->rank; s++)
        to[s] += p->at[c].lane[k] * row[s];
    }
}

/* The part of the stress of degree 2 along the gradients g at the points of block b; *quartic +=
 * that of V of degree 4. */
static v8_matrix terms_of(const thrum_model *model, thrum_law law, int64_t b, const v8_matrix *g,
                          double *quartic) {
  point_state at = {.g = *g, .m = point_moduli(model, b), .law = thrum_block_law(model, law, b)};
  point_prepare(model, b, &at);
  if (at.law != THRUM_LAW_STVK) {
    double gradient[THRUM_POINT_BLOCK], stress[THRUM_POINT_BLOCK], energy[8];
    const thrum_point_lanes lanes = point_lanes(&at, gradient);
    thrum_point_law_terms(&lanes, energy, stress);
    for (int c = 0; c < THRUM_POINT_ROWS; c++)
      at.p.at[c] = v8_load(stress + 8 * c);
    *quartic += thrum_lanes_sum(energy);
    return at.p;
  }

  // Saint Venant-Kirchhoff's are C:N + G C:sym G and N:C:N/2
  const v8_symmetric linear = v8_linear_strain(&at.g);
  at.n = v8_quadratic_strain(&at.g);
  at.t = v8_stress(at.m.lambda, at.m.mu, &at.n);
  at.s = v8_stress(at.m.lambda, at.m.mu, &linear);
  const v8_matrix second = point_force(&at);
  at.s = at.t;
  *quartic += v8_sum(point_energy(&at));
  return second;
}

void thrum_points_along(const thrum_model *model, int64_t j, double *c3, double *c4) {
  const thrum_law law = thrum_law_of_model(model);
  memset(c3, 0, (size_t)model->rank * sizeof *c3);
  *c4 = 0;
  for (int64_t b = 0; b < thrum_point_blocks(model); b++) {
    const v8_matrix g = gradients_of(model, b, j), second = terms_of(model, law, b, &g, c4);
    add_forces(model, b, &second, c3);
  }
}
