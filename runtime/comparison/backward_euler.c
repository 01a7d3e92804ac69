/* One step of backward Euler, for comparison (design 6): it damps every motion, fast modes most.
 *
 *   q' = q + h p',  p' = p - h [R(q') + D p' - f]
 *   0 = d - h p + h^2 [R(q + d) + D d/h - f],  d = q' - q,  Jacobian 1 + h^2 T(q') + h D
 *
 * The energy of a linear mode falls by the factor 1 + (h omega)^2 in each step. The equation is the
 * gradient of a potential that is bounded below (implicit_solve.c), so a step always has a solution
 * but for the tangent form of D.
 * Cost: an iteration takes one force evaluation and about r^2, a new Jacobian a tangent and r^3.
 * Source: Hairer & Wanner 1996, section IV.3, doi:10.1007/978-3-642-05221-7.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/comparison/backward_euler.h"

#include "core/solve/implicit_solve.h"

static bool problem(const thrum_model *model, const thrum_state *state, thrum_state_view *view,
                    thrum_solve_report *report, thrum_solver *s) {
  const double h = state->def.dt;
  *s = thrum_problem_make(model, state, view, report, 0, 1.0, h * h, 1.0 / h);
  return true;
}

static thrum_status step(const thrum_model *model, const thrum_state *state, thrum_state_view *view,
                         thrum_solve_report *report) {
  const double h = state->def.dt;
  thrum_solver s;
  problem(model, state, view, report, &s);
  for (int32_t i = 0; i < state->rank; i++)
    view->kick[i] = h * view->p[i];
  if (!thrum_solve_increment(&s))
    return report->saw_nonfinite ? THRUM_NOT_FINITE : THRUM_NOT_CONVERGED;
  thrum_solve_advance(&s);
  return THRUM_OK;
}

thrum_mode_factor thrum_backward_euler_frequency(const thrum_model *model, const thrum_state *state,
                                                 int32_t i, double z) {
  const double square = z * z;
  (void)model, (void)state, (void)i;
  return (thrum_mode_factor){1.0 / (1.0 + square), z / (1.0 + square)};
}

thrum_mode_answer thrum_backward_euler_answer(const thrum_model *model, const thrum_state *state,
                                              int32_t own, int32_t i) {
  (void)model, (void)state, (void)own, (void)i;
  return (thrum_mode_answer){1.0, 1.0, 1.0, 1.0};
}

const thrum_scheme_row thrum_backward_euler_scheme = {
    .scheme = THRUM_SCHEME_BACKWARD_EULER,
    .integrator = THRUM_INTEGRATOR_BACKWARD_EULER,
    .form = -1,
    .step = step,
    .frequency = thrum_backward_euler_frequency,
    .answer = thrum_backward_euler_answer,
    .problem = problem,
};
