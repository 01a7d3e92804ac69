/* One step: candidates are made in scratch, checked, and only then committed, so that a step that
 * fails leaves the persistent part of the state as it was (design 8) and no NaN or Inf ever enters
 * it.
 *
 *   begin    forces are added to the load, and the scheme may be changed for this step
 *   attempt  one step of that scheme (schemes.h)
 *   end      the step may be attempted again by another scheme, or settled in another way; then the
 *            commit
 *
 * Who does that is in the table of hooks, thrum_schemes: a library without any steps by its schemes
 * alone.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "core/step/step.h"

#include <math.h>
#include <string.h>

#include "core/base/finite.h"
#include "core/schemes/discrete_gradient.h"
#include "core/schemes/dissipation.h"
#include "core/schemes/schemes.h"
#include "core/state/motion_norm.h"
#include "core/step/state_private.h"
#include "core/step/step_length.h"

#define EAGER_STEPS 96 /* with an eager Jacobian refresh after a late one */
#define AVERAGE_FIELD_STEPS                                                                        \
  64 /* of `energy` with the average vector field after a failed solve                             \
      */

/* --- commit ----------------------------------------------------------------------------------- */

/* Puts an inverse made in this step into the ring in place of the oldest; returns where it is. */
static double *keep_inverse(thrum_state *next, const thrum_state_view *view) {
  const size_t n = (size_t)(next->rank - next->split);

  // a newest one that is BFGS-updated is of several steps and is replaced; the others stay
  const bool another = next->jacobian_kept && next->inverse_step[0] >= 0;
  double *place = view->inverse[another ? THRUM_INVERSES - 1 : 0];
  if (another)
    next->inverse_place = (next->inverse_place + 1) % THRUM_INVERSES;
  for (int j = THRUM_INVERSES - 1; j > 0; j--)
    next->inverse_step[j] = another ? next->inverse_step[j - 1] : -1;

  next->inverse_step[0] = next->report.steps;
  next->jacobian_kept = 1;
  memcpy(place, view->jacobian_next, n * n * sizeof *place);
  return place;
}

/* The increment and its force, from which the next first guess extrapolates. */
static void remember_solve(thrum_state *next, const thrum_state_view *view,
                           const thrum_solve_report *report) {
  const size_t vector = (size_t)next->rank * sizeof(double);
  const int64_t at = thrum_past_at(view, next->report.steps);

  // points of another mean force do not continue these
  if (next->past_discrete != report->discrete)
    next->past_count = 0;
  next->past_discrete = report->discrete;
  memcpy(view->past_q + at, view->middle, vector);
  memcpy(view->past_r + at, view->force, vector);
  next->past_dt[thrum_past_place(next->report.steps)] = next->def.dt;
  next->past_count =
      next->past_count < THRUM_PAST_SOLVES ? next->past_count + 1 : THRUM_PAST_SOLVES;
  next->guess_last = report->guess;
}

/* The history that the next solve begins with. */
static void remember(const thrum_model *model, thrum_state *next, const thrum_state_view *view,
                     const thrum_solve_report *report) {
  const int64_t step = next->report.steps;
  if (report->solved)
    remember_solve(next, view, report);
  if (report->late_refresh)
    next->eager_end = step + 1 + EAGER_STEPS;
  if (report->discrete_failed)
    next->average_field_end = step + 1 + AVERAGE_FIELD_STEPS;

  thrum_energy_keep(model, next, view, report);

  // a Jacobian of full Newton is factored, not inverted, and is not kept
  double *inverse = view->inverse[0];
  if (report->refreshed)
    inverse = keep_inverse(next, view);
  else if (report->newton)
    next->jacobian_kept = 0;

  // an inverse that has learnt is no longer that of one step
  if (report->solved && next->jacobian_kept && report->learnt > 0 && !report->extrapolated) {
    thrum_secant_fold(view->kernel, view->pairs, view->stride, next->rank - next->split,
                      report->learnt, inverse);
    if (!report->refreshed)
      next->inverse_step[0] = -1;
  }
}

/* Counts the step in the report of the state. */
static void count_step(thrum_state *next, const thrum_solve_report *report) {
  const bool switched =
      next->scheme == THRUM_SCHEME_ENERGY && next->def.integrator != THRUM_INTEGRATOR_ENERGY;
  thrum_state_report *counts = &next->report;
  counts->steps++;
  counts->time += next->def.dt;
  counts->iterations += report->iterations;
  counts->factorisations += report->factorisations;
  counts->iterations_last = report->iterations;
  counts->residual_last = report->residual;

  // steps out of the ordinary
  counts->newton_steps += report->newton ? 1 : 0;
  counts->energy_steps += report->fallback_level == THRUM_FALLBACK_ENERGY ? 1 : 0;
  counts->substep_steps += report->fallback_level == THRUM_FALLBACK_SUBSTEPS ? 1 : 0;
  counts->switched_steps += switched ? 1 : 0;
}

/* Writes the candidates and the header to be into the state. */
static void commit(const thrum_model *model, thrum_step_run *run, double amplitude) {
  thrum_state *next = &run->next;
  const thrum_state_view *view = &run->view;
  const size_t vector = (size_t)next->rank * sizeof(double);

  THRUM_CALL_HOOKS(thrum_on_accepted, keep, model, run);
  for (int64_t i = 0; i < next->ahead_count; i++)
    view->q_ahead[i] = 1.5 * view->q_next[i] - 0.5 * run->q[i];
  memcpy(run->q, view->q_next, vector);
  memcpy(run->p, view->p_next, vector);
  memcpy(view->load_before, view->load, vector);
  if (thrum_carries_acceleration(next))
    memcpy(view->acceleration, view->acceleration_next, vector);

  // the header last: the parts before still need the number of the step
  remember(model, next, view, &run->report);
  count_step(next, &run->report);
  next->amplitude = fmax(next->amplitude, amplitude);
  *run->state = *next;
}

/* --- the parts of a step ---------------------------------------------------------------------- */

/* Continues as if no hook had looked. */
static void drop_changes(thrum_step_run *run) {
  run->next = *run->state;
  run->view.p = run->p;
  run->view.power_sampled = run->samples = false;
}

/* The energy that the forces which hooks have added to the load took in the step [J]. */
static double taken_by_added(const thrum_step_run *run) {
  const thrum_state_view *view = &run->view;
  double sum = 0.0;
  for (int64_t i = 0; view->load != run->load && i < run->next.rank; i++)
    sum += (run->load[i] - view->load[i]) * (view->q_next[i] - run->q[i]);
  return sum;
}

/* What goes before the attempt: a change of the length of the steps, and what hooks change. */
static thrum_status prepare(const thrum_model *model, thrum_step_run *run) {
  THRUM_TRY(thrum_step_length_settle(model, &run->next, &run->view));
  for (const thrum_on_before *hook = thrum_schemes.before; hook && *hook; hook++)
    THRUM_TRY((*hook)(model, run));
  return THRUM_OK;
}

thrum_status thrum_step_begin(const thrum_model *model, thrum_state *state,
                              const thrum_borrowed_workspace *borrowed, thrum_step_run *run,
                              thrum_error *error) {
  THRUM_TRY(borrowed ? thrum_state_check(model, state, error)
                     : thrum_state_check_ready(model, state, error));
  run->state = state;
  run->next = *state;
  thrum_state_view_fill(state, &run->view);
  run->q = run->view.q;
  run->p = run->view.p;
  if (borrowed)
    thrum_state_view_borrow(&run->view, state->rank, borrowed);

  // only Newmark fills it, and fallback levels are checked for finite candidates
  memset(run->view.acceleration_next, 0, (size_t)state->rank * sizeof(double));
  memset(&run->report, 0, sizeof run->report);
  run->load = run->view.load;
  run->samples = false;
  run->notable = THRUM_OK;
  THRUM_CALL_HOOKS(thrum_on_load, load, model, run);
  if (prepare(model, run) < 0)
    drop_changes(run);
  return THRUM_OK;
}

void thrum_step_sample(const thrum_model *model, thrum_step_run *run, bool product_there) {
  if (!run->samples)
    return;
  thrum_status status = THRUM_OK;
  for (const thrum_on_sample *hook = thrum_schemes.sample; hook && *hook && status >= 0; hook++)
    status = (*hook)(model, run, product_there);
  if (status < 0)
    drop_changes(run);
}

thrum_status thrum_step_attempt(const thrum_model *model, thrum_step_run *run) {
  return thrum_row_of(&run->next)->step(model, &run->next, &run->view, &run->report);
}

/* Leads the attempt to candidates that may be committed: hooks may have the step made again, and
 * settle one that is not solved. *amplitude: scaled norm of the motion of the candidates. */
static thrum_status settle(const thrum_model *model, thrum_step_run *run, thrum_status status,
                           double *amplitude) {
  const thrum_state *next = &run->next;
  const thrum_state_view *view = &run->view;

  // also after a failure: the step before may have spoilt this one
  for (const thrum_on_attempt *hook = thrum_schemes.after_attempt; hook && *hook; hook++)
    if ((*hook)(model, run, &status))
      status = thrum_step_attempt(model, run);

  // a step is solved when its candidates are finite
  if (status >= 0) {
    *amplitude = thrum_motion_norm(model, next, view->q_next, view->p_next);
    if (isfinite(*amplitude))
      return THRUM_OK;
    status = THRUM_NOT_FINITE;
  }
  for (const thrum_on_settle *hook = thrum_schemes.settle; hook && *hook && status < 0; hook++)
    status = (*hook)(model, run, status);
  THRUM_TRY(status);
  *amplitude = thrum_motion_norm(model, next, view->q_next, view->p_next);
  return THRUM_OK;
}

static thrum_status say_failure(const thrum_state *state, thrum_status status, thrum_error *error) {
  const long long step = (long long)state->report.steps;
  if (status == THRUM_NOT_FINITE)
    return thrum_error_set(error, status,
                           "step %lld at t = %g s leaves the range of finite numbers; the state is "
                           "as it was before it: lower dt or the load",
                           step, state->report.time);
  return thrum_error_set(error, status,
                         "step %lld at t = %g s did not converge; the state is as it was before "
                         "it: lower dt or the load, or allow more iterations",
                         step, state->report.time);
}

/* Finds what the step dissipated, for the balances that follow and for the report. */
static void find_dissipation(const thrum_model *model, thrum_step_run *run) {
  if (thrum_is_damped(model, &run->next) && !run->report.dissipation_known)
    run->report.dissipation = thrum_step_dissipation(model, &run->next, &run->view);
  run->report.dissipation_known = true;
}

/* A step that hooks accept as it is solved, or have attempted once more. */
static thrum_status settle_solved(const thrum_model *model, thrum_step_run *run,
                                  thrum_status attempted, double *amplitude) {
  THRUM_TRY(settle(model, run, attempted, amplitude));
  find_dissipation(model, run);
  bool again = false;
  thrum_status changed = THRUM_OK;
  for (const thrum_on_attempt *hook = thrum_schemes.solved; hook && *hook && !again; hook++)
    again = (*hook)(model, run, &changed);
  if (!again)
    return changed;

  // what looks at it looks at the other attempt too, which is the last
  THRUM_TRY(settle(model, run, thrum_step_attempt(model, run), amplitude));
  find_dissipation(model, run);
  THRUM_CALL_HOOKS(thrum_on_attempt, solved, model, run, &changed);
  return changed;
}

/* Enters the energy that the step dissipated into the header of the next state, and puts a failure
 * into words. An amplitude that is not finite is a failure as well, because every later residual
 * would look small beside it. */
static thrum_status accept(thrum_step_run *run, thrum_status status, double amplitude,
                           thrum_error *error) {
  const double lost = run->report.dissipation + taken_by_added(run);
  const double dissipated = run->next.report.dissipated + lost;
  const bool finite = isfinite(amplitude) && isfinite(dissipated) &&
                      (!thrum_carries_acceleration(&run->next) ||
                       thrum_all_finite(run->view.acceleration_next, run->state->rank));
  if (status >= 0 && !finite)
    status = THRUM_NOT_FINITE;
  if (status < 0)
    return say_failure(run->state, status, error);
  run->next.report.dissipated = dissipated;
  return THRUM_OK;
}

thrum_status thrum_step_end(const thrum_model *model, thrum_step_run *run, thrum_status attempted,
                            thrum_error *error) {
  double amplitude = 0.0;
  const thrum_status status = settle_solved(model, run, attempted, &amplitude);
  THRUM_TRY(accept(run, status, amplitude, error));
  THRUM_CALL_HOOKS(thrum_on_accepted, accepted, model, run);
  commit(model, run, amplitude);

  // what the state is worth says more than how its step was made, and a fallback more than a switch
  // some time ago
  if (run->notable != THRUM_OK)
    return run->notable;
  if (run->report.newton || run->report.fallback_level != THRUM_FALLBACK_NONE)
    return THRUM_FELL_BACK;
  return thrum_is_first_scheme(&run->next) ? THRUM_OK : THRUM_SWITCHED;
}

thrum_status thrum_step_end_coupled(const thrum_model *model, thrum_step_run *run,
                                    thrum_status attempted, thrum_error *error) {
  double amplitude = 0.0;
  if (attempted >= 0) {
    amplitude = thrum_motion_norm(model, &run->next, run->view.q_next, run->view.p_next);
    find_dissipation(model, run);
  }
  THRUM_TRY(accept(run, attempted, amplitude, error));

  THRUM_CALL_HOOKS(thrum_on_accepted, coupled, model, run);
  commit(model, run, amplitude);
  return run->report.fallback_level == THRUM_FALLBACK_NONE ? THRUM_OK : THRUM_FELL_BACK;
}

thrum_status thrum_step_alone(const thrum_model *model, thrum_state *state,
                              const thrum_borrowed_workspace *borrowed, thrum_error *error) {
  THRUM_TRY(thrum_state_check(model, state, error));
  thrum_model seen;
  thrum_step_run run;
  model = thrum_seen_model(model, state, &seen);
  THRUM_TRY(thrum_step_begin(model, state, borrowed, &run, error));
  thrum_step_sample(model, &run, false);
  const thrum_status status = thrum_step_end(model, &run, thrum_step_attempt(model, &run), error);

  if (status >= 0)
    THRUM_CALL_HOOKS(thrum_on_committed, committed, model, state, &run.view);
  return status;
}

thrum_status thrum_step(const thrum_model *model, thrum_state *state, thrum_error *error) {
  return thrum_step_alone(model, state, NULL, error);
}

thrum_status thrum_steps(const thrum_model *model, thrum_state *state, int64_t count, int64_t *made,
                         thrum_error *error) {
  if (count < 0)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the number of steps is %lld; it must be 0 or more", (long long)count);

  thrum_status worst = THRUM_OK;
  int64_t done = 0;
  for (; done < count && worst >= 0; ++done) {
    const thrum_status status = thrum_step(model, state, error);

    // the smaller of two notable statuses stands first in the list; a failure ends the loop
    if (status < 0 || (status > 0 && (worst == THRUM_OK || status < worst)))
      worst = status;
  }
  if (made != NULL)
    *made = worst < 0 ? done - 1 : done;
  return worst;
}
