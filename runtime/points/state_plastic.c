/* The plastic strain of a state: copies it from another state, clears it and reads it
 * (thrum/state.h).
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include <math.h>
#include <string.h>

#include "core/polynomial/points.h"
#include "core/step/state_private.h"
#include "runtime/guard/energy_correction.h"
#include "runtime/material/plastic_flow.h"
#include "runtime/points/point_flow.h"
#include "runtime/points/point_rest.h"

/* The plastic part of a state, which is only read. */
static const double *plastic_of(const thrum_state *state) {
  return thrum_state_view_of((thrum_state *)(uintptr_t)state).plastic;
}

/* Numbers of the plastic strains of all points; what was released by them lies behind. */
static int64_t strains_of(const thrum_state *state) {
  const int64_t rank = state->rank;
  return state->plastic_count > 0 ? state->plastic_count - rank * rank - rank - 2 : 0;
}

/* Another material: its energy is another one at once, which the next step takes as its target. */
static void forget_material(thrum_state *state) {
  thrum_forget_forces(state);
  thrum_energy_correction_close(state);
}

thrum_status thrum_state_take_plastic(thrum_state *state, const thrum_state *from,
                                      thrum_error *error) {
  if (!state || !from)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "one of the states is NULL");
  const int64_t points = strains_of(state);
  if (points != strains_of(from) || points == 0)
    return thrum_error_set(
        error, THRUM_MODEL_MISMATCH, "what has flowed at %lld cubature points cannot go on at %lld",
        (long long)(strains_of(from) / THRUM_POINT_ROWS), (long long)(points / THRUM_POINT_ROWS));
  memmove(thrum_state_view_of(state).plastic, plastic_of(from), (size_t)points * sizeof(double));
  state->release_due = 1;
  forget_material(state);
  return THRUM_OK;
}

thrum_status thrum_state_clear_plastic(const thrum_model *model, thrum_state *state,
                                       thrum_error *error) {
  THRUM_TRY(thrum_state_check(model, state, error));
  if (!thrum_can_flow(state))
    return THRUM_OK;
  const thrum_state_view view = thrum_state_view_of(state);
  memset(view.plastic, 0, (size_t)strains_of(state) * sizeof(double));

  // what that releases is found here, so that no later call has to write it
  thrum_rest_release(model, view.shapes, view.shares, view.plastic);
  state->release_due = 0;
  forget_material(state);
  state->report.dissipated -= state->report.plastic_work;
  state->report.plastic_work = 0.0;
  return THRUM_OK;
}

double thrum_state_plastic_strain(const thrum_state *state) {
  if (!state || !thrum_can_flow(state))
    return 0.0;
  const double *at = plastic_of(state);
  double largest = 0.0, plastic[3][3];
  for (int64_t n = 0; n < strains_of(state); n += THRUM_POINT_ROWS) {
    memcpy(plastic, at + n, sizeof plastic);
    largest = fmax(largest, thrum_plastic_strain(plastic));
  }
  return largest;
}

double thrum_state_point_stiffness(const thrum_state *state) {
  if (!state || !thrum_can_flow(state))
    return 0.0;
  const double *shares = thrum_state_view_of((thrum_state *)(uintptr_t)state).shares;
  double largest = 0.0;
  for (int32_t k = 0; k < state->rank; k++)
    largest = fmax(largest, shares[k]);
  return largest;
}
