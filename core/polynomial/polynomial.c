/* The reduced strain energy V(q), its gradient R, its Hessian T and T v, design (1), and V with the
 * explicit coordinates held, design 5: quadratic and linear terms, and the passes of a kernel over
 * the cubic and quartic ones (core/polynomial/kernel_private.h).
 *
 * With E = {0..split-1} at q_E, V(q_E, .) is contracted once a step; an iteration of the implicit
 * solve then sees rank - split coordinates only (core/polynomial/packed.h).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "core/polynomial/polynomial_private.h"

#include <math.h>
#include <string.h>

#include "core/polynomial/packed.h"

int64_t thrum_c3_index(int64_t rank, int64_t i, int64_t j, int64_t k) {
  // before block j come all terms but those of the blocks from j on: with i >= j, and with i < j
  const int64_t n = rank - j;
  const int64_t block = thrum_c3_count(rank) - thrum_c3_count(n) - j * thrum_pair_count(n);
  return block + i * n + (k - j);
}

int64_t thrum_c4_index(int64_t rank, int64_t i, int64_t j, int64_t k, int64_t l) {
  const int64_t n = rank - j, columns = thrum_pair_count(n);
  const int64_t block = thrum_c4_count(rank) - thrum_c4_count(n) - j * thrum_c3_count(n);
  return block + i * columns + (columns - thrum_pair_count(rank - k)) + (l - k);
}

size_t thrum_work_count(const thrum_model *model) {
  // points have no lists of columns; solvers take as much as a small model of coefficients needs
  const int64_t common = thrum_pack_work(model->rank), points = thrum_points_work(model->rank);
  if (thrum_has_points(model))
    return (size_t)(points > common ? points : common);
  return (size_t)thrum_pack_work_tangent(model->rank);
}

/* The kernel asked for, where the coefficients are packed for it, or its passes over points. */
static const thrum_kernel *fit(const thrum_kernel *by, const thrum_model *model) {
  if (thrum_has_points(model))
    return by->points ? by->points : thrum_passes.points;
  return thrum_is_packed(model) ? by : &thrum_kernel_reference;
}

/* The terms of degree 2, and, of a model that may flow, what was released of them (18.7). */
static double quadratic_energy(const thrum_model *model, const double *q) {
  double sum = 0;
  for (int64_t i = 0; i < model->rank; i++)
    sum += 0.5 * model->omega2[i] * q[i] * q[i];
  return model->point_plastic ? sum + thrum_passes.released_energy(model, q) : sum;
}

/* The gradient of the quadratic terms by the first n coordinates. */
static void linear_force(const thrum_model *model, int64_t n, const double *q, double *force) {
  for (int64_t i = 0; i < n; i++)
    force[i] = model->omega2[i] * q[i];
  for (int64_t i = 0; model->point_plastic && i < n; i++)
    force[i] -= thrum_points_released(model)[i];
}

/* The same onto a force of the points alone, where they see displacements shortened. */
static void add_linear_force(const thrum_model *model, const double *q, double *force) {
  thrum_passes.return_force(model, force);
  for (int64_t i = 0; i < model->rank; i++)
    force[i] += model->omega2[i] * q[i] - thrum_points_released(model)[i];
}

static void linear_tangent(const thrum_model *model, double *tangent) {
  const int64_t n = model->rank;
  memset(tangent, 0, (size_t)(n * n) * sizeof *tangent);
  for (int64_t i = 0; i < n; i++)
    tangent[i * n + i] = model->omega2[i];
}

static void add_linear_tangent(const thrum_model *model, double *tangent) {
  const int64_t n = model->rank;
  thrum_passes.return_tangent(model, tangent);
  for (int64_t i = 0; i < n; i++)
    tangent[i * n + i] += model->omega2[i];
}

/* Where the points see q: there, or in `seen`. */
static const double *place_of(const thrum_model *model, const double *q, double *seen) {
  if (!thrum_points_shorten(model))
    return q;
  thrum_passes.see(model, q, seen);
  return seen;
}

static double own_energy(const thrum_kernel *by, const thrum_model *model, const double *q,
                         double *work) {
  double seen[THRUM_RANK_MAX];
  return quadratic_energy(model, q) + fit(by, model)->energy(model, place_of(model, q, seen), work);
}

static double own_force(const thrum_kernel *by, const thrum_model *model, const double *q,
                        double *force, double *work) {
  const double quadratic = quadratic_energy(model, q);
  if (!thrum_points_shorten(model)) {
    linear_force(model, model->rank, q, force);
    return quadratic + fit(by, model)->force(model, q, force, work);
  }

  // the points' own force first
  double seen[THRUM_RANK_MAX];
  memset(force, 0, (size_t)model->rank * sizeof *force);
  const double value = fit(by, model)->force(model, place_of(model, q, seen), force, work);
  add_linear_force(model, q, force);
  return quadratic + value;
}

static void own_forces(const thrum_kernel *by, const thrum_model *model, const double *const q[2],
                       double *const force[2], double energy[2], double *work) {
  // where points see displacements shortened, one read would save little
  if (thrum_points_shorten(model)) {
    for (int k = 0; k < 2; k++)
      energy[k] = own_force(by, model, q[k], force[k], work);
    return;
  }
  double value[2];
  for (int k = 0; k < 2; k++) {
    energy[k] = quadratic_energy(model, q[k]);
    linear_force(model, model->rank, q[k], force[k]);
  }
  fit(by, model)->forces(model, q, force, value, work);
  for (int k = 0; k < 2; k++)
    energy[k] += value[k];
}

static void own_tangent(const thrum_kernel *by, const thrum_model *model, const double *q,
                        double *tangent, double *work) {
  if (!thrum_points_shorten(model)) {
    linear_tangent(model, tangent);
    fit(by, model)->tangent(model, q, NULL, tangent, work);
    return;
  }
  double seen[THRUM_RANK_MAX];
  memset(tangent, 0, (size_t)(model->rank * model->rank) * sizeof *tangent);
  fit(by, model)->tangent(model, place_of(model, q, seen), NULL, tangent, work);
  add_linear_tangent(model, tangent);
}

static double own_force_tangent(const thrum_kernel *by, const thrum_model *model, const double *q,
                                double *force, double *tangent, double *work) {
  const double quadratic = quadratic_energy(model, q);
  if (!thrum_points_shorten(model)) {
    linear_force(model, model->rank, q, force);
    linear_tangent(model, tangent);
    return quadratic + fit(by, model)->tangent(model, q, force, tangent, work);
  }

  // the points' own first
  double seen[THRUM_RANK_MAX];
  const size_t vector = (size_t)model->rank * sizeof *force;
  memset(force, 0, vector);
  memset(tangent, 0, (size_t)model->rank * vector);
  const double value =
      fit(by, model)->tangent(model, place_of(model, q, seen), force, tangent, work);
  add_linear_force(model, q, force);
  add_linear_tangent(model, tangent);
  return quadratic + value;
}

static void own_product(const thrum_kernel *by, const thrum_model *model, const double *q,
                        const double *v, double *product, double *work) {
  if (!thrum_points_shorten(model)) {
    for (int64_t i = 0; i < model->rank; i++)
      product[i] = model->omega2[i] * v[i];
    fit(by, model)->tangent_vector(model, q, v, product, work);
    return;
  }
  double seen[THRUM_RANK_MAX], moved[THRUM_RANK_MAX];
  thrum_passes.see(model, v, moved);
  memset(product, 0, (size_t)model->rank * sizeof *product);
  fit(by, model)->tangent_vector(model, place_of(model, q, seen), moved, product, work);
  thrum_passes.return_force(model, product);
  for (int64_t i = 0; i < model->rank; i++)
    product[i] += model->omega2[i] * v[i];
}

/* --- with what acts on a state --------------------------------------------------------------- */

static double act(const thrum_kernel *by, const thrum_model *model, const double *q,
                  double *gradient, double *hessian, double weight) {
  return model->levels ? thrum_passes.act(by, model, q, gradient, hessian, weight) : 0.0;
}

double thrum_exchanged_energy_by(const thrum_kernel *by, const thrum_model *model,
                                 const double *q) {
  return fabs(act(by, model, q, NULL, NULL, 0.0));
}

double thrum_strain_energy_by(const thrum_kernel *by, const thrum_model *model, const double *q,
                              double *work) {
  return own_energy(by, model, q, work) + act(by, model, q, NULL, NULL, 0.0);
}

double thrum_internal_force_by(const thrum_kernel *by, const thrum_model *model, const double *q,
                               double *force, double *work) {
  const double own = own_force(by, model, q, force, work);
  return own + act(by, model, q, force, NULL, 0.0);
}

void thrum_internal_forces_by(const thrum_kernel *by, const thrum_model *model,
                              const double *const q[2], double *const force[2], double energy[2],
                              double *work) {
  own_forces(by, model, q, force, energy, work);
  for (int k = 0; k < 2; k++)
    energy[k] += act(by, model, q[k], force[k], NULL, 0.0);
}

void thrum_tangent_stiffness_near(const thrum_kernel *by, const thrum_model *model, double weight,
                                  const double *q, double *tangent, double *work) {
  own_tangent(by, model, q, tangent, work);
  act(by, model, q, NULL, tangent, weight);
}

double thrum_internal_force_tangent_near(const thrum_kernel *by, const thrum_model *model,
                                         double weight, const double *q, double *force,
                                         double *tangent, double *work) {
  const double own = own_force_tangent(by, model, q, force, tangent, work);
  return own + act(by, model, q, force, tangent, weight);
}

void thrum_tangent_stiffness_by(const thrum_kernel *by, const thrum_model *model, const double *q,
                                double *tangent, double *work) {
  thrum_tangent_stiffness_near(by, model, 0.0, q, tangent, work);
}

double thrum_internal_force_tangent_by(const thrum_kernel *by, const thrum_model *model,
                                       const double *q, double *force, double *tangent,
                                       double *work) {
  return thrum_internal_force_tangent_near(by, model, 0.0, q, force, tangent, work);
}

void thrum_tangent_product_by(const thrum_kernel *by, const thrum_model *model, const double *q,
                              const double *v, double *product, double *work) {
  own_product(by, model, q, v, product, work);
  if (model->levels)
    thrum_passes.act_along(by, model, q, v, product);
}

/* Integrators that ask for a part step no flow, so the points of the model see the whole of q. */
double thrum_internal_force_part(const thrum_kernel *by, const thrum_model *model, int32_t split,
                                 const double *q, double *force, double *work) {
  const double quadratic = quadratic_energy(model, q);
  linear_force(model, split, q, force);
  const double own = quadratic + fit(by, model)->force_part(model, split, q, force, work);
  if (!model->levels)
    return own;

  double all[THRUM_RANK_MAX] = {0.0};
  const double added = act(by, model, q, all, NULL, 0.0);
  for (int32_t i = 0; i < split; i++)
    force[i] += all[i];
  return own + added;
}

void thrum_tangent_product_part(const thrum_kernel *by, const thrum_model *model, int32_t split,
                                const double *q, const double *v, double *product, double *work) {
  for (int64_t i = 0; i < split; i++)
    product[i] = model->omega2[i] * v[i];
  fit(by, model)->tangent_vector_part(model, split, q, v, product, work);
  if (!model->levels)
    return;

  double all[THRUM_RANK_MAX] = {0.0}, part[THRUM_RANK_MAX] = {0.0};
  memcpy(part, v, (size_t)split * sizeof *part);
  thrum_passes.act_along(by, model, q, part, all);
  for (int32_t i = 0; i < split; i++)
    product[i] += all[i];
}

/* Fills what a model without a polynomial cannot give. */
static void fill_unknown(double *values, int64_t count) {
  for (int64_t n = 0; n < count; n++)
    values[n] = NAN;
}

double thrum_strain_energy(const thrum_model *model, const double *q, double *work) {
  if (!thrum_has_energy(model))
    return NAN;
  return thrum_strain_energy_by(thrum_kernel_get(THRUM_KERNEL_BEST), model, q, work);
}

double thrum_internal_force(const thrum_model *model, const double *q, double *force,
                            double *work) {
  if (thrum_has_energy(model))
    return thrum_internal_force_by(thrum_kernel_get(THRUM_KERNEL_BEST), model, q, force, work);
  fill_unknown(force, model->rank);
  return NAN;
}

void thrum_tangent_stiffness(const thrum_model *model, const double *q, double *tangent,
                             double *work) {
  if (thrum_has_energy(model))
    thrum_tangent_stiffness_by(thrum_kernel_get(THRUM_KERNEL_BEST), model, q, tangent, work);
  else
    fill_unknown(tangent, model->rank * model->rank);
}

double thrum_internal_force_tangent(const thrum_model *model, const double *q, double *force,
                                    double *tangent, double *work) {
  if (thrum_has_energy(model))
    return thrum_internal_force_tangent_by(thrum_kernel_get(THRUM_KERNEL_BEST), model, q, force,
                                           tangent, work);
  fill_unknown(force, model->rank);
  fill_unknown(tangent, model->rank * model->rank);
  return NAN;
}

void thrum_tangent_product(const thrum_model *model, const double *q, const double *v,
                           double *product, double *work) {
  if (thrum_has_energy(model))
    thrum_tangent_product_by(thrum_kernel_get(THRUM_KERNEL_BEST), model, q, v, product, work);
  else
    fill_unknown(product, model->rank);
}

/* q of the held coordinates, out of a restriction, and of the others. */
static void whole_place(const thrum_model *model, int32_t split, const double *restricted,
                        const double *q_high, double *q) {
  const int64_t n = model->rank - split;
  memcpy(q, restricted + thrum_restriction_count(model, n), (size_t)split * sizeof *q);
  memcpy(q + split, q_high, (size_t)n * sizeof *q);
}

void thrum_polynomial_restrict(const thrum_kernel *by, const thrum_model *model, int32_t split,
                               const double *q, double *restricted, double *work) {
  fit(by, model)->restrict_to(model, split, q, restricted, work);
  if (model->levels)
    memcpy(restricted + thrum_restriction_count(model, model->rank - split), q,
           (size_t)split * sizeof *q);
}

double thrum_restricted_gradient(const thrum_kernel *by, const thrum_model *model, int32_t split,
                                 const double *restricted, const double *q_high, double *gradient,
                                 double *work) {
  const double own =
      fit(by, model)->restricted_gradient(model, split, restricted, q_high, gradient, work);
  if (!model->levels)
    return own;

  double q[THRUM_RANK_MAX], all[THRUM_RANK_MAX] = {0.0};
  whole_place(model, split, restricted, q_high, q);
  const double added = act(by, model, q, all, NULL, 0.0);
  for (int64_t i = split; i < model->rank; i++)
    gradient[i - split] += all[i];
  return own + added;
}

void thrum_restricted_hessian(const thrum_kernel *by, const thrum_model *model, int32_t split,
                              const double *restricted, const double *q_high, double *hessian,
                              double *work) {
  fit(by, model)->restricted_hessian(model, split, restricted, q_high, hessian, work);
  if (!model->levels)
    return;

  // column by column, of which the others' part is kept
  const int64_t n = model->rank - split;
  double q[THRUM_RANK_MAX];
  whole_place(model, split, restricted, q_high, q);
  for (int64_t j = 0; j < n; j++) {
    double unit[THRUM_RANK_MAX] = {0.0}, column[THRUM_RANK_MAX] = {0.0};
    unit[split + j] = 1.0;
    thrum_passes.act_along(by, model, q, unit, column);
    for (int64_t i = 0; i < n; i++)
      hessian[i * n + j] += column[split + i];
  }
}
