/* The norm in which residuals and motions are compared; see motion_norm.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_STATE_MOTION_NORM_H
#define THRUM_CORE_STATE_MOTION_NORM_H

#include "core/state/state_layout.h"

/* Scaled norm of q and p (rank each), for the state's dt and split. */
double thrum_motion_norm(const thrum_model *model, const thrum_state *state, const double *q,
                         const double *p);

#endif
