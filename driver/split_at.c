/* What a state of a model would be at a given time step, asked of the runtime itself.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/split_at.h"

#include <stdlib.h>

#include "thrum/thrum.h"

#define STATE_ALIGNMENT 64

thrum_status split_at(const thrum_model *model, double dt, split_counts *split,
                      thrum_error *error) {
  thrum_state_def def = thrum_default_state_def();
  def.dt = dt;
  size_t size = 0;
  thrum_status status = thrum_state_size(model, &def, &size, error);
  if (status < 0)
    return status;
  // aligned_alloc wants a multiple of the alignment
  const size_t rounded = (size + STATE_ALIGNMENT - 1) / STATE_ALIGNMENT * STATE_ALIGNMENT;
  void *memory = aligned_alloc(STATE_ALIGNMENT, rounded);
  if (memory == NULL) {
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a state of %zu bytes", size);
  }
  thrum_state *state = NULL;
  status = thrum_state_init(memory, rounded, model, &def, &state, error);
  if (status >= 0) {
    const thrum_state_report report = thrum_state_report_get(state);
    *split = (split_counts){report.explicit_modes, report.implicit_modes, size};
  }
  free(memory);
  return status;
}
