/* A model scaled by a length s, a stiffness e (of Young's modulus) and a density d (thrum/model.h,
 * design 3).
 *
 * A body s times as large has the strains of the given one where u' = s u, so V'(u') = e s^3 V(u)
 * and M' = d s^3 M. From U'^T M' U' = 1 follows U' = k U with k = (d s^3)^-1/2, and from
 * U' q' = s U q the coordinates q = g q' with g = k / s. Hence
 *   V'(q') = e s^3 V(g q'):  omega2' = e/(s^2 d) omega2,  c3' = e s^3 g^3 c3,  c4' = e s^3 g^4 c4,
 * or for cubature points weights s^3, moduli e and gradients g times as large, and
 *   U'^T M' 1 = d s^3 k U^T M 1.
 * Cost: one pass over the arrays.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "core/model/model_layout.h"
#include "core/polynomial/points.h"
#include "thrum/polynomial.h"

/* Factor of each array. */
typedef struct factors {
  double omega2, c3, c4, axis_mass, basis, follow, weight, modulus, gradient;
} factors;

/* Doubles of what a lower rank would share with the model and a scale does not. */
static size_t vertex_doubles(const thrum_model *model) {
  return model->vertices ? 3 * (size_t)model->vertex_count : 0;
}

static size_t material_doubles(const thrum_model *model) {
  return model->material ? 3 * (size_t)model->region_count : 0;
}

static size_t spring_doubles(const thrum_model *model) {
  return model->springs ? 3 * (size_t)model->vertex_count : 0;
}

static size_t rigid_doubles(const thrum_model *model) {
  return model->rigid ? 18 * (size_t)model->vertex_count : 0;
}

static thrum_status find_factors(const thrum_model_scaling *by, factors *found,
                                 thrum_error *error) {
  // all three factors are finite and positive
  const double s = by->length, e = by->stiffness, d = by->density;
  if (!(s > 0.0) || !(e > 0.0) || !(d > 0.0) || !isfinite(s) || !isfinite(e) || !isfinite(d))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "a model is scaled by %g in length, %g in stiffness and %g in density; "
                           "all must be finite and > 0",
                           s, e, d);

  // lengths by s, stresses by e, masses by d s^3; q keeps unit mass, so the basis shrinks by k and
  // each power of q brings one g = k / s
  const double volume = s * s * s, k = 1.0 / sqrt(d * volume), g = k / s;
  const factors f = {.omega2 = e / (s * s * d),
                     .c3 = e * volume * (g * g * g),
                     .c4 = e * volume * (g * g * g * g),
                     .axis_mass = d * volume * k,
                     .basis = k,
                     .follow = g,
                     .weight = volume,
                     .modulus = e,
                     .gradient = g};

  // a factor beyond the range of numbers would leave a model of zeros or infinities
  const double all[] = {f.omega2, f.c3, f.c4, f.axis_mass, f.basis, f.follow, f.weight};
  for (int n = 0; n < 7; n++)
    if (!isnormal(all[n]))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "scaled by %g in length, %g in stiffness and %g in density the model "
                             "leaves the range of numbers",
                             s, e, d);

  *found = f;
  return THRUM_OK;
}

thrum_status thrum_model_scale_size(const thrum_model *model, size_t *size, thrum_error *error) {
  size_t own = 0;
  const thrum_status status = thrum_model_lock_size(model, model ? model->rank : 0, &own, error);
  if (status != THRUM_OK)
    return status;
  if (!size)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "size is NULL");
  *size = thrum_round_up(own) + thrum_round_up(vertex_doubles(model) * sizeof(double)) +
          thrum_round_up(material_doubles(model) * sizeof(double)) +
          thrum_round_up(spring_doubles(model) * sizeof(double)) +
          thrum_round_up(rigid_doubles(model) * sizeof(double));
  return THRUM_OK;
}

/* The part of `memory` that `array` points to, to be written. */
static double *within(void *memory, const void *array) {
  const ptrdiff_t offset = (const unsigned char *)array - (const unsigned char *)memory;
  return (double *)(void *)((unsigned char *)memory + offset);
}

/* to = by * from, `count` doubles; false when one is not finite. */
static bool multiply(const double *from, size_t count, double by, double *to) {
  bool finite = true;
  for (size_t n = 0; n < count; n++) {
    to[n] = by * from[n];
    finite = finite && isfinite(to[n]);
  }
  return finite;
}

/* `count` doubles of `from`, times `by`, at *next, which moves on; NULL for none. */
static double *append(unsigned char **next, const double *from, size_t count, double by,
                      bool *finite) {
  if (count == 0)
    return NULL;
  double *part = (double *)(void *)*next;
  *finite = multiply(from, count, by, part) && *finite;
  *next += thrum_round_up(count * sizeof *part);
  return part;
}

/* Scales weights, moduli and gradients of its cubature points. */
static bool scale_points(void *memory, const thrum_model *model, const factors *f,
                         const thrum_model *scaled) {
  const size_t count = (size_t)model->point_count;
  return multiply(model->point_weights, count, f->weight, within(memory, scaled->point_weights)) &&
         multiply(model->point_moduli, 2 * count, f->modulus,
                  within(memory, scaled->point_moduli)) &&
         multiply(model->point_gradients, THRUM_POINT_ROWS * count * (size_t)model->rank,
                  f->gradient, within(memory, scaled->point_gradients));
}

/* The factor of the energy that an actuator of level 1 has, each power of q aside. */
static double energy_factor(int32_t kind, const thrum_model_scaling *by) {
  const double volume = by->length * by->length * by->length;
  if (kind == THRUM_ACTUATOR_TENDON)
    return by->length;
  return kind == THRUM_ACTUATOR_STRAIN ? by->stiffness * volume : volume;
}

/* Actuators of the same levels: pressures in Pa, strains, tensions in N. */
static bool scale_actuators(void *memory, const thrum_model *model, const factors *f,
                            const thrum_model_scaling *by, const thrum_model *scaled) {
  const size_t r = (size_t)model->rank, square = r * r, cube = (size_t)model->actuator_cube;
  const double g = f->follow;
  size_t chamber = 0;
  bool finite = true;
  for (size_t n = 0; n < (size_t)model->actuator_count; n++) {
    const int32_t kind = model->actuator_kind[n];
    const double e = energy_factor(kind, by);
    double *rest = within(memory, scaled->actuator_rest + 3 * n);
    rest[0] *= e;
    finite = multiply(model->actuator_linear + n * r, r, e * g,
                      within(memory, scaled->actuator_linear + n * r)) &&
             multiply(model->actuator_quadratic + n * square, square, e * (g * g),
                      within(memory, scaled->actuator_quadratic + n * square)) &&
             isfinite(rest[0]) && finite;
    if (kind != THRUM_ACTUATOR_PRESSURE && kind != THRUM_ACTUATOR_GAS)
      continue;
    finite = multiply(model->actuator_cubic + chamber * cube, cube, e * (g * g * g),
                      within(memory, scaled->actuator_cubic + chamber * cube)) &&
             finite;
    chamber++;
  }

  // guides move as the body does
  const size_t guides = 3 * (size_t)model->guide_count;
  if (guides > 0)
    finite =
        multiply(model->guide_places, guides, by->length, within(memory, scaled->guide_places)) &&
        multiply(model->guide_rows, guides * r, f->basis, within(memory, scaled->guide_rows)) &&
        finite;
  return finite;
}

/* The arrays of `scaled`, a copy of `model` that lies in `memory`; false: not all are finite. */
static bool scale_arrays(void *memory, unsigned char *next, const thrum_model *model,
                         const factors *f, const thrum_model_scaling *by, thrum_model *scaled) {
  // the polynomial
  const size_t rank = (size_t)model->rank;
  bool finite = multiply(model->omega2, rank, f->omega2, within(memory, scaled->omega2));
  if (thrum_has_points(model))
    finite = scale_points(memory, model, f, scaled) && finite;
  else
    finite = multiply(model->c3, (size_t)model->c3_count, f->c3, within(memory, scaled->c3)) &&
             multiply(model->c4, (size_t)model->c4_count, f->c4, within(memory, scaled->c4)) &&
             finite;

  // what the mesh and the loads need
  if (model->axis_mass)
    finite =
        multiply(model->axis_mass, 3 * rank, f->axis_mass, within(memory, scaled->axis_mass)) &&
        finite;
  if (model->basis)
    finite = multiply(model->basis, 3 * (size_t)model->vertex_count * rank, f->basis,
                      within(memory, scaled->basis)) &&
             finite;

  finite = scale_actuators(memory, model, f, by, scaled) && finite;

  // arrays that a copy shares with its model get memory of their own
  scaled->vertices = append(&next, model->vertices, vertex_doubles(model), by->length, &finite);
  scaled->rigid = append(&next, model->rigid, rigid_doubles(model), f->basis, &finite);
  scaled->springs =
      append(&next, model->springs, spring_doubles(model), by->stiffness * by->length, &finite);
  double *material = append(&next, model->material, material_doubles(model), 1.0, &finite);
  scaled->material = material;

  // Young's modulus and density of each region
  for (int64_t n = 0; material && n < model->region_count; n++) {
    material[3 * n] *= by->stiffness;
    material[3 * n + 2] *= by->density;
    finite = finite && isfinite(material[3 * n]) && isfinite(material[3 * n + 2]);
  }
  return finite;
}

thrum_status thrum_model_scale(void *memory, size_t memory_size, const thrum_model *model,
                               const thrum_model_scaling *by, const thrum_model **scaled,
                               thrum_error *error) {
  // what cannot be scaled is refused before the memory is touched
  size_t size = 0, own = 0;
  factors f = {0};
  THRUM_TRY(thrum_model_scale_size(model, &size, error));
  if (!by || !scaled)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "by or scaled is NULL");
  THRUM_TRY(find_factors(by, &f, error));
  if (memory_size < size)
    return thrum_error_set(error, THRUM_BUFFER_TOO_SMALL,
                           "the memory has %zu bytes, this model needs %zu", memory_size, size);

  // a copy at the same rank has every array that changes; the rest goes behind it
  const thrum_model *copy = NULL;
  THRUM_TRY(thrum_model_lock(memory, memory_size, model, model->rank, &copy, error));
  thrum_model_lock_size(model, model->rank, &own, NULL);
  thrum_model result = *copy;
  result.damping = NULL;
  if (!scale_arrays(memory, (unsigned char *)memory + thrum_round_up(own), model, &f, by, &result))
    return thrum_error_set(error, THRUM_BAD_VALUE, "the scaled model leaves the range of numbers");

  // the packed coefficients come from the scaled ones
  const void *packed = copy->packed ? (const void *)copy->packed : copy->packed_single;
  if (packed)
    THRUM_TRY(
        thrum_model_pack(&result, within(memory, packed), thrum_model_pack_size(model), error));

  // y = g^-1 F(g q', g q') of slaves that are quadratic in the masters
  result.follow_scale = f.follow * model->follow_scale;
  result.unit_energy *= by->stiffness * by->length * by->length * by->length;
  result.identity = thrum_model_identity(&result);
  memcpy(memory, &result, sizeof result);
  *scaled = memory;
  return THRUM_OK;
}
