/* The inverse of a Jacobian, kept from step to step, for another time step.
 *
 * The Jacobian of each implicit problem is J = C + k T with a diagonal C and a number k that depend
 * on the time step, so that the one of another time step follows without an evaluation of T:
 *
 *   J' = C' + k' T = rho J + E,  rho = k'/k,  E = C' - rho C
 *   H' = (rho H^-1 + E)^-1 = E^-1 - E^-1 (H/rho + E^-1)^-1 E^-1
 *
 * for the inverses H and H'. It is as old as H, and as good; what BFGS has learnt comes along.
 * Cost: n^3 for n implicit modes, where a tangent costs about n^4/6.
 * Source of the identity: Woodbury 1950; Hager 1989, doi:10.1137/1031049.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "core/step/kept_inverse.h"

#include <math.h>
#include <string.h>

#include "core/base/finite.h"
#include "core/linear_algebra/dense.h"
#include "core/schemes/schemes.h"

#define CHANGE_LEAST 1e-6 /* of the diagonal: a smaller change is none, or cancels */

/* The problem that the scheme of a state solves; false where it keeps no inverse. */
static bool find_problem(const thrum_model *model, const thrum_state *state, thrum_state_view *view,
                         thrum_solve_report *report, thrum_solver *s) {
  const thrum_scheme_row *row = thrum_row_of(state);
  return row->problem && row->problem(model, state, view, report, s);
}

/* C into `diagonal`, returns k. */
static double take_parts(const thrum_solver *s, double *diagonal) {
  const double beta = s->state->def.damping_beta;
  for (int32_t i = 0; i < s->n; i++) {
    const int32_t mode = s->first + i;
    const double rest = s->tangent ? 0.0 : beta * s->model->omega2[mode];
    const double mass = s->view->mass[mode];
    const double damped = s->view->speed[mode] * s->view->drag[mode] / mass *
                          (thrum_mass_damping(s->model, s->state, mode) + rest);
    diagonal[i] = mass * (1.0 + s->weight * s->rate * damped);
  }
  return s->weight * (s->at + (s->tangent ? s->rate * beta : 0.0));
}

/* H' in place of H; false where it cannot be had. */
static bool convert(const thrum_state_view *view, int32_t n, double ratio, const double *change,
                    double *inverse) {
  double least = INFINITY, most = 0.0;
  for (int32_t i = 0; i < n; i++) {
    least = fmin(least, fabs(change[i]));
    most = fmax(most, fabs(change[i]));
  }
  if (most < CHANGE_LEAST)
    return true;
  if (!(least >= CHANGE_LEAST && most < INFINITY && ratio > 0.0))
    return false;

  // H/rho + E^-1, and its inverse
  double *matrix = view->jacobian_next;
  const size_t rows = (size_t)n;
  for (size_t a = 0; a < rows * rows; a++)
    matrix[a] = inverse[a] / ratio;
  for (size_t i = 0; i < rows; i++)
    matrix[i * rows + i] += 1.0 / change[i];
  if (!thrum_dense_invert(view->kernel, matrix, n, view->work))
    return false;

  for (size_t i = 0; i < rows; i++) {
    for (size_t j = 0; j < rows; j++)
      matrix[i * rows + j] /= -(change[i] * change[j]);
    matrix[i * rows + i] += 1.0 / change[i];
  }
  if (!thrum_all_finite(matrix, (int64_t)(rows * rows)))
    return false;
  memcpy(inverse, matrix, rows * rows * sizeof *inverse);
  return true;
}

void thrum_kept_inverse_convert(const thrum_model *model, const thrum_state *before,
                                thrum_state *state, thrum_state_view *view) {
  if (!state->jacobian_kept)
    return;

  // C and k before and after, and their change into `unknown`
  thrum_solve_report report = {0};
  thrum_solver s;
  double *diagonal = view->trial, *change = view->unknown;
  bool possible = find_problem(model, before, view, &report, &s);
  const double factor = possible ? take_parts(&s, diagonal) : 0.0;
  possible = possible && find_problem(model, state, view, &report, &s);
  const double ratio = possible ? take_parts(&s, change) / factor : 0.0;
  for (int32_t i = 0; possible && i < s.n; i++)
    change[i] -= ratio * diagonal[i];

  state->jacobian_kept = possible && convert(view, s.n, ratio, change, view->inverse[0]);
  for (int j = state->jacobian_kept ? 1 : 0; j < THRUM_INVERSES; j++)
    state->inverse_step[j] = -1;
}
