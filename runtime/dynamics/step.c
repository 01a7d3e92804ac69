/* One step: candidates are made in scratch, checked, and only then committed, so that a step that
 * fails leaves what persists of the state as it was (design 8) and no NaN or Inf ever enters it.
 * SPDX-License-Identifier: Apache-2.0 */
#include "runtime/base/fp_contract.h"

#include <math.h>
#include <string.h>

#include "runtime/dynamics/implicit_solve.h"
#include "runtime/dynamics/state_private.h"
#include "runtime/polynomial/polynomial_private.h"

/* An inverse made anew in this step, into the place of the oldest; those before stay where they
 * are, each that of one step, or are none. Returns where it is. */
static double *keep_inverse(thrum_state *next, const thrum_state_view *view) {
  const size_t n = (size_t)(next->rank - next->split);
  const bool another = next->jacobian_kept && next->inverse_step[0] >= 0;
  double *place = view->inverse[another ? THRUM_INVERSES - 1 : 0];
  if (another)
    next->inverse_place = (next->inverse_place + 1) % THRUM_INVERSES;
  for (int j = THRUM_INVERSES - 1; j > 0; j--)
    next->inverse_step[j] = another ? next->inverse_step[j - 1] : -1;
  next->inverse_step[0] = next->steps;
  next->jacobian_kept = 1;
  memcpy(place, view->jacobian_next, n * n * sizeof *place);
  return place;
}

/* What the next solve can begin with. */
static void remember(thrum_state *next, const thrum_state_view *view,
                     const thrum_solve_report *report) {
  const size_t vector = (size_t)next->rank * sizeof(double);
  const int32_t n = next->rank - next->split;
  if (report->solved) {
    if (next->past_ends != report->ends)
      next->past_count = 0;
    next->past_ends = report->ends;
    memcpy(view->past_q + thrum_past_at(view, next->steps), view->middle, vector);
    memcpy(view->past_r + thrum_past_at(view, next->steps), view->force, vector);
    next->past_count = next->past_count < THRUM_PAST ? next->past_count + 1 : THRUM_PAST;
    next->guess_last = report->guess;
  }
  if (report->slow)
    next->eager_end = next->steps + 1 + THRUM_EAGER;
  next->potential_step = report->potential_known ? next->steps + 1 : -1;
  next->potential = report->potential_known ? report->potential : 0.0;
  if (report->potential_known)
    memcpy(view->force_now, view->force_2, vector);
  if (report->path)
    next->path_end = next->steps + 1 + THRUM_PATH;
  double *inverse = view->inverse[0];
  if (report->refreshed)
    inverse = keep_inverse(next, view);
  else if (report->newton)
    next->jacobian_kept = 0;
  if (report->solved && next->jacobian_kept && report->learnt > 0 && !report->extrapolated) {
    thrum_secant_fold(view->kernel, view->pairs, view->stride, n, report->learnt, inverse);
    if (!report->refreshed)
      next->inverse_step[0] = -1;
  }
}

/* Candidates and the header to be into the state. */
static void commit(thrum_step_run *run, double amplitude) {
  thrum_state *next = &run->next;
  const thrum_state_view *view = &run->view;
  const thrum_solve_report *report = &run->report;
  const size_t vector = (size_t)next->rank * sizeof(double);
  // an energy that is finite has momenta that are
  if (report->energy_known && isfinite(report->energy)) {
    memcpy(view->q_kept, run->q, vector);
    memcpy(view->p_kept, view->p_kept_next, vector);
    next->kept_step = next->steps;
  }
  memcpy(run->q, view->q_next, vector);
  memcpy(run->p, view->p_next, vector);
  memcpy(view->load_before, view->load, vector);
  if (next->scheme == THRUM_SCHEME_NEWMARK)
    memcpy(view->acceleration, view->acceleration_next, vector);
  remember(next, view, report);
  if (view->guided) {
    memcpy(view->guide, view->guide_next, vector);
    memcpy(view->guide_whole, view->guide_whole_next, vector);
  }
  const bool handed =
      next->scheme == THRUM_SCHEME_ENERGY && next->integrator == THRUM_INTEGRATOR_IMEXV;
  next->steps++;
  next->time += next->dt;
  next->iterations += report->iterations;
  next->factorisations += report->factorisations;
  next->newton_steps += report->newton ? 1 : 0;
  next->energy_steps += report->fallback_level == THRUM_FALLBACK_ENERGY ? 1 : 0;
  next->substep_steps += report->fallback_level == THRUM_FALLBACK_SUBSTEPS ? 1 : 0;
  next->switched_steps += handed ? 1 : 0;
  next->iterations_last = report->iterations;
  next->residual_last = report->residual;
  next->amplitude = fmax(next->amplitude, amplitude);
  *run->state = *next;
}

static thrum_status say_failure(const thrum_state *state, thrum_status status, thrum_error *error) {
  if (status == THRUM_NOT_FINITE)
    return thrum_error_set(error, status,
                           "step %lld at t = %g s leaves the range of finite numbers; the state is "
                           "as it was before it: lower dt or the load",
                           (long long)state->steps, state->time);
  return thrum_error_set(error, status,
                         "step %lld at t = %g s did not converge; the state is as it was before "
                         "it: lower dt or the load, or raise iterations_max",
                         (long long)state->steps, state->time);
}

/* One step of the present scheme. */
static thrum_status attempt(const thrum_model *model, const thrum_state *state,
                            thrum_state_view *view, thrum_solve_report *report) {
  switch ((thrum_scheme)state->scheme) {
  case THRUM_SCHEME_QUADRATIC:
    return thrum_step_quadratic(model, state, view, report);
  case THRUM_SCHEME_ENERGY:
    return thrum_step_energy(model, state, view, report);
  case THRUM_SCHEME_NEWMARK:
    return thrum_step_newmark(model, state, view, report);
  case THRUM_SCHEME_COMPONENT:
    break;
  }
  return thrum_step_imexv(model, state, view, report);
}

/* As if the watch had not looked. */
static void unwatch(thrum_step_run *run) {
  run->next = *run->state;
  run->view.p = run->p;
  run->view.guided = run->samples = false;
}

thrum_status thrum_step_begin(const thrum_model *model, thrum_state *state, const thrum_lent *lent,
                              thrum_step_run *run, thrum_error *error) {
  const thrum_status status = thrum_state_check(model, state, error);
  if (status != THRUM_OK)
    return status;
  run->state = state;
  run->next = *state;
  run->view = thrum_state_view_of(state);
  run->q = run->view.q;
  run->p = run->view.p;
  if (lent)
    thrum_state_lend(&run->view, lent);
  // not all schemes have one
  memset(run->view.acceleration_next, 0, (size_t)state->rank * sizeof(double));
  memset(&run->report, 0, sizeof run->report);
  if (thrum_stability_before(model, &run->next, &run->view, &run->samples) != THRUM_OK)
    unwatch(run);
  return THRUM_OK;
}

void thrum_step_monitor(const thrum_model *model, thrum_step_run *run, bool product_there) {
  if (!run->samples)
    return;
  if (!product_there)
    thrum_stability_multiply(model, &run->next, &run->view);
  if (thrum_stability_sample(model, &run->next, &run->view) != THRUM_OK)
    unwatch(run);
}

thrum_status thrum_step_attempt(const thrum_model *model, thrum_step_run *run) {
  return attempt(model, &run->next, &run->view, &run->report);
}

/* What becomes of an attempt: the watch may prefer the step of design 7; then the fallback. With
 * the scaled norm of the motion. */
static thrum_status settle(const thrum_model *model, thrum_step_run *run, thrum_status status,
                           double *amplitude) {
  thrum_state *next = &run->next;
  thrum_state_view *view = &run->view;
  if (status == THRUM_OK)
    thrum_stability_ahead(model, next, view, &run->report);
  // a step that failed may have been spoilt by the one before, which stage 1 then has seen
  const thrum_stability_decision decision = thrum_stability_judge(next, &run->report);
  if (decision != THRUM_DECISION_CONTINUE) {
    status = thrum_stability_switch(model, next, view, decision, &run->report);
    if (status == THRUM_OK)
      status = thrum_step_attempt(model, run);
  }
  if (status == THRUM_OK) {
    *amplitude = thrum_state_amplitude(model, next, view->q_next, view->p_next);
    if (isfinite(*amplitude))
      return THRUM_OK;
    status = THRUM_NOT_FINITE;
  }
  status = thrum_fallback_run(model, next, view, status, &run->report);
  if (status == THRUM_OK)
    *amplitude = thrum_state_amplitude(model, next, view->q_next, view->p_next);
  return status;
}

thrum_status thrum_step_end(const thrum_model *model, thrum_step_run *run, thrum_status attempted,
                            thrum_error *error) {
  thrum_state *state = run->state;
  thrum_state_view *view = &run->view;
  double amplitude = 0.0;
  thrum_status status = settle(model, run, attempted, &amplitude);
  if (status == THRUM_OK) {
    // an amplitude that overflows would make every later residual look small
    if (isfinite(amplitude) && thrum_all_finite(view->acceleration_next, state->rank)) {
      thrum_stability_after(model, &run->next, view);
      thrum_energy_correction_after(model, &run->next, view, &run->report);
      commit(run, amplitude);
    } else {
      status = THRUM_NOT_FINITE;
    }
  }
  if (status != THRUM_OK)
    return say_failure(state, status, error);
  const bool fell_back = run->report.newton || run->report.fallback_level != THRUM_FALLBACK_NONE;
  return fell_back ? THRUM_FELL_BACK : THRUM_OK;
}

thrum_status thrum_step(const thrum_model *model, thrum_state *state, thrum_error *error) {
  thrum_step_run run;
  const thrum_status status = thrum_step_begin(model, state, NULL, &run, error);
  if (status != THRUM_OK)
    return status;
  thrum_step_monitor(model, &run, false);
  return thrum_step_end(model, &run, thrum_step_attempt(model, &run), error);
}
