/* How imexv would split a model at a time step. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SPLIT_AT_H
#define THRUM_DRIVER_SPLIT_AT_H

#include "thrum/model.h"
#include <stddef.h>
#include <stdint.h>

/* How imexv would split this model at `dt` with its other defaults, and what a state would take. */
typedef struct split_counts {
  int64_t explicit_modes;
  int64_t implicit_modes;
  size_t state_bytes;
} split_counts;
thrum_status split_at(const thrum_model *model, double dt, split_counts *split, thrum_error *error);

#endif
