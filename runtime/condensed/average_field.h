/* The average vector field by two points, and the first guess of steps that are solved with it, for
 * the manifold and the floating frame; private to the runtime, see average_field.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_CONDENSED_AVERAGE_FIELD_H
#define THRUM_RUNTIME_CONDENSED_AVERAGE_FIELD_H

#include "core/state/state_layout.h"

/* total += h times the mean of R from q to q + d; all have the rank of the state. view->point,
 * point_2, force and force_2 are used up. */
void thrum_average_field_add(const thrum_model *model, const thrum_state *state,
                             thrum_state_view *view, const double *d, double *total);

/* The derivative of that mean by d into `slope` (rank x rank), by two tangents. view->point and
 * tangent_2 are used up. */
void thrum_average_field_slope(const thrum_model *model, const thrum_state *state,
                               thrum_state_view *view, const double *d, double *slope);

/* The first guess of the increment into view->unknown: the middles of the steps before, continued;
 * h p where they are of other steps. */
void thrum_average_field_guess(const thrum_state *state, thrum_state_view *view);

#endif
