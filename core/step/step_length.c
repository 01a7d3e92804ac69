/* Steps whose length changes from one to the next, as a game's do (design 4).
 *
 * The explicit modes are those of the longest step lately, so that a length that jitters does not
 * move modes between the two sets: each move is a change of the discrete energy. A longer step
 * takes its own set at once, as stability demands it; so does one that is shorter by more than
 * jitter explains. Otherwise a longest step that has not come again for some time is forgotten.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "core/step/step_length.h"

#include <float.h>
#include <math.h>

#include "core/schemes/mode_split.h"
#include "core/step/scheme_change.h"

#define LENGTH_STEPS 256  /* after which a longest step that has not come again is forgotten */
#define LENGTH_JITTER 4.0 /* times a step: what the longest one lately may be */

static void open_window(thrum_state *state) {
  state->longest_dt = state->def.dt;
  state->split_end = state->report.steps + LENGTH_STEPS;
}

void thrum_step_length_begin(thrum_state *state) {
  state->split_dt = state->def.dt;
  open_window(state);
}

/* The split for another longest step: modes that the stability monitor has taken out of it stay
 * out. */
static int32_t split_for(const thrum_model *model, thrum_state *state, double dt) {
  const int32_t whole = thrum_mode_split(model, state);
  state->split_dt = dt;
  const int32_t changed = thrum_mode_split(model, state);
  return state->split == whole || changed < state->split ? changed : state->split;
}

void thrum_step_length_enter(const thrum_model *model, thrum_state *state, double dt) {
  const double longest = state->split_dt;
  state->def.dt = dt;
  state->longest_dt = fmax(state->longest_dt, dt);
  if (dt <= longest && dt * LENGTH_JITTER >= longest)
    return;

  // the energy integrator has no explicit modes
  if (state->scheme == THRUM_SCHEME_ENERGY)
    state->split_dt = dt;
  else
    state->split = split_for(model, state, dt);
  state->report.stability_number_last =
      fmin(state->report.stability_number_last * (dt / longest), DBL_MAX);
  open_window(state);
}

thrum_status thrum_step_length_settle(const thrum_model *model, thrum_state *state,
                                      thrum_state_view *view) {
  if (state->split_dt == state->def.dt && state->longest_dt == state->def.dt)
    return THRUM_OK;
  if (state->report.steps < state->split_end)
    return THRUM_OK;

  const int32_t split =
      state->scheme == THRUM_SCHEME_ENERGY ? 0 : split_for(model, state, state->longest_dt);
  state->split_dt = state->longest_dt;
  open_window(state);
  return split == state->split
             ? THRUM_OK
             : thrum_scheme_change(model, state, view, (thrum_scheme)state->scheme, split);
}
