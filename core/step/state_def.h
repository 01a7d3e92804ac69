/* Checks of a model and a def; private to libthrum, see state_def.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_STEP_STATE_DEF_H
#define THRUM_CORE_STEP_STATE_DEF_H

#include "thrum/state.h"

/* Checks the parts of a model that every evaluation needs. */
thrum_status thrum_state_check_model(const thrum_model *model, thrum_error *error);

/* Checks the model and the def. */
thrum_status thrum_state_def_check(const thrum_model *model, const thrum_state_def *def,
                                   thrum_error *error);

#endif
