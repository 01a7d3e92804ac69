/* One step of the linearly implicit Euler method, for comparison (design 6): backward Euler with a
 * single Newton iteration, as Baraff & Witkin step cloth. (Symplectic Euler, which is also called
 * semi-implicit, is another method; it is `verlet` with its momentum half a step away.)
 *
 *   [1 + h D(q) + h^2 T(q)] (p' - p) = -h [R(q) + D(q) p + h T(q) p - f],  q' = q + h p'
 *
 * Linear modes fall as with backward Euler. T may be indefinite, and then a step may amplify.
 * Cost: one force evaluation with its tangent and 2 r^3/3.
 * Source: Baraff & Witkin 1998, doi:10.1145/280814.280821.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/comparison/semi_implicit_euler.h"

#include "core/base/finite.h"
#include "core/linear_algebra/dense.h"
#include "core/polynomial/polynomial_private.h"
#include "runtime/comparison/backward_euler.h"

/* Makes the matrix from T(q) in jacobian_next, and the right-hand side in p_next from R(q) in
 * force. */
static void assemble(const thrum_model *model, const thrum_state *state, thrum_state_view *view) {
  const double h = state->def.dt, beta = state->def.damping_beta;
  const bool tangent = thrum_tangent_damped(state);
  const size_t rank = (size_t)state->rank;
  for (size_t i = 0; i < rank; i++) {
    double *row = view->jacobian_next + i * rank, stiff = 0.0;
    for (size_t j = 0; j < rank; j++)
      stiff += row[j] * view->p[j];

    const double alpha = thrum_mass_damping(model, state, (int64_t)i);

    // D p is alpha p + beta times T p or omega^2 p
    const double damped =
        alpha * view->p[i] + beta * (tangent ? stiff : model->omega2[i] * view->p[i]);
    view->p_next[i] = -h * (view->force[i] + damped + h * stiff - view->load[i]);

    for (size_t j = 0; j < rank; j++)
      row[j] *= h * h + (tangent ? h * beta : 0.0);
    row[i] += 1.0 + h * (alpha + (tangent ? 0.0 : beta * model->omega2[i]));
  }
}

static thrum_status step(const thrum_model *model, const thrum_state *state, thrum_state_view *view,
                         thrum_solve_report *report) {
  thrum_internal_force_tangent_by(view->kernel, model, view->q, view->force, view->jacobian_next,
                                  view->work);
  assemble(model, state, view);

  // T may be indefinite, and so may the matrix: LU, not Cholesky
  int32_t *pivots = (int32_t *)(void *)view->pivots_next;
  report->factorisations++;
  if (!thrum_dense_factor(view->jacobian_next, state->rank, pivots))
    return thrum_all_finite(view->p_next, state->rank) ? THRUM_NOT_CONVERGED : THRUM_NOT_FINITE;
  thrum_dense_solve(view->jacobian_next, state->rank, pivots, view->p_next);

  for (int32_t i = 0; i < state->rank; i++) {
    view->p_next[i] += view->p[i];
    view->q_next[i] = view->q[i] + state->def.dt * view->p_next[i];
  }
  return thrum_all_finite(view->q_next, state->rank) && thrum_all_finite(view->p_next, state->rank)
             ? THRUM_OK
             : THRUM_NOT_FINITE;
}

const thrum_scheme_row thrum_semi_implicit_euler_scheme = {
    .scheme = THRUM_SCHEME_SEMI_IMPLICIT_EULER,
    .integrator = THRUM_INTEGRATOR_SEMI_IMPLICIT_EULER,
    .form = -1,
    .keeps_nothing = true,
    .step = step,
    .frequency = thrum_backward_euler_frequency,
    .answer = thrum_backward_euler_answer,
};
