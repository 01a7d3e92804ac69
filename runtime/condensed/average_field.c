/* The mean force of a step, the average vector field of a quartic V: the integral of R along the
 * increment, for which two Gauss points are exact, so that d <R> = V(q + d) - V(q). Cost: two
 * forces by one pass.
 * Source: Quispel & McLaren 2008, doi:10.1088/1751-8113/41/4/045206.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/condensed/average_field.h"

#include <math.h>

#include "core/linear_algebra/dense.h"
#include "core/polynomial/polynomial_private.h"

#define GAUSS 0.211324865405187118 /* (1 - 1/sqrt(3)) / 2, the first of two points in [0, 1] */
#define QUIET 0x1p-34              /* step over the amplitude: below, guesses are not continued */

void thrum_average_field_add(const thrum_model *model, const thrum_state *state,
                             thrum_state_view *view, const double *d, double *total) {
  for (int32_t i = 0; i < state->rank; i++) {
    view->point[i] = view->q[i] + GAUSS * d[i];
    view->point_2[i] = view->q[i] + (1.0 - GAUSS) * d[i];
  }
  const double *const points[2] = {view->point, view->point_2};
  double *const forces[2] = {view->force, view->force_2};
  double values[2];
  thrum_internal_forces_by(view->kernel, model, points, forces, values, view->work);
  const double half = 0.5 * state->def.dt;
  for (int32_t i = 0; i < state->rank; i++)
    total[i] += half * (view->force[i] + view->force_2[i]);
}

void thrum_average_field_slope(const thrum_model *model, const thrum_state *state,
                               thrum_state_view *view, const double *d, double *slope) {
  const int64_t count = (int64_t)state->rank * state->rank;
  static const double places[2] = {GAUSS, 1.0 - GAUSS};
  double *const tangents[2] = {slope, view->tangent_2};
  for (int n = 0; n < 2; n++) {
    for (int32_t i = 0; i < state->rank; i++)
      view->point[i] = view->q[i] + places[n] * d[i];
    thrum_tangent_stiffness_by(view->kernel, model, view->point, tangents[n], view->work);
  }
  for (int64_t n = 0; n < count; n++)
    slope[n] = 0.5 * (places[0] * tangents[0][n] + places[1] * tangents[1][n]);
}

void thrum_average_field_guess(const thrum_state *state, thrum_state_view *view) {
  static const double weights[THRUM_PAST_SOLVES][THRUM_PAST_SOLVES] = {
      {1}, {2, -1}, {3, -3, 1}, {4, -6, 4, -1}, {5, -10, 10, -5, 1}};
  const double h = state->def.dt;
  const double speed = sqrt(thrum_dense_dot(view->p, view->p, state->rank));

  // earlier solutions of a body that hardly moves differ by rounding, which continuing multiplies
  int64_t known = 0;
  while (h * speed > QUIET * state->amplitude && known < THRUM_PAST_SOLVES &&
         known < state->past_count &&
         state->past_dt[thrum_past_place(state->report.steps - 1 - known)] == h)
    known++;

  // one step alone says less than the velocity
  for (int32_t i = 0; i < state->rank; i++)
    view->unknown[i] = known < 2 ? h * view->p[i] : -2.0 * view->q[i];
  for (int64_t n = 0; known >= 2 && n < known; n++) {
    const double *middle = view->past_q + thrum_past_at(view, state->report.steps - 1 - n);
    for (int32_t i = 0; i < state->rank; i++)
      view->unknown[i] += 2.0 * weights[known - 1][n] * middle[i];
  }
}
