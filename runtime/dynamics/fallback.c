/* What is done with a step that neither quasi-Newton nor full Newton solves (design 8):
 *
 *   imexv            one energy-conserving step (design 7) of all modes, from synchronised momenta
 *   imexv            2, 4, .. SUBSTEPS_MAX such steps of dt/2, dt/4, ..
 *   newmark, energy  as many shorter steps of their own
 *
 * Those of `energy` take the mean force of the path, which always has a solution.
 * The load of a step is its mean, so the shorter ones all take it. verlet and midpoint have no
 * fallback chain: they are there to be compared with.
 * Cost: of the steps tried; nothing in a step that is solved at once.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "runtime/base/fp_contract.h"

#include <math.h>
#include <string.h>

#include "runtime/dynamics/state_private.h"

#define SUBSTEPS_MAX 256

static bool whole(const thrum_state *state, const thrum_state_view *view) {
  return thrum_all_finite(view->q_next, state->rank) &&
         thrum_all_finite(view->p_next, state->rank) &&
         thrum_all_finite(view->acceleration_next, state->rank);
}

/* One step by the scheme of `state`, energy or newmark. */
static thrum_status advance(const thrum_model *model, const thrum_state *state,
                            thrum_state_view *view, thrum_solve_report *report) {
  report->saw_nonfinite = false;
  const thrum_status status = state->scheme == THRUM_SCHEME_NEWMARK
                                  ? thrum_step_newmark(model, state, view, report)
                                  : thrum_step_energy(model, state, view, report);
  return status == THRUM_OK && !whole(state, view) ? THRUM_NOT_FINITE : status;
}

/* `count` steps of dt/count from view->q and view->p; nothing of it is kept between them. */
static thrum_status substeps(const thrum_model *model, const thrum_state *state,
                             thrum_state_view *view, int32_t count, thrum_solve_report *report) {
  const size_t vector = (size_t)state->rank * sizeof(double);
  thrum_state shorter = *state;
  shorter.dt = state->dt / (double)count;
  shorter.jacobian_kept = 0;
  shorter.potential_step = -1;
  shorter.past_count = 0;
  shorter.amplitude = thrum_state_amplitude(model, &shorter, view->q, view->p);
  thrum_state_view at = *view;
  at.q = view->q_sub;
  at.p = view->p_sub;
  at.acceleration = view->acceleration_sub;
  memcpy(at.q, view->q, vector);
  memcpy(at.p, view->p, vector);
  memcpy(at.acceleration, view->acceleration, vector);
  thrum_status status = THRUM_OK;
  for (int32_t k = 0; k < count && status == THRUM_OK; k++) {
    status = advance(model, &shorter, &at, report);
    memcpy(at.q, view->q_next, vector);
    memcpy(at.p, view->p_next, vector);
    memcpy(at.acceleration, view->acceleration_next, vector);
    at.load_before = view->load;
    shorter.amplitude = fmax(shorter.amplitude, thrum_state_amplitude(model, &shorter, at.q, at.p));
  }
  return status;
}

/* Steps of all modes from the synchronised view->p: one and then shorter ones, or shorter ones. */
static thrum_status climb(const thrum_model *model, const thrum_state *state,
                          thrum_state_view *view, bool one, thrum_solve_report *report) {
  thrum_status status = THRUM_NOT_CONVERGED;
  if (one) {
    status = advance(model, state, view, report);
    report->fallback_level = THRUM_FALLBACK_ENERGY;
  }
  for (int32_t count = 2; count <= SUBSTEPS_MAX && status != THRUM_OK; count *= 2) {
    status = substeps(model, state, view, count, report);
    report->fallback_level = THRUM_FALLBACK_SUBSTEPS;
  }
  report->newton = false;
  report->refreshed = false;
  report->solved = false;
  return status;
}

thrum_status thrum_fallback_run(const thrum_model *model, thrum_state *state,
                                thrum_state_view *view, thrum_status failure,
                                thrum_solve_report *report) {
  const bool imexv = state->integrator == THRUM_INTEGRATOR_IMEXV;
  const bool climbs =
      imexv || state->scheme == THRUM_SCHEME_NEWMARK || state->scheme == THRUM_SCHEME_ENERGY;
  if (!state->fallback || !climbs)
    return failure;
  // what the failed solve left is no guess for the next one
  thrum_state other = *state;
  other.jacobian_kept = 0;
  other.past_count = 0;
  other.path_end = INT64_MAX;
  if (state->scheme == THRUM_SCHEME_NEWMARK || state->scheme == THRUM_SCHEME_ENERGY) {
    const thrum_status status = climb(model, &other, view, false, report);
    state->past_count = 0;
    return status;
  }
  thrum_status status = thrum_stagger_synchronise(model, state, view, NULL);
  if (status != THRUM_OK)
    return THRUM_NOT_CONVERGED;
  if (!thrum_all_finite(view->p_next, state->rank))
    return THRUM_NOT_FINITE;
  other.scheme = THRUM_SCHEME_ENERGY;
  other.split = 0;
  other.amplitude = fmax(state->amplitude, thrum_state_amplitude(model, &other, view->q, view->p));
  double *before = view->p;
  memcpy(view->p_level, view->p_next, (size_t)state->rank * sizeof *view->p_level);
  view->p = view->p_level;
  status = climb(model, &other, view, true, report);
  view->p = before;
  if (status != THRUM_OK)
    return status;
  thrum_stagger_delay(model, state, view, view->q_next, view->load, view->p_next);
  state->past_count = 0;
  return whole(state, view) ? THRUM_OK : THRUM_NOT_FINITE;
}
