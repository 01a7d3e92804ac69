/* A model of what a step of a body costs, so that a budget chooses the same coordinates on every
 * machine. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MODEL_STEP_COST_H
#define THRUM_DRIVER_MODEL_STEP_COST_H

#include "thrum/state.h"

/* Seconds of a step of `stepped` coordinates while `followers` others follow (0: none), modelled:
 * the time of one core of an Intel Xeon with AVX-512 (docs/scenes.md), whatever this machine is.
 */
double step_cost(const thrum_state_def *def, int64_t stepped, int64_t followers);

#endif
