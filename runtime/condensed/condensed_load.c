/* Loads on all coordinates of a condensed model, for the steps of its state
 * (thrum/condensed_model.h). SPDX-License-Identifier: Apache-2.0 */
#include "core/base/finite.h"
#include "core/state/state_layout.h"
#include "core/step/state_private.h"
#include "thrum/condensed_model.h"

thrum_status thrum_state_reduce_load(const thrum_model *model, thrum_state *state,
                                     const double *load, double *reduced, thrum_error *error) {
  THRUM_TRY(thrum_state_check(model, state, error));
  if (!load || !reduced)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "a load is NULL");
  if (!thrum_all_finite(load, thrum_condensed_shape_model(model)->rank))
    return thrum_error_set(error, THRUM_BAD_VALUE, "the load holds a number that is not finite");

  // a state of which nothing follows keeps no place ahead, and needs none
  const thrum_state_view view = thrum_state_view_of(state);
  thrum_condensed_load(model, state->ahead_count > 0 ? view.q_ahead : view.q, load, reduced);
  return THRUM_OK;
}

thrum_status thrum_state_set_load(const thrum_model *model, thrum_state *state, const double *load,
                                  thrum_error *error) {
  double reduced[THRUM_RANK_MAX];
  if (!load)
    return thrum_state_set_force(model, state, NULL, error);
  THRUM_TRY(thrum_state_reduce_load(model, state, load, reduced, error));
  return thrum_state_set_force(model, state, reduced, error);
}
