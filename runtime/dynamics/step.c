/* One step: candidates are made in scratch, checked, and only then committed, so that a step that
 * fails leaves the persistent part of the state as it was (design 8) and no NaN or Inf ever enters
 * it.
 *
 *   begin    the stability monitor may change the scheme for this step
 *   attempt  one step of that scheme
 *   end      the monitor may prefer the energy integrator; then the fallback chain; then the commit
 *   flow     plastic flow at cubature points, once a step that was made is committed
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "runtime/base/fp_contract.h"

#include "runtime/dynamics/step.h"

#include <math.h>
#include <string.h>

#include "runtime/base/finite.h"
#include "runtime/dynamics/backward_euler.h"
#include "runtime/dynamics/discrete_gradient.h"
#include "runtime/dynamics/dissipation.h"
#include "runtime/dynamics/energy_balance.h"
#include "runtime/dynamics/energy_correction.h"
#include "runtime/dynamics/fallback.h"
#include "runtime/dynamics/following.h"
#include "runtime/dynamics/fox_goodwin.h"
#include "runtime/dynamics/imexv.h"
#include "runtime/dynamics/manifold.h"
#include "runtime/dynamics/motion_norm.h"
#include "runtime/dynamics/newmark.h"
#include "runtime/dynamics/point_flow.h"
#include "runtime/dynamics/position_split.h"
#include "runtime/dynamics/quadratic_split.h"
#include "runtime/dynamics/rk4.h"
#include "runtime/dynamics/semi_implicit_euler.h"
#include "runtime/dynamics/stability.h"
#include "runtime/dynamics/state_private.h"
#include "runtime/dynamics/step_length.h"

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
  counts->grown_steps += next->balance.grew;
}

/* Writes the candidates and the header to be into the state. */
static void commit(const thrum_model *model, thrum_step_run *run, double amplitude) {
  thrum_state *next = &run->next;
  const thrum_state_view *view = &run->view;
  const size_t vector = (size_t)next->rank * sizeof(double);

  // the state before this step, should the next one repeat it; a finite energy has finite momenta
  const bool whole = next->scheme == THRUM_SCHEME_POSITION;
  if (whole || (run->report.energy_known && isfinite(run->report.energy))) {
    memcpy(view->q_before, run->q, vector);
    memcpy(view->p_before, whole ? view->p : view->p_before_next, vector);
    next->monitor.before_step = next->report.steps;
    next->monitor.before_dt = next->def.dt;
  }

  memcpy(run->q, view->q_next, vector);
  memcpy(run->p, view->p_next, vector);
  memcpy(view->load_before, view->load, vector);
  if (thrum_carries_acceleration(next))
    memcpy(view->acceleration, view->acceleration_next, vector);
  if (view->power_sampled) {
    memcpy(view->power_explicit, view->power_explicit_next, vector);
    memcpy(view->power_whole, view->power_whole_next, vector);
  }

  // the header last: the parts before still need the number of the step
  remember(model, next, view, &run->report);
  count_step(next, &run->report);
  next->amplitude = fmax(next->amplitude, amplitude);
  *run->state = *next;
}

/* --- the parts of a step ---------------------------------------------------------------------- */

/* Continues as if the stability monitor had not looked. */
static void drop_monitor(thrum_step_run *run) {
  run->next = *run->state;
  run->view.p = run->p;
  run->view.power_sampled = run->samples = false;
}

/* The load of the step: with the drag of what follows, which is a force of the step as well. */
static void add_drag(const thrum_model *model, thrum_step_run *run) {
  thrum_state_view *view = &run->view;
  run->load = view->load;
  if (!thrum_follow_is_damped(model, &run->next))
    return;
  thrum_follow_drag(model, &run->next, view, view->load_damped);
  for (int64_t i = 0; i < model->rank; i++)
    view->load_damped[i] += view->load[i];
  view->load = view->load_damped;
}

/* The energy that the drag took in the step [J]. */
static double taken_by_drag(const thrum_step_run *run) {
  const thrum_state_view *view = &run->view;
  double sum = 0.0;
  for (int64_t i = 0; view->load != run->load && i < run->next.rank; i++)
    sum += (run->load[i] - view->load[i]) * (view->q_next[i] - run->q[i]);
  return sum;
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
  add_drag(model, run);
  if (thrum_step_length_settle(model, &run->next, &run->view) < 0 ||
      thrum_stability_before(model, &run->next, &run->view, &run->samples) < 0)
    drop_monitor(run);
  return THRUM_OK;
}

void thrum_step_monitor(const thrum_model *model, thrum_step_run *run, bool product_there) {
  if (!run->samples)
    return;
  if (!product_there)
    thrum_stability_multiply(model, &run->next, &run->view);
  if (thrum_stability_sample(model, &run->next, &run->view) < 0)
    drop_monitor(run);
}

thrum_status thrum_step_attempt(const thrum_model *model, thrum_step_run *run) {
  switch ((thrum_scheme)run->next.scheme) {
  case THRUM_SCHEME_QUADRATIC:
    return thrum_step_quadratic(model, &run->next, &run->view, &run->report);
  case THRUM_SCHEME_ENERGY:
    return thrum_step_energy(model, &run->next, &run->view, &run->report);
  case THRUM_SCHEME_NEWMARK:
    return thrum_step_newmark(model, &run->next, &run->view, &run->report);
  case THRUM_SCHEME_FOX_GOODWIN:
    return thrum_step_fox_goodwin(model, &run->next, &run->view, &run->report);
  case THRUM_SCHEME_POSITION:
    return thrum_step_position(model, &run->next, &run->view, &run->report);

  // those that are there to be compared with
  case THRUM_SCHEME_BACKWARD_EULER:
    return thrum_step_backward_euler(model, &run->next, &run->view, &run->report);
  case THRUM_SCHEME_SEMI_IMPLICIT_EULER:
    return thrum_step_semi_implicit_euler(model, &run->next, &run->view, &run->report);
  case THRUM_SCHEME_RK4:
    return thrum_step_rk4(model, &run->next, &run->view, &run->report);
  case THRUM_SCHEME_MANIFOLD:
    return thrum_step_manifold(model, &run->next, &run->view, &run->report);
  case THRUM_SCHEME_THESIS:
    break;
  }
  return thrum_step_imexv(model, &run->next, &run->view, &run->report);
}

/* Leads the attempt to candidates that may be committed: the stability monitor may have the step
 * made again by `energy`, and the fallback chain takes one that is not solved. *amplitude: scaled
 * norm of the motion of the candidates. */
static thrum_status settle(const thrum_model *model, thrum_step_run *run, thrum_status status,
                           double *amplitude) {
  thrum_state *next = &run->next;
  thrum_state_view *view = &run->view;
  if (status >= 0)
    thrum_stability_look_ahead(model, next, view, &run->report);

  // also after a failure: the step before may have spoilt this one, which its kick then has seen
  const thrum_stability_decision decision = thrum_stability_decide(next, &run->report);
  if (decision != THRUM_DECISION_CONTINUE) {
    status = thrum_stability_switch_to_energy(model, next, view, decision, &run->report);
    if (status >= 0)
      status = thrum_step_attempt(model, run);
  }

  // a step is solved when its candidates are finite
  if (status >= 0) {
    *amplitude = thrum_motion_norm(model, next, view->q_next, view->p_next);
    if (isfinite(*amplitude))
      return THRUM_OK;
    status = THRUM_NOT_FINITE;
  }
  THRUM_TRY(thrum_fallback_run(model, next, view, status, &run->report));
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
  const thrum_state_def *def = &run->next.def;
  const bool damped = def->damping_alpha > 0.0 || def->damping_beta > 0.0;
  if (damped && !run->report.dissipation_known)
    run->report.dissipation = thrum_step_dissipation(model, &run->next, &run->view);
  run->report.dissipation_known = true;
}

/* A solved step whose energy is explained: one of a monitored fox-goodwin that is not is made again
 * by the energy integrator. */
static thrum_status settle_balance(const thrum_model *model, thrum_step_run *run,
                                   thrum_status attempted, double *amplitude) {
  THRUM_TRY(settle(model, run, attempted, amplitude));
  find_dissipation(model, run);
  if (!thrum_energy_balance_enter(model, &run->next, &run->view, &run->report))
    return THRUM_OK;

  // nothing of the first attempt stays
  memset(&run->report, 0, sizeof run->report);
  memset(run->view.acceleration_next, 0, (size_t)run->next.rank * sizeof(double));
  THRUM_TRY(thrum_energy_balance_switch(model, &run->next, &run->view));
  THRUM_TRY(settle(model, run, thrum_step_attempt(model, run), amplitude));
  find_dissipation(model, run);

  // a balance that goes on has this step too, whose energy may be right again
  thrum_energy_balance_enter(model, &run->next, &run->view, &run->report);
  return THRUM_OK;
}

/* Enters the energy that the step dissipated into the header of the next state, and puts a failure
 * into words. An amplitude that is not finite is a failure as well, because every later residual
 * would look small beside it. */
static thrum_status accept(thrum_step_run *run, thrum_status status, double amplitude,
                           thrum_error *error) {
  const double lost = run->report.dissipation + taken_by_drag(run);
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
  const thrum_status status = settle_balance(model, run, attempted, &amplitude);
  THRUM_TRY(accept(run, status, amplitude, error));
  thrum_stability_after(model, &run->next, &run->view, &run->report);
  thrum_energy_correction_after(model, &run->next, &run->view, &run->report);
  commit(model, run, amplitude);

  // what the state is worth says more than how its step was made, and a fallback more than a switch
  // some time ago
  if (run->next.balance.grew)
    return THRUM_ENERGY_GREW;
  if (run->report.newton || run->report.fallback_level != THRUM_FALLBACK_NONE)
    return THRUM_FELL_BACK;
  return run->next.scheme == (int32_t)thrum_state_first_scheme(&run->next.def) ? THRUM_OK
                                                                               : THRUM_SWITCHED;
}

thrum_status thrum_step_end_coupled(const thrum_model *model, thrum_step_run *run,
                                    thrum_status attempted, thrum_error *error) {
  double amplitude = 0.0;
  if (attempted >= 0) {
    amplitude = thrum_motion_norm(model, &run->next, run->view.q_next, run->view.p_next);
    find_dissipation(model, run);
  }
  THRUM_TRY(accept(run, attempted, amplitude, error));

  // the state sees a part of the energy alone, which has no target
  thrum_energy_correction_close(&run->next);
  commit(model, run, amplitude);
  return run->report.fallback_level == THRUM_FALLBACK_NONE ? THRUM_OK : THRUM_FELL_BACK;
}

thrum_status thrum_step_alone(const thrum_model *model, thrum_state *state,
                              const thrum_borrowed_workspace *borrowed, thrum_error *error) {
  THRUM_TRY(thrum_state_check(model, state, error));
  thrum_model flowed;
  thrum_step_run run;
  model = thrum_flowed_model(model, state, &flowed);
  THRUM_TRY(thrum_step_begin(model, state, borrowed, &run, error));
  thrum_step_monitor(model, &run, false);
  const thrum_status status = thrum_step_end(model, &run, thrum_step_attempt(model, &run), error);

  // a step is elastic, and the material flows where it has led to
  if (status >= 0)
    thrum_point_flow(model, state, &run.view);
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
