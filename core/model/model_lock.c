/* A model whose highest coordinates are held at zero (thrum/model.h, design 3).
 *
 * In block order what stays of each row is a run of every k, so the coefficients are copied run by
 * run, none is computed. Cost: one pass over what stays.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "core/base/alignment_check.h"
#include "core/model/model_layout.h"
#include "core/polynomial/points.h"
#include "core/polynomial/polynomial_private.h"

/* The arrays that a lower rank has anew, in doubles. */
typedef struct parts {
  size_t omega2, c3, c4, axis_mass, basis, weights, moduli, gradients, packed;
  size_t rest, linear, quadratic, cubic, places, guides; /* of actuators */
} parts;

static parts parts_of(const thrum_model *model, int64_t rank) {
  parts p = {.omega2 = (size_t)rank,
             .axis_mass = model->axis_mass ? 3 * (size_t)rank : 0,
             .basis = model->basis ? 3 * (size_t)model->vertex_count * (size_t)rank : 0};

  const size_t actuators = (size_t)model->actuator_count;
  p.rest = 3 * actuators;
  p.linear = actuators * p.omega2;
  p.quadratic = p.linear * p.omega2;
  p.cubic = (size_t)(model->chamber_count * thrum_pair_count(rank)) * p.omega2;
  p.places = 3 * (size_t)model->guide_count;
  p.guides = p.places * p.omega2;

  // the same model of fewer columns says how much of it is packed
  thrum_model lower = *model;
  lower.rank = rank;
  p.packed = thrum_model_pack_size(&lower) / sizeof(double);
  if (thrum_has_points(model)) {
    p.weights = (size_t)model->point_count;
    p.moduli = 2 * p.weights;
    p.gradients = THRUM_POINT_ROWS * p.weights * (size_t)rank;
    return p;
  }
  p.c3 = (size_t)thrum_c3_count(rank);
  p.c4 = (size_t)thrum_c4_count(rank);
  return p;
}

thrum_status thrum_model_lock_size(const thrum_model *model, int64_t rank, size_t *size,
                                   thrum_error *error) {
  if (!model || !size || !thrum_has_energy(model))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the model or size is NULL, or the model has no omega2, or neither c3 "
                           "and c4 nor cubature points");
  if (rank < 1 || rank > model->rank)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "rank %lld is asked for; the model has 1 to %lld", (long long)rank,
                           (long long)model->rank);
  if (model->shape && rank != model->rank)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "a condensed model has no lower rank: condense its shape model to it");
  const parts p = parts_of(model, rank);
  *size = thrum_round_up(sizeof(thrum_model)) + thrum_round_up(p.omega2 * sizeof(double)) +
          thrum_round_up(p.c3 * sizeof(double)) + thrum_round_up(p.c4 * sizeof(double)) +
          thrum_round_up(p.axis_mass * sizeof(double)) + thrum_round_up(p.basis * sizeof(double)) +
          thrum_round_up(p.weights * sizeof(double)) + thrum_round_up(p.moduli * sizeof(double)) +
          thrum_round_up(p.gradients * sizeof(double)) + thrum_round_up(p.rest * sizeof(double)) +
          thrum_round_up(p.linear * sizeof(double)) + thrum_round_up(p.quadratic * sizeof(double)) +
          thrum_round_up(p.cubic * sizeof(double)) + thrum_round_up(p.places * sizeof(double)) +
          thrum_round_up(p.guides * sizeof(double)) + p.packed * sizeof(double);
  return THRUM_OK;
}

/* The coefficients whose indices all lie below `rank`. */
static void copy_c3(const thrum_model *model, int64_t rank, double *to) {
  const double *from = model->c3;
  for (int64_t j = 0; j < rank; j++)
    for (int64_t i = 0; i <= j; i++) {
      memcpy(to, from, (size_t)(rank - j) * sizeof *to);
      to += rank - j;
      from += model->rank - j;
    }
}

static void copy_c4(const thrum_model *model, int64_t rank, double *to) {
  const double *from = model->c4;
  for (int64_t j = 0; j < rank; j++)
    for (int64_t i = 0; i <= j; i++) {
      const double *run = from;
      for (int64_t k = j; k < rank; k++) {
        memcpy(to, run, (size_t)(rank - k) * sizeof *to);
        to += rank - k;
        run += model->rank - k;
      }
      from += thrum_pair_count(model->rank - j);
    }
}

/* The first `rank` columns of a matrix. */
static void copy_columns(int64_t rows, int64_t columns, int64_t rank, const double *from,
                         double *to) {
  for (int64_t n = 0; n < rows; n++)
    memcpy(to + n * rank, from + n * columns, (size_t)rank * sizeof *to);
}

/* The actuators of a lower rank, behind `at`, which moves on. */
static void lock_actuators(unsigned char **at, const thrum_model *model, const parts *p,
                           int64_t rank, thrum_model *lower) {
  double *rest = thrum_cut_doubles(at, p->rest), *linear = thrum_cut_doubles(at, p->linear);
  double *quadratic = thrum_cut_doubles(at, p->quadratic), *cubic = thrum_cut_doubles(at, p->cubic);
  double *places = thrum_cut_doubles(at, p->places), *guides = thrum_cut_doubles(at, p->guides);
  const int64_t count = model->actuator_count, r = model->rank;
  if (count == 0)
    return;
  memcpy(rest, model->actuator_rest, p->rest * sizeof *rest);
  copy_columns(count, r, rank, model->actuator_linear, linear);
  for (int64_t n = 0; n < count; n++)
    copy_columns(rank, r, rank, model->actuator_quadratic + n * r * r, quadratic + n * rank * rank);

  // of the products q_i q_j those of the first coordinates
  double *to = cubic;
  for (int64_t n = 0; n < model->chamber_count; n++)
    for (int64_t i = 0; i < rank; i++) {
      const int64_t before = thrum_pair_count(r) - thrum_pair_count(r - i);
      copy_columns(rank - i, r, rank, model->actuator_cubic + n * model->actuator_cube + before * r,
                   to);
      to += (rank - i) * rank;
    }
  if (model->guide_count > 0)
    memcpy(places, model->guide_places, p->places * sizeof *places);
  copy_columns(3 * model->guide_count, r, rank, model->guide_rows, guides);

  lower->actuator_rest = rest;
  lower->actuator_linear = linear;
  lower->actuator_quadratic = quadratic;
  lower->actuator_square = rank * rank;
  lower->actuator_cubic = model->chamber_count > 0 ? cubic : NULL;
  lower->actuator_cube = model->chamber_count > 0 ? thrum_pair_count(rank) * rank : 0;
  lower->guide_places = model->guide_count > 0 ? places : NULL;
  lower->guide_rows = model->guide_count > 0 ? guides : NULL;
}

thrum_status thrum_model_lock(void *memory, size_t memory_size, const thrum_model *model,
                              int64_t rank, const thrum_model **locked, thrum_error *error) {
  // the memory is checked before it is touched
  size_t size = 0;
  THRUM_TRY(thrum_model_lock_size(model, rank, &size, error));
  if (!memory || !locked)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "memory or locked is NULL");
  THRUM_TRY(thrum_alignment_check("model", memory, memory_size, size, error));

  // where each array of the lower rank stands
  const parts p = parts_of(model, rank);
  thrum_model lower = *model;
  unsigned char *at = (unsigned char *)memory + thrum_round_up(sizeof lower);
  double *omega2 = thrum_cut_doubles(&at, p.omega2), *c3 = thrum_cut_doubles(&at, p.c3),
         *c4 = thrum_cut_doubles(&at, p.c4);
  double *axis_mass = thrum_cut_doubles(&at, p.axis_mass), *basis = thrum_cut_doubles(&at, p.basis);
  double *weights = thrum_cut_doubles(&at, p.weights), *moduli = thrum_cut_doubles(&at, p.moduli);
  double *gradients = thrum_cut_doubles(&at, p.gradients);
  lock_actuators(&at, model, &p, rank, &lower);

  // the coefficients of the first coordinates, and their columns of the basis
  memcpy(omega2, model->omega2, p.omega2 * sizeof *omega2);
  if (p.gradients > 0) {
    memcpy(weights, model->point_weights, p.weights * sizeof *weights);
    memcpy(moduli, model->point_moduli, p.moduli * sizeof *moduli);
    copy_columns(THRUM_POINT_ROWS * model->point_count, model->rank, rank, model->point_gradients,
                 gradients);
  } else {
    copy_c3(model, rank, c3);
    copy_c4(model, rank, c4);
  }
  if (model->axis_mass)
    copy_columns(3, model->rank, rank, model->axis_mass, axis_mass);
  if (model->basis)
    copy_columns(3 * model->vertex_count, model->rank, rank, model->basis, basis);

  // the struct, with the packed coefficients behind the arrays
  lower.rank = rank;
  lower.c3_count = (int64_t)p.c3;
  lower.c4_count = (int64_t)p.c4;
  lower.omega2 = omega2;
  lower.c3 = p.c3 > 0 ? c3 : NULL;
  lower.c4 = p.c4 > 0 ? c4 : NULL;
  lower.point_weights = p.weights > 0 ? weights : NULL;
  lower.point_moduli = p.moduli > 0 ? moduli : NULL;
  lower.point_gradients = p.gradients > 0 ? gradients : NULL;
  lower.axis_mass = model->axis_mass ? axis_mass : NULL;
  lower.basis = model->basis ? basis : NULL;
  lower.levels = NULL;
  lower.inertia = NULL;
  lower.damping = NULL;
  lower.region_energy = lower.region_mass = NULL;
  lower.energy_size = lower.mass_size = 0;
  THRUM_TRY(thrum_model_pack(&lower, at, size - (size_t)(at - (unsigned char *)memory), error));
  lower.identity = thrum_model_identity(&lower);
  memcpy(memory, &lower, sizeof lower);
  *locked = memory;
  return THRUM_OK;
}
