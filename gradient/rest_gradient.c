/* The gradient of a loss of a body at rest (thrum/gradient.h; design 22): R(q) = f, so with the
 * solution w of T w = q_bar the derivative by f is w, and that by a factor of V is -w R.
 * Cost: a tangent and 2/3 rank^3. SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include <string.h>

#include "core/base/finite.h"
#include "gradient/linear_system.h"
#include "thrum/gradient.h"
#include "thrum/polynomial.h"

static thrum_status check_rest(const thrum_model *model, const double *q, const double *q_bar,
                               const double *stiffness_bar, const double *work,
                               thrum_error *error) {
  if (!model || !q || !q_bar || !work)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the model, q, q_bar or work is NULL");
  if (model->rank < 1 || model->rank > THRUM_RANK_MAX)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the model's rank is %lld, not 1 to %d",
                           (long long)model->rank, THRUM_RANK_MAX);
  if (model->shape)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "a condensed model has no gradient here: the load of its slaves depends "
                           "on the shape");
  if (stiffness_bar && model->actuator_count > 0)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "the derivative by a factor of Young's modulus is not there for bodies "
                           "that act: pressures and tendons do not scale with it");
  if (!thrum_all_finite(q, model->rank) || !thrum_all_finite(q_bar, model->rank))
    return thrum_error_set(error, THRUM_BAD_VALUE, "q or q_bar has a number that is not finite");
  return THRUM_OK;
}

thrum_status thrum_rest_pull_back(const thrum_model *model, const double *q, const double *q_bar,
                                  double *force_bar, double *stiffness_bar, double *work,
                                  thrum_error *error) {
  THRUM_TRY(check_rest(model, q, q_bar, stiffness_bar, work, error));
  const int64_t r = model->rank;
  double *tangent = work, *w = tangent + r * r, *force = w + r, *rest = force + 2 * r;
  int32_t *rows = (int32_t *)(void *)(force + r);
  thrum_internal_force_tangent(model, q, force, tangent, rest);
  memcpy(w, q_bar, (size_t)r * sizeof *w);
  if (!thrum_linear_factor(tangent, r, rows))
    return thrum_error_set(
        error, THRUM_SINGULAR,
        "the tangent stiffness is singular: the body is at a limit or bifurcation "
        "point, where rest has no derivative");
  thrum_linear_solve(tangent, r, rows, w);
  if (!thrum_all_finite(w, r))
    return thrum_error_set(error, THRUM_SINGULAR, "the tangent stiffness is singular to rounding");

  double along = 0.0;
  for (int64_t i = 0; i < r; i++)
    along += w[i] * force[i];
  if (force_bar)
    memcpy(force_bar, w, (size_t)r * sizeof *w);
  if (stiffness_bar)
    *stiffness_bar = -along;
  return THRUM_OK;
}
