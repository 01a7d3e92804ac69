/* Passes over a tape: backward with the derivatives of a loss, forward with a direction (design
 * 22). Each end of a step is evaluated once, as the end of one and the start of the next.
 *
 * D of a mode is alpha + beta omega^2 plus what a caller adds to it, and a factor s of the
 * stiffness multiplies omega^2 in it too. A factor of the density divides all forces, in
 * coordinates that stay: its derivative is that of -s and of a factor of the loads with the
 * opposite sign.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include <string.h>

#include "core/base/finite.h"
#include "gradient/tape_private.h"

static thrum_made_step made_step(const thrum_tape *tape, int64_t k) {
  const int64_t r = tape->rank;
  return (thrum_made_step){.q = tape->q + k * r,
                           .p = tape->p + k * r,
                           .q_next = tape->q + (k + 1) * r,
                           .p_next = tape->p + (k + 1) * r,
                           .force = tape->force + (k + 1) * r,
                           .force_before = tape->force + k * r};
}

/* The scratch of a change; damping is zero. */
static thrum_step_change change_of(thrum_tape *tape) {
  thrum_step_change change = {.q = tape->change[0],
                              .p = tape->change[1],
                              .force = tape->change[2],
                              .force_before = tape->change[3],
                              .damping = tape->change[4]};
  memset(change.damping, 0, (size_t)tape->rank * sizeof(double));
  return change;
}

static void take_parts(const thrum_tape_gradient *from, thrum_step_change *change) {
  change->parts = from->parts;
  change->part = from->part;
  change->part_count = from->parts && from->part ? from->part_count : 0;
}

static thrum_status check_pass(const thrum_model *model, const thrum_tape *tape,
                               thrum_error *error) {
  THRUM_TRY(thrum_tape_check(model, tape, error));
  for (int64_t k = 0; k < tape->count; k++)
    if (tape->form[k] == THRUM_TAPE_DIVIDED)
      return thrum_error_set(error, THRUM_UNSUPPORTED,
                             "step %lld at t = %g s was not solved as it is, but divided into "
                             "shorter ones, which have no derivative here: lower dt or the load",
                             (long long)k, (double)k * tape->step.equation.dt);
  return THRUM_OK;
}

/* Makes step k ready to be passed, one of its ends evaluated. */
static thrum_status enter(thrum_tape *tape, int64_t k, const thrum_made_step *made, bool backward,
                          thrum_error *error) {
  thrum_linear_step *step = &tape->step;

  // both mean forces of `energy` need the same of the ends
  step->equation.form = (thrum_step_form)tape->form[k];
  if (backward)
    thrum_linear_step_evaluate(step, made->q, &step->start);
  else
    thrum_linear_step_evaluate(step, made->q_next, &step->end);
  if (thrum_linear_step_factor(step, made))
    return THRUM_OK;
  return thrum_error_set(error, THRUM_SINGULAR, "the Jacobian of step %lld at t = %g s is singular",
                         (long long)k, (double)k * step->equation.dt);
}

/* The tape's linear step with the model and the arrays of a pass, its first end evaluated. */
static void begin(const thrum_model *model, thrum_tape *tape, int64_t k, int64_t part_count) {
  thrum_linear_step *step = &tape->step;
  step->model = model;
  step->rank = tape->rank;
  step->kappa = tape->kappa;
  step->nu = tape->nu;
  step->damping = tape->damping;
  if (tape->count > 0)
    step->equation.form = (thrum_step_form)tape->form[0];
  memset(step->kept, 0, (size_t)step->rank * sizeof *step->kept);
  if (part_count > 0)
    thrum_linear_step_prepare_parts(step);
  thrum_linear_step_evaluate(step, tape->q + k * tape->rank, &step->start);
}

/* --- backward --------------------------------------------------------------------------------- */

static void add(double *to, const double *from, int64_t n) {
  for (int64_t i = 0; from && i < n; i++)
    to[i] += from[i];
}

/* a M b */
static double product(const double *a, const double *matrix, const double *b, int64_t n) {
  double sum = 0.0;
  for (int64_t i = 0; i < n; i++)
    for (int64_t j = 0; j < n; j++)
      sum += a[i] * matrix[i * n + j] * b[j];
  return sum;
}

/* Adds what parts that move mass have by vectors of q: those given move against x, those seen with
 * it. */
static void add_moved(const thrum_step_change *change, double by, const double *bar,
                      const double *q, int64_t n) {
  for (int64_t g = 0; g < change->part_count && bar; g++)
    if (change->parts[g].mass)
      change->part[g] += by * product(bar, change->parts[g].mass, q, n);
}

/* What the sums over all steps say; false, and nothing is written, where one is not finite. */
static bool put_sums(const thrum_model *model, const thrum_tape *tape,
                     const thrum_step_change *change, double loads, thrum_tape_gradient *gradient) {
  const int64_t r = tape->rank;
  double alpha = 0.0, beta = 0.0;
  for (int64_t i = 0; i < r; i++) {
    alpha += change->damping[i];
    beta += model->omega2[i] * change->damping[i];
  }
  const double stiffness = change->stiffness + tape->step.equation.damping_beta * beta;
  const double sums[] = {alpha, beta, stiffness, loads};
  if (!thrum_all_finite(change->q, r) || !thrum_all_finite(change->p, r) ||
      !thrum_all_finite(change->damping, r) || !thrum_all_finite(sums, 4) ||
      !thrum_all_finite(change->part, change->part_count) ||
      !thrum_all_finite(tape->force_bar, tape->count * r))
    return false;
  gradient->alpha = alpha;
  gradient->beta = beta;
  gradient->stiffness = stiffness;
  gradient->density = -stiffness - loads;

  const size_t vector = (size_t)r * sizeof(double);
  if (gradient->force)
    memcpy(gradient->force, tape->force_bar, (size_t)tape->count * vector);
  if (gradient->q)
    memcpy(gradient->q, change->q, vector);
  if (gradient->p)
    memcpy(gradient->p, change->p, vector);
  if (gradient->damping)
    memcpy(gradient->damping, change->damping, vector);
  return true;
}

thrum_status thrum_tape_pull_back(const thrum_model *model, thrum_tape *tape, const double *q_bar,
                                  const double *p_bar, thrum_tape_gradient *gradient,
                                  thrum_error *error) {
  THRUM_TRY(check_pass(model, tape, error));
  if (!gradient)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the gradient is NULL");
  const int64_t r = tape->rank, last = tape->count, count = (last + 1) * r;
  if ((q_bar && !thrum_all_finite(q_bar, count)) || (p_bar && !thrum_all_finite(p_bar, count)))
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "a derivative of the loss is not a finite number");

  // from the end, where nothing has followed
  const size_t vector = (size_t)r * sizeof(double);
  thrum_step_change change = change_of(tape);
  double *before = tape->change[5], loads = 0.0;
  take_parts(gradient, &change);
  for (int64_t g = 0; g < change.part_count; g++)
    change.part[g] = 0.0;
  memset(change.q, 0, vector);
  memset(change.p, 0, vector);
  memset(before, 0, vector);
  begin(model, tape, last, change.part_count);
  for (int64_t k = last - 1; k >= 0; k--) {
    const double *seen_q = q_bar ? q_bar + (k + 1) * r : NULL;
    const double *seen_p = p_bar ? p_bar + (k + 1) * r : NULL;
    add(change.q, seen_q, r);
    add(change.p, seen_p, r);
    thrum_linear_step_turn(&tape->step);
    const thrum_made_step made = made_step(tape, k);
    add_moved(&change, -0.5, seen_q, made.q_next, r);
    add_moved(&change, -0.5, seen_p, made.p_next, r);
    THRUM_TRY(enter(tape, k, &made, true, error));
    thrum_linear_step_pull(&tape->step, &made, &change);

    // the force of this step, also as the one before the next
    add(change.force, before, r);
    memcpy(before, change.force_before, vector);
    add_moved(&change, -0.5, change.force, made.force, r);
    for (int64_t i = 0; i < r; i++)
      loads += made.force[i] * change.force[i];
    memcpy(tape->force_bar + k * r, change.force, vector);
  }
  thrum_linear_step_end_pull(&tape->step, tape->q, &change);
  add_moved(&change, 0.5, change.q, tape->q, r);
  add_moved(&change, 0.5, change.p, tape->p, r);
  add(change.q, q_bar, r);
  add(change.p, p_bar, r);
  if (!put_sums(model, tape, &change, loads, gradient))
    return thrum_error_set(error, THRUM_NOT_FINITE,
                           "the gradient leaves the range of finite numbers: a run this long and "
                           "this chaotic has none of use");
  return THRUM_OK;
}

/* --- forward ---------------------------------------------------------------------------------- */

static void copy_or_zero(double *to, const double *from, int64_t n) {
  for (int64_t i = 0; i < n; i++)
    to[i] = from ? from[i] : 0.0;
}

/* to += by of each share M v */
static void add_shares(const thrum_step_change *change, double by, const double *v, int64_t n,
                       double *to) {
  for (int64_t g = 0; g < change->part_count; g++)
    for (int64_t i = 0; i < n && change->parts[g].mass; i++)
      for (int64_t j = 0; j < n; j++)
        to[i] += by * change->part[g] * change->parts[g].mass[i * n + j] * v[j];
}

/* The change of a step's force: that of the direction, and those of densities. */
static void put_force(const thrum_tape *tape, int64_t k, const thrum_tape_gradient *direction,
                      const thrum_step_change *change, double *to) {
  const int64_t r = tape->rank;
  const double *force = tape->force + (k + 1) * r;
  copy_or_zero(to, k >= 0 && direction->force ? direction->force + k * r : NULL, r);
  for (int64_t i = 0; i < r; i++)
    to[i] -= direction->density * force[i];
  add_shares(change, -0.5, force, r, to);
}

/* What is seen of the change of one end, in the coordinates of the caller. */
static void put_seen(const thrum_step_change *change, const double *moved, const double *at,
                     int64_t n, double *to) {
  copy_or_zero(to, moved, n);
  add_shares(change, -0.5, at, n, to);
}

thrum_status thrum_tape_push_forward(const thrum_model *model, thrum_tape *tape,
                                     const thrum_tape_gradient *direction, double *q, double *p,
                                     thrum_error *error) {
  THRUM_TRY(check_pass(model, tape, error));
  if (!direction || !q || !p)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the direction, q or p is NULL");
  const int64_t r = tape->rank;
  thrum_step_change change = change_of(tape);
  change.stiffness = direction->stiffness - direction->density;
  take_parts(direction, &change);

  // the damping of each mode
  const double beta = direction->beta + tape->step.equation.damping_beta * change.stiffness;
  copy_or_zero(change.damping, direction->damping, r);
  for (int64_t i = 0; i < r; i++)
    change.damping[i] += direction->alpha + beta * model->omega2[i];

  copy_or_zero(change.q, direction->q, r);
  copy_or_zero(change.p, direction->p, r);
  copy_or_zero(q, change.q, r);
  copy_or_zero(p, change.p, r);
  add_shares(&change, 0.5, tape->q, r, change.q);
  add_shares(&change, 0.5, tape->p, r, change.p);
  begin(model, tape, 0, change.part_count);
  thrum_linear_step_begin_push(&tape->step, tape->q, &change);
  for (int64_t k = 0; k < tape->count; k++) {
    const thrum_made_step made = made_step(tape, k);
    put_force(tape, k, direction, &change, change.force);
    put_force(tape, k - 1, direction, &change, change.force_before);
    THRUM_TRY(enter(tape, k, &made, false, error));
    thrum_linear_step_push(&tape->step, &made, &change);
    put_seen(&change, change.q, made.q_next, r, q + (k + 1) * r);
    put_seen(&change, change.p, made.p_next, r, p + (k + 1) * r);
    thrum_linear_step_turn(&tape->step);
  }
  if (!thrum_all_finite(change.q, r) || !thrum_all_finite(change.p, r))
    return thrum_error_set(error, THRUM_NOT_FINITE,
                           "the change leaves the range of finite numbers");
  return THRUM_OK;
}
