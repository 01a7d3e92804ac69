/* The energy that damping takes out of a body in a step; private to libthrum, see dissipation.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_SCHEMES_DISSIPATION_H
#define THRUM_CORE_SCHEMES_DISSIPATION_H

#include "core/state/state_layout.h"

/* Energy [J] that the step from view->q to view->q_next dissipates; negative where the tangent form
 * of damping feeds energy in. The tangent form overwrites the scratch vectors point, trial and
 * product. */
double thrum_step_dissipation(const thrum_model *model, const thrum_state *state,
                              const thrum_state_view *view);

#endif
