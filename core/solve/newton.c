/* Newton's method for the increment d of a step, as the thesis has it (design 5): a Jacobian and
 * its inverse in each iteration, from d = 0.
 *
 * Nothing is kept from one step to the next, no direction is searched along, and no indefinite
 * Jacobian is shifted: a step that this does not solve is not solved. It is there to measure the
 * thesis' own method by; thrum_solve_newton is the Newton of the fallback chain. The tangent form
 * of damping leaves the change of T out of its Jacobian, as quasi-Newton does. Cost: an evaluation
 * of R, a tangent and n^3 an iteration.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "core/solve/newton.h"

#include <math.h>
#include <string.h>

#include "core/linear_algebra/dense.h"

/* Corrects the increment by the inverse of the Jacobian there; false where it is singular. */
static bool correct(const thrum_solver *s) {
  thrum_state_view *view = s->view;
  const int32_t n = s->n;
  thrum_problem_assemble(s, false);
  s->report->factorisations++;
  if (!thrum_dense_invert(view->kernel, view->jacobian_next, n, view->work))
    return false;

  // the inverse as a secant without updates, so that the border of energy can use it
  const thrum_secant inverse = {
      .by = view->kernel, .base = view->jacobian_next, .stride = view->stride, .n = n};
  double *image = view->image + s->first, *residual = view->trial + s->first;
  memcpy(residual, view->residual + s->first, (size_t)n * sizeof *residual);
  thrum_secant_apply(&inverse, residual, image);
  if (s->border)
    s->border(s, &inverse, true, residual, image);

  // the whole correction, without a line search
  for (int32_t i = 0; i < n; i++)
    view->unknown[s->first + i] -= image[i];
  s->report->iterations++;
  return true;
}

bool thrum_newton_solve(const thrum_solver *s) {
  thrum_solve_report *report = s->report;
  memset(s->view->unknown, 0, (size_t)s->state->rank * sizeof *s->view->unknown);
  report->refreshed = report->extrapolated = report->late_refresh = false;
  report->learnt = 0;
  report->verified = true;

  // each iteration evaluates first, so that a good guess costs no Jacobian
  for (int32_t done = 0;; done++) {
    thrum_problem_place(s);
    s->evaluate(s);
    const double norm = thrum_problem_residual(s), step = thrum_problem_norm(s);
    report->saw_nonfinite = !isfinite(norm);
    if (report->saw_nonfinite)
      return false;
    if (thrum_problem_accept(s, norm, step))
      return true;
    if (done == s->state->def.iterations_max || !correct(s))
      return false;
  }
}
