/* One step: candidates are made in scratch, checked, and only then committed, so that a step that
 * fails leaves every byte of the state as it was (design 8) and no NaN or Inf ever enters it.
 * SPDX-License-Identifier: Apache-2.0 */
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif

#include <math.h>
#include <string.h>

#include "state.h"

/* Candidates into the state. */
static void commit(thrum_state *state, const thrum_state_view *view,
                   const thrum_solve_report *report, double amplitude) {
  const size_t vector = (size_t)state->rank * sizeof(double);
  memcpy(view->q, view->q_next, vector);
  memcpy(view->p, view->p_next, vector);
  memcpy(view->load_before, view->load, vector);
  if (state->integrator == THRUM_INTEGRATOR_NEWMARK) {
    memcpy(view->acceleration, view->acceleration_next, vector);
  } else if (state->scheme != THRUM_SCHEME_QUADRATIC && state->split < state->rank) {
    memcpy(view->past_2, view->past_1, vector);
    memcpy(view->past_1, view->past_next, vector);
    state->past_count = state->past_count < 2 ? state->past_count + 1 : 2;
  }
  if (report->refreshed) {
    const size_t n = (size_t)(state->rank - state->split);
    memcpy(view->jacobian, view->jacobian_next, n * n * sizeof(double));
    memcpy(view->pivots, view->pivots_next, n * sizeof(int32_t));
    state->jacobian_kept = 1;
  }
  state->steps++;
  state->time += state->dt;
  state->iterations += report->iterations;
  state->factorisations += report->factorisations;
  state->newton_steps += report->newton ? 1 : 0;
  state->iterations_last = report->iterations;
  state->residual_last = report->residual;
  state->amplitude = fmax(state->amplitude, amplitude);
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

thrum_status thrum_step(const thrum_model *model, thrum_state *state, thrum_error *error) {
  thrum_status status = thrum_state_check(model, state, error);
  if (status != THRUM_OK)
    return status;
  thrum_state_view view = thrum_state_view_of(state);
  thrum_solve_report report;
  memset(&report, 0, sizeof report);
  status = attempt(model, state, &view, &report);
  if (status == THRUM_OK) {
    // an amplitude that overflows would make every later residual look small
    const double amplitude = thrum_state_amplitude(model, state, view.q_next, view.p_next);
    if (isfinite(amplitude) && thrum_all_finite(view.acceleration_next, state->rank))
      commit(state, &view, &report, amplitude);
    else
      status = THRUM_NOT_FINITE;
  }
  thrum_state_clear_scratch(state, &view);
  if (status != THRUM_OK)
    return say_failure(state, status, error);
  return report.newton ? THRUM_FELL_BACK : THRUM_OK;
}
