/* The fallback chain: what is done with a step that neither quasi-Newton nor full Newton solves
 * (design 8).
 *
 *   imexv, fox-goodwin
 *                    one energy-conserving step (design 7) of all modes, from synchronised momenta
 *                    2, 4, .. THRUM_SUBSTEPS_MAX such steps of dt/2, dt/4, ..
 *   newmark, energy, manifold
 *                    as many shorter steps of their own
 *
 * The shorter steps of `energy` take the average vector field, whose equation always has a
 * solution. The load of a step is its mean, so the shorter steps all take it. The other integrators
 * have no fallback chain: they are there to be compared with. Cost: that of the steps tried;
 * nothing in a step that is solved at once.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/guard/fallback.h"

#include <math.h>
#include <string.h>

#include "core/base/finite.h"
#include "core/schemes/discrete_gradient.h"
#include "core/schemes/dissipation.h"
#include "core/schemes/newmark.h"
#include "core/schemes/staggered_momentum.h"
#include "core/state/motion_norm.h"
#include "runtime/condensed/manifold.h"

static bool candidates_finite(const thrum_state *state, const thrum_state_view *view) {
  return thrum_all_finite(view->q_next, state->rank) &&
         thrum_all_finite(view->p_next, state->rank) &&
         thrum_all_finite(view->acceleration_next, state->rank);
}

/* One step by the scheme of `state`: energy, newmark or manifold. */
static thrum_status advance(void *unused, const thrum_model *model, const thrum_state *state,
                            thrum_state_view *view, thrum_solve_report *report) {
  (void)unused;
  report->saw_nonfinite = false;
  if (state->scheme == THRUM_SCHEME_MANIFOLD)
    return thrum_step_manifold(model, state, view, report);
  THRUM_TRY(state->scheme == THRUM_SCHEME_NEWMARK ? thrum_step_newmark(model, state, view, report)
                                                  : thrum_step_energy(model, state, view, report));
  return candidates_finite(state, view) ? THRUM_OK : THRUM_NOT_FINITE;
}

thrum_status thrum_fallback_substeps(const thrum_model *model, const thrum_state *state,
                                     thrum_state_view *view, int32_t count, thrum_sub_step by,
                                     void *context, thrum_solve_report *report) {
  const size_t vector = (size_t)state->rank * sizeof(double);

  // a header without the history of steps of another length
  thrum_state shorter = *state;
  shorter.def.dt = state->def.dt / (double)count;
  shorter.jacobian_kept = 0;
  shorter.potential_step = -1;
  shorter.past_count = 0;
  shorter.amplitude = thrum_motion_norm(model, &shorter, view->q, view->p);

  // a view whose state between sub-steps lies in scratch
  thrum_state_view at = *view;
  at.q = view->q_sub;
  at.p = view->p_sub;
  at.acceleration = view->acceleration_sub;
  memcpy(at.q, view->q, vector);
  memcpy(at.p, view->p, vector);
  memcpy(at.acceleration, view->acceleration, vector);

  // each dissipates by its own increment
  thrum_status status = THRUM_OK;
  double dissipation = 0.0;
  for (int32_t k = 0; k < count && status >= 0; k++) {
    status = by(context, model, &shorter, &at, report);
    if (status >= 0)
      dissipation += shorter.scheme == THRUM_SCHEME_MANIFOLD
                         ? report->dissipation
                         : thrum_step_dissipation(model, &shorter, &at);
    memcpy(at.q, view->q_next, vector);
    memcpy(at.p, view->p_next, vector);
    memcpy(at.acceleration, view->acceleration_next, vector);

    // from the second on the load of the sub-step before is the same
    at.load_before = view->load;
    shorter.amplitude = fmax(shorter.amplitude, thrum_motion_norm(model, &shorter, at.q, at.p));
  }
  report->dissipation = dissipation;
  report->dissipation_known = true;
  return status;
}

/* Steps of all modes from the synchronised view->p: one if whole_first, then shorter ones. */
static thrum_status run_levels(const thrum_model *model, const thrum_state *state,
                               thrum_state_view *view, bool whole_first,
                               thrum_solve_report *report) {
  thrum_status status = THRUM_NOT_CONVERGED;
  report->dissipation_known = false;
  if (whole_first) {
    status = advance(NULL, model, state, view, report);
    report->fallback_level = THRUM_FALLBACK_ENERGY;
    if (status >= 0)
      report->dissipation = thrum_step_dissipation(model, state, view);
    report->dissipation_known = status >= 0;
  }
  for (int32_t count = 2; count <= THRUM_SUBSTEPS_MAX && status < 0; count *= 2) {
    status = thrum_fallback_substeps(model, state, view, count, advance, NULL, report);
    report->fallback_level = THRUM_FALLBACK_SUBSTEPS;
  }

  // none of it is of use for the next solve of the scheme that failed
  report->newton = false;
  report->refreshed = false;
  report->solved = false;
  return status;
}

/* imexv, fox-goodwin: a step of the energy integrator from the synchronised momentum, and back. */
static thrum_status run_by_energy(const thrum_model *model, thrum_state *state,
                                  thrum_state_view *view, thrum_state *other,
                                  thrum_solve_report *report) {
  if (thrum_staggered_synchronise(model, state, view, NULL) < 0)
    return THRUM_NOT_CONVERGED;
  if (!thrum_all_finite(view->p_next, state->rank))
    return THRUM_NOT_FINITE;
  other->scheme = THRUM_SCHEME_ENERGY;
  other->split = 0;
  other->amplitude = fmax(state->amplitude, thrum_motion_norm(model, other, view->q, view->p));

  // the levels start from the synchronised momentum, the scheme keeps its own
  double *before = view->p;
  memcpy(view->p_level, view->p_next, (size_t)state->rank * sizeof *view->p_level);
  view->p = view->p_level;
  const thrum_status status = run_levels(model, other, view, true, report);
  view->p = before;
  THRUM_TRY(status);

  // the next step's momentum and acceleration as the scheme stores them
  THRUM_TRY(
      thrum_staggered_unsynchronise(model, state, view, view->q_next, view->load, view->p_next));
  if (state->scheme == THRUM_SCHEME_FOX_GOODWIN) {
    thrum_newmark_acceleration(model, state, view, view->q_next, view->p_next,
                               view->acceleration_next);
    for (int32_t i = 0; i < state->rank; i++)
      view->acceleration_next[i] += view->load[i];
  }
  state->past_count = 0;
  return candidates_finite(state, view) ? THRUM_OK : THRUM_NOT_FINITE;
}

thrum_status thrum_fallback_run(const thrum_model *model, thrum_state *state,
                                thrum_state_view *view, thrum_status failure,
                                thrum_solve_report *report) {
  const bool all_modes = state->scheme == THRUM_SCHEME_NEWMARK ||
                         state->scheme == THRUM_SCHEME_ENERGY ||
                         state->scheme == THRUM_SCHEME_MANIFOLD;
  const bool by_energy =
      state->def.integrator == THRUM_INTEGRATOR_IMEXV || state->scheme == THRUM_SCHEME_FOX_GOODWIN;
  if (!state->def.fallback || !(all_modes || by_energy))
    return failure;

  // the remains of the failed solve are no guess for the next one
  thrum_state other = *state;
  other.jacobian_kept = 0;
  other.past_count = 0;
  other.average_field_end = INT64_MAX;
  if (!all_modes)
    return run_by_energy(model, state, view, &other, report);

  const thrum_status status = run_levels(model, &other, view, false, report);
  state->past_count = 0;
  return status;
}
