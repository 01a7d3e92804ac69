/* The shares of regions: those of the model's file, or each is reduced from the mesh; the energy of
 * a body of one region needs no mesh. A body of other values is made of them by the library.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/identify/region_body.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/alignment_check.h"
#include "platform/allocate.h"
#include "precompute/model/model_fem.h"
#include "precompute/polynomial/region_shares.h"
#include "thrum/parameters.h"

#define SAME 1e-6 /* of the largest stiffness: by which the sum of the regions may differ */

/* --- the shares ------------------------------------------------------------------------------- */

/* Room for shares of moduli and densities, and for a material where the model has none. */
static thrum_status reserve_shares(region_shares *s, thrum_error *error) {
  thrum_model *model = &s->model;
  const int64_t r = model->rank;
  model->region_count = s->count;
  model->energy_size = r * r + model->c3_count + model->c4_count;
  model->mass_size = r * (r + 3);
  THRUM_TRY(thrum_reserve(&s->energy, 2 * s->count * model->energy_size, sizeof *s->energy,
                          "the regions", error));
  THRUM_TRY(
      thrum_reserve(&s->mass, s->count * model->mass_size, sizeof *s->mass, "the regions", error));
  model->region_energy = s->energy;
  model->region_mass = s->mass;
  if (model->material)
    return THRUM_OK;

  // E = 1 Pa, a Poisson's ratio of 0 and 1 kg/m^3
  THRUM_TRY(thrum_reserve(&s->material, 3 * s->count, sizeof *s->material, "the regions", error));
  for (int64_t g = 0; g < s->count; g++)
    s->material[3 * g] = s->material[3 * g + 2] = 1;
  model->material = s->material;
  return THRUM_OK;
}

static thrum_status reduce_shares(const thrum_model *model, region_shares *s, thrum_error *error) {
  thrum_model_fem body = {0};
  thrum_status status = thrum_model_fem_create(model, &body, error);
  THRUM_THEN(status,
             thrum_region_shares(&body.fem, body.kind, &s->model, s->energy, s->mass, error));
  thrum_model_fem_free(&body);
  return status;
}

/* One region is the whole model. As E alone changes, all of its energy may be mu's. */
static thrum_status take_whole(region_shares *s, thrum_error *error) {
  const thrum_model *model = &s->model;
  const int64_t r = model->rank;
  double values[3];
  THRUM_TRY(thrum_model_parameters_get(model, values, error));
  double *linear = s->energy + model->energy_size, *c3 = linear + r * r, *c4 = c3 + model->c3_count;
  for (int64_t i = 0; i < r; i++) {
    linear[i * r + i] = model->omega2[i] / values[1];
    s->mass[i * r + i] = 1 / values[2];
  }
  for (int64_t n = 0; n < model->c3_count; n++)
    c3[n] = model->c3[n] / values[1];
  for (int64_t n = 0; n < model->c4_count; n++)
    c4[n] = model->c4[n] / values[1];
  return THRUM_OK;
}

/* Stiffness and mass of these values. */
static void sum_shares(const region_shares *s, const double *values, double *stiffness,
                       double *mass) {
  const thrum_model *model = &s->model;
  const int64_t square = model->rank * model->rank;
  memset(stiffness, 0, (size_t)square * sizeof *stiffness);
  memset(mass, 0, (size_t)square * sizeof *mass);
  for (int64_t g = 0; g < s->count; g++) {
    const double *v = values + 3 * g, *lambda = model->region_energy + 2 * g * model->energy_size;
    const double *mu = lambda + model->energy_size, *m = model->region_mass + g * model->mass_size;
    for (int64_t n = 0; n < square; n++) {
      stiffness[n] += v[0] * lambda[n] + v[1] * mu[n];
      mass[n] += v[2] * m[n];
    }
  }
}

/* Do the regions add up to the model? */
static thrum_status check_sum(const region_shares *s, thrum_error *error) {
  const int64_t r = s->model.rank;
  double *stiffness = NULL, worst = 0, worst_mass = 0;
  THRUM_TRY(thrum_reserve(&stiffness, 2 * r * r, sizeof *stiffness, "the regions", error));
  double *mass = stiffness + r * r;
  sum_shares(s, s->values, stiffness, mass);
  for (int64_t i = 0; i < r; i++) {
    stiffness[i * r + i] -= s->model.omega2[i];
    mass[i * r + i] -= 1;
  }
  for (int64_t n = 0; n < r * r; n++) {
    worst = fmax(worst, fabs(stiffness[n]));
    worst_mass = fmax(worst_mass, fabs(mass[n]));
  }
  free(stiffness);
  if (worst <= SAME * s->model.omega2[r - 1] && worst_mass <= SAME)
    return THRUM_OK;
  return thrum_error_set(error, THRUM_UNSUPPORTED,
                         "the regions of the mesh do not add up to the model, which was scaled or "
                         "made in another way");
}

thrum_status region_shares_open(const thrum_model *model, bool by_material, region_shares *shares,
                                thrum_error *error) {
  *shares =
      (region_shares){.model = *model, .count = model->region_count > 1 ? model->region_count : 1};
  if (model->c3 == NULL || model->c4 == NULL)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "the model has no polynomial of all its coordinates: make one without "
                           "--condense, --cubature and --law");
  const bool given = thrum_model_parameter_count(model) > 0;
  const bool whole = !given && shares->count == 1 && !by_material;
  shares->whole = whole;
  if (!given && !whole && (model->basis == NULL || model->tets == NULL))
    return thrum_error_set(error, THRUM_MISSING,
                           "the model has no mesh to tell its regions and moduli apart");

  if (!given) {
    THRUM_TRY(reserve_shares(shares, error));
    THRUM_TRY(whole ? take_whole(shares, error) : reduce_shares(model, shares, error));
  }
  shares->model.basis = NULL;
  shares->model.rigid = NULL;
  THRUM_TRY(thrum_reserve(&shares->values, 3 * shares->count, sizeof *shares->values, "the regions",
                          error));
  THRUM_TRY(thrum_model_parameters_get(&shares->model, shares->values, error));
  return check_sum(shares, error);
}

void region_shares_close(region_shares *shares) {
  free(shares->values);
  free(shares->energy);
  free(shares->mass);
  free(shares->material);
  memset(shares, 0, sizeof *shares);
}

/* --- a body of other values ------------------------------------------------------------------- */

/* back = turn^T M, the inverse of turn, as turn^T M turn = 1. work: rank x rank, twice. */
static void put_back(const region_shares *s, const double *values, region_body *body,
                     double *work) {
  const int64_t r = s->model.rank;
  double *mass = work + r * r;
  sum_shares(s, values, work, mass);
  for (int64_t i = 0; i < r; i++)
    for (int64_t j = 0; j < r; j++) {
      double sum = 0;
      for (int64_t k = 0; k < r; k++)
        sum += body->turn[k * r + i] * mass[k * r + j];
      body->back[i * r + j] = sum;
    }
}

thrum_status region_body_make(const region_shares *shares, const double *values, region_body *body,
                              thrum_error *error) {
  const int64_t r = shares->model.rank;
  const thrum_model *set = NULL;
  size_t size = 0, work_count = 0;
  double *work = NULL;
  memset(body, 0, sizeof *body);
  THRUM_TRY(thrum_model_parameters_size(&shares->model, &size, &work_count, error));
  THRUM_TRY(thrum_reserve(&body->turn, 2 * r * r, sizeof *body->turn, "a body", error));
  THRUM_TRY(thrum_reserve_aligned(&body->memory, size, "a body", error));
  THRUM_TRY(thrum_reserve(&work, (int64_t)work_count, sizeof *work, "a body", error));
  body->back = body->turn + r * r;
  thrum_status status = thrum_model_set_parameters(body->memory, size, &shares->model, values,
                                                   body->turn, work, &set, error);
  if (status >= 0)
    put_back(shares, values, body, work);
  free(work);
  THRUM_THEN(status, thrum_parameter_parts_create(set, &body->list, error));
  if (status < 0)
    return status;
  body->model = *set;
  body->parts = thrum_parameter_parts_list(body->list);
  return THRUM_OK;
}

void region_body_free(region_body *body) {
  thrum_parameter_parts_destroy(body->list);
  free(body->turn);
  free(body->memory);
  memset(body, 0, sizeof *body);
}
