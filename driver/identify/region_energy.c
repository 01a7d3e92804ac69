/* The energies of regions: those of the shares of the model's file, or the polynomial is reduced
 * once for each region, with the moduli of the others zero, which is exact as the energy is linear
 * in them; a body of other moduli has its modes found anew. SPDX-License-Identifier: Apache-2.0 */
#include "driver/identify/region_energy.h"

#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/alignment_check.h"
#include "platform/allocate.h"
#include "precompute/fem/lapack_status.h"
#include "precompute/model/model_fem.h"
#include "precompute/polynomial/change_of_basis.h"
#include "precompute/polynomial/polynomial_reduce.h"
#include "thrum/condensed_model.h"
#include "thrum/parameters.h"
#include "thrum/polynomial.h"

#define SAME 1e-6 /* of the largest stiffness: by which the sum of the regions may differ */

/* Doubles of a part. */
static int64_t part_size(int64_t rank) {
  return rank * rank + thrum_c3_count(rank) + thrum_c4_count(rank);
}

/* L of a region; c3 and c4 stand behind it. */
static double *linear_of(const region_energy *e, int64_t g) {
  return e->block + g * part_size(e->model->rank);
}

static thrum_status reduce_region(const region_energy *e, thrum_fem *fem, int64_t g,
                                  const double *moduli, thrum_error *error) {
  const int64_t r = e->model->rank;
  for (int64_t m = 0; m < e->count; m++) {
    fem->lambda[m] = m == g ? moduli[2 * m] : 0;
    fem->mu[m] = m == g ? moduli[2 * m + 1] : 0;
  }
  double *linear = linear_of(e, g), *c3 = linear + r * r, *c4 = c3 + thrum_c3_count(r);
  return thrum_polynomial_reduce(fem, r, r, e->model->basis, linear, c3, c4, NULL, error);
}

static thrum_status reduce_regions(const region_energy *e, thrum_error *error) {
  thrum_model_fem body = {0};
  double *moduli = NULL;
  THRUM_TRY(thrum_model_fem_elements(e->model, &body, error));
  thrum_status status = thrum_reserve(&moduli, 2 * e->count, sizeof *moduli, "the regions", error);
  for (int64_t m = 0; m < e->count && status >= 0; m++) {
    moduli[2 * m] = body.fem.lambda[m];
    moduli[2 * m + 1] = body.fem.mu[m];
  }
  for (int64_t g = 0; g < e->count && status >= 0; g++)
    status = reduce_region(e, &body.fem, g, moduli, error);
  free(moduli);
  thrum_model_fem_free(&body);
  return status;
}

/* Do the regions add up to the model? */
static thrum_status check_sum(const region_energy *e, thrum_error *error) {
  const int64_t r = e->model->rank;
  double worst = 0;
  for (int64_t i = 0; i < r * r; i++) {
    double sum = i % (r + 1) == 0 ? -e->model->omega2[i / r] : 0;
    for (int64_t g = 0; g < e->count; g++)
      sum += linear_of(e, g)[i];
    worst = fmax(worst, fabs(sum));
  }
  if (worst <= SAME * e->model->omega2[r - 1])
    return THRUM_OK;
  return thrum_error_set(error, THRUM_UNSUPPORTED,
                         "the energies of the regions of the mesh do not add up to that of the "
                         "model, which was scaled or made in another way");
}

/* The regions by the shares of the file, without its mesh. */
static thrum_status sum_shares(const region_energy *e, thrum_error *error) {
  const thrum_model *model = e->model;
  const int64_t size = part_size(model->rank);
  double *values = NULL;
  THRUM_TRY(thrum_reserve(&values, 3 * e->count, sizeof *values, "the regions", error));
  const thrum_status status = thrum_model_parameters_get(model, values, error);
  for (int64_t g = 0; g < e->count && status >= 0; g++) {
    const double *lambda = model->region_energy + 2 * g * size, *mu = lambda + size;
    for (int64_t n = 0; n < size; n++)
      linear_of(e, g)[n] = values[3 * g] * lambda[n] + values[3 * g + 1] * mu[n];
  }
  free(values);
  return status;
}

thrum_status region_energy_open(const thrum_model *model, region_energy *energy,
                                thrum_error *error) {
  const int64_t r = model->rank;
  *energy =
      (region_energy){.model = model, .count = model->region_count > 1 ? model->region_count : 1};
  if (model->c3 == NULL || model->c4 == NULL)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "the model has no polynomial of all its coordinates: make one without "
                           "--condense, --cubature and --law");
  const bool shares = thrum_model_parameter_count(model) > 0;
  if (energy->count > 1 && !shares && (model->basis == NULL || model->tets == NULL))
    return thrum_error_set(error, THRUM_MISSING,
                           "the model has several regions, and no mesh to tell them apart");
  THRUM_TRY(thrum_reserve(&energy->block, energy->count * part_size(r), sizeof *energy->block,
                          "the regions", error));
  if (energy->count > 1) {
    THRUM_TRY(shares ? sum_shares(energy, error) : reduce_regions(energy, error));
    return check_sum(energy, error);
  }

  // one region is the whole model
  double *linear = linear_of(energy, 0);
  for (int64_t i = 0; i < r; i++)
    linear[i * r + i] = model->omega2[i];
  memcpy(linear + r * r, model->c3, (size_t)model->c3_count * sizeof *linear);
  memcpy(linear + r * r + model->c3_count, model->c4, (size_t)model->c4_count * sizeof *linear);
  return THRUM_OK;
}

void region_energy_close(region_energy *energy) {
  free(energy->block);
  energy->block = NULL;
}

/* --- a body of other moduli ------------------------------------------------------------------- */

/* turn^T L turn; work: rank x rank */
static void turn_linear(int64_t r, const double *turn, const double *linear, double *work,
                        double *to) {
  for (int64_t i = 0; i < r; i++)
    for (int64_t j = 0; j < r; j++) {
      double sum = 0;
      for (int64_t k = 0; k < r; k++)
        sum += linear[i * r + k] * turn[k * r + j];
      work[i * r + j] = sum;
    }
  for (int64_t i = 0; i < r; i++)
    for (int64_t j = 0; j < r; j++) {
      double sum = 0;
      for (int64_t k = 0; k < r; k++)
        sum += turn[k * r + i] * work[k * r + j];
      to[i * r + j] = sum;
    }
}

/* Modes of the sum: omega2 and the columns of turn. */
static thrum_status find_modes(const region_energy *e, const double *factors, double *omega2,
                               double *turn, double *work, thrum_error *error) {
  const int64_t r = e->model->rank;
  memset(work, 0, (size_t)(r * r) * sizeof *work);
  for (int64_t g = 0; g < e->count; g++)
    for (int64_t i = 0; i < r * r; i++)
      work[i] += factors[g] * linear_of(e, g)[i];
  THRUM_TRY(
      thrum_lapack_status(LAPACKE_dsyev(LAPACK_COL_MAJOR, 'V', 'U', (int)r, work, (int)r, omega2),
                          THRUM_NOT_CONVERGED, "the modes of the body with other moduli", error));

  // LAPACK has vectors as rows here; their signs are those of the model's modes
  for (int64_t j = 0; j < r; j++) {
    const double sign = work[j * r + j] < 0 ? -1 : 1;
    for (int64_t i = 0; i < r; i++)
      turn[i * r + j] = sign * work[j * r + i];
    omega2[j] = fmax(omega2[j], 0);
  }
  return THRUM_OK;
}

/* Lays a form of these coefficients out for quick steps; *at moves on in the memory. */
static thrum_status pack(const region_energy *e, const double *omega2, const double *c3,
                         const double *c4, unsigned char **at, thrum_model *form,
                         thrum_error *error) {
  const int64_t r = e->model->rank;
  *form = (thrum_model){.rank = r,
                        .c3_count = thrum_c3_count(r),
                        .c4_count = thrum_c4_count(r),
                        .format = e->model->format,
                        .omega2 = omega2,
                        .c3 = c3,
                        .c4 = c4};
  const size_t size = thrum_round_up(thrum_model_pack_size(form));
  unsigned char *memory = *at;
  *at += size;
  return thrum_model_pack(form, memory, size, error);
}

/* A part in the coordinates of the body, added to the sum. */
static thrum_status turn_part(const region_energy *e, int64_t g, double share, const double *turn,
                              double *linear, double *c3, double *c4, double *work,
                              thrum_error *error) {
  const int64_t r = e->model->rank, n3 = thrum_c3_count(r), n4 = thrum_c4_count(r);
  const double *from = linear_of(e, g), *from3 = from + r * r, *from4 = from3 + n3;
  double *to3 = linear + r * r, *to4 = to3 + n3;
  turn_linear(r, turn, from, work, linear);
  if (e->count > 1) {
    THRUM_TRY(thrum_polynomial_change_basis(r, turn, from3, from4, to3, to4, error));
  } else {
    memcpy(to3, from3, (size_t)n3 * sizeof *to3);
    memcpy(to4, from4, (size_t)n4 * sizeof *to4);
  }
  for (int64_t c = 0; c < n3; c++)
    c3[c] += share * to3[c];
  for (int64_t c = 0; c < n4; c++)
    c4[c] += share * to4[c];
  return THRUM_OK;
}

thrum_status region_energy_body(const region_energy *energy, const double *factors,
                                region_body *body, thrum_error *error) {
  const int64_t r = energy->model->rank, n3 = thrum_c3_count(r), n4 = thrum_c4_count(r);
  const int64_t count = energy->count, all = 2 * r * r + 2 * r + n3 + n4;
  memset(body, 0, sizeof *body);
  THRUM_TRY(thrum_reserve(&body->parts, count, sizeof *body->parts, "a body", error));
  THRUM_TRY(thrum_reserve(&body->forms, count, sizeof *body->forms, "a body", error));
  THRUM_TRY(thrum_reserve(&body->block, all + count * part_size(r), sizeof *body->block, "a body",
                          error));
  double *none = body->block, *omega2 = none + r, *c3 = omega2 + r, *c4 = c3 + n3, *work = c4 + n4;
  double *parts = body->block + all;
  body->turn = work + r * r;
  THRUM_TRY(find_modes(energy, factors, omega2, body->turn, work, error));
  for (int64_t g = 0; g < count; g++)
    THRUM_TRY(turn_part(energy, g, factors[g], body->turn, parts + g * part_size(r), c3, c4, work,
                        error));

  // the sum steps, and the parts are what it changes by
  body->model = (thrum_model){.rank = r, .c3_count = n3, .c4_count = n4, .c3 = c3, .c4 = c4};
  const size_t size = thrum_round_up(thrum_model_pack_size(&body->model));
  THRUM_TRY(thrum_reserve_aligned(&body->packed, ((size_t)count + 1) * size, "a body", error));
  unsigned char *at = body->packed;
  THRUM_TRY(pack(energy, omega2, c3, c4, &at, &body->model, error));
  for (int64_t g = 0; g < count; g++) {
    const double *linear = parts + g * part_size(r), *part3 = linear + r * r;
    THRUM_TRY(pack(energy, none, part3, part3 + n3, &at, &body->forms[g], error));
    body->parts[g] = (thrum_energy_part){.linear = linear, .form = &body->forms[g]};
  }
  return THRUM_OK;
}

void region_body_free(region_body *body) {
  free(body->parts);
  free(body->forms);
  free(body->block);
  free(body->packed);
  body->parts = NULL;
  body->forms = NULL;
  body->block = NULL;
  body->packed = NULL;
}
