/* The kept inverse of a Jacobian for another time step; private to libthrum, see kept_inverse.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_STEP_KEPT_INVERSE_H
#define THRUM_CORE_STEP_KEPT_INVERSE_H

#include "core/state/state_layout.h"

/* Turns the newest inverse of a state whose header was `before` into the one of its new time step,
 * and forgets the older ones; forgets it too where that is not possible. Overwrites scratch. */
void thrum_kept_inverse_convert(const thrum_model *model, const thrum_state *before,
                                thrum_state *state, thrum_state_view *view);

#endif
