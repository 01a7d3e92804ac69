/* The state about which a model is made: at rest with what is held where the state has it.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_FEM_ABOUT_STATE_H
#define THRUM_PRECOMPUTE_FEM_ABOUT_STATE_H

#include "precompute/fem/fem.h"

/* Takes a body to the state of its mesh, where that has one: what it answers then is beyond that.
 * thrum_fem_create alone leaves it at rest. */
thrum_status thrum_fem_take_state(const thrum_mesh *mesh, thrum_fem *fem, thrum_error *error);

/* Finds the displacement u (3 vertex_count) at which no force is on the free components where the
 * held ones have those of `field`, which the free ones begin with; step by step, by Newton's method
 * with steps that halve where it fails. THRUM_SINGULAR: the body gives way before. */
thrum_status thrum_about_state(const thrum_fem *fem, const double *field, double *u,
                               thrum_error *error);

#endif
