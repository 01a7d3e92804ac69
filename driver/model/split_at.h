/* Tells what steps make of the modes of a model at a time step. SPDX-License-Identifier: Apache-2.0
 */
#ifndef THRUM_DRIVER_MODEL_SPLIT_AT_H
#define THRUM_DRIVER_MODEL_SPLIT_AT_H

#include <stddef.h>
#include <stdint.h>

#include "thrum/state.h"

/* How imexv would split this model at `dt` with its other defaults, and what a state would take. */
typedef struct split_counts {
  int64_t explicit_modes;
  int64_t implicit_modes;
  size_t state_bytes;
} split_counts;
thrum_status split_at(const thrum_model *model, double dt, split_counts *split, thrum_error *error);

/* How the modes vibrate as a state of this def steps them, into `modes` (rank). */
thrum_status stepped_modes_at(const thrum_model *model, const thrum_state_def *def,
                              thrum_stepped_mode *modes, thrum_error *error);

#endif
