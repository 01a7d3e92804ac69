/* Coefficients in single precision: c3 and c4 are rounded, and keep their place and type in the
 * file, so that every reader has them. A large model of such numbers is packed in half the bytes
 * (core/polynomial/packed.c), which its passes widen as they read.
 *
 * The error that this costs is measured: R before and after at random q, each coordinate with its
 * share 1/omega of a motion that goes as far as the nonlinear force equals the linear one. Only c3
 * and c4 are rounded, so frequencies stay. Cost: 2 forces a sample and some to find its size.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/model/single_precision.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "platform/allocate.h"
#include "precompute/model/model_fill.h"
#include "thrum/polynomial.h"

#define SAMPLES 16

/* Numbers in (-1, 1), the same in every run (Knuth's MMIX generator). */
static double next_number(uint64_t *seed) {
  *seed = *seed * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
  return (double)(*seed >> 11) * 0x1p-52 - 1.0;
}

static double norm(int64_t n, const double *a) {
  double sum = 0.0;
  for (int64_t i = 0; i < n; i++)
    sum += a[i] * a[i];
  return sqrt(sum);
}

/* |R(s q) - omega^2 s q| / |omega^2 s q| */
static double nonlinearity(const thrum_model *model, const double *q, double s, double *at,
                           double *force, double *work) {
  double linear = 0.0;
  for (int64_t i = 0; i < model->rank; i++)
    at[i] = s * q[i];
  thrum_internal_force(model, at, force, work);
  for (int64_t i = 0; i < model->rank; i++) {
    linear += model->omega2[i] * at[i] * model->omega2[i] * at[i];
    force[i] -= model->omega2[i] * at[i];
  }
  return norm(model->rank, force) / sqrt(linear);
}

/* A point to measure at, of that size; of any for a model that is linear. */
static void choose(const thrum_model *model, uint64_t *seed, double *q, double *at, double *force,
                   double *work) {
  const int64_t r = model->rank;

  for (int64_t i = 0; i < r; i++)
    q[i] = next_number(seed) / sqrt(fmax(model->omega2[i], DBL_MIN));

  // the size at which the nonlinear force equals the linear one, by bisection
  double low = 0.0, high = 1.0;
  for (int k = 0; k < 200 && nonlinearity(model, q, high, at, force, work) < 1.0; k++) {
    low = high;
    high *= 2.0;
  }
  for (int k = 0; k < 20; k++) {
    const double middle = 0.5 * (low + high);
    if (nonlinearity(model, q, middle, at, force, work) < 1.0)
      low = middle;
    else
      high = middle;
  }

  for (int64_t i = 0; i < r; i++)
    q[i] *= high;
}

static bool in_range(const double *values, int64_t count) {
  for (int64_t k = 0; k < count; k++)
    if (!(fabs(values[k]) <= FLT_MAX))
      return false;
  return true;
}

bool thrum_single_round(double *values, int64_t count) {
  if (!in_range(values, count))
    return false;
  for (int64_t k = 0; k < count; k++)
    values[k] = (double)(float)values[k];
  return true;
}

thrum_status thrum_single_precision_round(const thrum_model *model, double *worst,
                                          thrum_error *error) {
  if (!in_range(model->c3, model->c3_count) || !in_range(model->c4, model->c4_count))
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "a coefficient is beyond the range of single precision: use "
                           "--precision double");

  const int64_t r = model->rank, work_count = (int64_t)thrum_work_count(model);
  const size_t packed_size = thrum_model_pack_size(model);
  thrum_model packed = *model;
  thrum_scope memory = thrum_scope_begin("the samples of precision", error);
  void *pack_memory = thrum_scope_allocate_aligned(&memory, packed_size);
  double *q = thrum_scope_allocate(&memory, (2 * SAMPLES + 2) * r + work_count, sizeof *q);
  if (memory.status < 0) {
    thrum_scope_free(&memory);
    return memory.status;
  }
  thrum_model_pack(&packed, pack_memory, packed_size, NULL);

  // forces of sample points before the coefficients are rounded
  double *before = q + SAMPLES * r, *at = before + SAMPLES * r, *force = at + r;
  double *work = force + r;
  uint64_t seed = 17;
  for (int s = 0; s < SAMPLES; s++) {
    choose(&packed, &seed, q + s * r, at, force, work);
    thrum_internal_force(&packed, q + s * r, before + s * r, work);
  }

  thrum_single_round(thrum_model_writable(model->c3), model->c3_count);
  thrum_single_round(thrum_model_writable(model->c4), model->c4_count);
  thrum_model_pack(&packed, pack_memory, packed_size, NULL);

  // the same points afterwards
  *worst = 0.0;
  for (int s = 0; s < SAMPLES; s++) {
    thrum_internal_force(&packed, q + s * r, force, work);
    for (int64_t i = 0; i < r; i++)
      force[i] -= before[s * r + i];
    const double size = norm(r, before + s * r);
    *worst = fmax(*worst, size > 0.0 ? norm(r, force) / size : 0.0);
  }

  thrum_scope_free(&memory);
  return THRUM_OK;
}
