/* Kick and half-step shift of the explicit momentum; private to libthrum, see
 * staggered_momentum.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_SCHEMES_STAGGERED_MOMENTUM_H
#define THRUM_CORE_SCHEMES_STAGGERED_MOMENTUM_H

#include "core/state/state_layout.h"

/* How many modes have their momentum half a step before q: the first ones. */
static inline int32_t thrum_staggered_modes(const thrum_state *state) {
  if (state->scheme == THRUM_SCHEME_POSITION)
    return 0;
  return state->scheme == THRUM_SCHEME_QUADRATIC ? state->rank : state->split;
}

/* The force on the staggered modes at q, into their entries of view->force: R, less kappa q in the
 * quadratic split. Returns V(q). */
double thrum_staggered_force(const thrum_model *model, const thrum_state *state,
                             thrum_state_view *view, const double *q);

/* Kick of the staggered modes (2): p^+_E into view->p_next. Needs their force at q_k. With the
 * tangent form of damping also their synchronised p, into view->p_before_next. THRUM_OK or
 * THRUM_SINGULAR. */
thrum_status thrum_staggered_kick(const thrum_model *model, const thrum_state *state,
                                  thrum_state_view *view);

/* Momentum of all modes at the time of q into view->p_next; V(q) into *potential if not NULL.
 * Overwrites force. THRUM_OK or THRUM_SINGULAR. */
thrum_status thrum_staggered_synchronise(const thrum_model *model, const thrum_state *state,
                                         thrum_state_view *view, double *potential);

/* The inverse: turns the staggered part of `p` (rank, at the time of q) into p^-_E, for the dt and
 * split of `state` and the load of the step before (NULL: zero). Overwrites force and product, and
 * what the unsynchronise of the scheme does. THRUM_OK, or as that. */
thrum_status thrum_staggered_unsynchronise(const thrum_model *model, const thrum_state *state,
                                           thrum_state_view *view, const double *q,
                                           const double *load_before, double *p);

#endif
