/* Passes over a tape: backward with the derivatives of a loss, forward with a direction (design
 * 22). Each end of a step is evaluated once, as the end of one and the start of the next.
 *
 * A force f on what follows of a condensed model acts on the masters by J(x)^T f, with x in the
 * middle of the step. J(x) v = J(v) x, so that all its derivatives are such products.
 *
 * D of a mode is alpha + beta omega^2 plus what a caller adds to it, and a factor s of the
 * stiffness multiplies omega^2 in it too. A factor of the density divides all forces, in
 * coordinates that stay: its derivative is that of -s and of a factor of the loads with the
 * opposite sign.
 *
 * Levels of actuators belong to a step, so that an end between two steps of other levels is
 * evaluated with both. A factor of the stiffness is taken as one of all of V, what acts included,
 * and of pressures, tendons and gases, which do not follow it, is taken back by their levels and by
 * a factor of all gases.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include <string.h>

#include "core/base/finite.h"
#include "core/base/model_law.h"
#include "gradient/tape_private.h"
#include "thrum/actuation.h"
#include "thrum/condensed_model.h"

/* The scratch of a change; damping is zero. */
static thrum_step_change change_of(thrum_tape *tape) {
  thrum_step_change change = {.q = tape->change[0],
                              .p = tape->change[1],
                              .force = tape->change[2],
                              .force_before = tape->change[3],
                              .damping = tape->change[4],
                              .level = tape->level};
  memset(change.damping, 0, (size_t)tape->rank * sizeof(double));
  return change;
}

static void take_parts(const thrum_tape_gradient *from, thrum_step_change *change) {
  change->parts = from->parts;
  change->part = from->part;
  change->part_count = from->parts && from->part ? from->part_count : 0;
}

/* Words for what is not smooth. */
static const char *rough_text(thrum_rough_kind kind) {
  static const char *const texts[] = {[THRUM_ROUGH_NONE] = "",
                                      [THRUM_ROUGH_IMPACT] = "strikes",
                                      [THRUM_ROUGH_REST] = "rests on",
                                      [THRUM_ROUGH_STICK] = "sticks to",
                                      [THRUM_ROUGH_STORED] =
                                          "is thrown back by less than its spring by",
                                      [THRUM_ROUGH_GIVEN] = "is given back energy by",
                                      [THRUM_ROUGH_AGAIN] = "was solved anew on"};
  return texts[kind];
}

/* Refuses what is not smooth, unless the tape has a subgradient. */
static thrum_status check_contacts(const thrum_tape *tape, const thrum_tape_gradient *gradient,
                                   thrum_error *error) {
  if (tape->slope_count > 0 && gradient->parts && gradient->part_count > 0)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "steps with contact have no derivatives by parts of the energy");
  for (int64_t k = 0;
       tape->contacts && tape->subgradient == THRUM_SUBGRADIENT_NONE && k < tape->count; k++) {
    const thrum_contact_step_slopes *of = tape->contacts + k;
    if (of->kind != THRUM_ROUGH_NONE)
      return thrum_error_set(
          error, THRUM_UNSUPPORTED,
          "step %lld at t = %g s is not smooth: vertex %d %s obstacle %d; the subgradient of "
          "laws that stay as they are (THRUM_SUBGRADIENT_FIXED) passes it",
          (long long)k, (double)k * tape->step.equation.dt, (int)of->vertex, rough_text(of->kind),
          (int)of->obstacle);
  }
  return THRUM_OK;
}

static thrum_status check_pass(const thrum_model *model, const thrum_tape *tape,
                               const thrum_tape_gradient *gradient, thrum_error *error) {
  THRUM_TRY(thrum_tape_check(model, tape, error));
  if (!gradient)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the gradient is NULL");
  const bool held = model->shape || tape->actuators > 0;
  for (int64_t g = 0; held && gradient->parts && g < gradient->part_count; g++)
    if (gradient->parts[g].mass)
      return thrum_error_set(error, THRUM_UNSUPPORTED,
                             "part %lld moves mass, which what follows of a condensed model and "
                             "what acts do not have",
                             (long long)g);
  THRUM_TRY(check_contacts(tape, gradient, error));
  if (tape->divided < 0)
    return THRUM_OK;
  return thrum_error_set(error, THRUM_UNSUPPORTED,
                         "step %lld at t = %g s was not solved as it is, but divided into shorter "
                         "ones, which have no derivative here: lower dt or the load",
                         (long long)tape->divided, (double)tape->divided * tape->step.equation.dt);
}

/* Gives the model the levels of step k; true where they are others than it had. */
static bool take_levels(thrum_tape *tape, int64_t k) {
  const size_t all = (size_t)tape->actuators * sizeof(double);
  if (tape->actuators == 0 || tape->count == 0 ||
      memcmp(tape->acting, thrum_tape_levels(tape, k), all) == 0)
    return false;
  // cannot fail: these levels were those of a step
  thrum_model_actuate(&tape->seen, thrum_tape_levels(tape, k), tape->acting, &tape->seen, NULL);
  return true;
}

/* Makes step k ready to be passed, one of its ends evaluated. */
static thrum_status enter(thrum_tape *tape, int64_t k, const thrum_made_step *made, bool backward,
                          thrum_error *error) {
  thrum_linear_step *step = &tape->step;

  // both mean forces of `energy` need the same of the ends
  step->equation.form = (thrum_step_form)tape->form[k - tape->first];
  if (take_levels(tape, k)) {
    if (backward)
      thrum_linear_step_evaluate(step, made->q_next, &step->end);
    else
      thrum_linear_step_evaluate(step, made->q, &step->start);
  }
  if (backward)
    thrum_linear_step_evaluate(step, made->q, &step->start);
  else
    thrum_linear_step_evaluate(step, made->q_next, &step->end);
  if (thrum_linear_step_factor(step, made))
    return THRUM_OK;
  return thrum_error_set(error, THRUM_SINGULAR, "the Jacobian of step %lld at t = %g s is singular",
                         (long long)k, (double)k * step->equation.dt);
}

/* Is R cubic along a line? Not where a tendon or a gas acts, or the points have another law. */
static bool is_cubic(const thrum_model *model) {
  for (int64_t k = 0; k < thrum_model_actuators(model); k++)
    if (model->actuator_kind[k] == THRUM_ACTUATOR_TENDON ||
        model->actuator_kind[k] == THRUM_ACTUATOR_GAS)
      return false;
  return thrum_law_of_model(model) == THRUM_LAW_STVK;
}

/* The tape's linear step with the model and the arrays of a pass, its end at row `row` evaluated;
 * both mean forces of `energy` need the same there. */
static thrum_status begin(const thrum_model *model, thrum_tape *tape, int64_t row,
                          int64_t part_count, thrum_error *error) {
  thrum_linear_step *step = &tape->step;
  thrum_tape_prepare(model, tape);
  step->actuators = tape->actuators;
  step->inexact = !is_cubic(thrum_condensed_shape_model(model));
  step->levels_change = tape->actuators > 0;
  if (tape->actuators > 0) {
    THRUM_TRY(thrum_model_actuate(model, tape->end_levels, tape->acting, &tape->seen, error));
    take_levels(tape, row > 0 ? tape->count - 1 : 0);
    step->model = &tape->seen;
  }
  if (tape->count > 0)
    step->equation.form = (thrum_step_form)tape->form[0];
  memset(step->kept, 0, (size_t)step->rank * sizeof *step->kept);
  if (part_count > 0)
    thrum_linear_step_prepare_parts(step);
  thrum_linear_step_evaluate(step, tape->q + row * tape->rank, &step->start);
  return THRUM_OK;
}

static void add(double *to, const double *from, int64_t n) {
  for (int64_t i = 0; from && i < n; i++)
    to[i] += from[i];
}

/* --- what follows ----------------------------------------------------------------------------- */

/* The force of step k on what follows alone (width, into `to`). */
static void put_following(const thrum_tape *tape, int64_t k, double *to) {
  const double *force = thrum_tape_force(tape, k);
  for (int64_t i = 0; i < tape->width; i++)
    to[i] = i < tape->rank ? 0.0 : force[i];
}

/* The derivative by the force on the masters in step k becomes that by the whole force (width, into
 * `to`), and adds to that by the start of the step; `before` (rank) has that by the start of the
 * step before, which is added when that one has been passed. */
static void pull_following(const thrum_model *model, thrum_tape *tape, int64_t k,
                           thrum_step_change *change, double *before, double *to) {
  const int64_t r = tape->rank;
  double *middle = tape->change[5];
  for (int64_t i = 0; i < r; i++)
    change->q[i] += before[i];
  thrum_tape_ahead(tape, k, middle);
  thrum_condensed_velocity(model, middle, change->force, to);
  put_following(tape, k, tape->wide[1]);
  thrum_condensed_load(model, change->force, tape->wide[1], middle);
  for (int64_t i = 0; i < r; i++) {
    change->q[i] += (k > 0 ? 1.5 : 1.0) * middle[i];
    before[i] = k > 0 ? -0.5 * middle[i] : 0.0;
  }
}

/* The change of the force on the masters in step k (rank, into `to`) from that of the whole force
 * (width) and those of q at its start and before. */
static void push_following(const thrum_model *model, thrum_tape *tape, int64_t k,
                           const double *force, const double *q, const double *before, double *to) {
  double *middle = tape->change[6];
  thrum_tape_ahead(tape, k, middle);
  thrum_condensed_load(model, middle, force, to);
  for (int64_t i = 0; i < tape->rank; i++)
    middle[i] = k > 0 ? 1.5 * q[i] - 0.5 * before[i] : q[i];
  double *kept = tape->wide[1], *moved = tape->step.x;
  put_following(tape, k, kept);
  thrum_condensed_load(model, middle, kept, moved);
  add(to, moved, tape->rank);
}

/* The contact of step k; NULL: nothing touches. */
static const thrum_contact_step_slopes *contact_of(const thrum_tape *tape, int64_t k) {
  return tape->contacts && tape->contacts[k].count > 0 ? tape->contacts + k : NULL;
}

/* --- backward --------------------------------------------------------------------------------- */

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

/* What the sums over all steps say, `acts` by a factor of all that acts without following the
 * stiffness; false, and nothing is written, where one is not finite. */
static bool put_sums(const thrum_model *model, const thrum_tape *tape,
                     const thrum_step_change *change, double loads, double acts,
                     thrum_tape_gradient *gradient) {
  const int64_t r = tape->rank;
  double alpha = 0.0, beta = 0.0;
  for (int64_t i = 0; i < r; i++) {
    alpha += change->damping[i];
    beta += model->omega2[i] * change->damping[i];
  }
  const double all = change->stiffness + tape->step.equation.damping_beta * beta;
  const double sums[] = {alpha, beta, all, loads, acts};
  if (!thrum_all_finite(change->q, r) || !thrum_all_finite(change->p, r) ||
      !thrum_all_finite(change->damping, r) || !thrum_all_finite(sums, 5) ||
      !thrum_all_finite(change->part, change->part_count) ||
      (gradient->force && !thrum_all_finite(gradient->force, tape->count * tape->width)) ||
      (gradient->levels && !thrum_all_finite(gradient->levels, tape->count * tape->actuators)))
    return false;
  gradient->alpha = alpha;
  gradient->beta = beta;
  gradient->stiffness = all - acts;
  gradient->density = -all - loads;

  const size_t vector = (size_t)r * sizeof(double);
  if (gradient->q)
    memcpy(gradient->q, change->q, vector);
  if (gradient->p)
    memcpy(gradient->p, change->p, vector);
  if (gradient->damping)
    memcpy(gradient->damping, change->damping, vector);
  return true;
}

/* The derivatives by q and p at the end of step k have what is seen of them there. */
static void add_seen(const thrum_tape *tape, const double *q_bar, const double *p_bar,
                     const thrum_made_step *made, int64_t k, thrum_step_change *change) {
  const int64_t r = tape->rank;
  if ((k + 1) % tape->every != 0)
    return;
  const int64_t row = (k + 1) / tape->every;
  const double *q = q_bar ? q_bar + row * r : NULL, *p = p_bar ? p_bar + row * r : NULL;
  add(change->q, q, r);
  add(change->p, p, r);
  add_moved(change, -0.5, q, made->q_next, r);
  add_moved(change, -0.5, p, made->p_next, r);
}

/* Does an actuator stay as it is where the stiffness of the body changes? Of a gas the level does
 * not say all of its force. */
static bool is_held(const thrum_model *model, int64_t actuator) {
  const int32_t kind = model->actuator_kind[actuator];
  return kind == THRUM_ACTUATOR_PRESSURE || kind == THRUM_ACTUATOR_TENDON;
}

/* From the end of the run, where nothing has followed, to its start; *loads: a factor of all
 * forces, *acts: of the levels that do not follow the stiffness. */
static thrum_status pull_all(const thrum_model *model, thrum_tape *tape, const double *q_bar,
                             const double *p_bar, const thrum_tape_gradient *gradient,
                             thrum_step_change *change, double *loads, double *acts,
                             thrum_error *error) {
  const int64_t r = tape->rank, width = tape->width;
  const size_t vector = (size_t)r * sizeof(double);
  double *before = tape->change[model->shape ? 6 : 5];
  memset(before, 0, vector);
  memset(tape->p_end, 0, vector);
  for (int64_t k = tape->count - 1; k >= 0; k--) {
    THRUM_TRY(thrum_tape_reach(model, tape, k, error));
    const thrum_made_step made = thrum_tape_made(tape, k);
    double *force = gradient->force ? gradient->force + k * width : tape->wide[0];
    add_seen(tape, q_bar, p_bar, &made, k, change);
    thrum_linear_step_turn(&tape->step);
    THRUM_TRY(enter(tape, k, &made, true, error));
    const thrum_contact_step_slopes *touching = contact_of(tape, k);
    if (touching) {
      thrum_contact_slopes_end(&tape->step, touching, change->p);
      memcpy(tape->p_end, change->p, vector);
    }
    if (gradient->levels)
      change->level = gradient->levels + k * tape->actuators;
    for (int64_t a = 0; a < tape->actuators; a++)
      change->level[a] = 0.0;
    thrum_linear_step_pull(&tape->step, &made, change);
    for (int64_t a = 0; a < tape->actuators; a++)
      if (is_held(model, a))
        *acts += change->level[a] * thrum_tape_levels(tape, k)[a];

    // the force of this step, also as the one before the next
    if (model->shape) {
      add(change->force, tape->p_end, r);
      memcpy(tape->p_end, change->force_before, vector);
      pull_following(model, tape, k, change, before, force);
    } else {
      add(change->force, before, r);
      memcpy(before, change->force_before, vector);
      if (touching)
        thrum_contact_slopes_pull(&tape->step, &made, touching, tape->slopes + touching->first,
                                  tape->p_end, change);
      add_moved(change, -0.5, change->force, made.force, r);
      memcpy(force, change->force, vector);
    }
    const double *load = thrum_tape_force(tape, k);
    for (int64_t i = 0; i < width; i++)
      *loads += load[i] * force[i];
  }
  return THRUM_OK;
}

static void clear(double *numbers, int64_t count) {
  for (int64_t i = 0; numbers && i < count; i++)
    numbers[i] = 0.0;
}

thrum_status thrum_tape_pull_back(const thrum_model *model, thrum_tape *tape, const double *q_bar,
                                  const double *p_bar, thrum_tape_gradient *gradient,
                                  thrum_error *error) {
  THRUM_TRY(check_pass(model, tape, gradient, error));
  const int64_t r = tape->rank, last = tape->count, count = (last / tape->every + 1) * r;
  if ((q_bar && !thrum_all_finite(q_bar, count)) || (p_bar && !thrum_all_finite(p_bar, count)))
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "a derivative of the loss is not a finite number");

  thrum_step_change change = change_of(tape);
  double loads = 0.0, acts = 0.0;
  take_parts(gradient, &change);
  clear(change.part, change.part_count);
  memset(change.q, 0, (size_t)r * sizeof(double));
  memset(change.p, 0, (size_t)r * sizeof(double));
  thrum_status status = last > 0 ? thrum_tape_reach(model, tape, last - 1, error) : THRUM_OK;
  THRUM_THEN(status, begin(model, tape, last - tape->first, change.part_count, error));
  THRUM_THEN(status, pull_all(model, tape, q_bar, p_bar, gradient, &change, &loads, &acts, error));
  if (status >= 0) {
    thrum_linear_step_end_pull(&tape->step, tape->start_q, &change);
    add_moved(&change, 0.5, change.q, tape->start_q, r);
    add_moved(&change, 0.5, change.p, tape->start_p, r);
    add(change.q, q_bar, r);
    add(change.p, p_bar, r);
    if (!put_sums(model, tape, &change, loads, acts + change.gas, gradient))
      status = thrum_error_set(error, THRUM_NOT_FINITE,
                               "the gradient leaves the range of finite numbers: a run this long "
                               "and this chaotic has none of use");
  }
  if (status < 0) {
    clear(change.part, change.part_count);
    clear(gradient->force, last * tape->width);
    clear(gradient->levels, last * tape->actuators);
  }
  return status;
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

/* The change of the force of step k, that of the direction and those of densities, into
 * change->force, and that of the step before into change->force_before. before: q before. */
static void put_force(const thrum_model *model, thrum_tape *tape, int64_t k,
                      const thrum_tape_gradient *direction, thrum_step_change *change,
                      const double *before) {
  const int64_t width = tape->width;
  const double *force = thrum_tape_force(tape, k);
  double *moved = tape->wide[0];
  copy_or_zero(moved, direction->force ? direction->force + k * width : NULL, width);
  for (int64_t i = 0; i < width; i++)
    moved[i] -= direction->density * force[i];
  add_shares(change, -0.5, force, tape->rank, moved);
  copy_or_zero(change->force_before, change->force, tape->rank);
  if (model->shape)
    push_following(model, tape, k, moved, change->q, before, change->force);
  else
    copy_or_zero(change->force, moved, tape->rank);
}

/* The change of the levels of step k, what does not follow the stiffness taken back. */
static void put_levels(const thrum_model *model, thrum_tape *tape, int64_t k,
                       const thrum_tape_gradient *direction) {
  const double *levels = thrum_tape_levels(tape, k);
  copy_or_zero(tape->level, direction->levels ? direction->levels + k * tape->actuators : NULL,
               tape->actuators);
  for (int64_t a = 0; a < tape->actuators; a++)
    if (is_held(model, a))
      tape->level[a] -= direction->stiffness * levels[a];
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
  THRUM_TRY(check_pass(model, tape, direction, error));
  if (!q || !p)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "q or p is NULL");
  const int64_t r = tape->rank;
  thrum_step_change change = change_of(tape);
  change.stiffness = direction->stiffness - direction->density;
  change.gas = -direction->stiffness;
  take_parts(direction, &change);

  // the damping of each mode
  const double beta = direction->beta + tape->step.equation.damping_beta * change.stiffness;
  copy_or_zero(change.damping, direction->damping, r);
  for (int64_t i = 0; i < r; i++)
    change.damping[i] += direction->alpha + beta * model->omega2[i];

  copy_or_zero(change.q, direction->q, r);
  copy_or_zero(change.p, direction->p, r);
  copy_or_zero(change.force, NULL, r);
  copy_or_zero(q, change.q, r);
  copy_or_zero(p, change.p, r);
  add_shares(&change, 0.5, tape->start_q, r, change.q);
  add_shares(&change, 0.5, tape->start_p, r, change.p);
  if (tape->count > 0)
    THRUM_TRY(thrum_tape_reach(model, tape, 0, error));
  THRUM_TRY(begin(model, tape, 0, change.part_count, error));
  thrum_linear_step_begin_push(&tape->step, tape->start_q, &change);
  double *before = tape->change[5];
  for (int64_t k = 0; k < tape->count; k++) {
    THRUM_TRY(thrum_tape_reach(model, tape, k, error));
    const thrum_made_step made = thrum_tape_made(tape, k);
    put_force(model, tape, k, direction, &change, before);
    copy_or_zero(before, change.q, r);
    const thrum_contact_step_slopes *touching = contact_of(tape, k);
    if (touching)
      thrum_contact_slopes_push(&tape->step, &made, tape->slopes + touching->first, touching,
                                &change, tape->pressed);
    THRUM_TRY(enter(tape, k, &made, false, error));
    put_levels(model, tape, k, direction);
    thrum_linear_step_push(&tape->step, &made, &change);
    if (touching)
      thrum_contact_slopes_end(&tape->step, touching, change.p);
    for (int64_t i = 0; touching && i < r; i++)
      change.p[i] += touching->given * tape->pressed[i];
    if ((k + 1) % tape->every == 0) {
      const int64_t row = (k + 1) / tape->every;
      put_seen(&change, change.q, made.q_next, r, q + row * r);
      put_seen(&change, change.p, made.p_next, r, p + row * r);
    }
    thrum_linear_step_turn(&tape->step);
  }
  if (!thrum_all_finite(change.q, r) || !thrum_all_finite(change.p, r))
    return thrum_error_set(error, THRUM_NOT_FINITE,
                           "the change leaves the range of finite numbers");
  return THRUM_OK;
}
