/* Newton's method for the increment d of a step, F(d) = 0 with F of the size of (v' - v) + h <R>,
 * with an inverse of the Jacobian that is kept over steps and made anew where it leaves too much.
 * Residual and increment are compared in the norm of 1 + (h omega)^2/4: half a step times the
 * residual over it stands for an error of the increment. SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/condensed/increment_solve.h"

#include <math.h>

#include "core/polynomial/polynomial_private.h"
#include "core/solve/implicit_problem.h"

#define SLOW 0.2 /* residual over the one before: a new Jacobian */

/* Scaled norms of the residual, as an increment, and of the increment. */
static double measure(const thrum_increment *s, double *step) {
  const thrum_state_view *view = s->view;
  const double h = s->state->def.dt;
  double error = 0.0, square = 0.0;
  for (int64_t i = 0; i < s->model->rank; i++) {
    const double scale = 1.0 + 0.25 * h * h * s->model->omega2[i];
    square += scale * (view->unknown[i] * view->unknown[i]);
    error += view->residual[i] * view->residual[i] / scale;
  }
  *step = sqrt(square);
  return 0.5 * h * sqrt(error);
}

thrum_status thrum_increment_solve(const thrum_increment *s, const double *inverse,
                                   thrum_solve_report *report) {
  const thrum_state_def *def = &s->state->def;
  thrum_state_view *view = s->view;
  const double tolerance = def->tolerance > 0.0 ? def->tolerance : s->tolerance;
  double last = INFINITY, step = 0.0;

  // a body that hardly moves is judged by what has moved it before
  const double floor = THRUM_ROUNDING_FLOOR * s->state->amplitude;
  for (int32_t done = 0;; done++) {
    if (!s->evaluate(s->of))
      return THRUM_NOT_CONVERGED;
    const double error = measure(s, &step);
    report->saw_nonfinite = !isfinite(error);
    if (report->saw_nonfinite)
      return THRUM_NOT_FINITE;
    if (error <= tolerance * step + floor) {
      report->residual = step > 0.0 ? error / step : 0.0;
      return THRUM_OK;
    }

    // an inverse that no longer leaves little is made anew
    if (done == def->iterations_max)
      return THRUM_NOT_CONVERGED;
    if (!inverse || error > SLOW * last) {
      if (!s->invert(s->of, report))
        return THRUM_NOT_CONVERGED;
      inverse = view->jacobian_next;
    }

    // one step of Newton's method with that inverse
    view->kernel->product(s->model->rank, s->model->rank, inverse, view->residual, view->direction);
    for (int64_t i = 0; i < s->model->rank; i++)
      view->unknown[i] -= view->direction[i];
    report->iterations++;
    last = error;
  }
}
