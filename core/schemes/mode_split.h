/* The number of explicit modes; private to libthrum, see mode_split.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_SCHEMES_MODE_SPLIT_H
#define THRUM_CORE_SCHEMES_MODE_SPLIT_H

#include "core/state/state_layout.h"

/* Number of modes that a rule makes explicit: `count` for THRUM_SPLIT_COUNT, else by dt [s]. */
int32_t thrum_mode_split_by(const thrum_model *model, thrum_split_rule rule, double dt,
                            double safety, int32_t count);

/* |E| of a state as its def has it, for the longest step lately. */
int32_t thrum_mode_split(const thrum_model *model, const thrum_state *state);

#endif
