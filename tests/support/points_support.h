/* Models of cubature points for tests, and what every pass over them gives.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_TESTS_SUPPORT_POINTS_SUPPORT_H
#define THRUM_TESTS_SUPPORT_POINTS_SUPPORT_H

#include "tests/support/state_support.h"

#include "core/polynomial/polynomial_private.h"
#include "thrum/kernel.h"
#include "thrum/polynomial.h"

enum { MOST = 41 };

/* A model by points and the same one by coefficients. */
typedef struct both {
  random_model m; /* by coefficients */
  thrum_model points;
  double *weights, *moduli, *gradients;
} both;

/* The model by points alone: gradients of about `size` [1/(m kg^1/2)] and frequencies from 1 to 3
 * rad/s. */
static inline void points_make(both *made, uint64_t seed, int64_t rank, int64_t count,
                               double size) {
  *made = (both){0};
  random_model_make(&made->m, seed, rank, 1, 3, INFINITY);
  random_state random = {seed ^ 99};
  made->weights = random_alloc(count, sizeof(double));
  made->moduli = random_alloc(2 * count, sizeof(double));
  made->gradients = random_alloc(9 * count * rank, sizeof(double));
  random_vector(&random, count, 1, made->weights);
  random_vector(&random, 2 * count, 1, made->moduli);
  random_vector(&random, 9 * count * rank, size, made->gradients);

  // positive weights and moduli, which make every energy of strain positive
  for (int64_t p = 0; p < count; p++) {
    made->weights[p] = (1.1 + made->weights[p]) / (double)count;
    made->moduli[p] = 1.1 + made->moduli[p];
    made->moduli[count + p] = 1.1 + made->moduli[count + p];
  }

  // its energy comes from the points
  static const int32_t format[2] = {THRUM_MODEL_FORMAT_MAJOR,
                                    THRUM_MODEL_FORMAT_MINOR + THRUM_MODEL_FORMAT_MINOR_POINTS};
  made->points = made->m.model;
  made->points.format = format;
  made->points.c3 = made->points.c4 = NULL;
  made->points.c3_count = made->points.c4_count = 0;
  made->points.point_count = count;
  made->points.point_weights = made->weights;
  made->points.point_moduli = made->moduli;
  made->points.point_gradients = made->gradients;
  assert_int_equal(thrum_model_check(&made->points, NULL), THRUM_OK);
}

/* Another law at its points. */
static inline void points_obey(both *made, const char *law) {
  static const int32_t format[2] = {THRUM_MODEL_FORMAT_MAJOR_LAW, THRUM_MODEL_FORMAT_MINOR_LAW};
  made->points.format = format;
  made->points.point_law = (const uint8_t *)law;
  made->points.law_bytes = (int64_t)strlen(law) + 1;
  assert_int_equal(thrum_model_check(&made->points, NULL), THRUM_OK);
}

/* Three laws, one for each of three regions; blocks of eight points have one or all of them. */
enum { REGION_POINTS = 128 };
static inline void points_obey_regions(both *made, const uint8_t laws[3]) {
  static const int32_t format[2] = {THRUM_MODEL_FORMAT_MAJOR_REGIONS,
                                    THRUM_MODEL_FORMAT_MINOR_REGIONS};
  static int32_t regions[REGION_POINTS];
  for (int p = 0; p < REGION_POINTS; p++)
    regions[p] = p / 8 % 2 == 0 ? p % 3 : p / 16 % 3;

  // laws of regions take the place of one law
  made->points.format = format;
  made->points.point_law = NULL;
  made->points.law_bytes = 0;
  made->points.point_region = regions;
  made->points.region_law = laws;
  made->points.law_count = 3;
  assert_true(made->points.point_count <= REGION_POINTS);
  assert_int_equal(thrum_model_check(&made->points, NULL), THRUM_OK);
}

static inline void both_free(both *made) {
  random_model_free(&made->m);
  free(made->weights);
  free(made->moduli);
  free(made->gradients);
}

/* The results of every pass. */
typedef struct outcome {
  double energy, with_force, with_tangent, part, held, twice[2];
  double force[MOST], forces[2][MOST], product[MOST], force_part[MOST], product_part[MOST];
  double tangent_force[MOST], gradient[MOST];
  double tangent[MOST * MOST], tangent_again[MOST * MOST], hessian[MOST * MOST];
} outcome;

static inline void evaluate(const thrum_kernel *by, const thrum_model *model, int32_t split,
                            const double *q, const double *v, outcome *o) {
  // scratch of exactly the size that is promised, full of NaN, which no pass may read
  const int64_t count = (int64_t)thrum_work_count(model);
  double *work = random_alloc(count + 1, sizeof *work);
  for (int64_t i = 0; i <= count; i++)
    work[i] = i < count ? NAN : -12345.0;

  // the whole model
  *o = (outcome){0};
  o->energy = thrum_strain_energy_by(by, model, q, work);
  o->with_force = thrum_internal_force_by(by, model, q, o->force, work);
  const double *const places[2] = {v, q};
  double *const forces[2] = {o->forces[0], o->forces[1]};
  thrum_internal_forces_by(by, model, places, forces, o->twice, work);
  thrum_tangent_stiffness_by(by, model, q, o->tangent, work);
  o->with_tangent =
      thrum_internal_force_tangent_by(by, model, q, o->tangent_force, o->tangent_again, work);
  thrum_tangent_product_by(by, model, q, v, o->product, work);

  // what a split asks for
  o->part = thrum_internal_force_part(by, model, split, q, o->force_part, work);
  thrum_tangent_product_part(by, model, split, q, v, o->product_part, work);
  const int64_t n = model->rank - split, room = thrum_restriction_count(model, n);
  double *restricted = random_alloc(room + 1, sizeof *restricted);
  restricted[room] = -12345.0;
  thrum_polynomial_restrict(by, model, split, q, restricted, work);
  o->held = thrum_restricted_gradient(by, model, split, restricted, v, o->gradient, work);
  thrum_restricted_hessian(by, model, split, restricted, v, o->hessian, work);
  assert_true(restricted[room] == -12345.0 && work[count] == -12345.0);
  free(restricted);
  free(work);
}

static inline void assert_near(const double *a, const double *b, int64_t n) {
  double size = 0;
  for (int64_t i = 0; i < n; i++)
    size = fmax(size, fabs(b[i]));
  assert_true(largest_difference(a, b, n) <= 1e-12 * size);
}

/* Packs a model; returns the memory, for the caller to free. */
static inline void *pack(thrum_model *model) {
  const size_t size = thrum_model_pack_size(model);
  void *memory = aligned_alloc(64, (size + 63) / 64 * 64);
  assert_int_equal(thrum_model_pack(model, memory, size, NULL), THRUM_OK);
  return memory;
}

#endif
