/* What has flowed in a state: taken over, cleared and read (thrum/state.h).
 * SPDX-License-Identifier: Apache-2.0 */
#include "runtime/base/fp_contract.h"

#include <math.h>
#include <string.h>

#include "runtime/dynamics/energy_correction.h"
#include "runtime/dynamics/point_flow.h"
#include "runtime/dynamics/state_private.h"
#include "runtime/material/plastic_flow.h"
#include "runtime/polynomial/points.h"

/* The plastic part of a state, which is only read. */
static const double *plastic_of(const thrum_state *state) {
  return thrum_state_view_of((thrum_state *)(uintptr_t)state).plastic;
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
  if (state->plastic_count != from->plastic_count || state->plastic_count == 0)
    return thrum_error_set(error, THRUM_MODEL_MISMATCH,
                           "what has flowed at %lld cubature points cannot go on at %lld",
                           (long long)(from->plastic_count / THRUM_POINT_ROWS),
                           (long long)(state->plastic_count / THRUM_POINT_ROWS));
  memmove(thrum_state_view_of(state).plastic, plastic_of(from),
          (size_t)state->plastic_count * sizeof(double));
  forget_material(state);
  return THRUM_OK;
}

thrum_status thrum_state_clear_plastic(const thrum_model *model, thrum_state *state,
                                       thrum_error *error) {
  THRUM_TRY(thrum_state_check(model, state, error));
  if (!thrum_can_flow(&state->def))
    return THRUM_OK;
  memset(thrum_state_view_of(state).plastic, 0, (size_t)state->plastic_count * sizeof(double));
  forget_material(state);
  state->report.dissipated -= state->report.plastic_work;
  state->report.plastic_work = 0.0;
  return THRUM_OK;
}

double thrum_state_plastic_strain(const thrum_state *state) {
  if (!state || !thrum_can_flow(&state->def))
    return 0.0;
  const double *at = plastic_of(state);
  double largest = 0.0, plastic[3][3];
  for (int64_t n = 0; n < state->plastic_count; n += THRUM_POINT_ROWS) {
    memcpy(plastic, at + n, sizeof plastic);
    largest = fmax(largest, thrum_plastic_strain(plastic));
  }
  return largest;
}
