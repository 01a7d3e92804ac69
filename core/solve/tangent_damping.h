/* Linear systems of damping in the tangent form; private to libthrum, see tangent_damping.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_SOLVE_TANGENT_DAMPING_H
#define THRUM_CORE_SOLVE_TANGENT_DAMPING_H

#include "core/state/state_layout.h"

/* x (rank) := (1 + share D(q))^-1 x with D = alpha 1 + beta T(q), share in seconds; `matrix`
 * (rank x rank) is scratch, and pivots_next is overwritten. false, with x as it was: singular. */
bool thrum_tangent_damping_solve(const thrum_model *model, const thrum_state *state,
                                 thrum_state_view *view, const double *q, double share,
                                 double *matrix, double *x);

#endif
