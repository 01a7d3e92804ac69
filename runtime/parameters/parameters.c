/* A model of other moduli and densities from the shares of its regions (thrum/parameters.h, design
 * 22).
 *
 *   K = sum lambda_g K_lambda,g + mu_g K_mu,g,   M = sum rho_g M_g
 *
 * in the coordinates of the model, and likewise c3 and c4. The modes of the new body are the
 * columns of S, S^T M S = 1 and S^T K S diagonal: with M = C C^T they are C^-T Y, of the
 * eigenvectors Y of C^-1 K C^-T. Then q = S q', and the shares are turned with the rest, so that
 * the parameters of the new model can be set again.
 *
 * A density rho_g + t leaves unit mass to x = (1 + 1/2 t M_g) q, in which V(q) is to first order
 * V(x) - 1/2 t R(x) M_g x, a polynomial of the same degree.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "thrum/parameters.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "core/base/alignment_check.h"
#include "core/base/finite.h"
#include "core/base/lame.h"
#include "runtime/material/jacobi.h"
#include "runtime/parameters/form.h"
#include "thrum/polynomial.h"

#define SAME_FACTOR 1e-12 /* by which the factors of the densities of a free body may differ */

enum { PER_REGION = 3 }; /* lambda, mu and density */

/* --- values ----------------------------------------------------------------------------------- */

int64_t thrum_model_parameter_count(const thrum_model *model) {
  return model && model->region_energy && model->region_mass && model->material
             ? PER_REGION * model->region_count
             : 0;
}

static thrum_status check_model(const thrum_model *model, thrum_error *error) {
  if (!model)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the model is NULL");
  if (thrum_model_parameter_count(model) == 0)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "the model has no parameters: make it with thrum precompute "
                           "--parameters");
  if (model->springs)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "the model has springs to the ground, which are no share of a region");
  if (model->actuator_kind)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "the model has actuators, whose polynomials are those of its moduli");
  return THRUM_OK;
}

thrum_status thrum_model_parameters_get(const thrum_model *model, double *values,
                                        thrum_error *error) {
  THRUM_TRY(check_model(model, error));
  if (!values)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "values is NULL");
  for (int64_t g = 0; g < model->region_count; g++) {
    const thrum_lame lame = thrum_lame_of(model->material[3 * g], model->material[3 * g + 1]);
    values[PER_REGION * g] = lame.lambda;
    values[PER_REGION * g + 1] = lame.mu;
    values[PER_REGION * g + 2] = model->material[3 * g + 2];
  }
  return THRUM_OK;
}

static thrum_status check_values(const thrum_model *model, const double *values,
                                 thrum_error *error) {
  for (int64_t g = 0; g < model->region_count; g++) {
    const double *v = values + PER_REGION * g;
    if (!thrum_all_finite(v, PER_REGION) || !(v[1] > 0) || !(v[2] > 0) ||
        !(3 * v[0] + 2 * v[1] > 0))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "region %lld: lambda %g Pa, mu %g Pa and density %g kg/m^3 are those "
                             "of no material: mu, density and 3 lambda + 2 mu must be above 0",
                             (long long)g + 1, v[0], v[1], v[2]);
  }
  return THRUM_OK;
}

/* --- memory ----------------------------------------------------------------------------------- */

static size_t doubles(int64_t count) {
  return thrum_round_up((size_t)count * sizeof(double));
}

static int64_t rigid_count(const thrum_model *model) {
  return model->rigid ? 18 * model->vertex_count : 0;
}

thrum_status thrum_model_parameters_size(const thrum_model *model, size_t *size, size_t *work,
                                         thrum_error *error) {
  THRUM_TRY(check_model(model, error));
  size_t own = 0;
  THRUM_TRY(thrum_model_lock_size(model, model->rank, &own, error));
  const int64_t regions = model->region_count;
  const size_t r = (size_t)model->rank;
  if (size)
    *size = thrum_round_up(own) + doubles(3 * regions) + doubles(rigid_count(model)) +
            doubles(2 * regions * model->energy_size) + doubles(regions * model->mass_size);
  if (work)
    *work = 2 * r * r * r * r + 3 * r * r + 3 * r;
  return THRUM_OK;
}

/* The part of `memory` that `array` points to, to be written. */
static double *within(void *memory, const void *array) {
  const ptrdiff_t offset = (const unsigned char *)array - (const unsigned char *)memory;
  return (double *)(void *)((unsigned char *)memory + offset);
}

/* --- modes ------------------------------------------------------------------------------------ */

/* C of the symmetric M = C C^T into its lower triangle; false where M is not positive definite. */
static bool factor(int64_t rank, double *matrix) {
  for (int64_t i = 0; i < rank; i++)
    for (int64_t j = 0; j <= i; j++) {
      double sum = matrix[i * rank + j];
      for (int64_t k = 0; k < j; k++)
        sum -= matrix[i * rank + k] * matrix[j * rank + k];
      if (i == j && !(sum > 0))
        return false;
      matrix[i * rank + j] = i == j ? sqrt(sum) : sum / matrix[j * rank + j];
    }
  return true;
}

/* C^-1 A C^-T of a symmetric A, in place. */
static void reduce(int64_t rank, const double *factors, double *a) {
  // the columns, and then the rows, which are those of a symmetric matrix again
  for (int side = 0; side < 2; side++)
    for (int64_t c = 0; c < rank; c++) {
      const int64_t first = side == 0 ? c : c * rank, step = side == 0 ? rank : 1;
      for (int64_t i = 0; i < rank; i++) {
        double sum = a[first + i * step];
        for (int64_t k = 0; k < i; k++)
          sum -= factors[i * rank + k] * a[first + k * step];
        a[first + i * step] = sum / factors[i * rank + i];
      }
    }
  for (int64_t i = 0; i < rank; i++)
    for (int64_t j = 0; j < i; j++)
      a[i * rank + j] = a[j * rank + i] = 0.5 * (a[i * rank + j] + a[j * rank + i]);
}

/* Column `from` of the eigenvectors becomes mode `to`: C^-T of it, its largest entry positive. */
static void put_mode(int64_t rank, const double *factors, const double *vectors, int64_t from,
                     int64_t to, double *turn) {
  double largest = 0;
  for (int64_t i = rank - 1; i >= 0; i--) {
    double sum = vectors[i * rank + from];
    for (int64_t k = i + 1; k < rank; k++)
      sum -= factors[k * rank + i] * turn[k * rank + to];
    turn[i * rank + to] = sum / factors[i * rank + i];
    if (fabs(turn[i * rank + to]) > fabs(largest))
      largest = turn[i * rank + to];
  }
  for (int64_t i = 0; i < rank && largest < 0; i++)
    turn[i * rank + to] = -turn[i * rank + to];
}

/* Modes of the new body: omega2, ascending, and S into `turn`. work: 3 rank^2. */
static thrum_status find_modes(const thrum_model *model, const double *values, double *omega2,
                               double *turn, double *work, thrum_error *error) {
  const int64_t r = model->rank, regions = model->region_count;
  double *mass = work, *stiffness = mass + r * r, *vectors = stiffness + r * r;
  memset(stiffness, 0, (size_t)(r * r) * sizeof *stiffness);
  memset(mass, 0, (size_t)(r * r) * sizeof *mass);
  for (int64_t g = 0; g < regions; g++) {
    const double *v = values + PER_REGION * g;
    const double *lambda = model->region_energy + 2 * g * model->energy_size;
    const double *mu = lambda + model->energy_size, *share = model->region_mass;
    for (int64_t i = 0; i < r * r; i++) {
      stiffness[i] += v[0] * lambda[i] + v[1] * mu[i];
      mass[i] += v[2] * share[g * model->mass_size + i];
    }
  }
  if (!factor(r, mass))
    return thrum_error_set(error, THRUM_BAD_VALUE, "the masses of the regions are not positive");
  reduce(r, mass, stiffness);
  thrum_jacobi((int)r, stiffness, vectors);

  // ascending; what has been taken is infinite
  for (int64_t n = 0; n < r; n++) {
    int64_t least = 0;
    for (int64_t i = 1; i < r; i++)
      if (stiffness[i * r + i] < stiffness[least * r + least])
        least = i;
    omega2[n] = stiffness[least * r + least];
    if (!(omega2[n] >= 0) || isinf(omega2[n]))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "the stiffness of a body of these parameters is not positive");
    put_mode(r, mass, vectors, least, n, turn);
    stiffness[least * r + least] = INFINITY;
  }
  return THRUM_OK;
}

/* --- turning ---------------------------------------------------------------------------------- */

/* Turns `rows` rows of rank numbers: to = from S. */
static void turn_rows(int64_t rank, int64_t rows, const double *turn, const double *from,
                      double *to) {
  for (int64_t n = 0; n < rows; n++)
    for (int64_t j = 0; j < rank; j++) {
      double sum = 0;
      for (int64_t i = 0; i < rank; i++)
        sum += from[n * rank + i] * turn[i * rank + j];
      to[n * rank + j] = sum;
    }
}

/* c3 or c4 in the new coordinates. form: 2 rank^degree. */
static void turn_monomials(int64_t rank, int degree, int64_t entries, const double *turn,
                           const double *from, double *form, double *to) {
  thrum_form_expand(rank, degree, from, form);
  thrum_form_turn(rank, degree, turn, form, form + entries);
  thrum_form_collapse(rank, degree, form, to);
}

/* L, c3 and c4 of a modulus. */
static void turn_energy(const thrum_model *model, const double *turn, const double *from,
                        double *form, double *to) {
  const int64_t r = model->rank, square = r * r;
  memcpy(to, from, (size_t)square * sizeof *to);
  thrum_form_turn(r, 2, turn, to, form);
  from += square;
  to += square;
  turn_monomials(r, 3, square * r, turn, from, form, to);
  turn_monomials(r, 4, square * square, turn, from + model->c3_count, form, to + model->c3_count);
}

static void add_share(int64_t count, double by, const double *share, double *to) {
  for (int64_t n = 0; n < count; n++)
    to[n] += by * share[n];
}

/* The polynomial and the masses of the new body, and the shares of its parameters. */
static void fill_shares(const thrum_model *model, const double *values, const double *turn,
                        double *form, double *c3, double *c4, double *axis_mass, double *energy,
                        double *mass) {
  const int64_t r = model->rank, size = model->energy_size;
  memset(c3, 0, (size_t)model->c3_count * sizeof *c3);
  memset(c4, 0, (size_t)model->c4_count * sizeof *c4);
  for (int64_t n = 0; n < 2 * model->region_count; n++) {
    double *to = energy + n * size, *cubic = to + r * r;
    const double value = values[PER_REGION * (n / 2) + n % 2];
    turn_energy(model, turn, model->region_energy + n * size, form, to);
    add_share(model->c3_count, value, cubic, c3);
    add_share(model->c4_count, value, cubic + model->c3_count, c4);
  }

  for (int64_t i = 0; i < 3 * r && axis_mass; i++)
    axis_mass[i] = 0;
  for (int64_t g = 0; g < model->region_count; g++) {
    const double *from = model->region_mass + g * model->mass_size;
    double *to = mass + g * model->mass_size;
    memcpy(to, from, (size_t)(r * r) * sizeof *to);
    thrum_form_turn(r, 2, turn, to, form);
    turn_rows(r, 3, turn, from + r * r, to + r * r);
    if (axis_mass)
      add_share(3 * r, values[PER_REGION * g + 2], to + r * r, axis_mass);
  }
}

/* The rigid modes keep unit mass where all densities change by one factor. */
static thrum_status find_density_factor(const thrum_model *model, const double *values,
                                        double *found, thrum_error *error) {
  const double by = values[2] / model->material[2];
  for (int64_t g = 1; g < model->region_count && model->rigid; g++) {
    const double other = values[PER_REGION * g + 2] / model->material[3 * g + 2];
    if (!(fabs(other - by) <= SAME_FACTOR * by))
      return thrum_error_set(error, THRUM_UNSUPPORTED,
                             "the densities of a free body change by the factors %g and %g: it "
                             "then turns about another point, which takes a new precompute",
                             by, other);
  }
  *found = by;
  return THRUM_OK;
}

static void fill_materials(int64_t regions, const double *values, double *material) {
  for (int64_t g = 0; g < regions; g++) {
    const double lambda = values[PER_REGION * g], mu = values[PER_REGION * g + 1];
    material[3 * g] = mu * (3 * lambda + 2 * mu) / (lambda + mu);
    material[3 * g + 1] = lambda / (2 * (lambda + mu));
    material[3 * g + 2] = values[PER_REGION * g + 2];
  }
}

thrum_status thrum_model_set_parameters(void *memory, size_t memory_size, const thrum_model *model,
                                        const double *values, double *turn, double *work,
                                        const thrum_model **set, thrum_error *error) {
  // what cannot be set is refused before the memory is touched
  size_t size = 0, own = 0;
  double density = 1;
  THRUM_TRY(thrum_model_parameters_size(model, &size, NULL, error));
  if (!memory || !values || !work || !set)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "memory, values, work or set is NULL");
  THRUM_TRY(check_values(model, values, error));
  THRUM_TRY(find_density_factor(model, values, &density, error));
  THRUM_TRY(thrum_alignment_check("model", memory, memory_size, size, error));

  // the modes
  const int64_t r = model->rank, regions = model->region_count;
  double *omega2 = work, *change = omega2 + 3 * r, *form = change + r * r;
  THRUM_TRY(find_modes(model, values, omega2, change, form, error));

  // a copy has room for what changes; what it shares with the model goes behind it
  const thrum_model *copy = NULL;
  THRUM_TRY(thrum_model_lock(memory, memory_size, model, r, &copy, error));
  thrum_model_lock_size(model, r, &own, NULL);
  thrum_model result = *copy;
  unsigned char *next = (unsigned char *)memory + thrum_round_up(own);
  double *material = thrum_cut_doubles(&next, (size_t)(3 * regions));
  double *rigid = thrum_cut_doubles(&next, (size_t)rigid_count(model));
  double *energy = thrum_cut_doubles(&next, (size_t)(2 * regions * model->energy_size));
  double *mass = thrum_cut_doubles(&next, (size_t)(regions * model->mass_size));
  memcpy(within(memory, copy->omega2), omega2, (size_t)r * sizeof *omega2);
  fill_shares(model, values, change, form, within(memory, copy->c3), within(memory, copy->c4),
              copy->axis_mass ? within(memory, copy->axis_mass) : NULL, energy, mass);
  if (copy->basis)
    turn_rows(r, 3 * model->vertex_count, change, model->basis, within(memory, copy->basis));
  fill_materials(regions, values, material);
  for (int64_t n = 0; n < rigid_count(model); n++)
    rigid[n] = model->rigid[n] / sqrt(density);

  // what says the new body
  result.material = material;
  result.rigid = model->rigid ? rigid : NULL;
  result.region_energy = energy;
  result.region_mass = mass;
  result.energy_size = model->energy_size;
  result.mass_size = model->mass_size;
  result.unit_energy = 0;
  const void *packed = copy->packed ? (const void *)copy->packed : copy->packed_single;
  if (packed)
    THRUM_TRY(
        thrum_model_pack(&result, within(memory, packed), thrum_model_pack_size(&result), error));
  result.identity = thrum_model_identity(&result);
  memcpy(memory, &result, sizeof result);
  if (turn)
    memcpy(turn, change, (size_t)(r * r) * sizeof *turn);
  *set = memory;
  return THRUM_OK;
}

/* --- slopes ----------------------------------------------------------------------------------- */

/* - 1/2 of how a form changes where each of its indices is changed by M. form: 2 rank^degree. */
static void slope_of(int64_t rank, int degree, int64_t entries, const double *mass,
                     const double *monomials, double *form, double *to) {
  thrum_form_expand(rank, degree, monomials, form);
  thrum_form_turn_one(rank, degree, mass, form, form + entries);
  for (int64_t n = 0; n < entries; n++)
    form[entries + n] *= -0.5 * degree;
  thrum_form_collapse(rank, degree, form + entries, to);
}

thrum_status thrum_model_parameter_slope(const thrum_model *model, int64_t parameter,
                                         double *linear, double *c3, double *c4, double *mass,
                                         double *work, thrum_error *error) {
  THRUM_TRY(check_model(model, error));
  if (!linear || !c3 || !c4 || !mass || !work || parameter < 0 ||
      parameter >= thrum_model_parameter_count(model))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "an array is NULL, or parameter %lld is none of the %lld of the model",
                           (long long)parameter, (long long)thrum_model_parameter_count(model));
  const int64_t r = model->rank, square = r * r, kind = parameter % PER_REGION;
  const int64_t region = parameter / PER_REGION;
  if (kind < 2) {
    const double *from = model->region_energy + (2 * region + kind) * model->energy_size;
    memcpy(linear, from, (size_t)square * sizeof *linear);
    memcpy(c3, from + square, (size_t)model->c3_count * sizeof *c3);
    memcpy(c4, from + square + model->c3_count, (size_t)model->c4_count * sizeof *c4);
    memset(mass, 0, (size_t)square * sizeof *mass);
    return THRUM_OK;
  }

  const double *share = model->region_mass + region * model->mass_size;
  memcpy(mass, share, (size_t)square * sizeof *mass);
  for (int64_t i = 0; i < r; i++)
    for (int64_t j = 0; j < r; j++)
      linear[i * r + j] = -0.5 * (model->omega2[i] + model->omega2[j]) * share[i * r + j];
  slope_of(r, 3, square * r, mass, model->c3, work, c3);
  slope_of(r, 4, square * square, mass, model->c4, work, c4);
  return THRUM_OK;
}
