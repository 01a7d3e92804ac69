/* x := (1 + s D(q))^-1 x for damping in the tangent form, D = alpha 1 + beta T(q) (design 4): the
 * explicit member of Newmark's family and the halves of imexv's position form solve it.
 * Cost: one tangent and 2 r^3/3.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "core/solve/tangent_damping.h"

#include "core/linear_algebra/dense.h"
#include "core/polynomial/polynomial_private.h"

bool thrum_tangent_damping_solve(const thrum_model *model, const thrum_state *state,
                                 thrum_state_view *view, const double *q, double share,
                                 double *matrix, double *x) {
  const size_t rank = (size_t)state->rank;
  thrum_tangent_stiffness_by(view->kernel, model, q, matrix, view->work);
  for (size_t a = 0; a < rank * rank; a++)
    matrix[a] *= share * state->def.damping_beta;
  for (size_t i = 0; i < rank; i++)
    matrix[i * rank + i] += 1.0 + share * thrum_mass_damping(model, state, (int64_t)i);

  // T may be indefinite, and so may the matrix: LU, not Cholesky
  int32_t *pivots = (int32_t *)(void *)view->pivots_next;
  if (!thrum_dense_factor(matrix, state->rank, pivots))
    return false;
  thrum_dense_solve(matrix, state->rank, pivots, x);
  return true;
}
