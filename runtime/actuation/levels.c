/* The levels of a state's actuators (thrum/actuation.h).
 *
 * Between two changes of its level an actuator is a potential, so its work is a times the change of
 * its measure, and is summed up where a level changes or q is set; no step costs anything for it.
 * A change of levels changes V at once, at the same q and p. What a solve has kept for the next
 * step is taken along: R and V where `energy` starts, the acceleration of newmark, and a momentum
 * that is stored half a step before q. The guards learn what the energy that they know of lost.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/actuation/levels.h"

#include <math.h>
#include <string.h>

#include "core/base/finite.h"
#include "core/schemes/schemes.h"
#include "core/schemes/staggered_momentum.h"
#include "core/step/state_private.h"
#include "runtime/actuation/acting.h"
#include "runtime/guard/guards.h"
#include "runtime/points/point_flow.h"
#include "thrum/actuation.h"

#define JUMP_MOST 1e-4 /* work of a change of level on a carried correction, over |p|^2 */

/* --- a model ---------------------------------------------------------------------------------- */

int64_t thrum_model_actuators(const thrum_model *model) {
  return model && model->actuator_kind ? model->actuator_count : 0;
}

const char *thrum_model_actuator_text(const thrum_model *model, int64_t index) {
  if (index < 0 || index >= thrum_model_actuators(model))
    return NULL;
  const char *text = (const char *)model->actuator_texts;
  for (; index > 0; index--)
    text += strlen(text) + 1;
  return text;
}

thrum_status thrum_model_actuator(const thrum_model *model, const char *name, int64_t *index,
                                  thrum_error *error) {
  if (!model || !name || !index)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "thrum_model_actuator: an argument is NULL");
  const int64_t count = thrum_model_actuators(model);
  const size_t length = strlen(name);
  const char *text = (const char *)model->actuator_texts;
  for (int64_t k = 0; k < count; k++, text += strlen(text) + 1)
    if (strncmp(text, name, length) == 0 && text[length] == '=') {
      *index = k;
      return THRUM_OK;
    }
  if (count == 0)
    return thrum_error_set(error, THRUM_MISSING, "no actuator '%.100s': the model has none", name);
  text = thrum_model_actuator_text(model, 0);
  return thrum_error_set(error, THRUM_MISSING, "no actuator '%.100s'; the first of %lld is '%.*s'",
                         name, (long long)count, (int)strcspn(text, "="), text);
}

static thrum_status check_model(const thrum_model *model, thrum_error *error) {
  if (!model)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the model is NULL");
  if (thrum_model_actuators(model) > 0)
    return THRUM_OK;
  if (thrum_model_actuators(model->shape) > 0)
    return thrum_error_set(
        error, THRUM_UNSUPPORTED,
        "actuators act on coordinates that are stepped, and in a condensed model "
        "some follow at rest: step the model uncondensed");
  return thrum_error_set(error, THRUM_UNSUPPORTED,
                         "the model has no actuators: make it with thrum precompute --actuator");
}

static thrum_status check_levels(const thrum_model *model, const double *levels,
                                 thrum_error *error) {
  for (int64_t k = 0; levels && k < model->actuator_count; k++) {
    const char *text = thrum_model_actuator_text(model, k);
    const int length = (int)strcspn(text, "=");
    if (!isfinite(levels[k]))
      return thrum_error_set(error, THRUM_BAD_VALUE, "the level of %.*s is %g; it must be finite",
                             length, text, levels[k]);
    const double outside = model->actuator_rest[3 * k + 1];
    if (model->actuator_kind[k] == THRUM_ACTUATOR_GAS && !(outside + levels[k] >= 0.0))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "the level of the gas %.*s is %g Pa, which with the %g Pa outside "
                             "leaves no pressure",
                             length, text, levels[k], outside);
  }
  return THRUM_OK;
}

int64_t thrum_model_actuation_count(const thrum_model *model) {
  return thrum_model_actuators(model) > 0 ? thrum_acting_count(model) : 0;
}

thrum_status thrum_model_actuate(const thrum_model *model, const double *levels, double *memory,
                                 thrum_model *acting, thrum_error *error) {
  THRUM_TRY(check_model(model, error));
  if (!memory || !acting)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "memory or acting is NULL");
  THRUM_TRY(check_levels(model, levels, error));
  thrum_acting_fill(model, memory);
  for (int64_t k = 0; levels && k < model->actuator_count; k++)
    memory[k] = levels[k];
  thrum_acting_sum(model, memory);
  *acting = *model;
  acting->levels = memory;
  return THRUM_OK;
}

thrum_status thrum_model_actuation_force(const thrum_model *acting, int64_t index, const double *q,
                                         double *force, double *work, thrum_error *error) {
  THRUM_TRY(check_model(acting, error));
  if (!acting->levels || !q || index < 0 || index >= acting->actuator_count)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "actuator %lld of %lld: q is NULL, there is none of this index, or the "
                           "model is not one of thrum_model_actuate",
                           (long long)index, (long long)acting->actuator_count);
  if (!thrum_all_finite(q, acting->rank))
    return thrum_error_set(error, THRUM_BAD_VALUE, "q has a number that is not finite");
  double slope[THRUM_RANK_MAX] = {0.0}, only[THRUM_ACTUATORS_MAX] = {0.0};
  double measures[THRUM_ACTUATORS_MAX], bases[THRUM_ACTUATORS_MAX];
  only[index] = 1.0;
  thrum_acting_measures(thrum_kernel_get(THRUM_KERNEL_BEST), acting, q, only, slope, measures,
                        bases);
  const double measure = measures[index];
  if (!isfinite(measure) || !thrum_all_finite(slope, acting->rank))
    return thrum_error_set(error, THRUM_NOT_FINITE,
                           "at this q the force of actuator %lld is beyond the range of finite "
                           "numbers",
                           (long long)index);
  if (force)
    memcpy(force, slope, (size_t)acting->rank * sizeof *force);
  if (work)
    *work = measure;
  return THRUM_OK;
}

/* --- a state ---------------------------------------------------------------------------------- */

void thrum_actuation_plan(const thrum_model *model, thrum_state *state) {
  state->levels_count = thrum_model_actuation_count(model);
}

void thrum_actuation_prepare(const thrum_model *model, thrum_state *state) {
  if (state->levels_count > 0)
    thrum_acting_fill(model, thrum_state_view_of(state).levels);
}

const thrum_model *thrum_actuated_model(const thrum_model *model, thrum_state *state,
                                        thrum_model *copy) {
  const thrum_model *flowed = thrum_flowed_model(model, state, copy);
  if (state->levels_count == 0)
    return flowed;
  if (flowed != copy)
    *copy = *flowed;
  copy->levels = thrum_state_view_of(state).levels;
  return copy;
}

/* A number of each actuator. */
static double *row_of(const thrum_model *model, double *levels, thrum_acting_row row) {
  return levels + row * model->actuator_count;
}

/* What one has done at this level since its work was summed up last, where it now measures m. */
static double work_since(const thrum_model *model, double *levels, int64_t k, double level,
                         double m, double base) {
  return level * (m - row_of(model, levels, THRUM_ACTING_MEASURE)[k]) -
         (base - row_of(model, levels, THRUM_ACTING_BASE)[k]);
}

/* Adds that to its sum, with the rounding of the sum kept beside (Neumaier). */
static void sum_up(const thrum_model *model, double *levels, int64_t k, double level, double m,
                   double base) {
  const double added = work_since(model, levels, k, level, m, base);
  double *sum = row_of(model, levels, THRUM_ACTING_WORK) + k;
  const double before = *sum, after = before + added;

  // work beyond the range of numbers is not accounted
  if (!isfinite(after))
    return;
  row_of(model, levels, THRUM_ACTING_CARRY)[k] +=
      fabs(before) >= fabs(added) ? (before - after) + added : (added - after) + before;
  *sum = after;
}

/* From now on it is summed up from here. */
static void begin_at(const thrum_model *model, double *levels, int64_t k, double m, double base) {
  const bool known = isfinite(m) && isfinite(base);
  row_of(model, levels, THRUM_ACTING_MEASURE)[k] = known ? m : 0.0;
  row_of(model, levels, THRUM_ACTING_BASE)[k] = known ? base : 0.0;
}

/* Sums the work of all up where a state leaves a place, and begins anew from where it is. */
static void begin_all(const thrum_model *model, thrum_state *state, bool leaves) {
  if (state->levels_count == 0)
    return;
  const thrum_state_view view = thrum_state_view_of(state);
  double measures[THRUM_ACTUATORS_MAX], bases[THRUM_ACTUATORS_MAX];
  thrum_model seen = *model;
  seen.levels = view.levels;
  thrum_acting_measures(view.kernel, &seen, view.q, NULL, NULL, measures, bases);
  for (int64_t k = 0; k < model->actuator_count; k++) {
    if (leaves)
      sum_up(model, view.levels, k, view.levels[k], measures[k], bases[k]);
    begin_at(model, view.levels, k, measures[k], bases[k]);
  }
}

void thrum_actuation_leave(const thrum_model *model, thrum_state *state) {
  begin_all(model, state, true);
}

void thrum_actuation_arrive(const thrum_model *model, thrum_state *state) {
  begin_all(model, state, false);
}

/* --- a change of levels ----------------------------------------------------------------------- */

/* What V loses by a change of levels at a place, by how much its force grows (rank), and what the
 * actuators measure there. */
typedef struct change {
  double energy;
  double force[THRUM_RANK_MAX];
  double measures[THRUM_ACTUATORS_MAX], bases[THRUM_ACTUATORS_MAX];
} change;

/* The change at q by levels that differ by so much from those in force. */
static void find_change(const thrum_model *model, const thrum_state_view *view,
                        const double *difference, const double *q, change *found) {
  found->energy = 0.0;
  memset(found->force, 0, (size_t)model->rank * sizeof *found->force);
  thrum_acting_measures(view->kernel, model, q, difference, found->force, found->measures,
                        found->bases);
  for (int64_t k = 0; k < model->actuator_count; k++)
    if (difference[k] != 0.0)
      found->energy += difference[k] * found->measures[k];
}

/* Moves R and V, from which `energy` goes on, to the new levels: at q, and at the start of the next
 * step, where that is another place. */
static void move_known(const thrum_model *model, thrum_state *state, const thrum_state_view *view,
                       const double *difference, const change *here) {
  if (state->potential_step != state->report.steps)
    return;
  change there;
  const change *start = here;
  if (state->carried) {
    double square = 0.0;
    find_change(model, view, difference, view->q_corrected, &there);
    start = &there;
    for (int32_t i = 0; i < state->rank; i++)
      square += view->p[i] * view->p[i];

    // a jump that does work on the correction ends what was carried
    if (!(fabs(start->energy - here->energy) <= JUMP_MOST * square)) {
      thrum_forget_forces(state);
      return;
    }
  }
  double force[THRUM_RANK_MAX];
  for (int32_t i = 0; i < state->rank; i++)
    force[i] = view->force_now[i] - start->force[i];
  if (!isfinite(state->potential - start->energy) ||
      !isfinite(state->potential_end - here->energy) || !thrum_all_finite(force, state->rank)) {
    thrum_forget_forces(state);
    return;
  }
  state->potential -= start->energy;
  if (state->carried)
    state->potential_end -= here->energy;
  memcpy(view->force_now, force, (size_t)state->rank * sizeof *view->force_now);
}

/* Writes levels and what follows from them. */
static void write_levels(const thrum_model *model, const thrum_state_view *view, const double *to) {
  memcpy(view->levels, to, (size_t)model->actuator_count * sizeof *to);
  thrum_acting_sum(model, view->levels);
}

/* The levels themselves, with p at the time of q as it is where a momentum is stored elsewhere. */
static thrum_status move_levels(const thrum_model *seen, thrum_state *state, thrum_state_view *view,
                                const double *to, thrum_error *error) {
  if (!thrum_row_of(state)->synchronise && thrum_staggered_modes(state) == 0) {
    write_levels(seen, view, to);
    return THRUM_OK;
  }
  double before[THRUM_ACTUATORS_MAX];
  memcpy(before, view->levels, (size_t)seen->actuator_count * sizeof *before);
  thrum_status status = thrum_staggered_synchronise(seen, state, view, NULL);
  if (status >= 0) {
    write_levels(seen, view, to);
    status =
        thrum_staggered_unsynchronise(seen, state, view, view->q, view->load_before, view->p_next);
  }
  if (status >= 0 && thrum_all_finite(view->p_next, state->rank)) {
    memcpy(view->p, view->p_next, (size_t)state->rank * sizeof *view->p);
    return THRUM_OK;
  }
  write_levels(seen, view, before);
  return thrum_error_set(error, status < 0 ? status : THRUM_NOT_FINITE,
                         "the momentum of this state cannot be had under these levels");
}

thrum_status thrum_state_set_actuation(const thrum_model *model, thrum_state *state,
                                       const double *levels, thrum_error *error) {
  THRUM_TRY(thrum_state_check_ready(model, state, error));
  THRUM_TRY(check_model(model, error));
  THRUM_TRY(check_levels(model, levels, error));
  double to[THRUM_ACTUATORS_MAX], difference[THRUM_ACTUATORS_MAX];
  const size_t all = (size_t)model->actuator_count * sizeof *to;
  for (int64_t k = 0; k < model->actuator_count; k++)
    to[k] = levels ? levels[k] : 0.0;
  thrum_state_view view = thrum_state_view_of(state);
  if (memcmp(to, view.levels, all) == 0)
    return THRUM_OK;

  // what changes at q, before anything is written
  thrum_model copy;
  const thrum_model *seen = thrum_actuated_model(model, state, &copy);
  double before[THRUM_ACTUATORS_MAX];
  memcpy(before, view.levels, all);
  for (int64_t k = 0; k < model->actuator_count; k++)
    difference[k] = to[k] - before[k];
  change here;
  find_change(seen, &view, difference, view.q, &here);
  bool finite = isfinite(here.energy) && thrum_all_finite(here.force, state->rank);
  for (int32_t i = 0; thrum_carries_acceleration(state) && i < state->rank; i++)
    finite = finite && isfinite(view.acceleration[i] + here.force[i]);
  if (!finite)
    return thrum_error_set(error, THRUM_NOT_FINITE,
                           "the forces of these levels are beyond the range of finite numbers");
  THRUM_TRY(move_levels(seen, state, &view, to, error));

  // from here on nothing fails: the account under the old levels, and what is known of the forces
  for (int64_t k = 0; k < model->actuator_count; k++)
    if (difference[k] != 0.0) {
      sum_up(model, view.levels, k, before[k], here.measures[k], here.bases[k]);
      begin_at(model, view.levels, k, here.measures[k], here.bases[k]);
    }
  move_known(seen, state, &view, difference, &here);
  for (int32_t i = 0; thrum_carries_acceleration(state) && i < state->rank; i++)
    view.acceleration[i] += here.force[i];
  thrum_guards_take(state, here.energy);
  return THRUM_OK;
}

/* --- reading ---------------------------------------------------------------------------------- */

static thrum_status check_read(const thrum_model *model, const thrum_state *state, const double *to,
                               thrum_error *error) {
  THRUM_TRY(thrum_state_check(model, state, error));
  THRUM_TRY(check_model(model, error));
  return to ? THRUM_OK
            : thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the place for the numbers is NULL");
}

/* A state that is only read, and the model with its levels. */
typedef struct reading {
  thrum_model model;
  thrum_state_view view;
} reading;

static reading read_state(const thrum_model *model, const thrum_state *state) {
  reading r = {.model = *model, .view = thrum_state_view_of((thrum_state *)(uintptr_t)state)};
  r.model.levels = r.view.levels;
  return r;
}

thrum_status thrum_state_actuation(const thrum_model *model, const thrum_state *state,
                                   double *levels, thrum_error *error) {
  THRUM_TRY(check_read(model, state, levels, error));
  const reading r = read_state(model, state);
  memcpy(levels, r.view.levels, (size_t)model->actuator_count * sizeof *levels);
  return THRUM_OK;
}

thrum_status thrum_state_actuation_work(const thrum_model *model, const thrum_state *state,
                                        double *work, thrum_error *error) {
  THRUM_TRY(check_read(model, state, work, error));
  const reading r = read_state(model, state);
  double measures[THRUM_ACTUATORS_MAX], bases[THRUM_ACTUATORS_MAX];
  thrum_acting_measures(r.view.kernel, &r.model, r.view.q, NULL, NULL, measures, bases);
  for (int64_t k = 0; k < model->actuator_count; k++)
    work[k] = row_of(model, r.view.levels, THRUM_ACTING_WORK)[k] +
              (row_of(model, r.view.levels, THRUM_ACTING_CARRY)[k] +
               work_since(model, r.view.levels, k, r.view.levels[k], measures[k], bases[k]));
  return THRUM_OK;
}

thrum_status thrum_state_actuation_measures(const thrum_model *model, const thrum_state *state,
                                            double *measures, thrum_error *error) {
  THRUM_TRY(check_read(model, state, measures, error));
  const reading r = read_state(model, state);
  thrum_acting_sizes(r.view.kernel, &r.model, r.view.q, measures);
  return THRUM_OK;
}
