/* The split and the frequencies that a state of a model would have at a given time step, asked of
 * the runtime itself.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/model/split_at.h"

#include "thrum/thrum.h"

thrum_status split_at(const thrum_model *model, double dt, split_counts *split,
                      thrum_error *error) {
  thrum_state_def def = thrum_default_state_def();
  def.integrator = THRUM_INTEGRATOR_IMEXV; // the one that splits the modes
  def.dt = dt;
  thrum_state *state = NULL;
  thrum_model elastic = *model;
  elastic.region_yield = NULL; // which it does not step
  THRUM_TRY(thrum_state_create(&elastic, &def, &state, error));
  const thrum_state_report report = thrum_state_report_get(state);
  *split = (split_counts){report.explicit_modes, report.implicit_modes, thrum_state_bytes(state)};
  thrum_state_destroy(state);
  return THRUM_OK;
}

thrum_status stepped_modes_at(const thrum_model *model, const thrum_state_def *def,
                              thrum_stepped_mode *modes, thrum_error *error) {
  thrum_state *state = NULL;
  THRUM_TRY(thrum_state_create(model, def, &state, error));
  const thrum_status status = thrum_state_stepped_modes(model, state, modes, error);
  thrum_state_destroy(state);
  return status;
}
